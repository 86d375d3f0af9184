//! Interfaces between coarse cells: their nodes and the means that are tied.

use std::collections::BTreeMap;

use super::forces::{InterfaceForces, PairForces, active_cells, quarter_areas};
use super::pairs::pairs_at;
use super::solids::{Solids, local_node};
use super::space::{InterfaceSpace, Means, Rows, harmonic_rows, polynomial_rows};
use crate::fine::HARMONIC_FIELDS;
use crate::mesh::Node;
use crate::partition::CoarseCell;

/// Nodes that coarse cells share, and the weighted means of their displacement in which the cells agree.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Interface {
    /// The cells, ascending.
    pub cells: Vec<CoarseCell>,
    /// Ties nothing: only carries the initial forces from outside of a ring.
    pub loads_only: bool,
    /// The part of each cell that the nodes belong to.
    pub parts: Vec<usize>,
    /// Nodes, ascending.
    pub nodes: Vec<Node>,
    /// Orthonormal rows over three values per node.
    pub rows: Rows,
    /// The first of them, those of the chosen space. The others, mean rotations, are tied in rings where the motion of neighbours against each other matters.
    pub chosen: usize,
    /// Per row six multiples of it that make up the initial forces on the first cell, if all of them act here.
    pub force: Option<Vec<f64>>,
}

impl Interface {
    /// Whether two cells mean the same interface.
    pub(super) fn is(&self, other: &Self) -> bool {
        self.cells == other.cells && self.nodes[0] == other.nodes[0] && !self.loads_only && !other.loads_only
    }

    /// Number of rows that are tied, with or without mean rotations.
    pub(super) fn tied(&self, turns: bool) -> usize {
        if turns { self.rows.count() } else { self.chosen }
    }

    /// +1 for the first cell, −1 for the second.
    pub(super) fn sign(&self, cell: CoarseCell) -> f64 {
        if self.cells[0] == cell { 1.0 } else { -1.0 }
    }
}

/// All interfaces of a cell, in a fixed order.
pub(super) fn interfaces(
    forces: &InterfaceForces,
    solids: &[Solids],
    space: InterfaceSpace,
    cell: CoarseCell,
) -> Vec<Interface> {
    let own: Vec<(Node, Vec<CoarseCell>)> = forces
        .partition
        .fine_nodes(cell)
        .map(|node| (node, active_cells(&forces.partition, solids, node)))
        .filter(|(_, cells)| cells.len() > 1 && cells.contains(&cell))
        .collect();
    let part = |c: CoarseCell, node| solids[c.0].part(local_node(&forces.partition, c, node)).unwrap_or(0);
    let InterfaceSpace::Means(means) = space else {
        let tie = |(node, cells): (Node, Vec<CoarseCell>)| Interface {
            parts: cells.iter().map(|c| part(*c, node)).collect(),
            cells,
            loads_only: false,
            nodes: vec![node],
            rows: Rows::identity(),
            chosen: 3,
            force: None,
        };
        return own.into_iter().map(tie).collect();
    };
    let mut shared: BTreeMap<[usize; 4], Vec<Node>> = BTreeMap::new();
    for (node, cells) in own {
        for (a, b) in pairs_at(&forces.partition.coarse(), &cells) {
            if a == cell || b == cell {
                shared.entry([a.0, b.0, part(a, node), part(b, node)]).or_default().push(node);
            }
        }
    }
    let none = PairForces::default();
    let mut partial = neighbours(forces, cell);
    partial.push(cell);
    partial.retain(|c| !solids[c.0].is_full() && !solids[c.0].is_empty());
    let mut found = Vec::with_capacity(shared.len());
    for ([a, b, part_a, part_b], nodes) in shared {
        let cells = vec![CoarseCell(a), CoarseCell(b)];
        let known = forces.pairs.get(&(cells[0], cells[1])).unwrap_or(&none);
        let initial = known.on(&nodes);
        let (weights, area) = face_weights(forces, &nodes, &cells);
        let mut rows = Rows::new(3 * nodes.len());
        polynomial_rows(&mut rows, forces, means, (&nodes, &weights));
        if means.harmonic {
            let norm = area * weights.iter().map(|w| w * w).sum::<f64>().sqrt();
            harmonic_rows(&mut rows, &initial, norm);
        }
        let chosen = rows.count();
        if partial.iter().any(|c| cells.iter().all(|own| own == c || neighbours(forces, *c).contains(own))) {
            let turns =
                Means { translations: true, node_means: false, rotations: true, linear: false, harmonic: false };
            polynomial_rows(&mut rows, forces, turns, (&nodes, &weights));
        }
        let force = (means.harmonic && known.nodes == nodes).then(|| rows.times(&initial));
        found.push(Interface { cells, loads_only: false, parts: vec![part_a, part_b], nodes, chosen, rows, force });
    }
    found.extend(outer_forces(forces, &found, cell, solids));
    found
}

