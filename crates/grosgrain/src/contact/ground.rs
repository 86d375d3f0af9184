//! A horizontal ground.

use super::PointResponse;

/// The half-space z < `height`, which pushes points out of it: ψ = ½ k max(0, height − z)² at a point of stiffness k.
///
/// A penalty, not a barrier: a body rests as deep in the ground as its weight needs. With the default stiffness, Young's modulus per
/// fine cell, that is a strain of the order of pressure over modulus in one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// z of the surface \[m\].
    pub height: f64,
    /// Coulomb's coefficient of friction.
    pub friction: f64,
    /// Pressure per depth \[Pa/m\].
    pub stiffness: f64,
}

impl Ground {
    /// The normal force \[N\] on a point of this stiffness.
    pub fn normal_force(&self, stiffness: f64, at: [f64; 3]) -> f64 {
        stiffness * (self.height - at[2]).max(0.0)
    }

    /// The potential of the normal force.
    pub(super) fn push(&self, stiffness: f64, at: [f64; 3]) -> PointResponse {
        let mut response = PointResponse::default();
        let depth = self.height - at[2];
        if depth > 0.0 {
            response.energy = 0.5 * stiffness * depth * depth;
            response.gradient[2] = -stiffness * depth;
            response.hessian[2][2] = stiffness;
        }
        response
    }
}
