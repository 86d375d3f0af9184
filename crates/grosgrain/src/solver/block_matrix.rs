//! A symmetric matrix of 3×3 blocks, assembled from elements that meet at vertices.

use rayon::prelude::*;

use super::SolverError;
use crate::assembly::Constraints;
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
/// Prescribed components are zero rows and columns. Vertices stand in elimination order. Elements have N corners and row-major matrices of 3 N rows.
#[derive(Debug)]
pub(super) struct BlockMatrix<C = f64, const N: usize = 8> {
    /// Where the incidences of each vertex start.
    incidence_starts: Vec<u32>,
    /// N × element + corner, by vertex.
    incidences: Vec<u32>,
    corners: Vec<[u32; N]>,
    /// N² per element, for corners a and b at `N a + b`: the place of b's vertex in the row of a's.
    places: Vec<u32>,
    row_starts: Vec<u32>,
    columns: Vec<u32>,
    /// Three rows of numbers per vertex, so that products run along them.
    values: Vec<C>,
    /// Bit r of entry v: component r of vertex v is an unknown.
    free: Vec<u8>,
}

impl<C: Coefficient, const N: usize> BlockMatrix<C, N> {
    /// The zero matrix of `vertices` vertices and elements with these corners.
    pub fn new(vertices: usize, corners: Vec<[u32; N]>) -> Result<Self, SolverError> {
        let (incidence_starts, incidences) = incidences(vertices, &corners);
        let (mut row_starts, mut columns) = (vec![0u32], Vec::new());
        let mut row = Vec::new();
        for v in 0..vertices {
            row.clear();
            let own = &incidences[incidence_starts[v] as usize..incidence_starts[v + 1] as usize];
            row.extend(own.iter().flat_map(|n| corners[*n as usize / N]));
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
        let places = corners.iter().flat_map(|c| c.iter().flat_map(move |a| c.iter().map(move |b| (*a, *b))));
        let places = places.map(|(a, b)| place(a, b)).collect();
        let values = vec![C::default(); 9 * columns.len()];
        Ok(Self { incidence_starts, incidences, corners, places, row_starts, columns, values, free: vec![7; vertices] })
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

    /// Adds up factor × matrix of the elements, from zero; a matrix has 9 N² entries.
    pub fn assemble<'k>(&mut self, stiffness: &(impl Fn(usize) -> (f64, &'k [f64]) + Sync)) {
        let Self { incidence_starts, incidences, places, row_starts, columns, values, free, .. } = self;
        let (places, columns, free) = (&*places, &*columns, &*free);
        let rows = split_rows(values, row_starts);
        rows.into_par_iter().for_each(|(first, mut values)| {
            let mut sums = Vec::new();
            for v in first..(first + TASK).min(free.len()) {
                let (row, rest) = values.split_at_mut(9 * (row_starts[v + 1] - row_starts[v]) as usize);
                values = rest;
                sums.clear();
                sums.resize(row.len(), 0.0);
                for n in &incidences[incidence_starts[v] as usize..incidence_starts[v + 1] as usize] {
                    let (element, a) = (*n as usize / N, *n as usize % N);
                    let (factor, matrix) = stiffness(element);
                    let (three, at) = (&matrix[9 * N * a..9 * N * (a + 1)], N * *n as usize);
                    add_rows::<N>(factor, three, &places[at..at + N], &mut sums);
                }
                clear_prescribed(&mut sums, v, &columns[row_starts[v] as usize..row_starts[v + 1] as usize], free);
                row.iter_mut().zip(&sums).for_each(|(value, sum)| *value = C::of(*sum));
            }
        });
    }

    fn row(&self, v: usize) -> std::ops::Range<usize> {
        self.row_starts[v] as usize..self.row_starts[v + 1] as usize
    }

    /// The values of the three rows of a vertex.
    fn values_of(&self, v: usize) -> &[C] {
        &self.values[9 * self.row_starts[v] as usize..9 * self.row_starts[v + 1] as usize]
    }

    /// The place of a vertex in its own row.
    fn own_place(&self, v: usize) -> usize {
        self.columns[self.row(v)].partition_point(|column| (*column as usize) < v)
    }

    /// Row-major diagonal blocks.
    pub fn diagonal_blocks(&self) -> impl Iterator<Item = [f64; 9]> {
        (0..self.vertices()).map(|v| {
            let (values, own) = (self.values_of(v), self.own_place(v));
            std::array::from_fn(|e| values[e / 3 * (values.len() / 3) + 3 * own + e % 3].into())
        })
    }

    /// Bit r of entry v: component r of vertex v is an unknown.
    pub fn free(&self) -> &[u8] {
        &self.free
    }

    /// Corners of the elements.
    pub fn corners(&self) -> &[[u32; N]] {
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
            let (row, own) = (self.values_of(v), self.own_place(v));
            for (c, row) in row.chunks_exact(row.len() / 3).enumerate() {
                // The row of a symmetric matrix from the diagonal on is a column of its lower triangle.
                let (diagonal, later) = (row[3 * own + c].into(), &row[3 * own + c + 1..]);
                values[next] = if diagonal == 0.0 { 1.0 } else { diagonal * (1.0 + shift) };
                values[next + 1..].iter_mut().zip(later).for_each(|(value, entry)| *value = (*entry).into());
                next += 1 + later.len();
            }
        }
    }

    /// Multiplications of a product.
    pub fn operations(&self) -> f64 {
        self.values.len() as f64
    }

    /// Sets entries that are no unknowns to zero.
    pub fn keep_free(&self, vector: &mut [f64]) {
        for (three, free) in vector.chunks_exact_mut(3).zip(&self.free).filter(|(_, free)| **free != 7) {
            (0..3).filter(|r| free >> r & 1 == 0).for_each(|r| three[r] = 0.0);
        }
    }
}

