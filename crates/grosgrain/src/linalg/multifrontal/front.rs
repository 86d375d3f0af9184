//! Elimination of the leading columns of one dense front.
//!
//! Column-major lower triangle with a stride that is a multiple of 24. Finished columns are also packed, row tile by row tile,
//! into a panel from which all updates read: 24 × 8 entries are held in registers while the products of a run of pivots are subtracted.

use super::plan::{STRIP, TILE};

/// Pivots that are eliminated before their products are subtracted from the columns after them: a tile of so many columns of the panel stays in the first
/// cache, and those of all rows in the second.
const DEPTH: usize = 128;
/// A pivot below this share of the unknown's assembled diagonal is a motion without stiffness. Rounding leaves about 1e-14, the softest part that
/// is told apart is 1e-12 of what it hangs on.
pub(super) const VANISHING: f64 = 1e-12;

/// A front, ready to be eliminated.
pub(super) struct Elimination<'a> {
    /// Column-major, `stride` rows per column, lower triangle.
    pub front: &'a mut [f64],
    /// Packed finished columns: per tile `padded` columns of 24 rows.
    pub panel: &'a mut [f64],
    pub stride: usize,
    /// Rows that mean something: columns and extra rows.
    pub rows: usize,
    /// Pivots, and the same rounded up to strips.
    pub pivots: usize,
    pub padded: usize,
    /// All columns, and the same rounded up to strips.
    pub padded_columns: usize,
    /// Assembled diagonal of the pivots, against which a vanishing pivot is measured.
    pub scale: &'a [f64],
    /// Reciprocals of the diagonal of the factor; zero for a skipped pivot.
    pub inverse: &'a mut [f64],
    /// Counts skipped pivots.
    pub skipped: &'a mut usize,
}

impl pulp::WithSimd for Elimination<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, simd: S) {
        let tiles = self.stride / TILE;
        for start in (0..self.padded).step_by(DEPTH) {
            let end = (start + DEPTH).min(self.padded);
            for strip in (start..end).step_by(STRIP) {
                for tile in strip / TILE..tiles {
                    self.subtract(simd, tile, strip, start..strip);
                }
                let triangle = self.factor_diagonal(strip);
                for tile in strip / TILE..tiles {
                    self.divide(simd, tile, strip, &triangle);
                }
            }
            for tile in end / TILE..tiles {
                for strip in (end..(TILE * (tile + 1)).min(self.padded_columns)).step_by(STRIP) {
                    self.subtract(simd, tile, strip, start..end.min(self.pivots));
                }
            }
        }
    }
}

