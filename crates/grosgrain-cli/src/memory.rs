//! Estimates of the memory that a run would need.

use grosgrain::solver::FACTOR_LIMIT;

/// Memory of a sparse Cholesky factorisation \[B\]: 180 n^(4/3) for n unknowns on a three-dimensional grid in nested
/// dissection order. The exponent is that of the factor's entries; the constant fits 604 MB measured for 78,300 unknowns.
pub fn direct(unknowns: usize) -> f64 {
    180.0 * (unknowns as f64).powf(4.0 / 3.0)
}

/// Memory of matrix-free conjugate gradients with multigrid \[B\]: 150 per unknown, all vectors and coarser lattices
/// included; 143 were measured at 6.4 million unknowns.
pub fn iterative(unknowns: usize) -> f64 {
    150.0 * unknowns as f64
}

/// Memory of a 24×24 matrix \[B\].
const CELL_MATRIX: f64 = 8.0 * 576.0;

/// Memory of the steps of a fine model under large deformation \[B\]: one 24×24 matrix per solid cell, another one with stiffness-proportional
/// damping, and the solver: a factor, or beyond [`FACTOR_LIMIT`] unknowns 3.6 kB per node for multigrid.
pub fn fine_steps(solid_cells: usize, nodes: usize, damped: bool) -> f64 {
    let matrices = if damped { 2.0 } else { 1.0 };
    let solver = match 3 * nodes <= FACTOR_LIMIT {
        true => direct(3 * nodes),
        false => 3600.0 * nodes as f64,
    };
    matrices * CELL_MATRIX * solid_cells as f64 + solver
}

/// Memory of a coarse model of a degree and of its steps \[B\]: per element its stiffness, its tangent, another one with stiffness-proportional
/// damping, 3 (d + 1)³ rows of shape functions (24 columns) and of training (6), and a factor.
pub fn coarse_steps(elements: usize, nodes: usize, degree: usize, damped: bool) -> f64 {
    let matrices = if damped { 3.0 } else { 2.0 };
    let rows = 3.0 * ((degree + 1) as f64).powi(3);
    elements as f64 * (matrices * CELL_MATRIX + 8.0 * 30.0 * rows) + direct(3 * nodes)
}

/// Memory of a mesh of simplices in equilibrium or motion \[B\]: 1.7 kB per cell, 1.2 kB more with stiffness-proportional damping, and for tetrahedra a factor.
pub fn simplex_steps(cells: usize, nodes: usize, axes: usize, damped: bool) -> f64 {
    let per_cell = if damped { 2900.0 } else { 1700.0 };
    let factor = if axes == 3 { direct(3 * nodes) } else { 0.0 };
    per_cell * cells as f64 + factor
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_take_a_matrix_per_cell_and_a_solver() {
        // 100,000 cells: 461 MB of matrices, as many again for damping, 3.6 kB per node.
        let [plain, damped] = [false, true].map(|damped| fine_steps(100_000, 110_000, damped));
        assert!(
            (plain - 0.4608e9 - 0.396e9).abs() < 1.0 && (damped - plain - 0.4608e9).abs() < 1.0,
            "{plain} {damped}"
        );
        // 100 elements of degree 3: two matrices of 4608 B, 192 rows of 30 numbers.
        let coarse = coarse_steps(100, 200, 3, false) - direct(600);
        assert!((coarse - 100.0 * (9216.0 + 46_080.0)).abs() < 1e-6, "{coarse}");
    }
}
