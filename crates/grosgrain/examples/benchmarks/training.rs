//! Harmonic displacements of one cell fully surrounded, next to Table 2 of the paper.

use grosgrain::training::RingKind;

use super::cases::Outcome;
use super::cases::harmonic::HarmonicCase;
use super::machine::Machine;
use super::measure::{Effort, MILLI, Spread, digits, measure};
use super::table::Table;

/// Published milliseconds at d = 2 … 7: oversampling (one-ring) and single cell.
const PUBLISHED: [(f64, f64); 6] =
    [(10.3, 0.2), (92.5, 0.8), (804.0, 2.0), (3.3e3, 4.9), (11.6e3, 11.4), (28.9e3, 22.9)];
/// Limits we set ourselves [s], by degree.
const RING_LIMITS: [(usize, f64); 4] = [(2, 2e-3), (3, 11e-3), (4, 45e-3), (5, 140e-3)];
const CELL_LIMITS: [(usize, f64); 1] = [(4, 0.5e-3)];

struct Row {
    degree: usize,
    unknowns: usize,
    whole: Spread,
    assembly: Spread,
    factor: Spread,
    solve: Spread,
    simplicial: Option<Spread>,
    flops: f64,
    floor: f64,
}

impl Row {
    /// Seconds for all unknowns of the domain.
    fn domain(&self) -> f64 {
        self.assembly.median + self.factor.median + self.solve.median
    }
}

pub fn section(machine: &Machine, effort: &Effort) -> Outcome<String> {
    let rows = |kind| -> Outcome<Vec<Row>> {
        (2..=effort.largest_degree).map(|degree| row(degree, kind, machine, effort)).collect()
    };
    let (ring, cell) = (rows(RingKind::OneRing)?, rows(RingKind::SingleCell)?);
    let published = |pick: fn(&(f64, f64)) -> f64| PUBLISHED.map(|p| pick(&p));
    Ok(format!(
        "## Harmonic displacements of one coarse cell\n\nThe middle one of 3 × 3 × 3 coarse cells, six right-hand sides, one thread; \
         the symbolic analysis is made once per shape and not counted. *Whole* is what training does: the domain is eliminated from outside in, the loads with it, and only the \
         cell is substituted back; loads, support and cutting the cell out are in it. The floor counts the operations of that elimination at the peak rate. *Whole domain* is the \
         general way, which training takes where parts hang together by edges only: assembly, factorisation and six solves for all unknowns of the domain.\n\nOne-ring:\n\n{}\nSingle cell:\n\n{}\n{}\n{}\n{}",
        parts(&ring, &published(|p| p.0), &RING_LIMITS),
        parts(&cell, &published(|p| p.1), &CELL_LIMITS),
        parts_sentence(&ring),
        baseline(&ring),
        baseline_sentence(&ring),
    ))
}

fn row(degree: usize, kind: RingKind, machine: &Machine, effort: &Effort) -> Outcome<Row> {
    let mut case = HarmonicCase::new(degree, kind)?;
    let samples = effort.samples;
    let flops = case.elimination_flops()?;
    let whole = measure(samples, || case.train());
    let assembly = measure(samples, || case.assemble());
    let factor = measure(samples, || case.factor());
    let solve = measure(samples, || case.solve());
    let simplicial = match kind == RingKind::OneRing && degree <= effort.largest_simplicial {
        true => {
            let mut baseline = case.simplicial()?;
            if !case.factor_and_solve_with(&mut baseline) {
                return Err(format!("the baseline found the ring at degree {degree} not positive definite").into());
            }
            Some(measure(samples, || case.factor_and_solve_with(&mut baseline)))
        }
        false => None,
    };
    Ok(Row {
        degree,
        unknowns: case.unknowns(),
        whole,
        assembly,
        factor,
        solve,
        simplicial,
        flops,
        floor: machine.floor(flops, 0.0),
    })
}

fn parts(rows: &[Row], published: &[f64; 6], limits: &[(usize, f64)]) -> String {
    let mut table = Table::new(&[
        "d",
        "unknowns",
        "whole, ms",
        "limit we set, ms",
        "Mflop",
        "Gflop/s",
        "floor, ms",
        "whole / floor",
        "whole domain, ms",
        "whole domain / whole",
        "*published*, ms",
    ]);
    for row in rows {
        let limit = limits.iter().find(|(d, _)| *d == row.degree);
        table.row(&[
            row.degree.to_string(),
            row.unknowns.to_string(),
            row.whole.show(MILLI),
            limit.map_or(String::new(), |(_, seconds)| digits(seconds / MILLI)),
            digits(row.flops / 1e6),
            digits(row.flops / row.whole.median / 1e9),
            digits(row.floor / MILLI),
            digits(row.whole.median / row.floor),
            digits(row.domain() / MILLI),
            digits(row.domain() / row.whole.median),
            published.get(row.degree - 2).map_or(String::new(), |ms| digits(*ms)),
        ]);
    }
    table.text()
}

fn parts_sentence(rows: &[Row]) -> String {
    let Some(row) = rows.last() else { return String::new() };
    format!(
        "At d = {} the one-ring takes {} times its floor; solving for all of its unknowns takes {} times as long as eliminating from outside in.\n",
        row.degree,
        digits(row.whole.median / row.floor),
        digits(row.domain() / row.whole.median),
    )
}

fn baseline(rows: &[Row]) -> String {
    let mut table =
        Table::new(&["d", "ours, ms", "entry by entry with AMD, ms", "ratio", "*published* (with Eigen), ms"]);
    for row in rows {
        let Some(simplicial) = row.simplicial else { continue };
        let ours = row.factor.median + row.solve.median;
        table.row(&[
            row.degree.to_string(),
            digits(ours / MILLI),
            simplicial.show(MILLI),
            digits(simplicial.median / ours),
            PUBLISHED.get(row.degree - 2).map_or(String::new(), |(ring, _)| digits(*ring)),
        ]);
    }
    format!(
        "Numerical factorisation and six solves on the one-ring, against faer's simplicial Cholesky (entry by entry) in \
         approximate-minimum-degree order, run here as a stand-in for the Eigen SimplicialLLT of the papers. Neither counts its analysis.\n\n{}",
        table.text()
    )
}

fn baseline_sentence(rows: &[Row]) -> String {
    let ratios: Vec<f64> =
        rows.iter().filter_map(|r| Some(r.simplicial?.median / (r.factor.median + r.solve.median))).collect();
    let (low, high) = ratios.iter().fold((f64::INFINITY, 0.0f64), |(low, high), r| (low.min(*r), high.max(*r)));
    format!("Nested dissection with dense blocks is {} to {} times as fast.\n", digits(low), digits(high))
}
