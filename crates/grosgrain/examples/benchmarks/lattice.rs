//! The stiffness of whole bodies: analysis, assembly, factorisation, solve.

use super::cases::Outcome;
use super::cases::lattice::{IterativeCase, LatticeCase, analyse};
use super::machine::{Machine, copy_rate};
use super::measure::{Effort, MILLI, digits, measure, measure_once};
use super::table::Table;

pub fn section(machine: &Machine, effort: &Effort) -> Outcome<String> {
    let mut assembly = Table::new(&[
        "cells",
        "unknowns",
        "entries, million",
        "analysis, ms",
        "assembly, ms",
        "million entries/s",
        "GB/s written",
        "GB/s copying",
    ]);
    let mut solution = Table::new(&[
        "cells",
        "factor entries, million",
        "Gflop",
        "factor, ms",
        "Gflop/s",
        "factor / floor",
        "solve, ms",
        "solve, GB/s",
        "solve / floor",
    ]);
    let mut share = 0.0;
    for &cells in effort.lattices {
        let name = format!("{cells}³");
        let mut case = LatticeCase::new(cells)?;
        let analysis = measure(effort.samples.min(5), || analyse(cells));
        let assemble = measure(effort.samples, || case.assemble());
        let written = 8.0 * case.entries() as f64;
        assembly.row(&[
            name.clone(),
            case.unknowns().to_string(),
            digits(case.entries() as f64 / 1e6),
            analysis.show(MILLI),
            assemble.show(MILLI),
            digits(case.entries() as f64 / assemble.median / 1e6),
            digits(written / assemble.median / 1e9),
            digits(copy_rate(2.0 * written) / 1e9),
        ]);
        case.factor()?;
        let factor = measure(effort.samples.min(5), || case.factor());
        let solve = measure(effort.samples.min(5), || case.solve());
        let read_twice = 16.0 * case.factor_entries() as f64;
        share = machine.floor(case.factor_flops(), 0.0) / factor.median;
        solution.row(&[
            name,
            digits(case.factor_entries() as f64 / 1e6),
            digits(case.factor_flops() / 1e9),
            factor.show(MILLI),
            digits(case.factor_flops() / factor.median / 1e9),
            digits(1.0 / share),
            solve.show(MILLI),
            digits(read_twice / solve.median / 1e9),
            digits(solve.median / machine.floor(0.0, read_twice)),
        ]);
    }
    Ok(format!(
        "## Stiffness of a whole body\n\nA cube held at one end, one thread. Assembly writes the lower triangle straight into the analysed pattern.\n\n{}\n\
         The factor's floor counts operations, the solve's the bytes of the factor read twice (forward and backward) for one right-hand side.\n\n{}\n\
         At the largest size the factorisation runs at {} % of the peak rate.\n\n{}",
        assembly.text(),
        solution.text(),
        digits(100.0 * share),
        iterations(effort)?,
    ))
}

fn iterations(effort: &Effort) -> Outcome<String> {
    let mut table =
        Table::new(&["cells", "unknowns", "ratio of moduli", "iterations", "relative residual", "s", "µs per unknown"]);
    let (mut fewest, mut most) = (usize::MAX, 0);
    for (&cells, ratio) in effort.iterative.iter().flat_map(|cells| [(cells, 1.0), (cells, 1000.0)]) {
        let mut case = IterativeCase::new(cells, ratio)?;
        let (report, spread) = measure_once(|| case.solve());
        let report = report?;
        (fewest, most) = (fewest.min(report.iterations), most.max(report.iterations));
        table.row(&[
            format!("{cells}³"),
            report.unknowns.to_string(),
            ratio.to_string(),
            report.iterations.to_string(),
            format!("{:.1e}", report.relative_residual),
            digits(spread.median),
            digits(spread.median / report.unknowns as f64 / 1e-6),
        ]);
    }
    Ok(format!(
        "Conjugate gradients preconditioned by multigrid, all threads, one right-hand side (gravity), set-up included, timed once:\n\n{}\n\
         Between {fewest} and {most} iterations.\n",
        table.text(),
    ))
}
