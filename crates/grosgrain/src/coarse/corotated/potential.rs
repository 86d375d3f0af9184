//! Energies of points that move with the elements.

use crate::linalg::matrix3::Matrix3;

/// The potential energy of a point at a place in space: a spring, a wall.
pub trait Potential: Sync {
    /// Energy \[J\], gradient \[N\] and Hessian \[N/m\] at `at` \[m\], in the axes of the body frame. The Hessian must be symmetric, and positive
    /// semidefinite for tangents to be.
    fn evaluate(&self, at: [f64; 3]) -> (f64, [f64; 3], Matrix3);
}

/// The potential of no point at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoPotential {}

impl Potential for NoPotential {
    fn evaluate(&self, _: [f64; 3]) -> (f64, [f64; 3], Matrix3) {
        match *self {}
    }
}

/// For a model without embedded points.
pub const NO_POTENTIALS: &[NoPotential] = &[];
