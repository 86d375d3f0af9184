//! Harmonic displacements of the whole object.

use super::TrainingError;
use super::rigid::remove_rigid_motion;
use crate::assembly::CellStiffness;
use crate::fine::{FineModel, HARMONIC_FIELDS, constant_stress_loads};
use crate::mesh::hull;
use crate::progress::Progress;
use crate::solver::{Hold, LatticeSystem, SolveReport, SolverChoice};

/// The six harmonic displacements h_αβ of the whole object (`kharevych2009numerical`): div(C:ε(h_αβ)) = 0 with the traction
/// ½(e_α⊗e_β + e_β⊗e_α) n on the outer boundary; interior voids carry none.
#[derive(Clone, Debug)]
pub struct HarmonicDisplacements {
    /// Six lattice vectors \[m per Pa of traction\], 3 entries per node, one after the other in the order xx, yy, zz, yz, xz, xy;
    /// zero at nodes that touch no solid cell. Mean and first moment over the body's nodes are zero.
    pub displacements: Vec<f64>,
    /// How they were solved.
    pub report: SolveReport,
}

impl HarmonicDisplacements {
    /// Solves the six problems with one factorisation or six iterations.
    ///
    /// # Errors
    /// When the systems are not solved, or the callback interrupts.
    pub fn solve(model: &FineModel, choice: SolverChoice, progress: Progress<'_>) -> Result<Self, TrainingError> {
        let mut displacements = loads(model);
        let system = LatticeSystem { cells: model, spacing: model.grid().spacing, hold: Hold::Equilibrium };
        let report = system.solve(choice, &mut displacements, progress).map_err(TrainingError::Global)?;
        Ok(Self { displacements: without_rigid_motion(model, displacements), report })
    }
}

/// The loads of the six problems, one lattice vector after the other.
pub(super) fn loads(model: &FineModel) -> Vec<f64> {
    let lattice = model.lattice();
    let mut loads = vec![0.0; 3 * HARMONIC_FIELDS * lattice.node_count()];
    constant_stress_loads(lattice, model.grid().spacing, &hull(&model.grid().void, &lattice), &mut loads);
    loads
}

/// Takes the rigid part over the body's nodes out of each displacement.
pub(super) fn without_rigid_motion(model: &FineModel, mut displacements: Vec<f64>) -> Vec<f64> {
    let lattice = model.lattice();
    for column in displacements.chunks_exact_mut(3 * lattice.node_count()) {
        remove_rigid_motion(lattice, model.grid().spacing, model.active(), column);
    }
    displacements
}
