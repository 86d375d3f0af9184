//! Unknowns of a lattice: three displacement components per node that touches a solid cell.

use super::CellStiffness;
use crate::mesh::Cell;

/// Which lattice nodes touch a solid cell and so have unknowns.
pub fn active_nodes(cells: &dyn CellStiffness) -> Vec<bool> {
    let lattice = cells.lattice();
    let mut active = vec![false; lattice.node_count()];
    for c in (0..lattice.cell_count()).filter(|&c| cells.stiffness(c).is_some()) {
        lattice.corners(Cell(c)).iter().for_each(|n| active[n.0] = true);
    }
    active
}

/// Bit r of entry n is set if node n touches a solid cell and its component r is not prescribed.
pub fn free_components(cells: &dyn CellStiffness, constraints: &Constraints) -> Vec<u8> {
    active_nodes(cells)
        .iter()
        .enumerate()
        .map(|(n, active)| if *active { constraints.free_bits(n) } else { 0 })
        .collect()
}

/// Prescribed displacement components of lattice nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints {
    fixed: Vec<u8>,
}

impl Constraints {
    /// No component of any of `nodes` lattice nodes is prescribed.
    pub fn none(nodes: usize) -> Self {
        Self { fixed: vec![0; nodes] }
    }

    /// All three components of the marked nodes are prescribed.
    pub fn nodes(mask: &[bool]) -> Self {
        Self { fixed: mask.iter().map(|m| if *m { 7 } else { 0 }).collect() }
    }

    /// Prescribes one component of a node.
    pub fn fix(&mut self, node: usize, component: usize) {
        self.fixed[node] |= 1 << component;
    }

    /// Whether the component of the node is prescribed.
    pub fn is_fixed(&self, node: usize, component: usize) -> bool {
        self.fixed[node] >> component & 1 == 1
    }

    /// Whether no component of the node is prescribed.
    pub fn is_free(&self, node: usize) -> bool {
        self.fixed[node] == 0
    }

    /// Bit r is set if component r of the node is not prescribed.
    pub fn free_bits(&self, node: usize) -> u8 {
        7 & !self.fixed[node]
    }

    /// Number of prescribed components.
    pub fn count(&self) -> usize {
        self.fixed.iter().map(|f| f.count_ones() as usize).sum()
    }

    /// Number of lattice nodes.
    pub fn node_count(&self) -> usize {
        self.fixed.len()
    }
}
