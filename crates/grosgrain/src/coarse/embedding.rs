//! Coarse displacements on the fine nodes, and fine loads on the coarse nodes.

use super::CoarseModel;
use crate::coarsening::COLUMNS;
use crate::fine::FineModel;
use crate::mesh::Cell;

/// The prolongation u = A ū from coarse to fine nodes: W ū in each coarse cell, averaged at fine nodes where
/// cells meet. A cell counts at a node only if one of its own solid fine cells touches the node.
#[derive(Clone, Debug)]
pub struct Embedding<'a> {
    coarse: &'a CoarseModel,
    /// Fine lattice nodes of each coarse cell at which the cell counts, with their local index.
    members: Vec<Vec<(u32, u32)>>,
    /// Number of coarse cells that count at each fine lattice node.
    multiplicity: Vec<u8>,
}

impl<'a> Embedding<'a> {
    /// The embedding of the body of `model` into `coarse`.
    pub fn new(model: &FineModel, coarse: &'a CoarseModel) -> Self {
        let partition = coarse.partition();
        let local = partition.cell_lattice();
        let mut multiplicity = vec![0u8; partition.fine().node_count()];
        let mut members = Vec::with_capacity(coarse.cells().len());
        for &cell in coarse.cells() {
            let mut touched = vec![false; local.node_count()];
            for (index, fine) in partition.fine_cells(cell).enumerate() {
                if !model.is_void(fine) {
                    local.corners(Cell(index)).iter().for_each(|n| touched[n.0] = true);
                }
            }
            let nodes = partition.fine_nodes(cell).enumerate().filter(|(n, _)| touched[*n]);
            let list: Vec<(u32, u32)> = nodes.map(|(n, node)| (n as u32, node.0 as u32)).collect();
            list.iter().for_each(|(_, node)| multiplicity[*node as usize] += 1);
            members.push(list);
        }
        Self { coarse, members, multiplicity }
    }

    /// u = A ū on the fine lattice; `coarse_displacement` has 3 entries per coarse lattice node. Void nodes are zero.
    pub fn prolong(&self, coarse_displacement: &[f64]) -> Vec<f64> {
        let mut fine = vec![0.0; 3 * self.multiplicity.len()];
        for (index, list) in self.members.iter().enumerate() {
            let corners = self.corner_values(index, coarse_displacement);
            let functions = self.coarse.functions().of(index);
            for &(local, node) in list {
                let share = 1.0 / f64::from(self.multiplicity[node as usize]);
                for r in 0..3 {
                    let row = &functions[(3 * local as usize + r) * COLUMNS..][..COLUMNS];
                    fine[3 * node as usize + r] += share * row.iter().zip(&corners).map(|(w, u)| w * u).sum::<f64>();
                }
            }
        }
        fine
    }

    /// f̄ = Aᵀ f: coarse loads (3 per coarse lattice node) that do the same work as the fine loads.
    pub fn restrict(&self, fine_loads: &[f64]) -> Vec<f64> {
        let partition = self.coarse.partition();
        let mut loads = vec![0.0; 3 * partition.coarse().node_count()];
        for (index, list) in self.members.iter().enumerate() {
            let functions = self.coarse.functions().of(index);
            let mut corners = [0.0; COLUMNS];
            for &(local, node) in list {
                let share = 1.0 / f64::from(self.multiplicity[node as usize]);
                for r in 0..3 {
                    let force = share * fine_loads[3 * node as usize + r];
                    let row = &functions[(3 * local as usize + r) * COLUMNS..][..COLUMNS];
                    corners.iter_mut().zip(row).for_each(|(f, w)| *f += force * w);
                }
            }
            for (i, node) in partition.corners(self.coarse.cells()[index]).iter().enumerate() {
                (0..3).for_each(|r| loads[3 * node.0 + r] += corners[3 * i + r]);
            }
        }
        loads
    }

    /// Number of coarse cells that count at each fine lattice node.
    pub fn multiplicity(&self) -> &[u8] {
        &self.multiplicity
    }

    /// Fine lattice nodes at which coarse cell number `index` counts: (local index, fine node).
    pub fn members(&self, index: usize) -> &[(u32, u32)] {
        &self.members[index]
    }

    fn corner_values(&self, index: usize, coarse_displacement: &[f64]) -> [f64; COLUMNS] {
        let corners = self.coarse.partition().corners(self.coarse.cells()[index]);
        std::array::from_fn(|c| coarse_displacement[3 * corners[c / 3].0 + c % 3])
    }
}
