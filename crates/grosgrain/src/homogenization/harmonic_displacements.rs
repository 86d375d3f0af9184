//! Harmonic displacements at the nodes of a mesh, and their strains.

use std::f64::consts::SQRT_2;

use crate::simplex::{SimplexMesh, mandel_strain};

/// Displacements h_αβ \[m\] of the nodes under unit stresses \[1 Pa\] on the outer boundary (`kharevych2009numerical`, eq. 6): div(C : ε(h_αβ)) = 0 inside, traction
/// σ_αβ n outside, with σ_αβ = ½ (e_α ⊗ e_β + e_β ⊗ e_α).
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicDisplacements {
    /// `fields[node][k][n]`: component k of h_αβ at a node, where n counts αβ in the order xx | xx, yy, xy | xx, yy, zz, yz, xz, xy of the dimension. Entries beyond the
    /// dimension are zero.
    pub fields: Vec<[[f64; 6]; 3]>,
}

impl HarmonicDisplacements {
    /// The Mandel matrix G \[1/Pa\] of sym ∇H in a cell, G_klαβ = ½ (H_kαβ,l + H_lαβ,k), n × n with zeros beyond.
    ///
    /// Column αβ is √2 times the Mandel vector of ε(h_αβ) for a shear α ≠ β, and that vector itself otherwise: a shear σ_αβ is 1/√2 of a unit
    /// Mandel vector, so that G maps Mandel stresses of the boundary to strains. A homogeneous body has G = C⁻¹ as Mandel matrices, in every cell.
    pub fn mollifier(&self, mesh: &SimplexMesh, cell: usize) -> [[f64; 6]; 6] {
        let corners: [[[f64; 6]; 3]; 4] = std::array::from_fn(|n| match mesh.cell(cell).get(n) {
            Some(node) => self.fields[*node as usize],
            None => [[0.0; 6]; 3],
        });
        mollifier_of(mesh, cell, &corners)
    }
}

/// The matrix of [`HarmonicDisplacements::mollifier`] for fields given at the corners of a cell.
pub fn mollifier_of(mesh: &SimplexMesh, cell: usize, corners: &[[[f64; 6]; 3]; 4]) -> [[f64; 6]; 6] {
    let (gradients, dimension) = (mesh.gradients(cell), mesh.dimension());
    let mut matrix = [[0.0; 6]; 6];
    for column in 0..dimension.strains() {
        let derivative = |k: usize, l: usize| (0..4).map(|n| corners[n][k][column] * gradients[n][l]).sum();
        let strain = mandel_strain(dimension, &std::array::from_fn(|k| std::array::from_fn(|l| derivative(k, l))));
        let weight = if column < dimension.axes() { 1.0 } else { SQRT_2 };
        (0..6).for_each(|row| matrix[row][column] = weight * strain[row]);
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simplex::Dimension;

    /// Which pair of axes a column stands for.
    fn axes_of(dimension: Dimension, column: usize) -> (usize, usize) {
        match dimension {
            Dimension::Two => [(0, 0), (1, 1), (0, 1)][column],
            _ => [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)][column],
        }
    }

    #[test]
    fn displacements_that_are_unit_stresses_times_place_have_the_unit_mollifier() {
        // With C = 1 the strain is the stress: h_αβ = σ_αβ x, and G = C⁻¹ = 1.
        let nodes = [[0.1, 0.2, 0.0], [1.3, -0.1, 0.4], [0.2, 1.1, -0.3], [0.3, 0.4, 1.2]];
        for dimension in [Dimension::One, Dimension::Two, Dimension::Three] {
            let axes = dimension.axes();
            let nodes: Vec<[f64; 3]> =
                nodes.iter().map(|x| std::array::from_fn(|r| if r < axes { x[r] } else { 0.0 })).collect();
            let field = |x: &[f64; 3]| {
                let mut field = [[0.0; 6]; 3];
                for column in 0..dimension.strains() {
                    let (a, b) = axes_of(dimension, column);
                    field[a][column] += 0.5 * x[b];
                    field[b][column] += 0.5 * x[a];
                }
                field
            };
            let harmonic = HarmonicDisplacements { fields: nodes.iter().map(field).collect() };
            let mesh = SimplexMesh::new(dimension, nodes, vec![[0, 1, 2, 3]], vec![0]).unwrap();
            let found = harmonic.mollifier(&mesh, 0);
            for (row, column) in (0..6).flat_map(|r| (0..6).map(move |c| (r, c))) {
                let expected = f64::from(row == column && row < dimension.strains());
                assert!((found[row][column] - expected).abs() < 1e-14, "{dimension}: {found:?}");
            }
        }
    }
}
