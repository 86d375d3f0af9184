//! The stiffness of a whole body: analysis, assembly, factorisation, solve; and iteration instead.

#[path = "cases/mod.rs"]
mod cases;
#[path = "baselines/simplicial.rs"]
mod simplicial;

use cases::Outcome;
use cases::lattice::{IterativeCase, LatticeCase, analyse};

fn main() -> Outcome<()> {
    let mut criterion = cases::criterion();
    for cells in [16, 24] {
        let mut case = LatticeCase::new(cells)?;
        case.factor()?;
        let mut group = criterion.benchmark_group(format!("{cells}³ cells"));
        group.bench_function("analyse", |b| b.iter(|| analyse(cells)));
        group.bench_function("assemble", |b| b.iter(|| case.assemble()));
        group.bench_function("factor", |b| b.iter(|| case.factor()));
        group.bench_function("solve", |b| b.iter(|| case.solve()));
        group.finish();
    }
    let mut group = criterion.benchmark_group("conjugate gradients, 24³ cells");
    for ratio in [1.0, 1000.0] {
        let mut case = IterativeCase::new(24, ratio)?;
        case.solve()?;
        group.bench_function(format!("ratio {ratio}"), |b| b.iter(|| case.solve()));
    }
    group.finish();
    criterion.final_summary();
    Ok(())
}
