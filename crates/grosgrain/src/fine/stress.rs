//! Stresses at the centres of fine cells.

use super::FineModel;
use super::forces::{
    GaussPoints, corner_displacements, deformation_gradient, gradients_at, smallest_determinant as smallest_of,
};
use crate::element::Hex8;
use crate::linalg::matrix3::{determinant, product, transposed};
use crate::material::{Law, PointLaw};
use crate::mesh::Cell;

/// Entries of a symmetric tensor in Voigt order.
const VOIGT: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];

/// Stress at the centre of every fine cell \[Pa\], Voigt order xx, yy, zz, yz, xz, xy: σ = C B(½, ½, ½) u; zero in voids.
pub fn centre_stresses(model: &FineModel, displacement: &[f64]) -> Vec<[f64; 6]> {
    let lattice = model.grid().lattice;
    let strain_matrix = Hex8::new(model.grid().spacing).strain_matrix([0.5; 3]);
    let stress = |cell: usize| {
        let Some(tensor) = model.elasticity(Cell(cell)) else { return [0.0; 6] };
        let corners = lattice.corners(Cell(cell));
        let u: [f64; 24] = std::array::from_fn(|i| displacement[3 * corners[i / 3].0 + i % 3]);
        let strain: [f64; 6] = std::array::from_fn(|m| (0..24).map(|i| strain_matrix[m][i] * u[i]).sum());
        std::array::from_fn(|i| (0..6).map(|m| tensor.voigt()[i][m] * strain[m]).sum())
    };
    (0..lattice.cell_count()).map(stress).collect()
}

/// Cauchy stress P Fᵀ / J at the centre of every fine cell \[Pa\], Voigt order; zero in voids, not a number where the centre
/// is inverted. Cells of [`Law::Linear`] have the stress that [`centre_stresses`] gives.
pub fn cauchy_stresses(model: &FineModel, displacement: &[f64]) -> Vec<[f64; 6]> {
    let lattice = model.grid().lattice;
    let gradients = gradients_at(model.grid().spacing, [0.5; 3]);
    let mut stresses = centre_stresses(model, displacement);
    for (cell, stress) in stresses.iter_mut().enumerate().map(|(c, stress)| (Cell(c), stress)) {
        let Some((_, material)) = model.materials.get(usize::from(model.material_of[cell.0])) else { continue };
        if material.law == Law::Linear {
            continue;
        }
        let f = deformation_gradient(&gradients, &corner_displacements(lattice, cell, displacement));
        let (volume, law) = (determinant(&f), PointLaw::of(material, model.factors[cell.0]));
        *stress = match law.stress(&f).filter(|_| volume > 0.0) {
            None => [f64::NAN; 6],
            Some((_, first)) => {
                let kirchhoff = product(&first, &transposed(&f));
                VOIGT.map(|(i, j)| 0.5 * (kirchhoff[i][j] + kirchhoff[j][i]) / volume)
            }
        };
    }
    stresses
}

/// The solid cell with the smallest det F over its Gauss points, the first of equals, and that determinant. One is undeformed,
/// and a cell is inverted where it is not positive.
pub fn smallest_determinant(model: &FineModel, displacement: &[f64]) -> (Cell, f64) {
    let lattice = model.grid().lattice;
    let points = GaussPoints::new(model.grid().spacing);
    let mut smallest = (Cell(0), f64::INFINITY);
    for cell in (0..lattice.cell_count()).map(Cell).filter(|cell| !model.is_void(*cell)) {
        let least = smallest_of(&points, &corner_displacements(lattice, cell, displacement));
        if least < smallest.1 {
            smallest = (cell, least);
        }
    }
    smallest
}

/// Von Mises stress √(½ ((σxx−σyy)² + (σyy−σzz)² + (σzz−σxx)²) + 3 (σyz² + σxz² + σxy²)) \[Pa\] of a stress in Voigt order.
pub fn von_mises(stress: &[f64; 6]) -> f64 {
    let [xx, yy, zz, yz, xz, xy] = *stress;
    let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (0.5 * normal + 3.0 * (yz * yz + xz * xz + xy * xy)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn von_mises_of_uniaxial_pressure_and_shear() {
        assert!((von_mises(&[-3.0, 0.0, 0.0, 0.0, 0.0, 0.0]) - 3.0).abs() < 1e-15);
        assert!(von_mises(&[2.0, 2.0, 2.0, 0.0, 0.0, 0.0]) < 1e-15);
        assert!((von_mises(&[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]) - 3f64.sqrt()).abs() < 1e-15);
    }
}
