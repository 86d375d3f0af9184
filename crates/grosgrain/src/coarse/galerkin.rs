//! K̄ = Σ_e W_eᵀ K_e W_e of one coarse cell.

use crate::assembly::CellStiffness;
use crate::coarsening::COLUMNS;
use crate::element::CellMatrix;
use crate::mesh::Cell;

/// Galerkin stiffness \[N/m\] of a coarse cell with shape functions W (`3 (d + 1)³ × 24`, row-major) over its fine `cells`.
///
/// Symmetric bit for bit; rigid motions carry no force up to rounding, because W reproduces them.
pub fn galerkin_stiffness(cells: &dyn CellStiffness, functions: &[f64]) -> CellMatrix {
    let lattice = cells.lattice();
    let mut stiffness = [[0.0; COLUMNS]; COLUMNS];
    let mut local = [[0.0; COLUMNS]; COLUMNS];
    for cell in 0..lattice.cell_count() {
        let Some((factor, matrix)) = cells.stiffness(cell) else { continue };
        for (a, node) in lattice.corners(Cell(cell)).iter().enumerate() {
            for r in 0..3 {
                local[3 * a + r].copy_from_slice(&functions[(3 * node.0 + r) * COLUMNS..][..COLUMNS]);
            }
        }
        pulp::Arch::new().dispatch(Congruence { factor, matrix, functions: &local, stiffness: &mut stiffness });
    }
    let mut result = [0.0; COLUMNS * COLUMNS];
    for (row, column) in (0..COLUMNS * COLUMNS).map(|n| (n / COLUMNS, n % COLUMNS)) {
        result[COLUMNS * row + column] = 0.5 * (stiffness[row][column] + stiffness[column][row]);
    }
    result
}

/// stiffness += factor Wᵀ K W for 24×24 matrices.
struct Congruence<'a> {
    factor: f64,
    matrix: &'a CellMatrix,
    functions: &'a [[f64; COLUMNS]; COLUMNS],
    stiffness: &'a mut [[f64; COLUMNS]; COLUMNS],
}

impl pulp::NullaryFnOnce for Congruence<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for row in 0..COLUMNS {
            let mut product = [0.0; COLUMNS];
            for m in 0..COLUMNS {
                add_scaled(&mut product, self.factor * self.matrix[COLUMNS * row + m], &self.functions[m]);
            }
            for c in 0..COLUMNS {
                add_scaled(&mut self.stiffness[c], self.functions[row][c], &product);
            }
        }
    }
}

#[inline(always)]
fn add_scaled(sum: &mut [f64; COLUMNS], factor: f64, row: &[f64; COLUMNS]) {
    for c in 0..COLUMNS {
        sum[c] = factor.mul_add(row[c], sum[c]);
    }
}
