//! Writes the page of benchmarks, `docs/benchmarks.md`, from measurements on this machine.
//!
//! ```text
//! cargo run --release -p grosgrain --example benchmarks -- docs/benchmarks.md
//! cargo run --release -p grosgrain --example benchmarks -- --quick
//! ```
//!
//! Without a path the page goes to standard output. `--quick` measures the smallest cases only, to see that all of it runs.
//! The cases are those of `benches/`.

#[path = "../../benches/cases/mod.rs"]
mod cases;
#[path = "../../benches/baselines/simplicial.rs"]
mod simplicial;

mod coarse;
mod fitting;
mod lattice;
mod machine;
mod measure;
mod steps;
mod table;
mod threads;
mod training;
mod updates;

use std::io::Write;
use std::path::Path;

use cases::Outcome;
use grosgrain::io::write_atomically;
use machine::Machine;
use measure::Effort;

const INTRODUCTION: &str = "\
# Benchmarks

Written by one command, which runs everything on this page again; an idle machine gives the steadiest figures:

    cargo run --release -p grosgrain --example benchmarks -- docs/benchmarks.md

`cargo bench -p grosgrain` runs the same cases under criterion.

A time is the median of its samples, with the fastest and the slowest in brackets. Bodies are made of oblique layers two fine
cells thick whose Young's moduli differ by a factor of 50, Poisson's ratio 0.45. Times marked *published* are those of
`he2022fast` (an i7-10750H at 2.6 GHz); they stand there for orientation, and all ratios are between times
measured here.
A *floor* is the larger of two times: the operations the method needs at the peak rate below, and the bytes it must
move at the rate at which this machine copies a block of the same size.
";

fn main() -> Outcome<()> {
    let mut effort = Effort::full();
    let mut path = None;
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "--quick" => effort = Effort::quick(),
            unknown if unknown.starts_with('-') => {
                return Err(format!("unknown option {unknown}; there is --quick, and the path of the page").into());
            }
            _ => path = Some(argument),
        }
    }
    let page = page(&effort)?;
    match path {
        Some(path) => write_atomically(Path::new(&path), |file| file.write_all(page.as_bytes()))?,
        None => std::io::stdout().write_all(page.as_bytes())?,
    }
    Ok(())
}

fn page(effort: &Effort) -> Outcome<String> {
    let stage = |name: &str| eprintln!("measuring {name}");
    stage("the machine");
    let machine = Machine::measure();
    stage("shape functions");
    let fitting = fitting::section(&machine, effort)?;
    stage("harmonic displacements");
    let training = training::section(&machine, effort)?;
    stage("the stiffness of whole bodies");
    let lattice = lattice::section(&machine, effort)?;
    stage("coarse models");
    let coarse = coarse::section(&machine, effort)?;
    stage("threads");
    let threads = threads::section(effort)?;
    stage("updates");
    let updates = updates::section(effort)?;
    stage("steps in time");
    let steps = steps::section(&machine, effort)?;
    Ok([INTRODUCTION.to_owned(), machine.section(), fitting, training, updates, steps, lattice, coarse, threads]
        .join("\n"))
}
