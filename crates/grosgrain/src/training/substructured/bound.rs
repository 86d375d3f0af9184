//! How far the data of a ring are from its exact solution.

use std::collections::HashMap;

use super::cell::CellAnswer;
use super::solids::multiply;
use super::topology::Member;
use super::{F, Substructures};
use crate::fine::FineModel;
use crate::mesh::Node;
use crate::partition::CoarseCell;

/// Squared energies of the six fields.
struct RingEnergies {
    /// Σ_i (û − u_i)ᵀ H_i (û − u_i).
    mismatch: [f64; F],
    /// Σ_i u_iᵀ H_i u_i.
    energy: [f64; F],
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

    fn ring_energies(&self, model: &FineModel, cell: CoarseCell) -> Option<RingEnergies> {
        let fields = self.ring_displacements(model, cell)?;
        let means = self.means(&fields);
        let partition = &self.forces.partition;
        let mut energies = RingEnergies { mismatch: [0.0; F], energy: [0.0; F] };
        for (cell, fields) in &fields {
            for (k, u) in fields.chunks_exact(fields.len() / F).enumerate() {
                let mean = partition.fine_nodes(*cell).flat_map(|n| means.get(&n).map_or([0.0; 3], |m| m[k]));
                let error: Vec<f64> = u.iter().zip(mean).map(|(u, m)| m - u).collect();
                energies.mismatch[k] += self.energy(model, *cell, &error);
                energies.energy[k] += self.energy(model, *cell, u);
            }
        }
        Some(energies)
    }

    /// vᵀ H v.
    fn energy(&self, model: &FineModel, cell: CoarseCell, v: &[f64]) -> f64 {
        multiply(model, &self.forces.partition, cell, v).iter().zip(v).map(|(a, b)| a * b).sum()
    }

    /// û: per node and field the mean over the cells that have a solid fine cell there.
    fn means(&self, fields: &[(CoarseCell, Vec<f64>)]) -> HashMap<Node, [[f64; 3]; F]> {
        let mut sums: HashMap<Node, (f64, [[f64; 3]; F])> = HashMap::new();
        for (cell, fields) in fields {
            let (stride, solids) = (fields.len() / F, &self.solids[cell.0]);
            let active = self.forces.partition.fine_nodes(*cell).enumerate().filter(|(n, _)| solids.part(*n).is_some());
            for (n, node) in active {
                let (count, sum) = sums.entry(node).or_default();
                *count += 1.0;
                (0..3 * F).for_each(|i| sum[i / 3][i % 3] += fields[stride * (i / 3) + 3 * n + i % 3]);
            }
        }
        sums.into_iter().map(|(node, (count, sum))| (node, sum.map(|u| u.map(|x| x / count)))).collect()
    }

