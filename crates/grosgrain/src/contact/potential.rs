//! The potential energy of a point.

use super::{Grip, Ground};
use crate::linalg::matrix3::Matrix3;

/// A potential that depends on the position of one point; convex, so that its Hessian is positive semidefinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointPotential {
    /// ½ k ‖x − a‖².
    Spring {
        /// k \[N/m\].
        stiffness: f64,
        /// a \[m\].
        target: [f64; 3],
    },
    /// A ground that pushes and holds, see [`Ground`].
    Ground {
        /// The ground.
        ground: Ground,
        /// Its stiffness at this point \[N/m\]: that of the ground times the point's share of the surface.
        stiffness: f64,
        /// What friction holds on to.
        grip: Grip,
    },
}

/// A potential and its derivatives at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointResponse {
    /// ψ \[J\].
    pub energy: f64,
    /// ∂ψ/∂x \[N\], the negative force on the point.
    pub gradient: [f64; 3],
    /// ∂²ψ/∂x² \[N/m\].
    pub hessian: Matrix3,
}

impl PointPotential {
    /// ψ and its derivatives at the position `at` \[m\].
    pub fn evaluate(&self, at: [f64; 3]) -> PointResponse {
        match self {
            Self::Spring { stiffness, target } => {
                let stretch: [f64; 3] = std::array::from_fn(|i| at[i] - target[i]);
                let square: f64 = stretch.iter().map(|s| s * s).sum();
                let diagonal = |i: usize, j: usize| if i == j { *stiffness } else { 0.0 };
                PointResponse {
                    energy: 0.5 * stiffness * square,
                    gradient: stretch.map(|s| stiffness * s),
                    hessian: std::array::from_fn(|i| std::array::from_fn(|j| diagonal(i, j))),
                }
            }
            Self::Ground { ground, stiffness, grip } => {
                let mut response = ground.push(*stiffness, at);
                grip.add(*stiffness, ground.friction, at, &mut response);
                response
            }
        }
    }

    /// Renews the normal force that limits friction, from the position `at` within a step. Returns the relative change.
    pub fn renew_limit(&mut self, at: [f64; 3]) -> f64 {
        let Self::Ground { ground, stiffness, grip } = self else { return 0.0 };
        let now = ground.normal_force(*stiffness, at);
        if grip.anchor.is_none() || ground.friction == 0.0 {
            return 0.0;
        }
        let change = (now - grip.normal_force).abs() / now.max(grip.normal_force).max(f64::MIN_POSITIVE);
        grip.normal_force = now;
        change
    }

    /// Ends a step at the position `at`: a point that has slid holds on where it is now, one that has left the ground lets go.
    pub fn settle(&mut self, at: [f64; 3]) {
        if let Self::Ground { ground, stiffness, grip } = self {
            let force = ground.normal_force(*stiffness, at);
            grip.settle(*stiffness, (force, ground.friction), at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn examples() -> Vec<PointPotential> {
        let ground = Ground { height: 0.5, friction: 0.4, stiffness: 1.0 };
        let stuck = Grip { anchor: Some([0.1, 0.2]), normal_force: 100.0 };
        let slipping = Grip { anchor: Some([0.1, 0.2]), normal_force: 0.1 };
        vec![
            PointPotential::Spring { stiffness: 3.0, target: [0.2, -0.1, 0.4] },
            PointPotential::Ground { ground, stiffness: 7.0, grip: stuck },
            PointPotential::Ground { ground, stiffness: 7.0, grip: slipping },
            PointPotential::Ground { ground, stiffness: 7.0, grip: Grip::default() },
        ]
    }

    #[test]
    fn derivatives_are_those_of_the_energy() {
        let step = 1e-5;
        for (potential, z) in examples().into_iter().flat_map(|p| [(p, 0.3), (p, 0.7)]) {
            let at = [0.3, -0.1, z];
            let response = potential.evaluate(at);
            for i in 0..3 {
                let moved = |by: f64| std::array::from_fn(|a| if a == i { at[a] + by } else { at[a] });
                let (above, below) = (potential.evaluate(moved(step)), potential.evaluate(moved(-step)));
                let slope = (above.energy - below.energy) / (2.0 * step);
                assert!((slope - response.gradient[i]).abs() < 1e-8, "{potential:?}: {slope} {response:?}");
                for j in 0..3 {
                    let slope = (above.gradient[j] - below.gradient[j]) / (2.0 * step);
                    assert!((slope - response.hessian[i][j]).abs() < 1e-8, "{potential:?}: {slope} {response:?}");
                }
            }
        }
    }

    #[test]
    fn a_point_that_slides_drags_its_hold_behind_it_at_the_friction_limit() {
        let ground = Ground { height: 0.0, friction: 0.5, stiffness: 1.0 };
        let mut potential = PointPotential::Ground { ground, stiffness: 100.0, grip: Grip::default() };
        potential.settle([0.0, 0.0, -0.01]);
        potential.renew_limit([0.0, 0.0, -0.01]);
        let force = |p: &PointPotential, x: f64| p.evaluate([x, 0.0, -0.01]).gradient[0];
        // The normal force is 1 N: friction holds up to 0.5 N, which a stiffness of 100 N/m reaches after 5 mm.
        assert!((force(&potential, 0.004) - 0.4).abs() < 1e-12);
        assert!((force(&potential, 0.1) - 0.5).abs() < 1e-12);
        potential.settle([0.1, 0.0, -0.01]);
        assert!((force(&potential, 0.1) - 0.5).abs() < 1e-12);
        assert!((force(&potential, 0.095)).abs() < 1e-12);
    }
}
