//! The baselines that the benchmarks compare with compute what they claim to.

#[path = "../benches/cases/mod.rs"]
mod cases;
#[path = "../benches/baselines/simplicial.rs"]
mod simplicial;

use cases::fitting::FitCase;
use cases::harmonic::HarmonicCase;
use grosgrain::coarsening::Systems;
use grosgrain::training::RingKind;

/// Forming B Bᵀ squares the condition of the data, about 10² here: 10⁴ roundings of 10⁻¹⁶ leave room below 10⁻⁸.
#[test]
fn the_published_optimisation_per_node_is_the_closed_form() {
    for degree in 2..=4 {
        let mut case = FitCase::new(degree).unwrap();
        case.closed_form();
        let closed_form = case.functions.clone();
        for systems in [Systems::EveryNode, Systems::OncePerCell] {
            case.functions.fill(f64::NAN);
            assert!(case.per_node(systems), "singular multiplier system at degree {degree}");
            let difference = case.difference(&closed_form);
            assert!(difference < 1e-8, "degree {degree}, {systems:?}: {difference:.1e}");
        }
    }
}

#[test]
fn the_simplicial_baseline_solves_the_same_system() {
    let mut case = HarmonicCase::new(2, RingKind::OneRing).unwrap();
    let ours = case.solution().to_vec();
    let mut baseline = case.simplicial().unwrap();
    assert!(case.factor_and_solve_with(&mut baseline));
    let size = ours.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let difference = ours.iter().zip(case.solution()).fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / size;
    assert!(difference < 1e-10, "relative difference {difference:.1e}");
}
