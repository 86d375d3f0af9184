//! Results do not depend on the number of threads, to the last bit.

mod bodies;

use bodies::*;
use grosgrain::coarse::{BuildOptions, Method, build};
use grosgrain::coarsening::{BaseKind, Objective};
use grosgrain::dynamics::{solve_coarse, solve_fine};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::progress::silent;
use grosgrain::solver::SolverChoice;
use grosgrain::training::TrainingKind;

/// The bits of everything that a build and a solve compute.
fn coarse_bits(model: &FineModel, method: Method, base: BaseKind) -> Vec<u64> {
    let options = BuildOptions { method, base, objective: Objective::ClosedForm };
    let built = build(model, 2, &options, &silent).unwrap();
    let fixed = plane(model.grid().lattice, 0, 0);
    let loads = gravity(model, [0.0, 0.0, -9.81]);
    let solution = solve_coarse(model, &built.model, &fixed, &loads, &silent).unwrap();
    let mut values: Vec<f64> = built.training.iter().flat_map(|t| t.data().to_vec()).collect();
    values.extend(built.model.functions().data());
    (0..built.model.cells().len()).for_each(|index| values.extend(built.model.cell_stiffness(index)));
    values.extend(built.model.mass());
    values.extend(&solution.displacement);
    values.push(solution.energy);
    values.iter().map(|v| v.to_bits()).collect()
}

fn fine_bits(model: &FineModel, choice: SolverChoice) -> Vec<u64> {
    let fixed = plane(model.grid().lattice, 0, 0);
    let loads = gravity(model, [0.0, 0.0, -9.81]);
    let solution = solve_fine(model, &fixed, &loads, choice, &silent).unwrap();
    solution.displacement.iter().chain([&solution.energy]).map(|v| v.to_bits()).collect()
}

fn alike_with_1_2_and_5_threads(what: &str, compute: impl Fn() -> Vec<u64> + Sync) {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(&compute)
    };
    let one = with(1);
    for threads in [2, 5] {
        let many = with(threads);
        assert_eq!(many.len(), one.len());
        let differing = many.iter().zip(&one).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 0, "{what}: {differing} of {} numbers differ with {threads} threads", one.len());
    }
}

#[test]
fn training_functions_stiffness_and_coarse_solutions_are_alike_for_any_number_of_threads() {
    let model = random_model([12, 6, 6], [1.0, 0.5, 2.0], 1e4, 0.4, 31);
    let kinds = [TrainingKind::Global, TrainingKind::OneRing, TrainingKind::Substructured, TrainingKind::SingleCell];
    for kind in kinds {
        for base in [BaseKind::Harmonic, BaseKind::Material] {
            let what = format!("{kind:?}, {base:?}");
            alike_with_1_2_and_5_threads(&what, || coarse_bits(&model, Method::Trained(kind), base));
        }
    }
    for method in [Method::Trilinear, Method::Average] {
        alike_with_1_2_and_5_threads(&format!("{method:?}"), || coarse_bits(&model, method, BaseKind::Harmonic));
    }
}

#[test]
fn fine_solutions_are_alike_for_any_number_of_threads() {
    let model = random_model([24, 18, 18], [1.0, 0.5, 2.0], 1e3, 0.4, 37);
    for choice in [SolverChoice::Direct, SolverChoice::Iterative] {
        alike_with_1_2_and_5_threads(&format!("{choice:?}"), || fine_bits(&model, choice));
    }
}
