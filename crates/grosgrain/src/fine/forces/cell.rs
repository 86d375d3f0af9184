//! Energy, forces and tangent of one cell.

use super::points::{Contraction, CornerVectors, Gradients, add_forces, deformation_gradient};
use crate::element::CellMatrix;
use crate::linalg::matrix3::determinant;
use crate::material::{PointLaw, Projection};

/// Energy \[J\]; `None` where a Gauss point is inverted. `weight` is the volume of a point times the factor of the moduli.
pub(super) fn energy(points: &[Gradients; 8], weight: f64, law: &PointLaw, u: &CornerVectors) -> Option<f64> {
    let mut sum = 0.0;
    for gradients in points {
        sum += law.energy(&deformation_gradient(gradients, u))?;
    }
    Some(weight * sum)
}

/// Energy \[J\] and forces Σ w P ∇N_a \[N\]; `None` where a Gauss point is inverted.
pub(super) fn forces(
    points: &[Gradients; 8],
    weight: f64,
    law: &PointLaw,
    u: &CornerVectors,
) -> Option<(f64, CornerVectors)> {
    let (mut sum, mut forces) = (0.0, [[0.0; 8]; 3]);
    for gradients in points {
        let (energy, stress) = law.stress(&deformation_gradient(gradients, u))?;
        sum += energy;
        add_forces(weight, &stress, gradients, &mut forces);
    }
    Some((weight * sum, forces))
}

/// Writes the tangent \[N/m\]; `None` where a Gauss point is inverted.
pub(super) fn tangent(
    points: &[Gradients; 8],
    weight: f64,
    law: &PointLaw,
    projection: Projection,
    u: &CornerVectors,
    out: &mut CellMatrix,
) -> Option<()> {
    let mut tangents = [[[0.0; 9]; 9]; 8];
    for (tangent, gradients) in tangents.iter_mut().zip(points) {
        *tangent = law.tangent(&deformation_gradient(gradients, u), projection)?.2;
    }
    pulp::Arch::new().dispatch(Contraction { weight, points, tangents: &tangents, out });
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
pub(super) fn smallest_determinant(points: &[Gradients; 8], u: &CornerVectors) -> f64 {
    let determinants = points.iter().map(|gradients| determinant(&deformation_gradient(gradients, u)));
    determinants.reduce(|a, b| if a.is_nan() || a < b { a } else { b }).unwrap_or(f64::NAN)
}
