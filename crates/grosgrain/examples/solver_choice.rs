//! Writes the page that says where conjugate gradients overtake Cholesky, and how large bodies fare.
//!
//! ```sh
//! cargo run --release -p grosgrain --example solver_choice -- docs/solver-choice.md
//! ```
//!
//! Without a path the page goes to standard output. It takes several minutes and about 3 GB; `--quick` runs the smallest
//! bodies only, to see that all of it works.

use std::error::Error;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

use grosgrain::assembly::Constraints;
use grosgrain::fine::{FineModel, gravity};
use grosgrain::io::write_atomically;
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Axis, Label, Pattern, PlaneAt, Selector, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::solver::{Hold, LatticeSystem, SolverChoice};

const RATIO: f64 = 1e3;

const INTRODUCTION: &str = "\
# Which solver, measured

Written by one command, which runs everything on this page again; an idle machine gives the steadiest figures:

    cargo run --release -p grosgrain --example solver_choice -- docs/solver-choice.md

Each row is one static solve to a relative residual of 1e-8: a box of two phases with an E ratio of 1000 and ν = 0.45, clamped at
x = 0, under gravity. *Blobs* are random blocks of 4³ cells; *layers* lie at 45°, four cells thick. Seconds include analysis, factorisation
or the multigrid hierarchy, and the solve. Peak memory is that of the process so far.
";

const HEADING: &str = "
| body | cells | unknowns | right-hand sides | solver | iterations | residual | seconds | peak MB |
|---|---|---|---|---|---|---|---|---|
";

type Failure = Box<dyn Error>;

fn main() -> Result<(), Failure> {
    let machine = format!("\nMachine: {}, {} threads.\n", processor(), rayon::current_num_threads());
    let mut page = format!("{INTRODUCTION}{machine}\n## Side by side\n{HEADING}");
    let quick = std::env::args().any(|argument| argument == "--quick");
    let sizes: &[usize] = if quick { &[8, 12] } else { &[12, 16, 20, 24, 28, 32, 40] };
    for &n in sizes {
        for columns in [1, 6] {
            for choice in [SolverChoice::Direct, SolverChoice::Iterative] {
                page += &row([n; 3], ("blobs", blobs()), columns, choice)?;
                page += &row([n; 3], ("layers", layers()), columns, choice)?;
            }
        }
    }
    page += &format!("\n## Large bodies, the solver chosen automatically\n{HEADING}");
    let large = [([48, 48, 36], "blobs", blobs()), ([48, 48, 36], "layers", layers()), ([128; 3], "blobs", blobs())];
    for (cells, name, pattern) in large.into_iter().filter(|_| !quick) {
        page += &row(cells, (name, pattern), 1, SolverChoice::Auto)?;
    }
    match std::env::args().nth(1).filter(|argument| argument != "--quick") {
        Some(path) => write_atomically(Path::new(&path), |writer| writer.write_all(page.as_bytes()))?,
        None => print!("{page}"),
    }
    Ok(())
}

fn processor() -> String {
    let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = information.lines().find(|line| line.starts_with("model name"));
    line.and_then(|line| line.split(": ").nth(1)).unwrap_or("unknown processor").to_owned()
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
) -> Result<String, Failure> {
    let mut grid = VoxelGrid::uniform(cells, [0.01; 3], Label(0));
    pattern.paint(&mut grid)?;
    let fixed = Selector::Plane { axis: Axis::X, at: PlaneAt::Min }.nodes(&grid)?.mask;
    let model = FineModel::new(grid, &materials()?)?;
    let constraints = Constraints::nodes(&fixed);
    let direction = |column: usize| [[0.0, 0.0, -9.81], [0.0, 9.81, 0.0]][column % 2];
    let mut block: Vec<f64> = (0..columns).flat_map(|c| gravity(&model, direction(c))).collect();
    let system = LatticeSystem { cells: &model, spacing: [0.01; 3], hold: Hold::Fixed(&constraints) };
    let start = Instant::now();
    let outcome = system.solve(choice, &mut block, &silent);
    let seconds = start.elapsed().as_secs_f64();
    let [x, y, z] = cells;
    let solved = match outcome {
        Ok(report) => format!("{} | {} | {:.1e}", report.kind, report.iterations, report.relative_residual),
        Err(error) => format!("{error} | – | –"),
    };
    let unknowns = 3 * model.active_count();
    let peak = peak_megabytes().map_or("–".into(), |m| m.to_string());
    let row = format!("| {name} | {x}×{y}×{z} | {unknowns} | {columns} | {solved} | {seconds:.2} | {peak} |\n");
    eprint!("{row}");
    Ok(row)
}

fn materials() -> Result<MaterialTable, Failure> {
    let mut table = MaterialTable::new();
    for (label, young) in [(0, 1e5), (1, 1e5 * RATIO)] {
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45)?);
        table.insert(Label(label), Material::linear(format!("phase {label}"), elasticity, 1000.0));
    }
    Ok(table)
}

/// Peak memory of this process so far, where the system tells it.
fn peak_megabytes() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<usize>().ok()? / 1000)
}
