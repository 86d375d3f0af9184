//! What exact training costs, and which kind is cheaper at run time.

use super::condensed::{CondensedPlan, CondensedShape};
use super::{REFACTOR_LIMIT, TrainingKind};
use crate::fine::HARMONIC_FIELDS;
use crate::linalg::{FrontalPlan, box_tree};
use crate::mesh::{Cell, Lattice};
use crate::partition::Partition;

/// Training of a body that is edited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RunTimeTraining {
    /// The exact training, global or one-ring, that is cheaper for edits of so many coarse cells that touch each other.
    Auto {
        /// Number of coarse cells of a typical edit.
        edited_cells: usize,
    },
    /// This training.
    Fixed(TrainingKind),
}

impl Default for RunTimeTraining {
    fn default() -> Self {
        Self::Auto { edited_cells: 1 }
    }
}

/// Predicted seconds of training on one thread, from operation counts and the rate of rings that `examples/benchmarks` measured on one machine; good
/// for comparing kinds roughly, not for planning: the factorisation of a whole body is slower than that rate by up to two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingCost {
    /// One solution of the global problem.
    pub global: f64,
    /// The one-ring of one interior coarse cell.
    pub one_ring: f64,
    /// Coarse cells that an edit makes dirty for one-ring training.
    pub dirty: usize,
}

/// Seconds per operation, per unknown and per unknown of an iterative solution (six right-hand sides).
const PER_OPERATION: f64 = 1.2e-11;
const PER_UNKNOWN: f64 = 2.0e-7;
const PER_ITERATED_UNKNOWN: f64 = 1.0e-5;

impl TrainingCost {
    /// The cost of renewing what an edit of `edited_cells` coarse cells makes dirty.
    pub fn new(partition: &Partition, edited_cells: usize) -> Self {
        let coarse = partition.coarse().cells;
        let ring = coarse.map(|n| n.min(3));
        // The edited cells form a block that is as compact as the lattice lets it be.
        let side = (edited_cells.max(1) as f64).cbrt();
        let dirty: f64 = coarse.iter().map(|n| (*n as f64).min(side + 2.0)).product();
        Self { global: global(partition.fine()), one_ring: one_ring(partition, ring), dirty: dirty.ceil() as usize }
    }

    /// The cheaper exact training; global where they cost the same.
    pub fn cheaper(&self) -> TrainingKind {
        match self.global <= self.dirty as f64 * self.one_ring {
            true => TrainingKind::Global,
            false => TrainingKind::OneRing,
        }
    }
}

/// The training that a live model uses.
pub fn run_time_training(partition: &Partition, training: RunTimeTraining) -> TrainingKind {
    match training {
        RunTimeTraining::Fixed(kind) => kind,
        RunTimeTraining::Auto { edited_cells } => TrainingCost::new(partition, edited_cells).cheaper(),
    }
}

fn global(lattice: Lattice) -> f64 {
    let unknowns = 3.0 * lattice.node_count() as f64;
    if unknowns > REFACTOR_LIMIT as f64 {
        return PER_ITERATED_UNKNOWN * unknowns;
    }
    let corners = |c: usize| lattice.corners(Cell(c)).map(|n| n.0 as u32).to_vec();
    let elements: Vec<Vec<u32>> = (0..lattice.cell_count()).map(corners).collect();
    let plan = FrontalPlan::new(lattice.node_count(), 3, &elements, &box_tree(lattice.nodes()));
    // The groups of a box hold every node once; were there no plan, iterating would be left.
    plan.map_or(PER_ITERATED_UNKNOWN * unknowns, |plan| seconds(&plan))
}

fn one_ring(partition: &Partition, ring: [usize; 3]) -> f64 {
    let degree = partition.degree();
    let shape = CondensedShape { cells: ring.map(|n| n * degree), core: ring.map(|n| n / 2 * degree), degree };
    CondensedPlan::new(shape).map_or(f64::INFINITY, |plan| seconds(plan.frontal()))
}

fn seconds(plan: &FrontalPlan) -> f64 {
    PER_OPERATION * plan.operations(HARMONIC_FIELDS) + PER_UNKNOWN * plan.order() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(cells: [usize; 3], degree: usize) -> TrainingKind {
        let partition = Partition::new(Lattice::new(cells.map(|n| n * degree)), degree).unwrap();
        run_time_training(&partition, RunTimeTraining::default())
    }

    #[test]
    fn small_bodies_are_trained_as_a_whole_and_large_ones_around_the_edit() {
        assert_eq!(kind([6, 2, 2], 4), TrainingKind::Global);
        assert_eq!(kind([24, 24, 18], 2), TrainingKind::OneRing);
        assert_eq!(kind([1, 1, 1], 3), TrainingKind::Global);
    }

    #[test]
    fn the_larger_the_edit_the_more_cells_are_dirty_up_to_all() {
        let partition = Partition::new(Lattice::new([16, 8, 8]), 2).unwrap();
        let dirty = |n| TrainingCost::new(&partition, n).dirty;
        assert_eq!([dirty(1), dirty(8), dirty(10_000)], [27, 64, 8 * 4 * 4]);
    }
}
