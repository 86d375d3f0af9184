//! The stiffness of one cell.

use crate::simplex::{MandelTensor, SimplexMesh, mandel_strain};

/// V Bᵀ C B \[N/m\] of a cell with linear displacement: unknown d n + k is component k of corner n, 12 × 12 in three dimensions, zeros beyond.
pub fn cell_stiffness(mesh: &SimplexMesh, cell: usize, tensor: &MandelTensor) -> [[f64; 12]; 12] {
    let (dimension, measure) = (mesh.dimension(), mesh.measure(cell));
    let (axes, strains) = (dimension.axes(), dimension.strains());
    let unknowns = axes * dimension.corners();
    let gradients = mesh.gradients(cell);
    let (mut strain, mut stress) = ([[0.0; 6]; 12], [[0.0; 6]; 12]);
    for unknown in 0..unknowns {
        let mut gradient = [[0.0; 3]; 3];
        gradient[unknown % axes] = gradients[unknown / axes];
        strain[unknown] = mandel_strain(dimension, &gradient);
        for row in 0..strains {
            let product: f64 = (0..strains).map(|c| tensor.matrix[row][c] * strain[unknown][c]).sum();
            stress[unknown][row] = measure * product;
        }
    }
    let mut stiffness = [[0.0; 12]; 12];
    for (i, j) in (0..unknowns).flat_map(|i| (0..unknowns).map(move |j| (i, j))) {
        stiffness[i][j] = (0..strains).map(|c| strain[i][c] * stress[j][c]).sum();
    }
    stiffness
}