impl<C: Coefficient, const N: usize> LinearOperator for BlockMatrix<C, N> {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let (x, _) = x.as_chunks::<3>();
        y.par_chunks_mut(3 * TASK).enumerate().for_each(|(task, y)| {
            let (y, _) = y.as_chunks_mut::<3>();
            pulp::Arch::new().dispatch(Product { matrix: self, first: TASK * task, x, y });
        });
    }
}

/// The rows of some vertices times a vector, compiled for the widest registers.
struct Product<'a, C, const N: usize> {
    matrix: &'a BlockMatrix<C, N>,
    first: usize,
    x: &'a [[f64; 3]],
    y: &'a mut [[f64; 3]],
}

/// Blocks whose part of the vector is gathered at a time; more than the 27 of a lattice.
const GATHERED: usize = 32;

impl<C: Coefficient, const N: usize> pulp::WithSimd for Product<'_, C, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { matrix, first, x, y } = self;
        let mut near = [0.0; 3 * GATHERED];
        for (n, y) in y.iter_mut().enumerate() {
            let (from, to) = (matrix.row_starts[first + n] as usize, matrix.row_starts[first + n + 1] as usize);
            let (columns, values) = (&matrix.columns[from..to], &matrix.values[9 * from..9 * to]);
            let length = values.len() / 3;
            *y = [0.0; 3];
            for (piece, columns) in columns.chunks(GATHERED).enumerate() {
                for (near, column) in near.as_chunks_mut::<3>().0.iter_mut().zip(columns) {
                    *near = x[*column as usize];
                }
                let near = &near[..3 * columns.len()];
                for (r, sum) in y.iter_mut().enumerate() {
                    *sum += along(&values[r * length + 3 * GATHERED * piece..][..near.len()], near);
                }
            }
        }
    }
}

/// Σ aᵢ xᵢ.
#[inline(always)]
fn along<C: Coefficient>(a: &[C], x: &[f64]) -> f64 {
    let ((a, a_rest), (x, x_rest)) = (a.as_chunks::<8>(), x.as_chunks::<8>());
    let mut lanes = [0.0; 8];
    for (a, x) in a.iter().zip(x) {
        for l in 0..8 {
            let a: f64 = a[l].into();
            lanes[l] += a * x[l];
        }
    }
    let mut sum = 0.0;
    for (a, x) in a_rest.iter().zip(x_rest) {
        let a: f64 = (*a).into();
        sum += a * x;
    }
    let four = [lanes[0] + lanes[4], lanes[1] + lanes[5], lanes[2] + lanes[6], lanes[3] + lanes[7]];
    sum + ((four[0] + four[2]) + (four[1] + four[3]))
}

/// N × element + corner by vertex, in ascending order, and where those of each vertex start.
fn incidences<const N: usize>(vertices: usize, corners: &[[u32; N]]) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; vertices + 1];
    corners.iter().flatten().for_each(|v| starts[*v as usize + 1] += 1);
    (0..vertices).for_each(|v| starts[v + 1] += starts[v]);
    let mut next = starts.clone();
    let mut incidences = vec![0; N * corners.len()];
    for (n, v) in corners.iter().flatten().enumerate() {
        incidences[next[*v as usize] as usize] = n as u32;
        next[*v as usize] += 1;
    }
    (starts, incidences)
}

/// The values of [`TASK`] vertices at a time, with the first of these.
fn split_rows<'b, C>(mut values: &'b mut [C], row_starts: &[u32]) -> Vec<(usize, &'b mut [C])> {
    let vertices = row_starts.len() - 1;
    let mut rows = Vec::with_capacity(vertices.div_ceil(TASK));
    for first in (0..vertices).step_by(TASK) {
        let count = row_starts[(first + TASK).min(vertices)] - row_starts[first];
        let (head, tail) = values.split_at_mut(9 * count as usize);
        rows.push((first, head));
        values = tail;
    }
    rows
}

/// Adds the three rows of a corner to the rows of its vertex, at the places of the element's vertices.
fn add_rows<const N: usize>(factor: f64, three: &[f64], places: &[u32], sums: &mut [f64]) {
    let length = sums.len() / 3;
    for (row, sums) in three.chunks_exact(3 * N).zip(sums.chunks_exact_mut(length)) {
        let (sums, _) = sums.as_chunks_mut::<3>();
        for (block, place) in row.as_chunks::<3>().0.iter().zip(places) {
            let sum = &mut sums[*place as usize];
            (0..3).for_each(|c| sum[c] += factor * block[c]);
        }
    }
}

/// Sets prescribed rows and columns of vertex `v` to zero.
fn clear_prescribed(sums: &mut [f64], v: usize, columns: &[u32], free: &[u8]) {
    if free[v] == 7 && columns.iter().all(|column| free[*column as usize] == 7) {
        return;
    }
    for (r, sums) in sums.chunks_exact_mut(3 * columns.len()).enumerate() {
        for (block, column) in sums.as_chunks_mut::<3>().0.iter_mut().zip(columns) {
            let bits = if free[v] >> r & 1 == 1 { free[*column as usize] } else { 0 };
            (0..3).filter(|c| bits >> c & 1 == 0).for_each(|c| block[c] = 0.0);
        }
    }
}
