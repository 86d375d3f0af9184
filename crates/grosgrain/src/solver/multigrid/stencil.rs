//! A lattice operator stored as 27 blocks of 3×3 per node, lanes of nodes along x: in single precision for the levels of a cycle, in
//! double precision for a matrix to be solved with.

use rayon::prelude::*;

use super::grid::{LANES, Layout};
use super::level::{Level, invert};
use crate::element::CellMatrix;
use crate::linalg::LinearOperator;
use crate::mesh::Lattice;
use crate::solver::block_matrix::Coefficient;

/// Coefficients of [`LANES`] nodes: neighbour (x fastest), entry of the 3×3 block, lane.
type Block<C> = [[[C; LANES]; 9]; 27];

/// Inverse diagonal blocks of [`LANES`] nodes: entry of the upper triangle, lane.
type InverseLanes = [[f32; LANES]; 6];

pub(super) struct StencilLevel<C = f32> {
    lattice: Lattice,
    layout: Layout,
    blocks: Vec<Block<C>>,
    inverse: Vec<InverseLanes>,
}

impl<C: Coefficient> StencilLevel<C> {
    /// An operator without entries; [`Self::set_layer`] fills it layer by layer.
    pub fn new(lattice: Lattice) -> Self {
        let [nx, ny, nz] = lattice.nodes();
        let count = nx.div_ceil(LANES) * ny * nz;
        let blocks = vec![[[[C::default(); LANES]; 9]; 27]; count];
        Self { lattice, layout: Layout::rows(lattice), blocks, inverse: vec![[[0.0; LANES]; 6]; count] }
    }

    fn blocks_per_row(&self) -> usize {
        self.layout.nodes[0].div_ceil(LANES)
    }

    /// Assembles the nodes of layer k from the layers of cells below and above it (empty where there is none).
    pub fn set_layer(&mut self, k: usize, below: &[CellMatrix], above: &[CellMatrix]) {
        let cell = |index: usize, bit: usize| [below, above][bit].get(index).map(|matrix| (1.0, matrix));
        self.set_layer_of(k, &cell, None);
    }

    /// The same from a function that gives factor and matrix of a cell by its index in the layer below (0) or above (1), with zero rows and columns where
    /// bit r of a node's entry in `free` is not set.
    pub fn set_layer_of<'m>(
        &mut self,
        k: usize,
        cell: &(impl Fn(usize, usize) -> Option<(f64, &'m CellMatrix)> + Sync),
        free: Option<&[u8]>,
    ) {
        let per_row = self.blocks_per_row();
        let [nx, ny, _] = self.layout.nodes;
        let lattice = self.lattice;
        let range = k * ny * per_row..(k + 1) * ny * per_row;
        let rows = self.blocks[range.clone()].par_chunks_mut(per_row);
        let inverses = self.inverse[range].par_chunks_mut(per_row);
        rows.zip(inverses).enumerate().for_each(|(j, (blocks, inverses))| {
            for i in 0..nx {
                let mut stencil = node_stencil(lattice, [i, j], cell);
                if let Some(free) = free {
                    hold(&mut stencil, lattice, [i, j, k], free);
                }
                let (block, inverse, lane) = (&mut blocks[i / LANES], &mut inverses[i / LANES], i % LANES);
                for (entry, value) in stencil.iter().enumerate() {
                    block[entry / 9][entry % 9][lane] = C::of(*value);
                }
                let diagonal = std::array::from_fn(|e| stencil[9 * 13 + e]);
                invert(&diagonal).iter().enumerate().for_each(|(e, v)| inverse[e][lane] = *v as f32);
            }
        });
    }
}

/// The 27 blocks of node (i, j) between two layers of cells.
fn node_stencil<'m>(
    lattice: Lattice,
    at: [usize; 2],
    cell: &impl Fn(usize, usize) -> Option<(f64, &'m CellMatrix)>,
) -> [f64; 243] {
    let mut stencil = [0.0; 243];
    for octant in 0..8 {
        let bits = [octant & 1, octant >> 1 & 1, octant >> 2];
        let (i, j) = ((at[0] + bits[0]).wrapping_sub(1), (at[1] + bits[1]).wrapping_sub(1));
        if i >= lattice.cells[0] || j >= lattice.cells[1] {
            continue;
        }
        let Some((factor, matrix)) = cell(i + lattice.cells[0] * j, bits[2]) else { continue };
        let own = 7 - octant;
        for other in 0..8 {
            let place = |axis: usize| bits[axis] + (other >> axis & 1);
            let neighbour = place(0) + 3 * place(1) + 9 * place(2);
            for entry in 0..9 {
                stencil[9 * neighbour + entry] += factor * matrix[24 * (3 * own + entry / 3) + 3 * other + entry % 3];
            }
        }
    }
    stencil
}

/// Clears rows and columns of components that are no unknowns.
fn hold(stencil: &mut [f64; 243], lattice: Lattice, at: [usize; 3], free: &[u8]) {
    let own = free[lattice.node(at).0];
    let [nx, ny, nz] = lattice.nodes();
    for (n, block) in stencil.as_chunks_mut::<9>().0.iter_mut().enumerate() {
        let [x, y, z] = [at[0] + n % 3, at[1] + n / 3 % 3, at[2] + n / 9];
        let is_inside = (1..=nx).contains(&x) && (1..=ny).contains(&y) && (1..=nz).contains(&z);
        let bits = if is_inside { free[lattice.node([x - 1, y - 1, z - 1]).0] } else { 0 };
        if own & bits == 7 {
            continue;
        }
        for (entry, value) in block.iter_mut().enumerate() {
            if own >> (entry / 3) & bits >> (entry % 3) & 1 == 0 {
                *value = 0.0;
            }
        }
    }
}

impl<C: Coefficient> LinearOperator for StencilLevel<C> {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let layout = self.layout;
        let per_row = self.blocks_per_row();
        let layers = y.par_chunks_mut(layout.strides[2]).skip(1).take(layout.nodes[2]).enumerate();
        layers.for_each(|(k, layer)| {
            let rows = layer.chunks_mut(layout.strides[1]).skip(1).take(layout.nodes[1]).enumerate();
            for (j, row) in rows {
                let first = (k * layout.nodes[1] + j) * per_row;
                let work = Row { blocks: &self.blocks[first..first + per_row], x, y: row, at: [j, k], layout };
                pulp::Arch::new().dispatch(work);
            }
        });
    }
}

