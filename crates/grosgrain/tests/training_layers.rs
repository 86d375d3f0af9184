//! Harmonic displacements of finite layered bodies whose exact solution is known.
//!
//! Under a uniform traction σ_zz on its ends a body layered along z has the uniaxial stress σ_zz everywhere if the lateral strain −ν σ/E is the same in
//! all layers: then the layers do not hinder each other. The displacement is piecewise linear, so the hexahedra are exact.

mod bodies;

use bodies::*;
use grosgrain::fine::FineModel;
use grosgrain::mesh::{Cell, Label, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::solver::SolverChoice;
use grosgrain::training::HarmonicDisplacements;

/// Layers along `axis`; (E, ν) per layer, two cells each.
fn check(layers: &[(f64, f64)], axis: usize) {
    let mut cells = [3, 4, 5];
    cells[axis] = 2 * layers.len();
    let mut grid = VoxelGrid::uniform(cells, [1.0, 0.5, 2.0], Label(0));
    for c in 0..grid.lattice.cell_count() {
        grid.labels[c] = Label((grid.lattice.cell_position(Cell(c))[axis] / 2) as i32);
    }
    let phases: Vec<_> = layers.iter().map(|(young, poisson)| isotropic(*young, *poisson)).collect();
    let model = FineModel::new(grid, &table(&phases)).unwrap();
    let lattice = model.grid().lattice;
    let softest = layers.iter().fold(f64::INFINITY, |m, l| m.min(l.0));
    for (choice, tolerance) in [(SolverChoice::Direct, 1e-9), (SolverChoice::Iterative, 1e-5)] {
        let harmonic = HarmonicDisplacements::solve(&model, choice, &silent).unwrap();
        let stride = 3 * lattice.node_count();
        let u = &harmonic.displacements[stride * axis..][..stride];
        for cell in (0..lattice.cell_count()).map(Cell) {
            let (young, poisson) = layers[lattice.cell_position(cell)[axis] / 2];
            let mut exact = [0.0; 6];
            exact[..3].fill(-poisson / young);
            exact[axis] = 1.0 / young;
            for at in sample_points() {
                let found = strain(lattice, model.grid().spacing, u, cell, at);
                for i in 0..6 {
                    let error = (found[i] - exact[i]).abs() * softest;
                    assert!(error < tolerance, "{choice:?}, axis {axis}, {cell:?}, strain {i}: off by {error:.1e}");
                }
            }
        }
    }
}

#[test]
fn a_layered_body_without_lateral_contraction_stretches_like_springs_in_series() {
    for axis in 0..3 {
        check(&[(1.0, 0.0), (50.0, 0.0), (1e3, 0.0), (7.0, 0.0)], axis);
    }
}

#[test]
fn layers_of_equal_ratio_of_poisson_to_young_contract_alike() {
    for axis in 0..3 {
        check(&[(1.0, 0.1), (4.5, 0.45), (2.0, 0.2), (3.5, 0.35)], axis);
    }
}
