//! Coulomb friction as a spring that slips.

use super::PointResponse;

/// What friction holds a point at: the place where it stuck last, and the normal force that limits the hold.
///
/// The tangential potential is Huber's function of the distance s from the anchor, with the stiffness k of the normal contact:
/// ½ k s² up to k s = μ N, beyond that μ N s − (μ N)² / 2k. N is that of the last iterate, so that the potential is convex.
/// A body at rest stays at rest: the spring does not creep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grip {
    /// x and y of the place \[m\]; `None` for a point that did not touch the ground.
    pub anchor: Option<[f64; 2]>,
    /// N \[N\].
    pub normal_force: f64,
}

impl Grip {
    /// Adds the tangential potential.
    pub(super) fn add(&self, stiffness: f64, friction: f64, at: [f64; 3], response: &mut PointResponse) {
        let Some(anchor) = self.anchor else { return };
        let limit = friction * self.normal_force;
        let slip = [at[0] - anchor[0], at[1] - anchor[1]];
        let distance = slip[0].hypot(slip[1]);
        if stiffness * distance <= limit {
            response.energy += 0.5 * stiffness * distance * distance;
            for i in 0..2 {
                response.gradient[i] += stiffness * slip[i];
                response.hessian[i][i] += stiffness;
            }
            return;
        }
        let direction = slip.map(|s| s / distance);
        response.energy += limit * distance - 0.5 * limit * limit / stiffness;
        for i in 0..2 {
            response.gradient[i] += limit * direction[i];
            for j in 0..2 {
                let identity = if i == j { 1.0 } else { 0.0 };
                response.hessian[i][j] += limit / distance * (identity - direction[i] * direction[j]);
            }
        }
    }

    /// Ends a step: the anchor follows a point that has slid, at the distance that the limit holds.
    pub(super) fn settle(&mut self, stiffness: f64, (force, friction): (f64, f64), at: [f64; 3]) {
        if force == 0.0 {
            *self = Self::default();
            return;
        }
        self.normal_force = force;
        let anchor = self.anchor.unwrap_or([at[0], at[1]]);
        let slip = [at[0] - anchor[0], at[1] - anchor[1]];
        let (distance, held) = (slip[0].hypot(slip[1]), friction * force / stiffness);
        let kept = if distance > held { held / distance } else { 1.0 };
        self.anchor = Some(std::array::from_fn(|i| at[i] - kept * slip[i]));
    }
}