impl Elimination<'_> {
    /// Subtracts the products of the finished columns `depth` from the rows of a tile in a strip of columns, those above the diagonal and
    /// beyond the last left out.
    #[inline(always)]
    fn subtract<S: pulp::Simd>(&mut self, simd: S, tile: usize, strip: usize, depth: std::ops::Range<usize>) {
        if depth.is_empty() {
            return;
        }
        let first = strip.saturating_sub(TILE * tile);
        let last = (self.rows - TILE * tile).min(TILE);
        // Eight lanes: 24 accumulators of 32 registers. Four lanes: 12 of 16.
        match (S::F64_LANES, (last - first).div_ceil(STRIP)) {
            (8, 3) => self.subtract_block::<S, 3, 8>(simd, (tile, first), (strip, 0), depth),
            (8, 2) => self.subtract_block::<S, 2, 8>(simd, (tile, first), (strip, 0), depth),
            (8, _) => self.subtract_block::<S, 1, 8>(simd, (tile, first), (strip, 0), depth),
            (4, _) => {
                for rows in [0, 12].into_iter().filter(|r| r + 12 > first && *r < last) {
                    self.subtract_block::<S, 3, 4>(simd, (tile, rows), (strip, 0), depth.clone());
                    self.subtract_block::<S, 3, 4>(simd, (tile, rows), (strip, 4), depth.clone());
                }
            }
            (lanes, _) => {
                for rows in (0..TILE).step_by(2 * lanes) {
                    for columns in (0..STRIP).step_by(4) {
                        self.subtract_block::<S, 2, 4>(simd, (tile, rows), (strip, columns), depth.clone());
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn subtract_block<S: pulp::Simd, const V: usize, const C: usize>(
        &mut self,
        simd: S,
        (tile, row): (usize, usize),
        (strip, column): (usize, usize),
        depth: std::ops::Range<usize>,
    ) {
        let size = TILE * self.padded;
        let part = TILE * depth.start..TILE * depth.end;
        let (left, _) = self.panel[size * tile..][part.clone()].as_chunks::<TILE>();
        let (right, _) = self.panel[size * (strip / TILE)..][part].as_chunks::<STRIP>();
        let offset = strip % TILE / STRIP;
        let mut sums = [[simd.splat_f64s(0.0); V]; C];
        for (l, r) in left.iter().zip(right[offset..].iter().step_by(TILE / STRIP)) {
            let rows = S::as_simd_f64s(&l[row..row + V * S::F64_LANES]).0;
            let rows: [S::f64s; V] = std::array::from_fn(|v| rows[v]);
            for (c, sum) in sums.iter_mut().enumerate() {
                let factor = simd.splat_f64s(r[column + c]);
                for (s, x) in sum.iter_mut().zip(rows) {
                    *s = simd.mul_add_f64s(factor, x, *s);
                }
            }
        }
        for (c, sum) in sums.iter().enumerate() {
            let start = (strip + column + c) * self.stride + TILE * tile + row;
            let target = S::as_mut_simd_f64s(&mut self.front[start..start + V * S::F64_LANES]).0;
            for (t, s) in target.iter_mut().zip(sum) {
                *t = simd.sub_f64s(*t, *s);
            }
        }
    }

    /// Cholesky factor of the 8 × 8 diagonal block: columns of the triangle below the diagonal; sets the reciprocals.
    #[inline(always)]
    fn factor_diagonal(&mut self, strip: usize) -> [[f64; STRIP]; STRIP] {
        let mut block = [[0.0; STRIP]; STRIP];
        for (c, column) in block.iter_mut().enumerate() {
            column.copy_from_slice(&self.front[(strip + c) * self.stride + strip..][..STRIP]);
        }
        for c in 0..STRIP {
            let pivot = block[c][c];
            let padding = strip + c >= self.pivots;
            let vanishes = padding || pivot <= VANISHING * self.scale[strip + c];
            *self.skipped += usize::from(vanishes && !padding);
            let inverse = if vanishes { 0.0 } else { 1.0 / pivot.sqrt() };
            self.inverse[strip + c] = inverse;
            block[c].iter_mut().for_each(|x| *x *= inverse);
            let (done, rest) = block.split_at_mut(c + 1);
            for (later, column) in rest.iter_mut().enumerate() {
                let factor = done[c][c + 1 + later];
                (c + 1 + later..STRIP).for_each(|r| column[r] -= factor * done[c][r]);
            }
        }
        block
    }

    /// Solves X L^T = A for a tile of rows of the strip, in place, and packs X into the panel.
    #[inline(always)]
    fn divide<S: pulp::Simd>(&mut self, simd: S, tile: usize, strip: usize, triangle: &[[f64; STRIP]; STRIP]) {
        let first = strip.saturating_sub(TILE * tile);
        let last = (self.rows - TILE * tile).min(TILE);
        for row in (first..last).step_by(S::F64_LANES) {
            let place = |c: usize| (strip + c) * self.stride + TILE * tile + row;
            let mut x = [simd.splat_f64s(0.0); STRIP];
            for (c, x) in x.iter_mut().enumerate() {
                *x = S::as_simd_f64s(&self.front[place(c)..place(c) + S::F64_LANES]).0[0];
            }
            for c in 0..STRIP {
                x[c] = simd.mul_f64s(x[c], simd.splat_f64s(self.inverse[strip + c]));
                for later in c + 1..STRIP {
                    let product = simd.mul_f64s(x[c], simd.splat_f64s(triangle[c][later]));
                    x[later] = simd.sub_f64s(x[later], product);
                }
            }
            for (c, x) in x.iter().enumerate() {
                let place = place(c);
                S::as_mut_simd_f64s(&mut self.front[place..place + S::F64_LANES]).0[0] = *x;
                let packed = TILE * self.padded * tile + TILE * (strip + c) + row;
                S::as_mut_simd_f64s(&mut self.panel[packed..packed + S::F64_LANES]).0[0] = *x;
            }
        }
    }
}
