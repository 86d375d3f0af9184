//! One cell of the fine model, for models that move its corners in their own way.

use super::cell;
use super::points::{GaussPoints, Gradients, deformation_gradient, gradients_at};
use crate::element::CellMatrix;
use crate::linalg::matrix3::Matrix3;
use crate::material::{PointLaw, Projection};

/// Displacements \[m\] or forces \[N\] of a cell's corners, `[component][corner]`.
pub(crate) type CellVectors = [[f64; 8]; 3];

/// The Gauss points and the centre of the cells of a lattice.
#[derive(Clone, Debug)]
pub(crate) struct SingleCell {
    points: GaussPoints,
    centre: Gradients,
    volume: f64,
}

impl SingleCell {
    /// Cells with edge lengths `spacing` \[m\].
    pub fn new(spacing: [f64; 3]) -> Self {
        let volume = spacing.iter().product();
        Self { points: GaussPoints::new(spacing), centre: gradients_at(spacing, [0.5; 3]), volume }
    }

    /// Volume \[m³\].
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Energy \[J\] with eight points; `None` where one is inverted. `factor` multiplies the moduli of the law.
    pub fn energy(&self, factor: f64, law: &PointLaw, u: &CellVectors) -> Option<f64> {
        cell::energy(&self.points, factor * self.volume / 8.0, law, u)
    }

    /// Energy \[J\] and its gradient \[N\] with eight points; `None` where one is inverted.
    pub fn forces(&self, factor: f64, law: &PointLaw, u: &CellVectors) -> Option<(f64, CellVectors)> {
        cell::forces(&self.points, factor * self.volume / 8.0, law, u)
    }

    /// Writes the Hessian \[N/m\] with eight points; `None` where one is inverted.
    pub fn tangent(
        &self,
        factor: f64,
        law: (&PointLaw, Projection),
        u: &CellVectors,
        out: &mut CellMatrix,
    ) -> Option<()> {
        cell::tangent(&self.points, factor * self.volume / 8.0, law, u, out)
    }

    /// The smallest det F over the eight points.
    pub fn smallest_determinant(&self, u: &CellVectors) -> f64 {
        cell::smallest_determinant(&self.points, u)
    }

    /// Energy ½ u·K u \[J\] and forces K u \[N\] with K = `factor` · `stiffness`.
    pub fn linear(factor: f64, stiffness: &CellMatrix, u: &CellVectors) -> (f64, CellVectors) {
        cell::linear(factor, stiffness, u)
    }

    /// ∂N_a/∂X_l at the centre \[1/m\], `[l][corner a]`.
    pub fn centre(&self) -> &[[f64; 8]; 3] {
        &self.centre
    }

    /// F at the centre.
    pub fn centre_gradient(&self, u: &CellVectors) -> Matrix3 {
        deformation_gradient(&self.centre, u)
    }

    /// What a stress at the centre adds to the forces of the corners: `factor` V P ∇N_a.
    pub fn centre_forces(&self, factor: f64, stress: &Matrix3) -> CellVectors {
        let weight = factor * self.volume;
        let force = |i: usize, a: usize| (0..3).map(|j| stress[i][j] * self.centre[j][a]).sum::<f64>();
        std::array::from_fn(|i| std::array::from_fn(|a| weight * force(i, a)))
    }
}
