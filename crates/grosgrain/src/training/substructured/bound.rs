//! How far the data of a ring are from its exact solution.

use super::cell::CellAnswer;
use super::solids::{local_node, multiply};
use super::topology::Member;
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
    /// `None` where the ring is not solved in substructures, see [`Self::train_cell`].
    pub fn error_bound(&self, model: &FineModel, cell: CoarseCell) -> Option<[f64; F]> {
        let RingEnergies { mismatch, energy } = self.ring_energies(model, cell)?;
        Some(std::array::from_fn(|k| if energy[k] > 0.0 { (mismatch[k] / energy[k]).sqrt() } else { 0.0 }))
    }

    pub(super) fn ring_energies(&self, model: &FineModel, cell: CoarseCell) -> Option<RingEnergies> {
        let fields = self.ring_displacements(model, cell)?;
        let partition = &self.forces.partition;
        let mut sums: std::collections::HashMap<Node, (f64, [f64; 3 * F])> = std::collections::HashMap::new();
        for (cell, fields) in &fields {
            let stride = fields.len() / F;
            for (n, node) in
                partition.fine_nodes(*cell).enumerate().filter(|(n, _)| self.solids[cell.0].part(*n).is_some())
            {
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
                let dot =
                    |v: &[f64]| -> f64 { multiply(model, partition, *cell, v).iter().zip(v).map(|(a, b)| a * b).sum() };
                energies.mismatch[k] += dot(&error);
                energies.energy[k] += dot(u);
            }
        }
        Some(energies)
    }

    /// The displacements of all cells of a ring, with their rigid motions.
    pub(super) fn ring_displacements(
        &self,
        model: &FineModel,
        centre: CoarseCell,
    ) -> Option<Vec<(CoarseCell, Vec<f64>)>> {
        let ring = self.ring(model, centre)?;
        let groups = ring.groups();
        let answers = self.answers(&ring, &groups, true)?;
        let of = |(member, answer): (&Option<Member<'_>>, Option<CellAnswer>)| {
            let member = member.as_ref()?;
            Some((member.cell, self.displacements_of(member, &answer?)?))
        };
        Some(ring.members.iter().zip(answers).filter_map(of).collect())
    }
}
