//! Steps in time of a beam of 24 coarse cells, coarse and fine.

#[path = "cases/mod.rs"]
mod cases;
#[path = "baselines/simplicial.rs"]
mod simplicial;

use cases::Outcome;
use cases::steps::MovingBody;
use grosgrain::coarse::Integration;
use grosgrain::dynamics::StepOptions;

fn main() -> Outcome<()> {
    let mut criterion = cases::criterion();
    let mut group = criterion.benchmark_group("steps in time");
    let body = MovingBody::beam()?;
    let coarse = body.coarse()?;
    for integration in [Integration::Stiffness, Integration::Centre, Integration::Gauss] {
        let mut steps = body.coarse_steps(&coarse, integration, StepOptions::default())?;
        steps.advance()?;
        group.bench_function(format!("coarse, {integration:?}"), |b| {
            b.iter(|| steps.advance().map_err(|e| e.to_string()))
        });
    }
    let mut steps = body.fine_steps(StepOptions::default())?;
    steps.advance()?;
    group.bench_function("fine", |b| b.iter(|| steps.advance().map_err(|e| e.to_string())));
    group.finish();
    criterion.final_summary();
    Ok(())
}
