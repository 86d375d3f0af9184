//! Harmonic displacements of one coarse cell on its one-ring and alone, and of many cells on threads.

#[path = "cases/mod.rs"]
mod cases;
#[path = "baselines/simplicial.rs"]
mod simplicial;

use cases::Outcome;
use cases::harmonic::{HarmonicCase, ManyCells};
use grosgrain::training::RingKind;

fn main() -> Outcome<()> {
    let mut criterion = cases::criterion();
    for (name, kind) in [("one-ring", RingKind::OneRing), ("single-cell", RingKind::SingleCell)] {
        let mut group = criterion.benchmark_group(name);
        for degree in 2..=7 {
            let case = HarmonicCase::new(degree, kind)?;
            group.bench_function(format!("d = {degree}"), |b| b.iter(|| case.train()));
        }
        group.finish();
    }
    let mut group = criterion.benchmark_group("simplicial baseline, one-ring");
    for degree in 2..=3 {
        let mut case = HarmonicCase::new(degree, RingKind::OneRing)?;
        let mut baseline = case.simplicial()?;
        group.bench_function(format!("d = {degree}"), |b| b.iter(|| case.factor_and_solve_with(&mut baseline)));
    }
    group.finish();
    let mut group = criterion.benchmark_group("64 cells, one-ring, d = 3");
    for threads in 1..=2 {
        let case = ManyCells::new(3, threads)?;
        group.bench_function(format!("threads = {threads}"), |b| b.iter(|| case.train()));
    }
    group.finish();
    criterion.final_summary();
    Ok(())
}
