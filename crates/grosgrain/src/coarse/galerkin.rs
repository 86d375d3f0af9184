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
        add_congruence::<COLUMNS, ROWS>(factor, matrix, &local, &mut stiffness);
    }
    let mut result = [0.0; COLUMNS * COLUMNS];
    for (row, column) in (0..COLUMNS * COLUMNS).map(|n| (n / COLUMNS, n % COLUMNS)) {
        result[COLUMNS * row + column] = stiffness[row.min(column)][row.max(column)];
    }
    result
}

/// stiffness += factor Wᵀ K W for a symmetric M×M matrix K (row-major) and M rows W, in the blocks that touch the upper triangle. R divides M: so
/// many rows of K W are summed in registers together.
///
/// # Panics
/// Panics when `matrix` has fewer than M² entries.
pub(super) fn add_congruence<const M: usize, const R: usize>(
    factor: f64,
    matrix: &[f64],
    functions: &[[f64; COLUMNS]; M],
    stiffness: &mut [[f64; COLUMNS]; COLUMNS],
) {
    pulp::Arch::new().dispatch(Congruence::<M, R> { factor, matrix, functions, stiffness });
}

struct Congruence<'a, const M: usize, const R: usize> {
    factor: f64,
    matrix: &'a [f64],
    functions: &'a [[f64; COLUMNS]; M],
    stiffness: &'a mut [[f64; COLUMNS]; COLUMNS],
}

/// Rows whose sums are kept in registers together: enough to hide the latency of multiply-adds.
pub(super) const ROWS: usize = 8;

impl<const M: usize, const R: usize> pulp::WithSimd for Congruence<'_, M, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        const { assert!(M.is_multiple_of(R), "R divides M") };
        let mut forces = [[0.0; COLUMNS]; M];
        let factor = simd.splat_f64s(self.factor);
        for vector in 0..COLUMNS / S::F64_LANES {
            for first in (0..M).step_by(R) {
                let zero = [simd.splat_f64s(0.0); R];
                let entry = |row: usize, m: usize| self.matrix[M * (first + row) + m];
                let sums = add_products(simd, entry, (self.functions, vector), zero);
                for (row, sum) in forces[first..first + R].iter_mut().zip(sums) {
                    S::as_mut_simd_f64s(row).0[vector] = simd.mul_f64s(factor, sum);
                }
            }
        }
        for vector in 0..COLUMNS / S::F64_LANES {
            for first in (0..S::F64_LANES * (vector + 1)).step_by(ROWS) {
                let old: [S::f64s; ROWS] =
                    std::array::from_fn(|row| S::as_simd_f64s(&self.stiffness[first + row]).0[vector]);
                let entry = |row: usize, m: usize| self.functions[m][first + row];
                let sums = add_products(simd, entry, (&forces, vector), old);
                for (row, sum) in self.stiffness[first..first + ROWS].iter_mut().zip(sums) {
                    S::as_mut_simd_f64s(row).0[vector] = sum;
                }
            }
        }
    }
}

/// sums\[row\] + Σ_m left(row, m) right\[m\], for one vector of columns of the right matrix.
#[inline(always)]
fn add_products<S: pulp::Simd, const M: usize, const R: usize>(
    simd: S,
    left: impl Fn(usize, usize) -> f64,
    (right, vector): (&[[f64; COLUMNS]; M], usize),
    mut sums: [S::f64s; R],
) -> [S::f64s; R] {
    for (m, row_of_right) in right.iter().enumerate() {
        let columns = S::as_simd_f64s(row_of_right).0[vector];
        for (row, sum) in sums.iter_mut().enumerate() {
            *sum = simd.mul_add_f64s(simd.splat_f64s(left(row, m)), columns, *sum);
        }
    }
    sums
}
