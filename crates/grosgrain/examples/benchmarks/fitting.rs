//! Shape functions of one cell, next to Table 3 of the paper.

use grosgrain::coarsening::Systems;

use super::cases::Outcome;
use super::cases::fitting::FitCase;
use super::machine::Machine;
use super::measure::{Effort, MICRO, MILLI, Spread, digits, measure, measure_once};
use super::table::Table;

/// Published milliseconds at d = 2, 3, 4, 5: one optimisation per node, and the coupled one.
const PUBLISHED: [(f64, f64); 4] = [(2.8, 190.0), (5.6, 2.6e3), (10.7, 18.9e3), (17.8, 86.1e3)];
/// Limits we set ourselves [s], by degree.
const LIMITS: [(usize, f64); 2] = [(4, 10e-6), (5, 16e-6)];

struct Row {
    degree: usize,
    nodes: usize,
    flops: f64,
    bytes: f64,
    floor: f64,
    closed_form: Spread,
    every_node: Spread,
    once_per_cell: Spread,
    coupled: Option<Spread>,
    difference: f64,
}

pub fn section(machine: &Machine, effort: &Effort) -> Outcome<String> {
    let rows: Vec<Row> =
        (2..=effort.largest_degree).map(|degree| row(degree, machine, effort)).collect::<Outcome<_>>()?;
    Ok(format!("{}\n{}\n{}\n{}", floors(&rows), floors_sentence(&rows), baselines(&rows), baselines_sentence(&rows)))
}

fn row(degree: usize, machine: &Machine, effort: &Effort) -> Outcome<Row> {
    let mut case = FitCase::new(degree)?;
    let closed_form = measure(effort.samples, || case.closed_form());
    let reference = case.functions.clone();
    let mut difference = 0.0f64;
    let mut per_node = |case: &mut FitCase, systems| -> Outcome<Spread> {
        let spread = measure(effort.samples, || case.per_node(systems));
        if !case.per_node(systems) {
            return Err(format!("the multiplier system at degree {degree} is singular").into());
        }
        difference = difference.max(case.difference(&reference));
        Ok(spread)
    };
    let every_node = per_node(&mut case, Systems::EveryNode)?;
    let once_per_cell = per_node(&mut case, Systems::OncePerCell)?;
    let coupled = match degree <= effort.largest_coupled {
        true => {
            let (outcome, spread) = measure_once(|| case.coupled());
            outcome?;
            difference = difference.max(case.difference(&reference));
            Some(spread)
        }
        false => None,
    };
    if difference >= 1e-8 {
        return Err(format!("at degree {degree} a baseline differs from the closed form by {difference:.1e}").into());
    }
    let (nodes, flops, bytes) = (case.nodes(), case.flops(), case.bytes());
    let floor = machine.floor(flops, bytes);
    Ok(Row { degree, nodes, flops, bytes, floor, closed_form, every_node, once_per_cell, coupled, difference })
}

fn floors(rows: &[Row]) -> String {
    let mut table = Table::new(&[
        "d",
        "fine nodes",
        "closed form, µs",
        "limit we set, µs",
        "kflop",
        "kB moved",
        "floor, µs",
        "measured / floor",
        "Gflop/s",
    ]);
    for row in rows {
        let limit = LIMITS.iter().find(|(d, _)| *d == row.degree);
        table.row(&[
            row.degree.to_string(),
            row.nodes.to_string(),
            row.closed_form.show(MICRO),
            limit.map_or(String::new(), |(_, seconds)| digits(seconds / MICRO)),
            digits(row.flops / 1e3),
            digits(row.bytes / 1e3),
            digits(row.floor / MICRO),
            digits(row.closed_form.median / row.floor),
            digits(row.flops / row.closed_form.median / 1e9),
        ]);
    }
    format!(
        "## Shape functions of one coarse cell\n\nTraining data are given, the base is cached, one thread. Operations are those of E = [φ 1 x] M − U \
         and W = W⁰ − E P; what is done once per cell (pseudo-inverse, M) is not in the floor. Bytes are base, geometry and training data read \
         and functions written.\n\n{}",
        table.text()
    )
}

fn floors_sentence(rows: &[Row]) -> String {
    let ratios = rows.iter().map(|r| r.closed_form.median / r.floor);
    let (low, high) = ratios.fold((f64::INFINITY, 0.0f64), |(low, high), r| (low.min(r), high.max(r)));
    format!(
        "Between {} and {} times the floor; what is done once per cell weighs most at small d.\n",
        digits(low),
        digits(high)
    )
}

fn baselines(rows: &[Row]) -> String {
    let mut table = Table::new(&[
        "d",
        "closed form, ms",
        "a system per cell, ms",
        "a system per node, ms",
        "coupled, ms",
        "per node / closed form",
        "coupled / closed form",
        "largest difference",
        "*published* per node, ms",
        "*published* coupled, ms",
    ]);
    for row in rows {
        let published = PUBLISHED.get(row.degree - 2);
        let factor = |other: Spread| digits(other.median / row.closed_form.median);
        table.row(&[
            row.degree.to_string(),
            row.closed_form.show_median(MILLI),
            row.once_per_cell.show_median(MILLI),
            row.every_node.show(MILLI),
            row.coupled.map_or(String::new(), |s| s.show_median(MILLI)),
            factor(row.every_node),
            row.coupled.map_or(String::new(), factor),
            format!("{:.0e}", row.difference),
            published.map_or(String::new(), |(per_node, _)| digits(*per_node)),
            published.map_or(String::new(), |(_, coupled)| digits(*coupled)),
        ]);
    }
    format!(
        "Next to Table 3 of the paper. *A system per node* projects the coefficients onto the null space of the geometric constraints and forms, \
         factors and solves one 18 × 18 multiplier system at every fine node, as published; *a system per cell* forms and factors it once, \
         since it is the same at every node. *Coupled* is the whole saddle-point system of `chen2018numerical` by sparse LU, timed once. The \
         difference is the largest of all results from the closed form, relative to the largest coefficient.\n\n{}",
        table.text()
    )
}

fn baselines_sentence(rows: &[Row]) -> String {
    let Some(row) = rows.iter().rev().find(|r| r.coupled.is_some()) else { return String::new() };
    let factor = |other: Spread| digits(other.median / row.closed_form.median);
    format!(
        "At d = {} the same functions cost {} times as much with a system per node, {} times with a system per cell and {} times \
         as one coupled system, all run here.\n",
        row.degree,
        factor(row.every_node),
        factor(row.once_per_cell),
        row.coupled.map_or(String::new(), factor),
    )
}
