//! The pattern of a matrix with d unknowns per node, and its assembly from cells.

use std::sync::Arc;

use super::SimplexModel;
use super::cell_stiffness::cell_stiffness;
use crate::linalg::{CholeskyError, SparsePattern, graph_of_cliques};
use crate::solver::SolverError;

/// The lower triangle by blocks of d × d: block column r holds the blocks at `rows[starts[r]..starts[r + 1]]`, r first, then ascending.
#[derive(Debug)]
pub(super) struct BlockColumns {
    axes: usize,
    starts: Vec<usize>,
    rows: Vec<u32>,
    pub(super) pattern: Arc<SparsePattern>,
}

impl BlockColumns {
    /// The pattern of `nodes` nodes of which each clique is coupled, all by their ranks.
    pub(super) fn new(nodes: usize, cliques: &[[u32; 4]], axes: usize) -> Result<Self, super::SimplexSystemError> {
        let (graph_starts, neighbours) = graph_of_cliques(nodes, cliques)?;
        let (mut starts, mut rows) = (vec![0], Vec::with_capacity(nodes + neighbours.len() / 2));
        for rank in 0..nodes {
            rows.push(rank as u32);
            let list = &neighbours[graph_starts[rank] as usize..graph_starts[rank + 1] as usize];
            rows.extend(list.iter().filter(|other| **other as usize > rank));
            starts.push(rows.len());
        }
        let pattern = Arc::new(scalar_pattern(axes, &starts, &rows)?);
        Ok(Self { axes, starts, rows, pattern })
    }

    /// Adds up the stiffness of all cells into `values`, one per entry of the pattern, with rows and columns of the identity where `fixed`.
    pub(super) fn assemble(&self, model: &SimplexModel, rank_of: &[u32], fixed: &[bool], values: &mut [f64]) {
        let (mesh, axes) = (model.mesh(), self.axes);
        values.fill(0.0);
        for cell in 0..mesh.cell_count() {
            let stiffness = cell_stiffness(mesh, cell, model.tensor(cell));
            let mut ranks = [0; 4];
            ranks.iter_mut().zip(mesh.cell(cell)).for_each(|(rank, node)| *rank = rank_of[*node as usize] as usize);
            let corners = mesh.dimension().corners();
            let pairs = (0..corners).flat_map(|n| (0..corners).map(move |m| (n, m)));
            for (n, m) in pairs.filter(|(n, m)| ranks[*n] <= ranks[*m]) {
                let (column, row) = (ranks[n], ranks[m]);
                let block = self.block(column, row);
                for (c, r) in (0..axes).flat_map(|c| (0..axes).map(move |r| (c, r))) {
                    let is_free = !fixed[axes * column + c] && !fixed[axes * row + r];
                    if is_free && (row > column || r >= c) {
                        values[self.entry(column, c, block, r)] += stiffness[axes * m + r][axes * n + c];
                    }
                }
            }
        }
        for unknown in (0..fixed.len()).filter(|unknown| fixed[*unknown]) {
            values[self.pattern.column(unknown).start] = 1.0;
        }
    }

    /// Which block of a block column is that of `row`.
    fn block(&self, column: usize, row: usize) -> usize {
        let rows = &self.rows[self.starts[column]..self.starts[column + 1]];
        rows.partition_point(|r| (*r as usize) < row)
    }

    fn entry(&self, column: usize, component: usize, block: usize, row_component: usize) -> usize {
        let first = self.pattern.column(self.axes * column + component).start;
        first + self.axes * block + row_component - component
    }
}

fn scalar_pattern(axes: usize, starts: &[usize], rows: &[u32]) -> Result<SparsePattern, SolverError> {
    let nodes = starts.len() - 1;
    let too_large = || CholeskyError::TooLarge { order: axes * nodes };
    let entries = axes * axes * rows.len() - nodes * axes * (axes - 1) / 2;
    u32::try_from(entries).map_err(|_| too_large())?;
    let mut pattern = SparsePattern { column_starts: vec![0], rows: Vec::with_capacity(entries) };
    for rank in 0..nodes {
        let blocks = &rows[starts[rank]..starts[rank + 1]];
        for component in 0..axes {
            let below = blocks.iter().flat_map(|row| (0..axes).map(move |r| axes as u32 * row + r as u32));
            pattern.rows.extend(below.skip(component));
            pattern.column_starts.push(pattern.rows.len() as u32);
        }
    }
    Ok(pattern)
}
