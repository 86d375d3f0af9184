//! Table 3: times of the shape functions of one cell.

use grosgrain::partition::CoarseCell;
use grosgrain::training::RingKind;

use super::bodies::{Heterogeneity, fine_model};
use super::fits::{BOUND, Fit, FitCase, PAIRS, difference, pair_name, published};
use super::row::{Row, digits, or_dash};
use super::{Findings, Study, pictures};
use crate::failure::Failure;
use crate::results;
use crate::timing::measure;

const NAME: &str = "table3";
/// The middle one of 3 × 3 × 3 coarse cells.
const CENTRE: CoarseCell = CoarseCell(13);
/// Published milliseconds at d = 2 … 5: a system per node, and the coupled one.
const PUBLISHED: [(f64, f64); 4] = [(2.8, 190.0), (5.6, 2.6e3), (10.7, 18.9e3), (17.8, 86.1e3)];

fn published_time(degree: usize, fit: Fit) -> Option<f64> {
    let (per_node, coupled) = PUBLISHED.get(degree.checked_sub(2)?)?;
    match fit {
        Fit::ClosedForm => None,
        Fit::PerNode => Some(*per_node),
        Fit::Coupled => Some(*coupled),
    }
}

/// Times every fit on one thread and compares what they give.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one_thread = one_thread.map_err(|error| Failure::Failed(format!("a thread cannot be started: {error}")))?;
    let mut rows = Vec::new();
    for &degree in &study.degrees {
        rows.extend(one_thread.install(|| degree_rows(study, degree))?);
    }
    let written = match &study.folder {
        Some(folder) => {
            let methods = Fit::ALL.map(Fit::name);
            vec![pictures::time_chart("Shape functions of one cell", &rows, &methods, &folder.join("table3.png"))?]
        }
        None => Vec::new(),
    };
    Ok(Findings { text: text(study, &rows), rows, written, ..Findings::default() })
}

fn degree_rows(study: &Study, degree: usize) -> Result<Vec<Row>, Failure> {
    let model = fine_model(Heterogeneity::Oblique.ring(degree)?)?;
    let case = FitCase::new(&model, degree, CENTRE, RingKind::OneRing)?;
    let mut rows = Vec::new();
    for fit in Fit::ALL {
        study.progress.say(&format!("d = {degree}: {}", fit.name()));
        let mut functions = case.room();
        let spread = measure(|| case.fit_into(fit, &mut functions))?;
        rows.push(Row {
            degree: Some(degree),
            method: Some(fit.name()),
            note: (fit == Fit::ClosedForm).then(|| "not in the paper".into()),
            ..Row::time(study, NAME, published_time(degree, fit), Some(spread))
        });
    }
    let functions = case.functions()?;
    rows.extend(PAIRS.map(|pair| Row {
        degree: Some(degree),
        method: Some(pair_name(pair)),
        published: published(pair),
        measured: Some(difference(&functions, pair)),
        note: published(pair).map(|_| BOUND.into()),
        ..Row::new(study, NAME, "difference", "%")
    }));
    Ok(rows)
}

fn find<'r>(rows: &'r [Row], degree: usize, method: &str) -> Option<&'r Row> {
    rows.iter().find(|row| row.degree == Some(degree) && row.method == Some(method))
}

fn text(study: &Study, rows: &[Row]) -> String {
    let heading = ["d", "closed form", "per node", "published", "coupled", "published", "coupled / closed form"];
    let mut times = vec![heading.map(String::from)];
    let mut differences = vec![
        ["d", "per node against coupled", "published", "closed form against coupled", "closed form against per node"]
            .map(String::from),
    ];
    for &degree in &study.degrees {
        let row = |method: &str| find(rows, degree, method);
        let measured = |method: &str| or_dash(row(method).and_then(|r| r.measured), digits);
        let paper = |method: &str| or_dash(row(method).and_then(|r| r.published), digits);
        let [ours, node, coupled] = Fit::ALL.map(Fit::name);
        let ratio = row(coupled).and_then(|r| r.measured).zip(row(ours).and_then(|r| r.measured)).map(|(c, o)| c / o);
        times.push([
            degree.to_string(),
            measured(ours),
            measured(node),
            paper(node),
            measured(coupled),
            paper(coupled),
            or_dash(ratio, digits),
        ]);
        let [first, second, third] = PAIRS.map(|pair| measured(pair_name(pair)));
        differences.push([degree.to_string(), first, "< 0.001".into(), second, third]);
    }
    format!(
        "Table 3 of he2022fast: milliseconds for the shape functions of one cell, one thread\n\
         per node is the published method and coupled its baseline, both run here; closed form is ours; training data are given\n{}\n\
         difference of the functions in percent, ‖m − m'‖ / ‖m'‖ over all coefficients\n{}\n\
         machine: {}; published: Intel Core i7-10750H, one thread",
        results::columns(&times),
        results::columns(&differences),
        study.machine.processor,
    )
}
