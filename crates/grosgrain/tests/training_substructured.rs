//! Training in substructures: exact where nothing has changed, exact under full coupling, the same after an update as after a new build.

mod bodies;

use std::sync::Arc;

use bodies::*;
use grosgrain::coarse::occupied_cells;
use grosgrain::fine::FineModel;
use grosgrain::mesh::{Label, VoxelGrid};
use grosgrain::partition::{CoarseCell, Partition};
use grosgrain::progress::silent;
use grosgrain::solver::SolverChoice;
use grosgrain::training::{
    HarmonicDisplacements, InterfaceForces, InterfaceSpace, LocalTrainer, RingKind, Substructures, Training,
};
use proptest::prelude::*;

/// Phases 1, 2, …; 0 is void.
fn body(cells: [usize; 3], phases: &[u8], youngs: &[f64]) -> FineModel {
    let mut grid = VoxelGrid::uniform(cells, [1.0, 0.5, 1.5], Label(0));
    for (c, phase) in phases.iter().enumerate() {
        grid.void[c] = *phase == 0;
        grid.labels[c] = Label(i32::from((*phase).max(1)) - 1);
    }
    let materials: Vec<_> = youngs.iter().map(|young| isotropic(*young, 0.45)).collect();
    FineModel::new(grid, &table(&materials)).unwrap()
}

fn phases(count: usize, seed: usize) -> Vec<u8> {
    (0..count).map(|n| 1 + ((n + 3) * (n + 11 * seed) * 2654435761 >> 7 & 1) as u8).collect()
}

fn forces(model: &FineModel, degree: usize) -> (Partition, HarmonicDisplacements, Arc<InterfaceForces>) {
    let partition = Partition::new(model.grid().lattice, degree).unwrap();
    let harmonic = HarmonicDisplacements::solve(model, SolverChoice::Direct, &silent).unwrap();
    let forces = Arc::new(InterfaceForces::new(model, &partition, &harmonic));
    (partition, harmonic, forces)
}

/// Largest difference of a cell's data over their largest entry.
fn difference(found: &[f64], expected: &[f64]) -> f64 {
    let size = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    found.iter().zip(expected).fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / size
}

/// Compares the cells that are solved in substructures with the global data; returns how many they are.
fn compare_with_global(model: &FineModel, degree: usize, tolerance: f64) -> usize {
    let (partition, harmonic, forces) = forces(model, degree);
    let substructures = Substructures::new(model, forces, InterfaceSpace::default());
    let cells = occupied_cells(model, &partition);
    let global = Training::from_harmonic(model, &partition, &cells, &harmonic);
    let mut solved = 0;
    for (index, &cell) in cells.iter().enumerate() {
        let Some(found) = substructures.train_cell(model, cell) else { continue };
        solved += 1;
        let error = difference(&found, global.of(index));
        assert!(error < tolerance, "{cell:?}: {error:e}");
    }
    solved
}

#[test]
fn without_a_change_the_data_are_the_global_ones() {
    for (degree, coarse) in [(2, [4, 3, 3]), (3, [3, 2, 4]), (4, [3, 3, 1]), (1, [4, 3, 3])] {
        let cells = coarse.map(|n| n * degree);
        let count = cells.iter().product();
        let model = body(cells, &phases(count, degree), &[1e5, 5e6]);
        assert_eq!(compare_with_global(&model, degree, 1e-8), coarse.iter().product());
    }
}
