//! Energy, forces and tangents of the fine model under large deformation, on one thread.

#[path = "cases/mod.rs"]
mod cases;
#[path = "baselines/simplicial.rs"]
mod simplicial;

use cases::Outcome;
use cases::forces::ForcesCase;
use criterion::Throughput;
use grosgrain::material::{Law, Projection};

const CELLS: [usize; 3] = [32, 16, 16];

fn main() -> Outcome<()> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let mut criterion = cases::criterion();
    let mut group = criterion.benchmark_group("large deformation");
    group.throughput(Throughput::Elements(CELLS.iter().product::<usize>() as u64));
    for law in [Law::Linear, Law::Corotational, Law::NeoHookean] {
        let mut case = ForcesCase::new(CELLS, law)?;
        case.tangents(Projection::Exact)?;
        group.bench_function(format!("energy, {law}"), |b| b.iter(|| case.energy()));
        group.bench_function(format!("forces, {law}"), |b| b.iter(|| case.gradient()));
        group.bench_function(format!("exact tangents, {law}"), |b| b.iter(|| case.tangents(Projection::Exact)));
        let projection = Projection::PositiveSemidefinite;
        group.bench_function(format!("projected tangents, {law}"), |b| b.iter(|| case.tangents(projection)));
    }
    group.finish();
    criterion.final_summary();
    Ok(())
}
