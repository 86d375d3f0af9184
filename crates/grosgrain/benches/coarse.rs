//! The coarse model: stiffness of one cell, and the maps between coarse and fine nodes.

#[path = "cases/mod.rs"]
mod cases;
#[path = "baselines/simplicial.rs"]
mod simplicial;

use cases::Outcome;
use cases::coarse::CoarseCase;

fn main() -> Outcome<()> {
    let mut criterion = cases::criterion();
    let mut group = criterion.benchmark_group("coarse model");
    for degree in 2..=5 {
        let case = CoarseCase::new(degree)?;
        group.bench_function(format!("stiffness of a cell, d = {degree}"), |b| b.iter(|| case.galerkin()));
        let embedding = case.embedding();
        group.bench_function(format!("prolong, d = {degree}"), |b| b.iter(|| case.prolong(&embedding)));
        group.bench_function(format!("restrict, d = {degree}"), |b| b.iter(|| case.restrict(&embedding)));
    }
    group.finish();
    criterion.final_summary();
    Ok(())
}
