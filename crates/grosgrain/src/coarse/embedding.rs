//! Coarse displacements on the fine nodes, and fine loads on the vertices.

use super::CoarseModel;
use crate::coarsening::COLUMNS;

/// The prolongation u = A ū from vertices to fine nodes: W ū in each element, averaged at fine nodes where
/// elements meet. An element counts at a node only if one of its own fine cells touches the node.
#[derive(Clone, Debug)]
pub struct Embedding<'a> {
    coarse: &'a CoarseModel,
    /// Fine lattice nodes of each element, with their number in its coarse cell.
    members: Vec<Vec<(u32, u32)>>,
    /// Number of elements that count at each fine lattice node.
    multiplicity: Vec<u8>,
}

impl<'a> Embedding<'a> {
    /// The embedding of the fine body that `coarse` was made from.
    pub fn new(coarse: &'a CoarseModel) -> Self {
        let mut multiplicity = vec![0u8; coarse.partition().fine().node_count()];
        let members: Vec<Vec<(u32, u32)>> = coarse.elements().iter().map(|e| coarse.mesh().fine_nodes(*e)).collect();
        members.iter().flatten().for_each(|(_, node)| multiplicity[*node as usize] += 1);
        Self { coarse, members, multiplicity }
    }

    /// u = A ū on the fine lattice; `coarse_displacement` has 3 entries per vertex. Void nodes are zero.
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

    /// f̄ = Aᵀ f: coarse loads (3 per vertex) that do the same work as the fine loads.
    pub fn restrict(&self, fine_loads: &[f64]) -> Vec<f64> {
        let mesh = self.coarse.mesh();
        let mut loads = vec![0.0; 3 * mesh.vertices().len()];
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
            for (i, vertex) in mesh.corners()[index].iter().enumerate() {
                (0..3).for_each(|r| loads[3 * *vertex as usize + r] += corners[3 * i + r]);
            }
        }
        loads
    }

    /// Number of elements that count at each fine lattice node.
    pub fn multiplicity(&self) -> &[u8] {
        &self.multiplicity
    }

    /// Fine lattice nodes at which element number `index` counts: (number in its coarse cell, fine node).
    pub fn members(&self, index: usize) -> &[(u32, u32)] {
        &self.members[index]
    }

    fn corner_values(&self, index: usize, coarse_displacement: &[f64]) -> [f64; COLUMNS] {
        let corners = self.coarse.mesh().corners()[index];
        std::array::from_fn(|c| coarse_displacement[3 * corners[c / 3] as usize + c % 3])
    }
}
