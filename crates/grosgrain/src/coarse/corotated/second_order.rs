//! 24×24 products of an element's Hessian, compiled for the widest registers.

use super::frame::Columns;
use crate::coarsening::COLUMNS;
use crate::linalg::matrix3::Matrix3;

/// K + Σ_k (n_k ⊗ ω_k + ω_k ⊗ n_k) for the rows n of `side` and ω of `spin`; symmetric bit for bit if K is.
pub(super) fn combined(
    stiffness: &[Columns; COLUMNS],
    side: &[Columns; 3],
    spin: &[Columns; 3],
    sum: &mut [Columns; COLUMNS],
) {
    pulp::Arch::new().dispatch(Combined { stiffness, side, spin, sum });
}

/// Every 3×3 block H replaced by R H Rᵀ, for a symmetric matrix; symmetric bit for bit.
pub(super) fn rotated(rotation: &Matrix3, matrix: &[Columns; COLUMNS]) -> [Columns; COLUMNS] {
    let (mut half, mut result) = ([[0.0; COLUMNS]; COLUMNS], [[0.0; COLUMNS]; COLUMNS]);
    pulp::Arch::new().dispatch(Rotated { rotation, matrix, half: &mut half, result: &mut result });
    result
}

struct Combined<'a> {
    stiffness: &'a [Columns; COLUMNS],
    side: &'a [Columns; 3],
    spin: &'a [Columns; 3],
    sum: &'a mut [Columns; COLUMNS],
}

impl pulp::WithSimd for Combined<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { stiffness, side: [n0, n1, n2], spin: [w0, w1, w2], sum } = self;
        for a in 0..COLUMNS {
            for b in 0..COLUMNS {
                let one = n0[a] * w0[b] + n1[a] * w1[b] + n2[a] * w2[b];
                let other = n0[b] * w0[a] + n1[b] * w1[a] + n2[b] * w2[a];
                sum[a][b] = stiffness[a][b] + (one + other);
            }
        }
    }
}

struct Rotated<'a> {
    rotation: &'a Matrix3,
    matrix: &'a [Columns; COLUMNS],
    half: &'a mut [Columns; COLUMNS],
    result: &'a mut [Columns; COLUMNS],
}

impl pulp::WithSimd for Rotated<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { rotation, matrix, half, result } = self;
        // The transpose of R H, turned once more, is that of R H Rᵀ, which is symmetric.
        turn_rows(rotation, matrix, result);
        for a in 0..COLUMNS {
            for b in 0..COLUMNS {
                half[a][b] = result[b][a];
            }
        }
        turn_rows(rotation, half, result);
        for a in 0..COLUMNS {
            for b in a + 1..COLUMNS {
                result[b][a] = result[a][b];
            }
        }
    }
}

/// Rows 3 i + r of the result are Σ_s R_rs times rows 3 i + s.
#[inline(always)]
fn turn_rows(rotation: &Matrix3, matrix: &[Columns; COLUMNS], result: &mut [Columns; COLUMNS]) {
    for i in (0..COLUMNS).step_by(3) {
        for r in 0..3 {
            let [x, y, z] = rotation[r];
            for b in 0..COLUMNS {
                result[i + r][b] = x * matrix[i][b] + y * matrix[i + 1][b] + z * matrix[i + 2][b];
            }
        }
    }
}
