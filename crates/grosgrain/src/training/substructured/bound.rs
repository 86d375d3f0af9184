//! How far the data of a ring are from its exact solution.

use super::cell::{RIGID, rigid_motions};
use super::dense::solve_semidefinite;
use super::solids::{local_node, multiply};
use super::{F, Substructures};
use crate::fine::FineModel;
use crate::mesh::Node;
use crate::partition::CoarseCell;

/// Squared energies of the six fields.
pub(super) struct RingEnergies {
    /// Σ_i (û − u_i)ᵀ H_i (û − u_i).
    pub mismatch: [f64; F],
    /// Σ_i u_iᵀ H_i u_i.
    pub energy: [f64; F],
}

impl Substructures {
    /// Upper bounds of the relative energy errors of the six fields of a cell's ring against the exact solution of the ring under the same forces from outside.
    ///
    /// The cells' displacements u_i are in equilibrium with each other but do not agree at all nodes; û, their mean at every shared node, agrees but is not in
    /// equilibrium. For the exact solution u the two errors are orthogonal (`prager1947approximations`),
    /// Σ_i ‖û − u_i‖² = ‖û − u‖² + Σ_i ‖u − u_i‖² in the norm uᵀH u, so the root of the left side over that of Σ_i ‖u_i‖² bounds both.
    /// `None` where [`Self::train_cell`] gives no data, and where a cell cannot tell its means apart.
    pub fn error_bound(&self, model: &FineModel, cell: CoarseCell) -> Option<[f64; F]> {
        let RingEnergies { mismatch, energy } = self.ring_energies(model, cell)?;
        Some(std::array::from_fn(|k| if energy[k] > 0.0 { (mismatch[k] / energy[k]).sqrt() } else { 0.0 }))
    }

    pub(super) fn ring_energies(&self, model: &FineModel, cell: CoarseCell) -> Option<RingEnergies> {
        let fields = self.ring_displacements(model, cell)?;
        let partition = &self.forces.partition;
        let fine = partition.fine();
        let mut sums: std::collections::HashMap<Node, (f64, [f64; 3 * F])> = std::collections::HashMap::new();
        for (cell, fields) in &fields {
            let stride = fields.len() / F;
            for (n, node) in partition.fine_nodes(*cell).enumerate().filter(|(n, _)| self.solids[cell.0].part(*n).is_some()) {
                let entry = sums.entry(node).or_insert((0.0, [0.0; 3 * F]));
                entry.0 += 1.0;
                (0..3 * F).for_each(|i| entry.1[i] += fields[stride * (i / 3) + 3 * n + i % 3]);
            }
        }
        let mut energies = RingEnergies { mismatch: [0.0; F], energy: [0.0; F] };
        for (cell, fields) in &fields {
            for (k, u) in fields.chunks_exact(fields.len() / F).enumerate() {
                let mut error = u.to_vec();
                for (node, (count, sum)) in partition.fine_nodes(*cell).filter_map(|n| Some((n, sums.get(&n)?))) {
                    let local = local_node(partition, *cell, node);
                    (0..3).for_each(|r| error[3 * local + r] -= sum[3 * k + r] / count);
                }
                let dot = |v: &[f64]| -> f64 {
                    multiply(model, partition, *cell, v).iter().zip(v).map(|(a, b)| a * b).sum()
                };
                energies.mismatch[k] += dot(&error);
                energies.energy[k] += dot(u);
            }
        }
        debug_assert_eq!(fine.node_count(), model.grid().lattice.node_count());
        Some(energies)
    }

    /// The displacements of all cells of a ring, with their rigid motions.
    pub(super) fn ring_displacements(&self, model: &FineModel, centre: CoarseCell) -> Option<Vec<(CoarseCell, Vec<f64>)>> {
        let ring = self.ring(model, centre)?;
        let (all, means) = self.with_workspace(&ring.shape, true, |workspace| {
            let all = workspace.multipliers(&ring)?;
            let means: Vec<_> = (0..ring.members.len()).map(|i| workspace.means(&ring, i)).collect();
            Some((all, means))
        })??;
        let mut found = Vec::new();
        for ((member, multipliers), q) in ring.members.iter().zip(all).zip(means) {
            let (Some(member), Some(multipliers)) = (member, multipliers) else { continue };
            let cache = member.cache;
            let mut fields = cache.displacements(&multipliers, self.plan.as_ref()?);
            let rows: Vec<usize> =
                member.inner.iter().flat_map(|n| cache.offsets[*n]..cache.offsets[n + 1]).collect();
            // G α = q − S H⁺(f − Sᵀλ), in the least-squares sense where a part hangs at too few means.
            let (count, motions) = (cache.rows(), RIGID * cache.parts);
            let (mut matrix, mut alpha) = (vec![0.0; motions * motions], vec![0.0; motions * F]);
            for (&row, q) in rows.iter().zip(&q) {
                let g = &cache.rigid[motions * row..][..motions];
                let held = |k: usize| {
                    let sum: f64 =
                        (0..count).map(|s| cache.flexibility[count * row + s] * multipliers[F * s + k]).sum();
                    q[k] - (cache.answer[F * row + k] - sum)
                };
                let left: [f64; F] = std::array::from_fn(held);
                for m in 0..motions {
                    (0..motions).for_each(|l| matrix[motions * m + l] += g[m] * g[l]);
                    (0..F).for_each(|k| alpha[F * m + k] += g[m] * left[k]);
                }
            }
            solve_semidefinite(motions, &mut matrix, &mut alpha, F);
            let stride = fields.len() / F;
            for node in 0..stride / 3 {
                let Some(part) = self.solids[member.cell.0].part(node) else { continue };
                let r = rigid_motions(&self.forces.partition, self.forces.spacing, node);
                for (k, column) in fields.chunks_exact_mut(stride).enumerate() {
                    for (m, r) in r.iter().enumerate() {
                        (0..3).for_each(|a| column[3 * node + a] += r[a] * alpha[F * (RIGID * part + m) + k]);
                    }
                }
            }
            found.push((member.cell, fields));
        }
        Some(found)
    }
}