/// Forces of the initial pairs of an unchanged cell that no interface of today holds entirely: on its rings they still act from outside.
fn outer_forces(forces: &InterfaceForces, found: &[Interface], cell: CoarseCell, solids: &[Solids]) -> Vec<Interface> {
    if solids[cell.0].void != forces.solids[cell.0].void {
        return Vec::new();
    }
    let held = |pair: &[CoarseCell; 2]| found.iter().any(|i| i.cells == pair && i.force.is_some());
    let pairs = neighbours(forces, cell).into_iter().map(|other| [cell.min(other), cell.max(other)]);
    let load = |pair: [CoarseCell; 2]| {
        let known = forces.pairs.get(&(pair[0], pair[1]))?;
        let mut rows = Rows::new(3 * known.nodes.len());
        let area = quarter_areas(forces.spacing).into_iter().fold(0.0, f64::max);
        harmonic_rows(&mut rows, &known.forces, area * (known.nodes.len() as f64).sqrt());
        let force = Some(rows.times(&known.forces));
        let some = rows.count() > 0;
        some.then(|| Interface {
            cells: pair.to_vec(),
            loads_only: true,
            parts: Vec::new(),
            nodes: known.nodes.clone(),
            chosen: 0,
            rows,
            force,
        })
    };
    pairs.filter(|pair| !held(pair)).filter_map(load).collect()
}

/// The up to 26 coarse cells around a cell, ascending.
pub(super) fn neighbours(forces: &InterfaceForces, cell: CoarseCell) -> Vec<CoarseCell> {
    let (ring, d, coarse) = (forces.partition.one_ring(cell), forces.partition.degree(), forces.partition.coarse());
    let (low, size) = (ring.start.map(|x| x / d), ring.cells.map(|n| n / d));
    let all = crate::mesh::Lattice::new(size);
    let at = |c| {
        let at = all.cell_position(crate::mesh::Cell(c));
        CoarseCell(coarse.cell(std::array::from_fn(|a| low[a] + at[a])).0)
    };
    (0..all.cell_count()).map(at).filter(|c| *c != cell).collect()
}

impl PairForces {
    /// 3 × 6 forces at each of the given nodes, zero where none is known.
    fn on(&self, nodes: &[Node]) -> Vec<f64> {
        let size = 3 * HARMONIC_FIELDS;
        let mut forces = vec![0.0; size * nodes.len()];
        for (node, out) in nodes.iter().zip(forces.chunks_exact_mut(size)) {
            if let Ok(place) = self.nodes.binary_search(node) {
                out.copy_from_slice(&self.forces[size * place..][..size]);
            }
        }
        forces
    }
}

/// Share of each node in the interface's area, in quarters of a fine face, and the area of a quarter; all one where cells share no whole fine face.
fn face_weights(forces: &InterfaceForces, nodes: &[Node], cells: &[CoarseCell]) -> (Vec<f64>, f64) {
    let partition = &forces.partition;
    let areas = quarter_areas(forces.spacing);
    let position = |c: CoarseCell| partition.coarse().cell_position(crate::mesh::Cell(c.0));
    let (a, b) = (position(cells[0]), position(cells[1]));
    let across: Vec<usize> = (0..3).filter(|&i| a[i] != b[i]).collect();
    let mut weights = vec![0.0; nodes.len()];
    if let [axis] = across[..] {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let fine = partition.fine();
        for start in 0..nodes.len() {
            let at = fine.node_position(nodes[start]);
            let corner = |du: usize, dv: usize| {
                let mut to = at;
                to[u] += du;
                to[v] += dv;
                let inside = (0..3).all(|i| to[i] <= fine.cells[i]);
                inside.then(|| nodes.binary_search(&fine.node(to)).ok()).flatten()
            };
            if let (Some(p), Some(q), Some(r)) = (corner(1, 0), corner(0, 1), corner(1, 1)) {
                [start, p, q, r].iter().for_each(|n| weights[*n] += 1.0);
            }
        }
        if weights.iter().any(|w| *w > 0.0) {
            return (weights, areas[axis]);
        }
    }
    weights.fill(1.0);
    (weights, areas.into_iter().fold(0.0, f64::max))
}
