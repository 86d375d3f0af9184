//! The stiffness of a lattice as an operator, y = K x, without a matrix.
//!
//! Cells of one row that share a 24×24 matrix are taken four at a time, so that the matrix is read once
//! for the four. Layers of cells are taken in two colours (even z, then odd z): layers of one colour touch
//! disjoint layers of nodes, so they run in parallel and each sum has one order for any number of threads.

use std::collections::HashMap;

use rayon::prelude::*;

use super::{CellStiffness, Constraints, free_components};
use crate::element::CellMatrix;
use crate::linalg::LinearOperator;
use crate::mesh::{Cell, Lattice, Node};

/// Cells per batch: 4 × 24 sums fill half of the AVX-512 registers.
const BATCH: usize = 4;

/// y = K x on all lattice nodes, three components per node, component fastest.
///
/// Prescribed components and nodes without a solid cell are identity rows: yᵢ = xᵢ, and xᵢ enters no other row.
pub struct MatrixFree<'a> {
    lattice: Lattice,
    matrices: Vec<&'a CellMatrix>,
    layers: Vec<Vec<Batch>>,
    free: Vec<u8>,
}

/// Up to four cells of one row with the same matrix.
#[derive(Clone, Copy)]
struct Batch {
    class: u32,
    length: u8,
    masked: bool,
    /// First corner of each cell, counted from the first node of the cell layer.
    corners: [u32; BATCH],
    factors: [f64; BATCH],
}

/// A solid cell on its way into a batch; sorted by row, then by class, then along x.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    row: usize,
    masked: bool,
    class: u32,
    cell: usize,
}

impl<'a> MatrixFree<'a> {
    /// The operator of `cells` with the components of `constraints` held.
    ///
    /// Cells whose [`CellStiffness::stiffness`] is the same reference are taken together.
    pub fn new(cells: &'a dyn CellStiffness, constraints: &Constraints) -> Self {
        let lattice = cells.lattice();
        let free = free_components(cells, constraints);
        let mut classes = Classes::default();
        let layers = (0..lattice.cells[2]).map(|k| layer(cells, &free, k, &mut classes)).collect();
        Self { lattice, matrices: classes.matrices, layers, free }
    }

    /// The lattice.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// Bit r of entry n is set if component r of node n is an unknown.
    pub fn free(&self) -> &[u8] {
        &self.free
    }

    /// The 3×3 diagonal blocks of K (row-major), identity rows and columns where a component is no unknown.
    pub fn diagonal_blocks(&self) -> Vec<[f64; 9]> {
        let mut blocks = vec![[0.0; 9]; self.lattice.node_count()];
        let corners = corner_offsets(self.lattice);
        let plane = self.plane();
        for (k, layer) in self.layers.iter().enumerate() {
            for (batch, n) in layer.iter().flat_map(|b| (0..usize::from(b.length)).map(move |n| (b, n))) {
                let matrix = self.matrices[batch.class as usize];
                for (a, offset) in corners.iter().enumerate() {
                    let block = &mut blocks[k * plane + batch.corners[n] as usize + offset];
                    for (entry, value) in block.iter_mut().enumerate() {
                        *value += batch.factors[n] * matrix[24 * (3 * a + entry / 3) + 3 * a + entry % 3];
                    }
                }
            }
        }
        blocks.iter_mut().zip(&self.free).for_each(|(block, free)| hold(block, *free));
        blocks
    }

    /// Nodes per layer.
    fn plane(&self) -> usize {
        let [nx, ny, _] = self.lattice.nodes();
        nx * ny
    }

    /// Adds the forces of one layer of cells to the two layers of nodes `y`.
    fn add_layer(&self, k: usize, x: &[f64], y: &mut [f64]) {
        let plane = self.plane();
        let x = &x[3 * k * plane..3 * (k + 2) * plane];
        let work = Layer {
            batches: &self.layers[k],
            matrices: &self.matrices,
            free: &self.free[k * plane..(k + 2) * plane],
            runs: run_offsets(self.lattice),
            x,
            y,
        };
        pulp::Arch::new().dispatch(work);
    }
}

impl LinearOperator for MatrixFree<'_> {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let plane = self.plane();
        y.par_chunks_mut(6 * plane).enumerate().for_each(|(c, y)| {
            let (from, nodes) = (2 * c * plane, y.len() / 3);
            identity_rows(&self.free[from..from + nodes], &x[3 * from..3 * from + y.len()], y);
            if 2 * c < self.layers.len() {
                self.add_layer(2 * c, x, y);
            }
        });
        y[3 * plane..].par_chunks_mut(6 * plane).enumerate().for_each(|(c, y)| {
            if 2 * c + 1 < self.layers.len() {
                self.add_layer(2 * c + 1, x, y);
            }
        });
    }
}

#[derive(Default)]
struct Classes<'a> {
    numbers: HashMap<*const CellMatrix, u32>,
    matrices: Vec<&'a CellMatrix>,
}

impl<'a> Classes<'a> {
    fn number(&mut self, matrix: &'a CellMatrix) -> u32 {
        let next = self.matrices.len() as u32;
        let number = *self.numbers.entry(std::ptr::from_ref(matrix)).or_insert(next);
        if number == next {
            self.matrices.push(matrix);
        }
        number
    }
}