/// One row of nodes of y = A x.
struct Row<'r, C> {
    blocks: &'r [Block<C>],
    x: &'r [f64],
    y: &'r mut [f64],
    at: [usize; 2],
    layout: Layout,
}

impl<C: Coefficient> pulp::NullaryFnOnce for Row<'_, C> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Row { blocks, x, y, at: [j, k], layout } = self;
        let length = layout.component;
        for (b, block) in blocks.iter().enumerate() {
            let mut sum = [[0.0; LANES]; 3];
            for (line, neighbours) in block.as_chunks::<3>().0.iter().enumerate() {
                let row = &x[(j + line % 3) * layout.strides[1] + (k + line / 3) * layout.strides[2]..][..3 * length];
                for (dx, entries) in neighbours.iter().enumerate() {
                    let values = |c: usize| lanes(row, c * length + LANES * b + dx);
                    add_products(entries, &[values(0), values(1), values(2)], &mut sum);
                }
            }
            for (r, sum) in sum.iter().enumerate() {
                y[r * length + LANES * b + 1..][..LANES].copy_from_slice(sum);
            }
        }
    }
}

#[inline(always)]
fn lanes(row: &[f64], from: usize) -> [f64; LANES] {
    let mut values = [0.0; LANES];
    values.copy_from_slice(&row[from..from + LANES]);
    values
}

/// sum_r += Σ_c entries_rc · values_c, lane by lane; one loop over lanes becomes one vector register per array.
#[inline(always)]
fn add_products<C: Coefficient>(entries: &[[C; LANES]; 9], values: &[[f64; LANES]; 3], sum: &mut [[f64; LANES]; 3]) {
    for (r, sum) in sum.iter_mut().enumerate() {
        for (c, values) in values.iter().enumerate() {
            for l in 0..LANES {
                sum[l] = entries[3 * r + c][l].into().mul_add(values[l], sum[l]);
            }
        }
    }
}

impl<C: Coefficient> Level for StencilLevel<C> {
    fn layout(&self) -> Layout {
        self.layout
    }

    fn relax(&self, factors: [f64; 2], b: &[f64], ax: Option<&[f64]>, [d, x]: [&mut [f64]; 2]) {
        let layout = self.layout;
        let plane = layout.strides[2];
        let layers = d.par_chunks_mut(plane).zip(x.par_chunks_mut(plane)).enumerate();
        layers.skip(1).take(layout.nodes[2]).for_each(|(kk, (d, x))| {
            for j in 0..layout.nodes[1] {
                let row = (j + 1) * layout.strides[1]..(j + 2) * layout.strides[1];
                let whole = kk * plane + row.start..kk * plane + row.end;
                let first = ((kk - 1) * layout.nodes[1] + j) * self.blocks_per_row();
                let work = RelaxRow {
                    inverse: &self.inverse[first..first + self.blocks_per_row()],
                    factors,
                    b: &b[whole.clone()],
                    ax: ax.map(|ax| &ax[whole]),
                    d: &mut d[row.clone()],
                    x: &mut x[row],
                };
                pulp::Arch::new().dispatch(work);
            }
        });
    }
}

/// One row of nodes of [`Level::relax`].
struct RelaxRow<'r> {
    inverse: &'r [InverseLanes],
    factors: [f64; 2],
    b: &'r [f64],
    ax: Option<&'r [f64]>,
    d: &'r mut [f64],
    x: &'r mut [f64],
}

/// Which entry of the upper triangle stands at row r and column c.
const TRIANGLE: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

impl pulp::NullaryFnOnce for RelaxRow<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let RelaxRow { inverse, factors: [alpha, beta], b, ax, d, x } = self;
        let length = b.len() / 3;
        for (block, inverse) in inverse.iter().enumerate() {
            let at = |r: usize| r * length + LANES * block + 1;
            let residual: [[f64; LANES]; 3] =
                std::array::from_fn(|r| std::array::from_fn(|l| b[at(r) + l] - ax.map_or(0.0, |ax| ax[at(r) + l])));
            for r in 0..3 {
                for l in 0..LANES {
                    let step: f64 = (0..3).map(|c| f64::from(inverse[TRIANGLE[r][c]][l]) * residual[c][l]).sum();
                    let (d, x) = (&mut d[at(r) + l], &mut x[at(r) + l]);
                    match ax {
                        Some(_) => *d = alpha * *d + beta * step,
                        None => (*d, *x) = (beta * step, 0.0),
                    }
                    *x += *d;
                }
            }
        }
    }
}
