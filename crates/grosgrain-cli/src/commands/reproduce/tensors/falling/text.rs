//! The tables and rows that both figures have.

use super::super::super::Study;
use super::super::super::row::{Row, digits, or_dash};
use super::Model;
use super::course::Course;
use super::pair::{Fall, Pair};
use crate::quantities::{count, counted, number, seconds};
use crate::results;

/// What a figure is about.
pub struct Published {
    /// Of the artefact.
    pub name: &'static str,
    /// How many times faster the coarse animation is said to be.
    pub ratio: f64,
    /// The words of that.
    pub words: &'static str,
}

/// Sizes of the meshes and of the coarsening.
pub fn sizes(pair: &Pair) -> String {
    let (fine, coarse, found) = (pair.fine.mesh(), pair.coarse_mesh(), &pair.found);
    let condition = found.effective.condition.iter().copied().fold(0.0, f64::max);
    let outside = pair.embedding.outside().count() as f64 / pair.embedding.fine_nodes() as f64;
    format!(
        "fine {} tetrahedra, {} unknowns; coarse {} tetrahedra, {} unknowns, on the ground by {} points of the fine boundary\n\
         coarsened in {}: condition {} at worst, {} cells averaged; {:.1} % of the fine nodes outside of the coarse mesh; masses differ by {:.1e}",
        count(fine.cell_count()),
        count(3 * fine.nodes().len()),
        count(coarse.cell_count()),
        count(3 * coarse.nodes().len()),
        count(pair.surface_points()),
        seconds(pair.seconds),
        digits(condition),
        found.effective.averaged.len(),
        100.0 * outside,
        mass_difference(pair),
    )
}

fn mass_difference(pair: &Pair) -> f64 {
    (pair.found.mass.iter().sum::<f64>() / pair.fine.mass() - 1.0).abs()
}

/// Tables of errors and costs.
pub fn tables(study: &Study, published: &Published, fall: &Fall, course: &Course) -> String {
    let mut errors = vec![["coarse model", "at the end", "mean", "worst"].map(String::from)];
    for (n, model) in Model::COARSE.into_iter().enumerate() {
        let figure = |k: usize| or_dash(course.summary(n).map(|summary| summary[k]), digits);
        errors.push([model.label().into(), figure(0), figure(1), figure(2)]);
    }
    let mut costs = vec![["model", "step", "Newton steps in it", "times faster", "published"].map(String::from)];
    for (n, model) in Model::ALL.into_iter().enumerate() {
        let [step, newton] = course.cost(n);
        let claim = (model == Model::Tensor).then_some(published.ratio);
        costs.push([
            model.label().into(),
            seconds(step),
            digits(newton),
            or_dash(course.ratio(n), digits),
            or_dash(claim, digits),
        ]);
    }
    let mut text = format!(
        "{} of {} s; RMS error of displacements in percent of the fine model's\n{}\n\
         time of a step, all models to the same tolerance of Newton's method\n{}\nmachine: {}; published: {}",
        counted(course.errors.len(), "step"),
        number(fall.step),
        results::columns(&errors),
        results::columns(&costs),
        study.machine,
        published.words,
    );
    if let Some(stopped) = &course.stopped {
        text.push_str(&format!("\nthe run ended early: {stopped}"));
    }
    text
}

/// The same as rows.
pub fn rows(study: &Study, published: &Published, pair: &Pair, course: &Course) -> Vec<Row> {
    let row = |quantity, unit| Row::new(study, published.name, quantity, unit);
    let mut rows = vec![
        Row { measured: Some(mass_difference(pair)), published: Some(0.0), ..row("mass difference", "1") },
        Row { measured: Some(pair.seconds), method: Some(Model::Tensor.name()), ..row("coarsening", "s") },
    ];
    for (n, model) in Model::ALL.into_iter().enumerate() {
        let method = Some(model.name());
        let [step, newton] = course.cost(n);
        rows.push(Row { method, measured: Some(step), ..row("time of a step", "s") });
        rows.push(Row { method, measured: Some(newton), ..row("Newton steps in a step", "1") });
        if let Some(ratio) = course.ratio(n) {
            let is_claim = model == Model::Tensor;
            let words = is_claim.then(|| format!("published: {}", published.words));
            let claim = is_claim.then_some(published.ratio);
            let over = claim.map(|claim| claim / ratio);
            let measured = Some(ratio);
            let row = row("cost ratio", "1");
            rows.push(Row { method, measured, published: claim, published_over_measured: over, note: words, ..row });
        }
    }
    for (n, model) in Model::COARSE.into_iter().enumerate() {
        let Some(summary) = course.summary(n) else { continue };
        for (quantity, measured) in ["error at the end", "mean error", "worst error"].into_iter().zip(summary) {
            rows.push(Row { method: Some(model.name()), measured: Some(measured), ..row(quantity, "%") });
        }
    }
    rows
}
