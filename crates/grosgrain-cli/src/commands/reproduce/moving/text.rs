//! The tables of a figure for the reader.

use super::figures::Figures;
use super::{COARSE, Example, MODELS};
use crate::commands::reproduce::Study;
use crate::commands::reproduce::row::{digits, or_dash};
use crate::quantities::{count, counted, number, seconds, triple_count};
use crate::results;

/// Tables of errors, times and updates.
pub fn text(study: &Study, example: &Example, figures: &Figures) -> String {
    let (steps, step) = figures.steps;
    let number_of_figure = example.name.trim_start_matches("fig");
    let mut text = format!(
        "Fig. {number_of_figure} of he2022fast: {}\n\
         {} fine cells, {} unknowns; coarse, {}, d = {}: {} unknowns; {} of {} s\n\
         RMS error of displacements in percent of the fine model's\n{}\n\
         time of a step; all models to the tolerance {:.0e} of Newton's method\n{}\n{}\n\
         machine: {}; published: Intel Core i7-10750H, one thread",
        example.title,
        triple_count(figures.body.cells),
        count(figures.body.unknowns),
        figures.method,
        figures.degree,
        count(figures.coarse_unknowns),
        counted(steps, "step"),
        number(step),
        errors(example, figures),
        figures.tolerance,
        times(figures),
        updates(example, figures),
        study.machine,
    );
    if let Some(stopped) = &figures.stopped {
        text.push_str(&format!("\nthe run ended early: {stopped}"));
    }
    text
}

fn errors(example: &Example, figures: &Figures) -> String {
    let heading = ["coarse", "at the end", "published", "mean", "worst", "elastic energy over fine"];
    let mut lines = vec![heading.map(String::from)];
    for (n, model) in COARSE.into_iter().enumerate() {
        let errors = figures.errors[n];
        let words = example.words.map(|words| format!("“{}”", words[n]));
        lines.push([
            model.name().into(),
            or_dash(errors.end, digits),
            words.unwrap_or_else(|| or_dash(example.errors[n], digits)),
            or_dash(errors.mean, digits),
            or_dash(errors.worst, digits),
            or_dash(errors.energy_ratio, digits),
        ]);
    }
    results::columns(&lines)
}

fn times(figures: &Figures) -> String {
    let mut lines = vec![["model", "step", "Newton steps in it", "speed-up over fine"].map(String::from)];
    for model in MODELS {
        let cost = figures.cost(model);
        let speed_up = or_dash(figures.speed_up(model), |ratio| format!("{} ×", digits(ratio)));
        lines.push([model.name().into(), seconds(cost.step), format!("{:.1}", cost.newton), speed_up]);
    }
    results::columns(&lines)
}

fn updates(example: &Example, figures: &Figures) -> String {
    let updates = figures.updates;
    if updates.count == 0 {
        return "no edits in these steps".into();
    }
    let mut lines = vec![["update", "cells", "training data", "shape functions", "all of it"].map(String::from)];
    let [training, fitting] = updates.seconds.map(seconds);
    lines.push(["measured".into(), digits(updates.updated), training, fitting, seconds(updates.total)]);
    if let Some(published) = example.update {
        let [training, fitting] = published.milliseconds.map(|ms| seconds(1e-3 * ms));
        lines.push(["published".into(), published.cells.to_string(), training, fitting, "–".into()]);
    }
    let edits = counted(updates.count, "edit");
    format!(
        "{edits}, in {} coarse cells on average; an update of the shape functions on average\n{}",
        digits(updates.changed),
        results::columns(&lines)
    )
}
