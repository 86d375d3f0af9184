//! The forces between coarse cells in the six global harmonic displacements.

use std::collections::BTreeMap;

use super::pairs::{pairs_at, split};
use super::solids::{Solids, face_quarters, local_node, multiply};
use crate::fine::{FineModel, HARMONIC_FIELDS};
use crate::mesh::{Lattice, Node, hull};
use crate::partition::{CoarseCell, Partition};
use crate::training::HarmonicDisplacements;
use crate::training::condensed::node_loads;

use rayon::prelude::*;

/// Columns of the forces at a node: three components times six fields.
pub(super) const NODE_COLUMNS: usize = 3 * HARMONIC_FIELDS;

/// The forces that neighbouring coarse cells exert on each other in the six harmonic displacements of a body, beyond the uniform stress.
///
/// Every coarse cell i carries its own share f_i of the body's loads: the constant stress on its hull, so that uniform tractions act on all its faces, those to
/// other cells included. The residual r_i = H_i u − f_i lives on nodes that it shares with other cells and sums to zero over the cells at a node. It is
/// split into pairwise forces t_ij = −t_ji with Σ_j t_ij = r_i of least norm, between cells that share a face and, where these do not connect all cells at a node, the
/// closest others (`he2022fast` §3.2; the split at edges and corners is ours).
#[derive(Clone, Debug)]
pub struct InterfaceForces {
    pub(super) partition: Partition,
    pub(super) spacing: [f64; 3],
    /// Per coarse cell what was solid.
    pub(super) solids: Vec<Solids>,
    /// Per coarse cell its loads.
    pub(super) loads: Vec<CellLoads>,
    /// Forces on the first cell of each pair.
    pub(super) pairs: BTreeMap<(CoarseCell, CoarseCell), PairForces>,
}

/// A coarse cell's share of the constant-stress loads.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct CellLoads {
    /// Per local node the integrals of the gradient of its shape function, in quarters of a fine cell's faces.
    pub faces: Vec<[f64; 3]>,
    /// The share is not that of the cell's own hull, because a void reaches from this cell into others without reaching the outside.
    pub corrected: bool,
}

impl CellLoads {
    pub(super) fn of_own_hull(solids: &Solids, local: &Lattice) -> Self {
        Self { faces: face_quarters(local, &solids.own_hull(local)), corrected: false }
    }

    /// Three times six loads \[N per Pa\] of a local node.
    pub(super) fn at(&self, node: usize, area: [f64; 3]) -> [f64; NODE_COLUMNS] {
        let mut out = [0.0; NODE_COLUMNS];
        node_loads(self.faces[node], area, &mut out);
        out
    }
}

/// Nodes of a pair, ascending, and 3 × 6 forces on its first cell at each.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PairForces {
    pub nodes: Vec<Node>,
    pub forces: Vec<f64>,
}

/// Quarters of the areas of a fine cell's faces across x, y, z.
pub(super) fn quarter_areas(spacing: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| spacing[(a + 1) % 3] * spacing[(a + 2) % 3] / 4.0)
}

impl InterfaceForces {
    /// The interface forces of `harmonic`, the harmonic displacements of `model`.
    ///
    /// # Panics
    /// Panics when the model's lattice is not that of the partition, or the displacements are another body's.
    pub fn new(model: &FineModel, partition: &Partition, harmonic: &HarmonicDisplacements) -> Self {
        assert_eq!(model.grid().lattice, partition.fine(), "a partition of the model's lattice");
        let cells = (0..partition.coarse().cell_count()).into_par_iter().map(CoarseCell);
        let solids: Vec<Solids> = cells.map(|c| Solids::new(model, partition, c)).collect();
        let mut forces = Self {
            partition: *partition,
            spacing: model.grid().spacing,
            loads: cell_loads(model, partition, &solids),
            solids,
            pairs: BTreeMap::new(),
        };
        let residuals: Vec<Vec<f64>> = (0..forces.solids.len())
            .into_par_iter()
            .map(|c| forces.residual(model, CoarseCell(c), &harmonic.displacements))
            .collect();
        forces.add_pairs(&residuals);
        forces
    }

