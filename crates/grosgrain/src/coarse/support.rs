//! Prescribed fine nodes on the coarse model.

use std::collections::{BTreeSet, HashMap};

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
/// A coarse node is fixed when the fine node at its place is; one at a void node only if the nearest node of the body in
/// every coarse cell around it is fixed too. Fixed fine nodes that lie on no face, edge or corner between fixed corners are
/// held on average: in each such cell a stiff penalty acts on the trilinear moments Σ_j N_i(x_j) W_j ū of those nodes j, for
/// the corners i. On a face between fixed corners trilinear functions hold every fine node; fitted functions let the inner ones
/// move with the far corners of the cell.
#[derive(Clone, Debug)]
pub struct SupportedCoarse<'a> {
    coarse: &'a CoarseModel,
    /// Prescribed components of the coarse lattice's nodes.
    pub constraints: Constraints,
    /// Number of fixed fine nodes held by penalty.
    pub held_by_penalty: usize,
    by_penalty: BTreeSet<u32>,
    stiffened: HashMap<usize, CellMatrix>,
}

impl<'a> SupportedCoarse<'a> {
    /// Holds `coarse` where `fixed` marks nodes of the fine lattice, void ones included.
    pub fn new(coarse: &'a CoarseModel, embedding: &Embedding<'_>, fixed: &[bool]) -> Self {
        let mask = held_coarse_nodes(coarse, embedding, fixed);
        let constraints = Constraints::nodes(&mask);
        let mut this =
            Self { coarse, constraints, held_by_penalty: 0, by_penalty: BTreeSet::new(), stiffened: HashMap::new() };
        for index in 0..coarse.cells().len() {
            this.hold_uncovered(index, embedding, (fixed, &mask));
        }
        this.held_by_penalty = this.by_penalty.len();
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
        let is_uncovered = |(local, node): &(u32, u32)| fixed[*node as usize] && !covered(*local);
        let found: Vec<(u32, u32)> = embedding.members(index).iter().copied().filter(is_uncovered).collect();
        let uncovered: Vec<u32> = found.iter().map(|(local, _)| *local).collect();
        if uncovered.is_empty() {
            return;
        }
        self.by_penalty.extend(found.iter().map(|(_, node)| *node));
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

/// Which coarse nodes are fixed.
fn held_coarse_nodes(coarse: &CoarseModel, embedding: &Embedding<'_>, fixed: &[bool]) -> Vec<bool> {
    let partition = coarse.partition();
    let nodes = partition.coarse().node_count();
    let mut held: Vec<bool> = (0..nodes).map(|n| fixed[partition.coincident_node(CoarseNode(n)).0]).collect();
    for (index, &cell) in coarse.cells().iter().enumerate() {
        for (corner, local) in partition.corners(cell).iter().zip(partition.local_corners()) {
            held[corner.0] &= nearest_is_fixed(coarse, embedding.members(index), local, fixed);
        }
    }
    held
}

/// Whether any of the cell's own nodes that are nearest (in fine cells) to its node `local` is fixed.
fn nearest_is_fixed(coarse: &CoarseModel, members: &[(u32, u32)], local: usize, fixed: &[bool]) -> bool {
    let lattice = coarse.partition().cell_lattice();
    let corner = lattice.node_position(Node(local));
    let distance = |member: u32| -> usize {
        let at = lattice.node_position(Node(member as usize));
        (0..3).map(|a| at[a].abs_diff(corner[a]).pow(2)).sum()
    };
    let nearest = members.iter().map(|(member, _)| distance(*member)).min();
    members.iter().any(|(member, node)| Some(distance(*member)) == nearest && fixed[*node as usize])
}

impl CellStiffness for SupportedCoarse<'_> {
    fn lattice(&self) -> Lattice {
        self.coarse.lattice()
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        self.stiffened.get(&cell).map(|matrix| (1.0, matrix)).or_else(|| self.coarse.stiffness(cell))
    }
}
