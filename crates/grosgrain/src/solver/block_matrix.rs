//! A symmetric matrix of 3×3 blocks, assembled from elements that meet at vertices.

use rayon::prelude::*;

use super::SolverError;
use crate::assembly::Constraints;
use crate::element::CellMatrix;
use crate::linalg::{CholeskyError, LinearOperator, SparsePattern};

/// Vertices per task of parallel loops.
const TASK: usize = 128;

/// `f32` or `f64`.
pub(super) trait Coefficient: Copy + Default + Into<f64> + Send + Sync {
    /// Rounds to it.
    fn of(value: f64) -> Self;
}

impl Coefficient for f32 {
    fn of(value: f64) -> Self {
        value as f32
    }
}

impl Coefficient for f64 {
    fn of(value: f64) -> Self {
        value
    }
}

/// Rows of blocks, both triangles, so that a product gathers and needs no colours: every sum has one order.
///
/// Prescribed components are zero rows and columns. Vertices stand in elimination order.
#[derive(Debug)]
pub(super) struct BlockMatrix<C = f64> {
    /// Where the incidences of each vertex start.
    incidence_starts: Vec<u32>,
    /// 8 × element + corner, by vertex.
    incidences: Vec<u32>,
    corners: Vec<[u32; 8]>,
    /// Per element, for corners a and b at `8 a + b`: the place of b's vertex in the row of a's.
    places: Vec<[u32; 64]>,
    row_starts: Vec<u32>,
    columns: Vec<u32>,
    blocks: Vec<[C; 9]>,
    /// Bit r of entry v: component r of vertex v is an unknown.
    free: Vec<u8>,
}

impl<C: Coefficient> BlockMatrix<C> {
    /// The zero matrix of `vertices` vertices and elements with these corners.
    pub fn new(vertices: usize, corners: Vec<[u32; 8]>) -> Result<Self, SolverError> {
        let (incidence_starts, incidences) = incidences(vertices, &corners);
        let (mut row_starts, mut columns) = (vec![0u32], Vec::new());
        let mut row = Vec::new();
        for v in 0..vertices {
            row.clear();
            let own = &incidences[incidence_starts[v] as usize..incidence_starts[v + 1] as usize];
            row.extend(own.iter().flat_map(|n| corners[*n as usize / 8]));
            row.push(v as u32);
            row.sort_unstable();
            row.dedup();
            columns.extend_from_slice(&row);
            row_starts.push(columns.len() as u32);
        }
        // The Cholesky pattern holds up to nine entries per block of one triangle, counted by 32-bit numbers.
        if columns.len().saturating_add(vertices) > 2 * (u32::MAX as usize / 9) {
            return Err(CholeskyError::TooLarge { order: 3 * vertices }.into());
        }
        let place = |a: u32, b: u32| {
            let row = &columns[row_starts[a as usize] as usize..row_starts[a as usize + 1] as usize];
            row.partition_point(|column| *column < b) as u32
        };
        let places = corners.iter().map(|c| std::array::from_fn(|n| place(c[n / 8], c[n % 8]))).collect();
        let blocks = vec![[C::default(); 9]; columns.len()];
        Ok(Self { incidence_starts, incidences, corners, places, row_starts, columns, blocks, free: vec![7; vertices] })
    }

    pub fn vertices(&self) -> usize {
        self.free.len()
    }

    /// Marks the unknowns; returns whether they are others than before. `vertex_at` tells the vertex of a rank.
    pub fn hold(&mut self, constraints: &Constraints, vertex_at: &[u32]) -> bool {
        let mut changed = false;
        for (free, vertex) in self.free.iter_mut().zip(vertex_at) {
            let bits = constraints.free_bits(*vertex as usize);
            changed |= *free != bits;
            *free = bits;
        }
        changed
    }

