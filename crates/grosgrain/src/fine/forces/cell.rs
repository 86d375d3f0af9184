//! Energy, forces and tangent of one cell.

use super::points::{Contraction, CornerVectors, GaussPoints};
use crate::element::CellMatrix;
use crate::linalg::matrix3::determinant;
use crate::material::{PointLaw, Projection, matrix_at};

/// Energy \[J\]; `None` where a Gauss point is inverted. `weight` is the volume of a point times the factor of the moduli.
pub(super) fn energy(points: &GaussPoints, weight: f64, law: &PointLaw, u: &CornerVectors) -> Option<f64> {
    let mut stress = [[[0.0; 8]; 3]; 3];
    Some(weight * law.stress_at_eight(&points.deformation_gradients(u), &mut stress)?)
}

/// Energy \[J\] and forces Σ w P ∇N_a \[N\]; `None` where a Gauss point is inverted.
pub(super) fn forces(
    points: &GaussPoints,
    weight: f64,
    law: &PointLaw,
    u: &CornerVectors,
) -> Option<(f64, CornerVectors)> {
    let mut stress = [[[0.0; 8]; 3]; 3];
    let energy = law.stress_at_eight(&points.deformation_gradients(u), &mut stress)?;
    Some((weight * energy, points.forces(weight, &stress)))
}

/// Writes the tangent \[N/m\]; `None` where a Gauss point is inverted.
pub(super) fn tangent(
    points: &GaussPoints,
    weight: f64,
    (law, projection): (&PointLaw, Projection),
    u: &CornerVectors,
    out: &mut CellMatrix,
) -> Option<()> {
    let mut tangents = [[[0.0; 8]; 9]; 9];
    law.tangent_at_eight(&points.deformation_gradients(u), projection, &mut tangents)?;
    let gradients = &points.gradients;
    pulp::Arch::new().dispatch(Contraction { weight, gradients, tangents: &tangents, out });
    Some(())
}

/// Energy ½ uᵀ K u \[J\] and forces K u \[N\] of a cell with stiffness factor · `reference`.
pub(super) fn linear(factor: f64, reference: &CellMatrix, u: &CornerVectors) -> (f64, CornerVectors) {
    let mut sums = [0.0; 24];
    // K is symmetric, so its rows serve as columns.
    for (row, i) in reference.as_chunks::<24>().0.iter().zip(0..) {
        let scaled = factor * u[i % 3][i / 3];
        sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += scaled * value);
    }
    let forces: CornerVectors = std::array::from_fn(|r| std::array::from_fn(|a| sums[3 * a + r]));
    let energy = 0.5 * (0..24).map(|i| u[i % 3][i / 3] * sums[i]).sum::<f64>();
    (energy, forces)
}

/// The smallest det F over the Gauss points; not a number if one of them is not.
pub(in crate::fine) fn smallest_determinant(points: &GaussPoints, u: &CornerVectors) -> f64 {
    let f = points.deformation_gradients(u);
    let determinants = (0..8).map(|point| determinant(&matrix_at(&f, point)));
    determinants.reduce(|a, b| if a.is_nan() || a < b { a } else { b }).unwrap_or(f64::NAN)
}