/// The batches of cell layer k in a fixed order.
fn layer<'a>(cells: &'a dyn CellStiffness, free: &[u8], k: usize, classes: &mut Classes<'a>) -> Vec<Batch> {
    let lattice = cells.lattice();
    let per_layer = lattice.cells[0] * lattice.cells[1];
    let mut keys: Vec<Key> = (k * per_layer..(k + 1) * per_layer)
        .filter_map(|cell| {
            let (_, matrix) = cells.stiffness(cell)?;
            let masked = lattice.corners(Cell(cell)).iter().any(|n| free[n.0] != 7);
            Some(Key { row: cell / lattice.cells[0], masked, class: classes.number(matrix), cell })
        })
        .collect();
    keys.sort_unstable();
    let first = lattice.node([0, 0, k]).0;
    let alike = |a: &Key, b: &Key| (a.row, a.masked, a.class) == (b.row, b.masked, b.class);
    keys.chunk_by(alike).flat_map(|run| run.chunks(BATCH)).map(|keys| batch(cells, first, keys)).collect()
}

fn batch(cells: &dyn CellStiffness, first: usize, keys: &[Key]) -> Batch {
    let lattice = cells.lattice();
    let mut batch = Batch {
        class: keys[0].class,
        length: keys.len() as u8,
        masked: keys[0].masked,
        corners: [0; BATCH],
        factors: [0.0; BATCH],
    };
    for (n, key) in keys.iter().enumerate() {
        batch.corners[n] = (lattice.corners(Cell(key.cell))[0].0 - first) as u32;
        batch.factors[n] = cells.stiffness(key.cell).map_or(0.0, |(factor, _)| factor);
    }
    batch
}

/// Offsets of the eight corners of a cell from its first, in nodes.
fn corner_offsets(lattice: Lattice) -> [usize; 8] {
    lattice.corners(Cell(0)).map(|Node(n)| n)
}

/// Offsets of the four runs of two nodes of a cell, in vector entries.
fn run_offsets(lattice: Lattice) -> [usize; 4] {
    let corners = corner_offsets(lattice);
    std::array::from_fn(|run| 3 * corners[2 * run])
}

fn identity_rows(free: &[u8], x: &[f64], y: &mut [f64]) {
    let (x, _) = x.as_chunks::<3>();
    let (y, _) = y.as_chunks_mut::<3>();
    for ((free, x), y) in free.iter().zip(x).zip(y) {
        *y = std::array::from_fn(|r| if free >> r & 1 == 1 { 0.0 } else { x[r] });
    }
}

/// Makes the rows and columns of components that are no unknowns those of the identity.
fn hold(block: &mut [f64; 9], free: u8) {
    for (entry, value) in block.iter_mut().enumerate() {
        let (row, column) = (entry / 3, entry % 3);
        if free >> row & free >> column & 1 == 0 {
            *value = f64::from(u8::from(row == column));
        }
    }
}

struct Layer<'l> {
    batches: &'l [Batch],
    matrices: &'l [&'l CellMatrix],
    free: &'l [u8],
    runs: [usize; 4],
    x: &'l [f64],
    y: &'l mut [f64],
}

impl pulp::NullaryFnOnce for Layer<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Layer { batches, matrices, free, runs, x, y } = self;
        for batch in batches {
            let mut u = [[0.0; 24]; BATCH];
            let corners = &batch.corners[..usize::from(batch.length)];
            for ((corner, factor), u) in corners.iter().zip(&batch.factors).zip(&mut u) {
                gather(x, 3 * *corner as usize, runs, *factor, u);
                if batch.masked {
                    mask(free, *corner as usize, runs, u);
                }
            }
            let mut f = multiply(matrices[batch.class as usize], &u);
            for (corner, f) in corners.iter().zip(&mut f) {
                if batch.masked {
                    mask(free, *corner as usize, runs, f);
                }
                scatter(f, 3 * *corner as usize, runs, y);
            }
        }
    }
}

#[inline(always)]
fn gather(x: &[f64], base: usize, runs: [usize; 4], factor: f64, u: &mut [f64; 24]) {
    for (run, offset) in runs.iter().enumerate() {
        let from = &x[base + offset..base + offset + 6];
        for i in 0..6 {
            u[6 * run + i] = factor * from[i];
        }
    }
}

#[inline(always)]
fn scatter(f: &[f64; 24], base: usize, runs: [usize; 4], y: &mut [f64]) {
    for (run, offset) in runs.iter().enumerate() {
        let to = &mut y[base + offset..base + offset + 6];
        for i in 0..6 {
            to[i] += f[6 * run + i];
        }
    }
}

#[inline(always)]
fn mask(free: &[u8], corner: usize, runs: [usize; 4], u: &mut [f64; 24]) {
    for (i, value) in u.iter_mut().enumerate() {
        let node = corner + runs[i / 6] / 3 + i % 6 / 3;
        if free[node] >> (i % 3) & 1 == 0 {
            *value = 0.0;
        }
    }
}

/// K u for the vectors of a batch; K is symmetric, so its rows serve as columns.
#[inline(always)]
fn multiply(matrix: &CellMatrix, u: &[[f64; 24]; BATCH]) -> [[f64; 24]; BATCH] {
    let mut f = [[0.0f64; 24]; BATCH];
    let (columns, _) = matrix.as_chunks::<24>();
    for (j, column) in columns.iter().enumerate() {
        for n in 0..BATCH {
            let s = u[n][j];
            for i in 0..24 {
                f[n][i] = s.mul_add(column[i], f[n][i]);
            }
        }
    }
    f
}
