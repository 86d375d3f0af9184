//! The velocity of a body that moves as a whole.

use crate::fine::FineModel;
use crate::linalg::matrix3::cross;
use crate::mesh::Cell;

/// Velocity of a body that flies and spins: v(X) = v + ω × (X − c).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigidVelocity {
    /// v \[m/s\].
    pub velocity: [f64; 3],
    /// ω \[rad/s\], right-handed.
    pub spin: [f64; 3],
    /// c \[m\], the point that moves with v.
    pub centre: [f64; 3],
}

impl RigidVelocity {
    /// Velocity \[m/s\] of the point at `position`.
    pub fn at(&self, position: [f64; 3]) -> [f64; 3] {
        let around = cross(&self.spin, &[0, 1, 2].map(|r| position[r] - self.centre[r]));
        [0, 1, 2].map(|r| self.velocity[r] + around[r])
    }
}

/// The centre of mass \[m\] of the undeformed body; `None` if it has no mass. Masses lumped at the corners of the cells have the same.
pub fn centre_of_mass(model: &FineModel) -> Option<[f64; 3]> {
    let grid = model.grid();
    let (mut mass, mut moment) = (0.0, [0.0; 3]);
    for cell in (0..grid.lattice.cell_count()).map(Cell) {
        let (own, centre) = (model.cell_mass(cell), grid.centre(grid.lattice.cell_position(cell)));
        mass += own;
        (0..3).for_each(|r| moment[r] += own * centre[r]);
    }
    (mass > 0.0).then(|| moment.map(|m| m / mass))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
    use crate::mesh::{Label, Node, VoxelGrid};

    /// 4 × 2 × 2 cells of unequal edges: heavy where i < 1, void at one corner.
    fn model() -> FineModel {
        let mut grid = VoxelGrid::uniform([4, 2, 2], [0.1, 0.2, 0.3], Label(1));
        for c in (0..16).step_by(4) {
            grid.labels[c] = Label(2);
        }
        grid.void[15] = true;
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(1e5, 0.3).unwrap());
        let mut materials = MaterialTable::new();
        materials.insert(Label(1), Material::linear("light", elasticity, 500.0));
        materials.insert(Label(2), Material::linear("heavy", elasticity, 3000.0));
        FineModel::new(grid, &materials).unwrap()
    }

    #[test]
    fn the_centre_of_mass_balances_the_body() {
        let centre = centre_of_mass(&model()).unwrap();
        // Per cell volume: 4 heavy cells at x = 0.05, and light ones, 4 at 0.15, 4 at 0.25, 3 at 0.35.
        let mass = 4.0 * 3000.0 + 11.0 * 500.0;
        let x = (4.0 * 3000.0 * 0.05 + 500.0 * (4.0 * 0.15 + 4.0 * 0.25 + 3.0 * 0.35)) / mass;
        // Without the void the rest is symmetric about the middle; the missing cell is half an edge off.
        let off = 500.0 * 0.5 / mass;
        let expected = [x, 0.2 - 0.2 * off, 0.3 - 0.3 * off];
        assert!((0..3).all(|r| (centre[r] - expected[r]).abs() < 1e-15), "{centre:?} instead of {expected:?}");
    }

    #[test]
    fn a_spin_about_the_centre_of_mass_has_no_momentum() {
        let model = model();
        let centre = centre_of_mass(&model).unwrap();
        let motion = RigidVelocity { velocity: [1.0, -2.0, 0.5], spin: [3.0, 1.0, -2.0], centre };
        let (grid, mut momentum) = (model.grid(), [0.0; 3]);
        for cell in (0..16).map(Cell) {
            for Node(node) in grid.lattice.corners(cell) {
                let velocity = motion.at(model.node_position(Node(node)));
                (0..3).for_each(|r| momentum[r] += model.cell_mass(cell) / 8.0 * velocity[r]);
            }
        }
        let expected = motion.velocity.map(|v| model.mass() * v);
        assert!((0..3).all(|r| (momentum[r] - expected[r]).abs() < 1e-12 * model.mass()), "{momentum:?}, {expected:?}");
    }

    #[test]
    fn a_spin_turns_by_the_right_hand_and_keeps_distances() {
        let motion = RigidVelocity { spin: [0.0, 0.0, 2.0], centre: [1.0, 0.0, 0.0], ..RigidVelocity::default() };
        assert_eq!(motion.at([1.5, 0.0, 4.0]), [0.0, 1.0, 0.0]);
        let (a, b) = ([0.3, 0.2, 0.9], [-0.4, 0.7, 0.1]);
        let motion = RigidVelocity { velocity: [1.0, 2.0, 3.0], spin: [0.5, -1.5, 2.5], ..motion };
        let rate: f64 = (0..3).map(|r| (a[r] - b[r]) * (motion.at(a)[r] - motion.at(b)[r])).sum();
        assert!(rate.abs() < 1e-15, "{rate}");
    }
}