    /// Adds up factor × matrix of the elements, from zero.
    pub fn assemble<'k>(&mut self, stiffness: &(impl Fn(usize) -> (f64, &'k CellMatrix) + Sync)) {
        let Self { incidence_starts, incidences, corners, places, row_starts, blocks, free, .. } = self;
        let (corners, places, free) = (&*corners, &*places, &*free);
        let rows = split_rows(blocks, row_starts);
        rows.into_par_iter().for_each(|(first, mut blocks)| {
            let mut sums = Vec::new();
            for v in first..(first + TASK).min(free.len()) {
                let (row, rest) = blocks.split_at_mut((row_starts[v + 1] - row_starts[v]) as usize);
                blocks = rest;
                sums.clear();
                sums.resize(row.len(), [0.0; 9]);
                for n in &incidences[incidence_starts[v] as usize..incidence_starts[v + 1] as usize] {
                    let (element, a) = (*n as usize / 8, *n as usize % 8);
                    let (factor, matrix) = stiffness(element);
                    let places = &places[element][8 * a..8 * a + 8];
                    add_rows(
                        factor,
                        &matrix[72 * a..72 * a + 72],
                        (places, &corners[element], free),
                        free[v],
                        &mut sums,
                    );
                }
                row.iter_mut().zip(&sums).for_each(|(block, sum)| *block = sum.map(C::of));
            }
        });
    }

    fn row(&self, v: usize) -> std::ops::Range<usize> {
        self.row_starts[v] as usize..self.row_starts[v + 1] as usize
    }

    /// Row-major diagonal blocks.
    pub fn diagonal_blocks(&self) -> impl Iterator<Item = [f64; 9]> {
        (0..self.vertices()).map(|v| {
            let row = self.row(v);
            let own = row.start + self.columns[row].partition_point(|column| (*column as usize) < v);
            self.blocks[own].map(Into::into)
        })
    }

    /// Bit r of entry v: component r of vertex v is an unknown.
    pub fn free(&self) -> &[u8] {
        &self.free
    }

    /// Corners of the elements.
    pub fn corners(&self) -> &[[u32; 8]] {
        &self.corners
    }

    /// Marks the unknowns by bits.
    pub fn set_free(&mut self, free: &[u8]) {
        self.free.copy_from_slice(free);
    }

    /// Where the lower triangle has entries, by columns.
    pub fn lower_pattern(&self) -> SparsePattern {
        let (mut column_starts, mut rows) = (vec![0], Vec::new());
        for v in 0..self.vertices() {
            let later = &self.columns[self.row(v)];
            let later = &later[later.partition_point(|column| (*column as usize) < v)..];
            for c in 0..3 {
                rows.extend(later.iter().flat_map(|w| 3 * w..3 * w + 3).filter(|row| *row as usize >= 3 * v + c));
                column_starts.push(rows.len() as u32);
            }
        }
        SparsePattern { column_starts, rows }
    }

    /// The entries of [`Self::lower_pattern`], each diagonal one raised by `shift` times itself; one on the diagonal where it is zero.
    pub fn lower_into(&self, shift: f64, values: &mut [f64]) {
        let mut next = 0;
        for v in 0..self.vertices() {
            let row = self.row(v);
            let own = row.start + self.columns[row.clone()].partition_point(|column| (*column as usize) < v);
            for c in 0..3 {
                let diagonal: f64 = self.blocks[own][4 * c].into();
                values[next] = if diagonal == 0.0 { 1.0 } else { diagonal * (1.0 + shift) };
                next += 1;
                let mut put = |entries: &[C]| {
                    entries.iter().zip(&mut values[next..]).for_each(|(entry, value)| *value = (*entry).into());
                    next += entries.len();
                };
                put(&self.blocks[own][4 * c + 1..3 * c + 3]);
                self.blocks[own + 1..row.end].iter().for_each(|block| put(&block[3 * c..3 * c + 3]));
            }
        }
    }

    /// Multiplications of a product.
    pub fn operations(&self) -> f64 {
        9.0 * self.blocks.len() as f64
    }

    /// Sets entries that are no unknowns to zero.
    pub fn keep_free(&self, vector: &mut [f64]) {
        for (three, free) in vector.chunks_exact_mut(3).zip(&self.free).filter(|(_, free)| **free != 7) {
            (0..3).filter(|r| free >> r & 1 == 0).for_each(|r| three[r] = 0.0);
        }
    }
}

impl<C: Coefficient> LinearOperator for BlockMatrix<C> {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let (x, _) = x.as_chunks::<3>();
        y.par_chunks_mut(3 * TASK).enumerate().for_each(|(task, y)| {
            let (y, _) = y.as_chunks_mut::<3>();
            for (n, y) in y.iter_mut().enumerate() {
                let row = self.row(TASK * task + n);
                let mut sum = [0.0; 3];
                for (block, column) in self.blocks[row.clone()].iter().zip(&self.columns[row]) {
                    let u = &x[*column as usize];
                    let block = block.map(Into::into);
                    for r in 0..3 {
                        sum[r] += block[3 * r] * u[0] + block[3 * r + 1] * u[1] + block[3 * r + 2] * u[2];
                    }
                }
                *y = sum;
            }
        });
    }
}

/// 8 × element + corner by vertex, in ascending order, and where those of each vertex start.
fn incidences(vertices: usize, corners: &[[u32; 8]]) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; vertices + 1];
    corners.iter().flatten().for_each(|v| starts[*v as usize + 1] += 1);
    (0..vertices).for_each(|v| starts[v + 1] += starts[v]);
    let mut next = starts.clone();
    let mut incidences = vec![0; 8 * corners.len()];
    for (n, v) in corners.iter().flatten().enumerate() {
        incidences[next[*v as usize] as usize] = n as u32;
        next[*v as usize] += 1;
    }
    (starts, incidences)
}

/// The rows of [`TASK`] vertices at a time, with the first of these.
fn split_rows<'b, C>(mut blocks: &'b mut [[C; 9]], row_starts: &[u32]) -> Vec<(usize, &'b mut [[C; 9]])> {
    let vertices = row_starts.len() - 1;
    let mut rows = Vec::with_capacity(vertices.div_ceil(TASK));
    for first in (0..vertices).step_by(TASK) {
        let count = row_starts[(first + TASK).min(vertices)] - row_starts[first];
        let (head, tail) = blocks.split_at_mut(count as usize);
        rows.push((first, head));
        blocks = tail;
    }
    rows
}

/// Adds the three rows of a corner to the blocks at their places, without prescribed rows and columns.
fn add_rows(
    factor: f64,
    three: &[f64],
    (places, corners, free): (&[u32], &[u32; 8], &[u8]),
    own: u8,
    row: &mut [[f64; 9]],
) {
    for (b, (place, vertex)) in places.iter().zip(corners).enumerate() {
        let block = &mut row[*place as usize];
        let bits = free[*vertex as usize];
        if own & bits == 7 {
            for (e, entry) in block.iter_mut().enumerate() {
                *entry += factor * three[24 * (e / 3) + 3 * b + e % 3];
            }
            continue;
        }
        for (e, entry) in block.iter_mut().enumerate() {
            if own >> (e / 3) & bits >> (e % 3) & 1 == 1 {
                *entry += factor * three[24 * (e / 3) + 3 * b + e % 3];
            }
        }
    }
}
