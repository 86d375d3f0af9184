//! Products with the shape functions of an element, compiled for the widest registers.

use super::frame::Columns;
use crate::coarsening::COLUMNS;
use crate::element::CellMatrix;

/// u = W v for the rows W of `functions`.
///
/// # Panics
/// Panics when there are not 24 functions per entry of `u`.
pub(super) fn prolong(functions: &[f64], v: &Columns, u: &mut [f64]) {
    assert_eq!(functions.len(), COLUMNS * u.len(), "one row per entry");
    pulp::Arch::new().dispatch(Prolong { functions: functions.as_chunks().0, v, u });
}

/// g += Wᵀ f.
///
/// # Panics
/// Panics when there are not 24 functions per entry of `f`.
pub(super) fn add_restricted(functions: &[f64], f: &[f64], g: &mut Columns) {
    assert_eq!(functions.len(), COLUMNS * f.len(), "one row per entry");
    pulp::Arch::new().dispatch(Restrict { functions: functions.as_chunks().0, f, g });
}

/// M, rows 3 i + j: the map from v to the displacement gradient Σ_a (W v)_a,i ∂N_a/∂X_j. `rows` are the 24 rows of W at the corners of a fine cell.
pub(super) fn gradient_map(rows: &[Columns; COLUMNS], gradients: &[[f64; 8]; 3]) -> [Columns; 9] {
    let mut map = [[0.0; COLUMNS]; 9];
    pulp::Arch::new().dispatch(GradientMap { rows, gradients, map: &mut map });
    map
}

/// g += K v for a symmetric K; returns ½ v·K v.
pub(super) fn add_quadratic(matrix: &CellMatrix, v: &Columns, g: &mut Columns) -> f64 {
    pulp::Arch::new().dispatch(Quadratic { matrix: matrix.as_chunks().0, v, g })
}

struct Quadratic<'a> {
    matrix: &'a [Columns],
    v: &'a Columns,
    g: &'a mut Columns,
}

impl pulp::WithSimd for Quadratic<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> f64 {
        let Self { matrix, v, g } = self;
        let mut product = [0.0; COLUMNS];
        // Columns instead of rows, because K is symmetric: so the sums run over vectors.
        for (column, v) in matrix.iter().zip(v) {
            for n in 0..COLUMNS {
                product[n] += column[n] * v;
            }
        }
        let mut work = 0.0;
        for n in 0..COLUMNS {
            g[n] += product[n];
            work += product[n] * v[n];
        }
        0.5 * work
    }
}

struct Prolong<'a> {
    functions: &'a [Columns],
    v: &'a Columns,
    u: &'a mut [f64],
}

impl pulp::WithSimd for Prolong<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let v = S::as_simd_f64s(self.v).0;
        for (row, u) in self.functions.iter().zip(self.u) {
            let mut sum = simd.splat_f64s(0.0);
            for (w, v) in S::as_simd_f64s(row).0.iter().zip(v) {
                sum = simd.mul_add_f64s(*w, *v, sum);
            }
            *u = simd.reduce_sum_f64s(sum);
        }
    }
}

struct Restrict<'a> {
    functions: &'a [Columns],
    f: &'a [f64],
    g: &'a mut Columns,
}

impl pulp::WithSimd for Restrict<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        for (row, f) in self.functions.iter().zip(self.f) {
            let f = simd.splat_f64s(*f);
            for (g, w) in S::as_mut_simd_f64s(self.g).0.iter_mut().zip(S::as_simd_f64s(row).0) {
                *g = simd.mul_add_f64s(f, *w, *g);
            }
        }
    }
}

struct GradientMap<'a> {
    rows: &'a [Columns; COLUMNS],
    gradients: &'a [[f64; 8]; 3],
    map: &'a mut [Columns; 9],
}

impl pulp::WithSimd for GradientMap<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        for vector in 0..COLUMNS / S::F64_LANES {
            let mut sums = [simd.splat_f64s(0.0); 9];
            for a in 0..8 {
                for j in 0..3 {
                    // Not in a closure, which would be compiled without the wide instructions.
                    let slope = simd.splat_f64s(self.gradients[j][a]);
                    for i in 0..3 {
                        let row = S::as_simd_f64s(&self.rows[3 * a + i]).0[vector];
                        sums[3 * i + j] = simd.mul_add_f64s(slope, row, sums[3 * i + j]);
                    }
                }
            }
            for (row, sum) in self.map.iter_mut().zip(sums) {
                S::as_mut_simd_f64s(row).0[vector] = sum;
            }
        }
    }
}
