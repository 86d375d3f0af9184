//! Cholesky against multigrid-preconditioned conjugate gradients: prints a table as Markdown.
//!
//! Sample runs:
//!
//! ```sh
//! cargo run --release -p grosgrain --example solver_choice            # both solvers, small bodies
//! cargo run --release -p grosgrain --example solver_choice -- large   # 48 x 48 x 36 and 128 x 128 x 128, automatic choice
//! ```
//!
//! The bodies are cubes (or boxes) of two phases with an E ratio of 1000 and ν = 0.45, clamped at x = 0 under gravity:
//! blobs (random blocks of 4³ cells) and layers four cells thick. Each row is one static solve to a relative residual of 1e-8.

use std::error::Error;
use std::time::Instant;

use grosgrain::assembly::Constraints;
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Axis, Label, Pattern, PlaneAt, Selector, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::solver::{Hold, LatticeSystem, SolverChoice};

const RATIO: f64 = 1e3;

fn main() -> Result<(), Box<dyn Error>> {
    println!("| body | cells | unknowns | right-hand sides | solver | iterations | residual | seconds | peak MB |");
    println!("|---|---|---|---|---|---|---|---|---|");
    if std::env::args().any(|argument| argument == "large") {
        for cells in [[48, 48, 36], [128, 128, 128]] {
            row(cells, ("blobs", blobs()), 1, SolverChoice::Auto)?;
        }
        return row([48, 48, 36], ("layers", layers()), 1, SolverChoice::Auto);
    }
    for n in [12, 16, 20, 24, 28, 32, 40] {
        for columns in [1, 6] {
            for choice in [SolverChoice::Direct, SolverChoice::Iterative] {
                row([n; 3], ("blobs", blobs()), columns, choice)?;
                row([n; 3], ("layers", layers()), columns, choice)?;
            }
        }
    }
    Ok(())
}

fn blobs() -> Pattern {
    Pattern::Random { seed: 1, size: 4, labels: vec![Label(0), Label(1)], fractions: None }
}

fn layers() -> Pattern {
    Pattern::Layers { direction: [1.0, 0.0, 1.0], period: 8.0, labels: vec![Label(0), Label(1)] }
}

fn row(
    cells: [usize; 3],
    (name, pattern): (&str, Pattern),
    columns: usize,
    choice: SolverChoice,
) -> Result<(), Box<dyn Error>> {
    let mut grid = VoxelGrid::uniform(cells, [0.01; 3], Label(0));
    pattern.paint(&mut grid)?;
    let fixed = Selector::Plane { axis: Axis::X, at: PlaneAt::Min }.nodes(&grid)?.mask;
    let model = FineModel::new(grid, &materials()?)?;
    let constraints = Constraints::nodes(&fixed);
    let mut block: Vec<f64> =
        (0..columns).flat_map(|c| gravity(&model, [[0.0, 0.0, -9.81], [0.0, 9.81, 0.0]][c % 2])).collect();
    let system = LatticeSystem { cells: &model, spacing: [0.01; 3], hold: Hold::Fixed(&constraints) };
    let start = Instant::now();
    let outcome = system.solve(choice, &mut block, &silent);
    let seconds = start.elapsed().as_secs_f64();
    let [x, y, z] = cells;
    let unknowns = 3 * model.active_count();
    print!("| {name} | {x}×{y}×{z} | {unknowns} | {columns} | ");
    match outcome {
        Ok(report) => {
            print!("{} | {} | {:.1e} | {seconds:.2} | ", report.kind, report.iterations, report.relative_residual);
        }
        Err(error) => print!("{error} | – | – | {seconds:.2} | "),
    }
    println!("{} |", peak_megabytes().map_or("–".into(), |m| m.to_string()));
    Ok(())
}

fn materials() -> Result<MaterialTable, Box<dyn Error>> {
    let mut table = MaterialTable::new();
    for (label, young) in [(0, 1e5), (1, 1e5 * RATIO)] {
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45)?);
        table.insert(Label(label), Material { name: format!("phase {label}"), elasticity, density: 1000.0 });
    }
    Ok(table)
}

/// Peak memory of this process so far, where the system tells it.
fn peak_megabytes() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<usize>().ok()? / 1000)
}
