//! Patch tests: where the exact displacement is linear, the fine model finds it.

mod bodies;

use bodies::*;
use grosgrain::dynamics::solve_fine;
use grosgrain::fine::{FineModel, constant_stress};
use grosgrain::material::Elasticity;
use grosgrain::mesh::{Cell, Label, Node, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::solver::SolverChoice;
use grosgrain::training::HarmonicDisplacements;

const GRADIENT: [[f64; 3]; 3] = [[1e-3, 2e-3, -5e-4], [3e-4, -2e-3, 7e-4], [1e-4, 4e-4, 1.5e-3]];

fn homogeneous_bodies() -> Vec<(&'static str, Elasticity)> {
    vec![
        ("soft", isotropic(3.0, 0.3)),
        ("nearly incompressible", isotropic(2e9, 0.49)),
        ("auxetic", isotropic(1.0, -0.6)),
        ("21 constants", Elasticity::Anisotropic(random_tensor(4))),
    ]
}

/// Non-cubic cells, a void inside, a notch at one corner and a shaft through the body.
fn body_with_voids() -> VoxelGrid {
    let mut grid = VoxelGrid::uniform([7, 6, 5], [1.0, 0.4, 2.5], Label(0));
    for c in 0..grid.lattice.cell_count() {
        let [i, j, k] = grid.lattice.cell_position(Cell(c));
        grid.void[c] = [i, j, k] == [2, 2, 2] || (i > 4 && j > 3 && k > 2) || (i, j) == (4, 1);
    }
    grid
}

/// Solid nodes that touch fewer than eight solid cells.
fn boundary_nodes(model: &FineModel) -> Vec<bool> {
    let lattice = model.grid().lattice;
    let solid = |n: usize| lattice.cells_at(Node(n)).filter(|c| !model.is_void(*c)).count();
    (0..lattice.node_count()).map(|n| (1..8).contains(&solid(n))).collect()
}

#[test]
fn linear_displacements_of_the_boundary_are_continued_linearly() {
    for (name, elasticity) in homogeneous_bodies() {
        let model = FineModel::new(body_with_voids(), &table(&[elasticity])).unwrap();
        let boundary = boundary_nodes(&model);
        let free = (0..boundary.len()).filter(|&n| model.active()[n] && !boundary[n]).count();
        assert!(free >= 20, "the body has only {free} free nodes");
        let mut exact = lattice_vector(model.grid(), |x| apply(GRADIENT, x));
        (0..exact.len()).filter(|i| !model.active()[i / 3]).for_each(|i| exact[i] = 0.0);
        let start: Vec<f64> = (0..exact.len()).map(|i| if boundary[i / 3] { exact[i] } else { 0.0 }).collect();
        let loads: Vec<f64> = multiply(&model, &start).iter().map(|f| -f).collect();
        // The solvers stop at relative residuals of 1e-12 and 1e-8; inner nodes hang on their prescribed neighbours,
        // so the condition stays below 1e3 at Poisson's ratio 0.49.
        for (choice, tolerance) in [(SolverChoice::Direct, 1e-10), (SolverChoice::Iterative, 1e-5)] {
            let solution = solve_fine(&model, &boundary, &loads, choice, &silent).unwrap();
            let found: Vec<f64> = start.iter().zip(&solution.displacement).map(|(a, b)| a + b).collect();
            let error = relative(&found, &exact);
            assert!(error < tolerance, "{name}, {choice:?}: {error:.1e}");
        }
    }
}

#[test]
fn a_constant_surface_stress_makes_the_same_stress_everywhere() {
    for (name, elasticity) in homogeneous_bodies() {
        let mut grid = body_with_voids();
        let inside = grid.lattice.cell([2, 2, 2]).0;
        grid.void[inside] = false;
        let model = FineModel::new(grid, &table(&[elasticity])).unwrap();
        let lattice = model.grid().lattice;
        let harmonic = HarmonicDisplacements::solve(&model, SolverChoice::Direct, &silent).unwrap();
        for (field, u) in harmonic.displacements.chunks_exact(3 * lattice.node_count()).enumerate() {
            let exact = voigt(constant_stress(field));
            let mut worst = 0.0f64;
            for cell in (0..lattice.cell_count()).map(Cell) {
                let Some(tensor) = model.elasticity(cell) else { continue };
                for at in sample_points() {
                    let e = strain(lattice, model.grid().spacing, u, cell, at);
                    for (i, row) in tensor.voigt().iter().enumerate() {
                        worst = worst.max((dot(row, &e) - exact[i]).abs());
                    }
                }
            }
            // Strains are differences of displacements: a relative residual of 1e-12 loses the cells across the body
            // and the ratio of the largest to the smallest stiffness, below 1e3 together.
            assert!(worst < 1e-9, "{name}, field {field}: stress off by {worst:.1e} of 1");
        }
    }
}

#[test]
fn harmonic_displacements_have_no_mean_and_no_first_moment() {
    let model = FineModel::new(body_with_voids(), &table(&[isotropic(1.0, 0.3)])).unwrap();
    let harmonic = HarmonicDisplacements::solve(&model, SolverChoice::Direct, &silent).unwrap();
    let nodes: Vec<usize> = (0..model.active().len()).filter(|&n| model.active()[n]).collect();
    for (field, u) in harmonic.displacements.chunks_exact(3 * model.active().len()).enumerate() {
        let (mut mean, mut moment) = ([0.0; 3], [0.0; 3]);
        for &n in &nodes {
            let (x, v) = (model.node_position(Node(n)), &u[3 * n..3 * n + 3]);
            for a in 0..3 {
                let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                mean[a] += v[a] / nodes.len() as f64;
                moment[a] += (x[b] * v[c] - x[c] * v[b]) / nodes.len() as f64;
            }
        }
        let scale = largest(u);
        assert!(largest(&mean) < 1e-13 * scale, "field {field}: mean {mean:?} of {scale}");
        assert!(largest(&moment) < 1e-12 * scale * 12.5, "field {field}: moment {moment:?} of {scale} m × 12.5 m");
    }
}

fn voigt(stress: [[f64; 3]; 3]) -> [f64; 6] {
    [stress[0][0], stress[1][1], stress[2][2], stress[1][2], stress[0][2], stress[0][1]]
}
