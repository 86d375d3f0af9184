//! Which coarse nodes a selection of fine nodes holds.

use grosgrain::coarse::{BuildOptions, build};
use grosgrain::dynamics::{solve_coarse, solve_fine};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Axis, Cell, Label, PlaneAt, Selector, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::solver::{SolverChoice, SolverError};

const SPACING: f64 = 0.01;

/// A slab of half the height of its coarse cells, the rest void.
fn half_filled_slab() -> FineModel {
    let mut grid = VoxelGrid::uniform([12, 4, 4], [SPACING; 3], Label(1));
    for cell in 0..grid.lattice.cell_count() {
        grid.void[cell] = grid.lattice.cell_position(Cell(cell))[2] >= 2;
    }
    let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(1e5, 0.3).unwrap());
    let mut table = MaterialTable::new();
    table.insert(Label(1), Material::linear("soft", elasticity, 1000.0));
    FineModel::new(grid, &table).unwrap()
}

fn clamped_end() -> Selector {
    Selector::Plane { axis: Axis::X, at: PlaneAt::Min }
}

#[test]
fn nodes_of_the_air_hold_nothing() {
    let model = half_filled_slab();
    let coarse = build(&model, 4, &BuildOptions::default(), &silent).unwrap().model;
    let loads = gravity(&model, [0.0, 0.0, -9.81]);
    let air = Selector::Box { low: [0.0, 0.0, 0.035], high: [1.0, 1.0, 1.0] };
    let end = clamped_end().nodes(model.grid()).unwrap().mask;
    let end_and_air = Selector::Or(vec![clamped_end(), air]).nodes(model.grid()).unwrap().mask;
    assert_ne!(end, end_and_air, "the box must select nodes of the air");
    let expected = solve_coarse(&coarse, &end, &loads, &silent).unwrap();
    let found = solve_coarse(&coarse, &end_and_air, &loads, &silent).unwrap();
    assert_eq!(found.displacement, expected.displacement);
}

#[test]
fn void_corners_of_a_clamped_end_are_held_with_it() {
    let model = half_filled_slab();
    let coarse = build(&model, 4, &BuildOptions::default(), &silent).unwrap().model;
    let end = clamped_end().nodes(model.grid()).unwrap().mask;
    let solution = solve_coarse(&coarse, &end, &gravity(&model, [0.0, 0.0, -9.81]), &silent).unwrap();
    assert_eq!(solution.held_by_penalty, 0);
    let lattice = coarse.partition().coarse();
    for (j, k) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let node = lattice.node([0, j, k]).0;
        assert_eq!(solution.coarse_displacement[3 * node..3 * node + 3], [0.0; 3]);
    }
}

#[test]
fn loads_that_overflow_are_an_error_and_no_result() {
    let model = half_filled_slab();
    let end = clamped_end().nodes(model.grid()).unwrap().mask;
    for size in [1e200, f64::INFINITY, f64::NAN] {
        let mut loads = gravity(&model, [0.0, 0.0, -9.81]);
        *loads.iter_mut().rfind(|force| **force != 0.0).unwrap() = size;
        for choice in [SolverChoice::Direct, SolverChoice::Iterative] {
            let outcome = solve_fine(&model, &end, &loads, choice, &silent);
            let error = outcome.expect_err("a load that overflows has no solution");
            assert!(matches!(error, SolverError::Inaccurate { .. } | SolverError::Iterative(_)), "{size}: {error}");
        }
    }
}
