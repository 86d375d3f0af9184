//! What the cycle needs of a lattice: its operator, and its smoother's diagonal.

use rayon::prelude::*;

use super::grid::Layout;
use crate::assembly::MatrixFree;
use crate::linalg::LinearOperator;

/// An operator A with the inverse of its 3×3 block diagonal D.
pub(super) trait Level: LinearOperator {
    /// Where vectors keep their nodes.
    fn layout(&self) -> Layout;

    /// d = α d + β D⁻¹ (b − A x) and x += d, given A x; without it, x is taken as zero and α as 0.
    fn relax(&self, factors: [f64; 2], b: &[f64], ax: Option<&[f64]>, vectors: [&mut [f64]; 2]);
}

/// The upper triangle of a symmetric 3×3 block: xx, xy, xz, yy, yz, zz.
pub(super) type InverseBlock = [f64; 6];

/// The inverse of a symmetric positive semi-definite block; directions without stiffness get zero.
pub(super) fn invert(block: &[f64; 9]) -> InverseBlock {
    let pivot = |value: f64, scale: f64| if value > 1e-12 * scale { 1.0 / value } else { 0.0 };
    let [a, b, c, _, d, e, _, _, f] = *block;
    let p0 = pivot(a, a.abs());
    let (l1, l2) = (b * p0, c * p0);
    let p1 = pivot(d - l1 * b, d);
    let l3 = (e - l1 * c) * p1;
    let p2 = pivot(f - l2 * c - l3 * (e - l1 * c), f);
    // A⁻¹ = L⁻ᵀ P L⁻¹ with unit lower triangular L.
    let (m1, m2, m3) = (-l1, l1 * l3 - l2, -l3);
    [p0 + m1 * m1 * p1 + m2 * m2 * p2, m1 * p1 + m2 * m3 * p2, m2 * p2, p1 + m3 * m3 * p2, m3 * p2, p2]
}

/// The finest lattice: cells without a matrix.
pub(super) struct FineLevel<'a> {
    pub operator: &'a MatrixFree<'a>,
    jacobi: BlockJacobi,
}

/// The inverse of D, block by block, for vectors with three entries per node.
#[derive(Debug, Default)]
pub(super) struct BlockJacobi {
    inverse: Vec<[f32; 6]>,
}

impl<'a> FineLevel<'a> {
    pub fn new(operator: &'a MatrixFree<'a>) -> Self {
        let mut jacobi = BlockJacobi::default();
        jacobi.renew(operator.diagonal_blocks().into_iter());
        Self { operator, jacobi }
    }
}

impl LinearOperator for FineLevel<'_> {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.operator.apply(x, y);
    }
}

/// Nodes per task of the fine level's elementwise loops.
const TASK: usize = 4096;

impl Level for FineLevel<'_> {
    fn layout(&self) -> Layout {
        Layout::interleaved(self.operator.lattice())
    }

    fn relax(&self, factors: [f64; 2], b: &[f64], ax: Option<&[f64]>, vectors: [&mut [f64]; 2]) {
        self.jacobi.relax(factors, b, ax, vectors);
    }
}

impl BlockJacobi {
    /// Inverts the diagonal blocks.
    pub fn renew(&mut self, blocks: impl Iterator<Item = [f64; 9]>) {
        self.inverse.clear();
        self.inverse.extend(blocks.map(|block| invert(&block).map(|v| v as f32)));
    }

    /// See [`Level::relax`].
    pub fn relax(&self, [alpha, beta]: [f64; 2], b: &[f64], ax: Option<&[f64]>, [d, x]: [&mut [f64]; 2]) {
        let chunks = d.par_chunks_mut(3 * TASK).zip(x.par_chunks_mut(3 * TASK)).enumerate();
        chunks.for_each(|(c, (d, x))| {
            let (d, _) = d.as_chunks_mut::<3>();
            let (x, _) = x.as_chunks_mut::<3>();
            for (i, (d, x)) in d.iter_mut().zip(x).enumerate() {
                let n = c * TASK + i;
                let residual = std::array::from_fn(|r| b[3 * n + r] - ax.map_or(0.0, |ax| ax[3 * n + r]));
                let step = multiply(&self.inverse[n].map(f64::from), residual);
                for r in 0..3 {
                    match ax {
                        Some(_) => d[r] = alpha * d[r] + beta * step[r],
                        None => (d[r], x[r]) = (beta * step[r], 0.0),
                    }
                    x[r] += d[r];
                }
            }
        });
    }
}

fn multiply(m: &InverseBlock, v: [f64; 3]) -> [f64; 3] {
    [
        m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
        m[1] * v[0] + m[3] * v[1] + m[4] * v[2],
        m[2] * v[0] + m[4] * v[1] + m[5] * v[2],
    ]
}
