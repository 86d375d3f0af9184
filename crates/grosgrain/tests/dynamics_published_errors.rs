//! Errors of coarse cantilevers against those of an independent prototype of the method.

mod bodies;

use std::path::Path;

use bodies::*;
use grosgrain::coarse::{BuildOptions, Method, build};
use grosgrain::coarsening::BaseKind;
use grosgrain::dynamics::{FineSolution, relative_error, solve_coarse, solve_fine};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::mesh::{Label, Pattern, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::solver::SolverChoice;
use grosgrain::training::TrainingKind;

const DEGREE: usize = 3;

/// 16×4×4 coarse cells of degree 3, layers two fine cells thick, ratio of moduli 50.
fn cantilever(direction: [f64; 3]) -> FineModel {
    let mut grid = VoxelGrid::uniform([48, 12, 12], [1.0; 3], Label(0));
    let labels = vec![Label(0), Label(1)];
    Pattern::Layers { direction, period: 4.0, labels }.paint(&mut grid).unwrap();
    let mut table = table(&[isotropic(1e5, 0.45), isotropic(5e6, 0.45)]);
    let mut stiff = table.get(Label(1)).unwrap().clone();
    stiff.density = table.get(Label(0)).unwrap().density;
    table.insert(Label(1), stiff);
    FineModel::new(grid, &table).unwrap()
}

fn options(name: &str) -> BuildOptions {
    let (method, base) = match name {
        "trilinear" => (Method::Trilinear, BaseKind::Harmonic),
        "global[harmonic]" => (Method::Trained(TrainingKind::Global), BaseKind::Harmonic),
        "global[trilinear]" => (Method::Trained(TrainingKind::Global), BaseKind::Trilinear),
        "global[material]" => (Method::Trained(TrainingKind::Global), BaseKind::Material),
        "one-ring[harmonic]" => (Method::Trained(TrainingKind::OneRing), BaseKind::Harmonic),
        _ => panic!("the table names an unknown method {name}"),
    };
    BuildOptions { method, base, ..BuildOptions::default() }
}

/// Relative L² error of the embedded coarse displacement in percent.
fn error(model: &FineModel, fixed: &[bool], loads: &[f64], fine: &FineSolution, name: &str) -> f64 {
    let built = build(model, DEGREE, &options(name), &silent).unwrap();
    let coarse = solve_coarse(&built.model, fixed, loads, &silent).unwrap();
    100.0 * relative_error(&coarse.displacement, &fine.displacement)
}

#[test]
fn errors_of_coarse_cantilevers_are_those_of_the_prototype() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/cantilever_errors.txt");
    let text = std::fs::read_to_string(file).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split_whitespace());
    let methods: Vec<&str> = lines.next().unwrap().skip(4).collect();
    let mut compared = 0;
    for mut words in lines {
        let name = words.next().unwrap();
        let direction: Vec<f64> = words.by_ref().take(3).map(|w| w.parse().unwrap()).collect();
        let model = cantilever([direction[0], direction[1], direction[2]]);
        let fixed = plane(model.grid().lattice, 0, 0);
        let loads = gravity(&model, [0.0, 0.0, -9.81]);
        let fine = solve_fine(&model, &fixed, &loads, SolverChoice::Direct, &silent).unwrap();
        for (method, printed) in methods.iter().zip(words) {
            let decimals = printed.split_once('.').map_or(0, |(_, tail)| tail.len() as i32);
            let found = error(&model, &fixed, &loads, &fine, method);
            let difference = (found - printed.parse::<f64>().unwrap()).abs();
            // Printed values are rounded; half a unit of the last digit, and a hundredth of it for the rounding of a tie.
            assert!(difference <= 0.51 * 10f64.powi(-decimals), "{name}, {method}: {found:.3} % against {printed} %");
            compared += 1;
        }
    }
    assert_eq!(compared, 15);
}
