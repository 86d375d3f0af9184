//! Shape functions of one coarse cell: closed form, per-node systems, coupled system.

#[path = "cases/mod.rs"]
mod cases;
#[path = "baselines/simplicial.rs"]
mod simplicial;

use cases::Outcome;
use cases::fitting::FitCase;
use grosgrain::coarsening::Systems;

fn main() -> Outcome<()> {
    let mut criterion = cases::criterion();
    let mut group = criterion.benchmark_group("fit");
    for degree in 2..=7 {
        let mut case = FitCase::new(degree)?;
        group.bench_function(format!("closed form, d = {degree}"), |b| b.iter(|| case.closed_form()));
        group.bench_function(format!("a system per node, d = {degree}"), |b| {
            b.iter(|| case.per_node(Systems::EveryNode));
        });
        group.bench_function(format!("a system per cell, d = {degree}"), |b| {
            b.iter(|| case.per_node(Systems::OncePerCell));
        });
        if degree <= 3 {
            case.coupled()?;
            group.bench_function(format!("coupled, d = {degree}"), |b| b.iter(|| case.coupled()));
        }
    }
    group.finish();
    criterion.final_summary();
    Ok(())
}