    /// The displacements of all cells of a ring, with their rigid motions.
    fn ring_displacements(&self, model: &FineModel, centre: CoarseCell) -> Option<Vec<(CoarseCell, Vec<f64>)>> {
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
    use crate::mesh::{Label, VoxelGrid};
    use crate::partition::Partition;
    use crate::progress::silent;
    use crate::solver::SolverChoice;
    use crate::training::{HarmonicDisplacements, InterfaceForces, InterfaceSpace};

    /// Two phases in random order on 3 × 3 × 3 coarse cells, of which one lacks its first layer of fine cells from degree 3 on.
    fn body(degree: usize, seed: usize) -> FineModel {
        let mut grid = VoxelGrid::uniform([3 * degree; 3], [1.0, 0.5, 1.5], Label(0));
        for c in 0..grid.labels.len() {
            grid.labels[c] = Label((((c + 3) * (c + seed) * 2654435761) >> 9 & 1) as i32);
            let at = grid.lattice.cell_position(crate::mesh::Cell(c));
            grid.void[c] = degree > 2 && at[0] == 0 && at[1] < degree && at[2] < degree;
        }
        let mut table = MaterialTable::new();
        for (label, young) in [(0, 1e5), (1, 5e6)] {
            let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45).unwrap());
            table.insert(Label(label), Material::linear("", elasticity, 1.0));
        }
        FineModel::new(grid, &table).unwrap()
    }

    #[test]
    fn the_two_errors_are_orthogonal() {
        for degree in [2, 3, 4] {
            let (initial, model) = (body(degree, 11), body(degree, 40));
            let partition = Partition::new(initial.grid().lattice, degree).unwrap();
            let solve = |model| HarmonicDisplacements::solve(model, SolverChoice::Direct, &silent).unwrap();
            let forces = Arc::new(InterfaceForces::new(&initial, &partition, &solve(&initial)));
            let substructures = Substructures::new(&model, forces, InterfaceSpace::default());
            // The ring of the middle cell is the whole body: its exact solution is the global one.
            let (middle, exact) = (CoarseCell(13), solve(&model).displacements);
            let fields = substructures.ring_displacements(&model, middle).unwrap();
            let means = substructures.means(&fields);
            let energies = substructures.ring_energies(&model, middle).unwrap();
            let bound = substructures.error_bound(&model, middle).unwrap();
            assert_eq!(fields.len(), 27);
            for k in 0..F {
                let (mut of_cells, mut of_mean) = (0.0, 0.0);
                for (cell, fields) in &fields {
                    let u = &fields[fields.len() / F * k..][..fields.len() / F];
                    let global = &exact[exact.len() / F * k..][..exact.len() / F];
                    let own: Vec<f64> =
                        partition.fine_nodes(*cell).flat_map(|n| global[3 * n.0..][..3].to_vec()).collect();
                    let mean = partition.fine_nodes(*cell).flat_map(|n| means.get(&n).map_or([0.0; 3], |m| m[k]));
                    let less = |v: Vec<f64>| v.iter().zip(&own).map(|(v, u)| v - u).collect::<Vec<f64>>();
                    of_cells += substructures.energy(&model, *cell, &less(u.to_vec()));
                    of_mean += substructures.energy(&model, *cell, &less(mean.collect()));
                }
                let (sum, all) = (of_cells + of_mean, energies.mismatch[k]);
                assert!((sum - all).abs() < 1e-7 * all, "field {k}: {of_cells:e} + {of_mean:e} is not {all:e}");
                assert!(of_cells > 1e-4 * energies.energy[k], "the change matters");
                assert!((of_cells / energies.energy[k]).sqrt() <= bound[k]);
            }
        }
    }

    #[test]
    fn means_and_forces_as_unknowns_give_the_same_displacements() {
        let (initial, model) = (body(3, 11), body(3, 40));
        let partition = Partition::new(initial.grid().lattice, 3).unwrap();
        let harmonic = HarmonicDisplacements::solve(&initial, SolverChoice::Direct, &silent).unwrap();
        let forces = Arc::new(InterfaceForces::new(&initial, &partition, &harmonic));
        let substructures = Substructures::new(&model, forces, InterfaceSpace::default());
        for cell in [4, 13, 26].map(CoarseCell) {
            let ring = substructures.ring(&model, cell).unwrap();
            let groups = ring.groups();
            let solve = |workspace: &mut super::super::RingWorkspace| workspace.answers(&ring, &groups);
            let means = substructures.with_workspace(&ring.shape, true, solve).unwrap().unwrap();
            let plan = substructures.ring_plan(&ring.shape).unwrap();
            let forces = super::super::dual_answers(&ring, &plan, &groups, true).unwrap();
            for ((member, means), forces) in ring.members.iter().zip(&means).zip(&forces) {
                let of = |answer: &Option<CellAnswer>| {
                    let answer = answer.as_ref().unwrap();
                    substructures.displacements_of(member.as_ref().unwrap(), answer).unwrap()
                };
                let (means, forces) = (of(means), of(forces));
                let size = means.iter().fold(0.0f64, |m, u| m.max(u.abs()));
                let error = means.iter().zip(&forces).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
                assert!(error < 1e-8 * size, "{error:e} of {size:e}");
            }
        }
    }
}