    /// r = H u − f of a cell: 3 × 6 values per local node; empty for an empty cell.
    fn residual(&self, model: &FineModel, cell: CoarseCell, displacements: &[f64]) -> Vec<f64> {
        if self.solids[cell.0].is_empty() {
            return Vec::new();
        }
        let nodes: Vec<Node> = self.partition.fine_nodes(cell).collect();
        let mut residual = vec![0.0; NODE_COLUMNS * nodes.len()];
        let stride = displacements.len() / HARMONIC_FIELDS;
        for (field, u) in displacements.chunks_exact(stride).enumerate() {
            let own: Vec<f64> = nodes.iter().flat_map(|n| u[3 * n.0..][..3].to_vec()).collect();
            let forces = multiply(model, &self.partition, cell, &own);
            forces.iter().enumerate().for_each(|(i, f)| residual[HARMONIC_FIELDS * i + field] = *f);
        }
        let area = quarter_areas(self.spacing);
        for (node, r) in residual.chunks_exact_mut(NODE_COLUMNS).enumerate() {
            if self.solids[cell.0].part(node).is_some() {
                r.iter_mut().zip(self.loads[cell.0].at(node, area)).for_each(|(r, f)| *r -= f);
            }
        }
        residual
    }

    fn add_pairs(&mut self, residuals: &[Vec<f64>]) {
        let partition = self.partition;
        let (fine, coarse) = (partition.fine(), partition.coarse());
        for node in (0..fine.node_count()).map(Node) {
            let cells = active_cells(&partition, &self.solids, node);
            if cells.len() < 2 {
                continue;
            }
            let pairs = pairs_at(&coarse, &cells);
            let of =
                |c: &CoarseCell| &residuals[c.0][NODE_COLUMNS * local_node(&partition, *c, node)..][..NODE_COLUMNS];
            let r: Vec<f64> = cells.iter().flat_map(of).copied().collect();
            let t = split(&cells, &pairs, &r, NODE_COLUMNS);
            for (pair, t) in pairs.into_iter().zip(t.chunks_exact(NODE_COLUMNS)) {
                let entry = self.pairs.entry(pair).or_default();
                entry.nodes.push(node);
                entry.forces.extend(t);
            }
        }
    }
}

/// The coarse cells, ascending, that have a solid fine cell at a node; none for a node inside of a coarse cell.
pub(super) fn active_cells(partition: &Partition, solids: &[Solids], node: Node) -> Vec<CoarseCell> {
    let d = partition.degree();
    let at = partition.fine().node_position(node);
    if at.iter().all(|x| x % d != 0) {
        return Vec::new();
    }
    let coarse = partition.coarse();
    let mut cells = Vec::with_capacity(8);
    let sides = at.map(|x| if x % d == 0 { [(x / d).checked_sub(1), Some(x / d)] } else { [None, Some(x / d)] });
    for k in sides[2].into_iter().flatten() {
        for j in sides[1].into_iter().flatten() {
            for i in sides[0].into_iter().flatten() {
                let position = [i, j, k];
                if (0..3).any(|a| position[a] >= coarse.cells[a]) {
                    continue;
                }
                let cell = CoarseCell(coarse.cell(position).0);
                if solids[cell.0].part(local_node(partition, cell, node)).is_some() {
                    cells.push(cell);
                }
            }
        }
    }
    cells
}

/// The loads of every cell's own hull, and where these do not add to the body's loads the difference, in equal shares on the cells at the node.
fn cell_loads(model: &FineModel, partition: &Partition, solids: &[Solids]) -> Vec<CellLoads> {
    let local = partition.cell_lattice();
    let mut loads: Vec<CellLoads> = solids.par_iter().map(|s| CellLoads::of_own_hull(s, &local)).collect();
    if solids.iter().all(Solids::is_full) {
        return loads;
    }
    let fine = partition.fine();
    let mut missing = face_quarters(&fine, &hull(&model.grid().void, &fine));
    let mut sharing = vec![0.0; missing.len()];
    for_active(partition, solids, &mut |cell, n, node| {
        sharing[node] += 1.0;
        (0..3).for_each(|a| missing[node][a] -= loads[cell].faces[n][a]);
    });
    for_active(partition, solids, &mut |cell, n, node| {
        if missing[node] != [0.0; 3] {
            (0..3).for_each(|a| loads[cell].faces[n][a] += missing[node][a] / sharing[node]);
            loads[cell].corrected = true;
        }
    });
    loads
}

/// Visits the nodes that touch a solid fine cell of a coarse cell: coarse cell, local node, node.
fn for_active(partition: &Partition, solids: &[Solids], visit: &mut dyn FnMut(usize, usize, usize)) {
    for (cell, solid) in solids.iter().enumerate() {
        for (n, node) in partition.fine_nodes(CoarseCell(cell)).enumerate() {
            if solid.part(n).is_some() {
                visit(cell, n, node.0);
            }
        }
    }
}
