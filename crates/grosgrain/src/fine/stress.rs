//! Stresses at the centres of fine cells.

use super::FineModel;
use crate::element::Hex8;
use crate::mesh::Cell;

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
