//! Prescribed fine nodes on the coarse model.

use std::collections::HashMap;

use super::{CoarseModel, Embedding};
use crate::assembly::{CellStiffness, Constraints};
use crate::coarsening::COLUMNS;
use crate::element::{CellMatrix, trilinear};
use crate::mesh::{Lattice, Node};
use crate::partition::CoarseNode;

/// Stiffness of the penalty on uncovered fixed nodes, relative to the largest diagonal entry of the cell.
const PENALTY: f64 = 1e4;
/// A fine node is covered when the trilinear weights of fixed corners sum to one within this.
const COVERED: f64 = 1e-9;

/// A coarse model held where fine nodes are held.
///
/// A coarse node is fixed when the fine node at its place is. Fixed fine nodes that this does not hold (they lie inside
/// a coarse cell, not on a face or edge between fixed corners) are held on average: in each such cell a stiff penalty acts on the
/// trilinear moments Σ_j N_i(x_j) W_j ū of those nodes j, for the corners i.
#[derive(Clone, Debug)]
pub struct SupportedCoarse<'a> {
    coarse: &'a CoarseModel,
    /// Prescribed components of the coarse lattice's nodes.
    pub constraints: Constraints,
    /// Number of fixed fine nodes held by penalty.
    pub held_by_penalty: usize,
    stiffened: HashMap<usize, CellMatrix>,
}

impl<'a> SupportedCoarse<'a> {
    /// Holds `coarse` where `fixed` marks nodes of the fine lattice.
    pub fn new(coarse: &'a CoarseModel, embedding: &Embedding<'_>, fixed: &[bool]) -> Self {
        let partition = coarse.partition();
        let coarse_nodes = partition.coarse().node_count();
        let mask: Vec<bool> = (0..coarse_nodes).map(|n| fixed[partition.coincident_node(CoarseNode(n)).0]).collect();
        let mut this =
            Self { coarse, constraints: Constraints::nodes(&mask), held_by_penalty: 0, stiffened: HashMap::new() };
        for index in 0..coarse.cells().len() {
            this.hold_uncovered(index, embedding, (fixed, &mask));
        }
        this
    }

    fn hold_uncovered(&mut self, index: usize, embedding: &Embedding<'_>, (fixed, mask): (&[bool], &[bool])) {
        let cell = self.coarse.cells()[index];
        let partition = self.coarse.partition();
        let corners = partition.corners(cell);
        let d = partition.degree() as f64;
        let weights =
            |local: u32| trilinear(partition.cell_lattice().node_position(Node(local as usize)).map(|x| x as f64 / d));
        let covered = |local: u32| {
            let sum: f64 = (0..8).filter(|&i| mask[corners[i].0]).map(|i| weights(local)[i]).sum();
            sum >= 1.0 - COVERED
        };
        let uncovered: Vec<u32> = embedding
            .members(index)
            .iter()
            .filter(|(local, node)| fixed[*node as usize] && !covered(*local))
            .map(|(local, _)| *local)
            .collect();
        if uncovered.is_empty() {
            return;
        }
        self.held_by_penalty += uncovered.len();
        let functions = self.coarse.functions().of(index);
        let mut stiffness = *self.coarse.cell_stiffness(index);
        let largest = (0..COLUMNS).fold(0.0f64, |m, i| m.max(stiffness[COLUMNS * i + i]));
        for i in 0..8 {
            let total: f64 = uncovered.iter().map(|&local| weights(local)[i]).sum();
            if total <= COVERED {
                continue;
            }
            for r in 0..3 {
                let mut moment = [0.0; COLUMNS];
                for &local in &uncovered {
                    let row = &functions[(3 * local as usize + r) * COLUMNS..][..COLUMNS];
                    let weight = weights(local)[i] / total;
                    moment.iter_mut().zip(row).for_each(|(m, w)| *m += weight * w);
                }
                for (a, b) in (0..COLUMNS * COLUMNS).map(|n| (n / COLUMNS, n % COLUMNS)) {
                    stiffness[COLUMNS * a + b] += PENALTY * largest * moment[a] * moment[b];
                }
            }
        }
        self.stiffened.insert(cell.0, stiffness);
    }
}

impl CellStiffness for SupportedCoarse<'_> {
    fn lattice(&self) -> Lattice {
        self.coarse.lattice()
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        self.stiffened.get(&cell).map(|matrix| (1.0, matrix)).or_else(|| self.coarse.stiffness(cell))
    }
}
