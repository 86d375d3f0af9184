//! The figures of a run beside the published ones.

use super::{COARSE, Example, MODELS, Model};
use crate::commands::reproduce::Study;
use crate::commands::reproduce::row::Row;
use crate::problem::Problem;
use crate::tracks::{Outcome, Track};

/// Seconds to milliseconds.
const MILLI: f64 = 1e-3;

/// The body before any edit.
#[derive(Clone, Debug)]
pub struct Body {
    /// Fine cells along x, y, z.
    pub cells: [usize; 3],
    /// Unknowns of the fine model.
    pub unknowns: usize,
}

impl Body {
    /// The body of a problem as it is now.
    pub fn of(problem: &Problem) -> Self {
        Self { cells: problem.model.grid().lattice.cells, unknowns: problem.fine_size().unknowns }
    }
}

/// What was measured.
#[derive(Clone, Debug)]
pub struct Figures {
    /// The fine body at the beginning.
    pub body: Body,
    /// Unknowns of the coarse model at the end.
    pub coarse_unknowns: usize,
    /// Coarsening degree.
    pub degree: usize,
    /// The method of the coarse models.
    pub method: &'static str,
    /// Tolerance of Newton's method in all models.
    pub tolerance: f64,
    /// Steps made, and seconds of each.
    pub steps: (usize, f64),
    /// Errors of the coarse models, with update and without.
    pub errors: [Errors; 2],
    /// Costs, in the order of [`MODELS`].
    pub costs: [Cost; 3],
    /// What updates cost.
    pub updates: Updates,
    /// Why the run ended early.
    pub stopped: Option<String>,
}

/// RMS errors of displacements in percent of the fine ones; `None` where nothing moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// At the last step.
    pub end: Option<f64>,
    /// Mean over the steps.
    pub mean: Option<f64>,
    /// Largest of all steps.
    pub worst: Option<f64>,
    /// Elastic energy over that of the fine model, at the last step.
    pub energy_ratio: Option<f64>,
}

/// What the steps of a model cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Seconds for a step.
    pub step: f64,
    /// Newton steps for a step.
    pub newton: f64,
}

/// What the updates of the shape functions cost: means over the edits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Updates {
    /// Number of edits.
    pub count: usize,
    /// Coarse cells with a changed fine cell.
    pub changed: f64,
    /// Coarse cells that were made anew.
    pub updated: f64,
    /// Seconds for training data and for shape functions.
    pub seconds: [f64; 2],
    /// Seconds for all of an edit's consequences.
    pub total: f64,
}

impl Errors {
    fn of(outcome: &Outcome, track: usize, energy_ratio: f64) -> Self {
        // At the start nothing has moved.
        let errors: Vec<f64> = outcome.errors.iter().skip(1).filter_map(|errors| errors[track]).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        Self {
            end: outcome.errors.iter().skip(1).next_back().and_then(|errors| errors[track]),
            mean: mean.is_finite().then_some(mean),
            worst: errors.iter().copied().reduce(f64::max),
            energy_ratio: energy_ratio.is_finite().then_some(energy_ratio),
        }
    }
}

impl Updates {
    fn of(outcome: &Outcome) -> Self {
        let edits = &outcome.edits;
        let mean = |value: &dyn Fn(&crate::report::Edit) -> f64| {
            edits.iter().map(value).sum::<f64>() / edits.len().max(1) as f64
        };
        let seconds = |stage: &str| mean(&|edit| edit.seconds.get(stage).copied().unwrap_or_default());
        Self {
            count: edits.len(),
            changed: mean(&|edit| edit.changed_cells as f64),
            updated: mean(&|edit| edit.dirty_cells as f64),
            seconds: ["training", "fitting"].map(seconds),
            total: seconds("total"),
        }
    }
}

impl Figures {
    /// The figures of a run that has ended.
    pub fn of(problem: &Problem, tracks: &[Track], outcome: &Outcome, body: Body) -> Self {
        let track = |model: Model| MODELS.iter().position(|m| *m == model).and_then(|n| tracks.get(n).map(|t| (n, t)));
        let elastic = |model| track(model).map_or(f64::NAN, |(_, track)| track.books.elastic);
        let fine = elastic(Model::Fine);
        let cost = |model| {
            track(model).map_or_else(Cost::default, |(_, Track { books, .. })| {
                let steps = books.steps.max(1) as f64;
                Cost { step: books.solving / steps, newton: books.newton as f64 / steps }
            })
        };
        let errors = |model| track(model).map(|(n, _)| Errors::of(outcome, n, elastic(model) / fine));
        Self {
            body,
            coarse_unknowns: track(Model::WithUpdate).map_or(0, |(_, track)| track.size(problem).unknowns),
            degree: problem.scene.coarsening.degree,
            method: problem.own_method().name(),
            tolerance: problem.scene.time.tolerance,
            steps: (outcome.times.len().saturating_sub(1), problem.schedule.time(1)),
            errors: COARSE.map(|model| errors(model).unwrap_or_default()),
            costs: MODELS.map(cost),
            updates: Updates::of(outcome),
            stopped: outcome.stopped.as_ref().map(ToString::to_string),
        }
    }

    /// The cost of a model.
    pub fn cost(&self, model: Model) -> Cost {
        MODELS.iter().position(|m| *m == model).map_or_else(Cost::default, |n| self.costs[n])
    }

    /// How many times faster a step is than the fine model's.
    pub fn speed_up(&self, model: Model) -> Option<f64> {
        let ratio = self.cost(Model::Fine).step / self.cost(model).step;
        (model != Model::Fine && ratio.is_finite()).then_some(ratio)
    }

    /// All figures as rows.
    pub fn rows(&self, study: &Study, example: &Example) -> Vec<Row> {
        let row = |quantity, unit, model: Model, measured: Option<f64>| Row {
            degree: Some(self.degree),
            method: Some(model.name()),
            measured,
            note: self.stopped.clone(),
            ..Row::new(study, example.name, quantity, unit)
        };
        let mut rows = Vec::new();
        for (n, model) in COARSE.into_iter().enumerate() {
            let Errors { end, mean, worst, energy_ratio } = self.errors[n];
            let words = example.words.map(|words| format!("the paper gives no number: {}", words[n]));
            let note = match (&self.stopped, words) {
                (Some(stopped), _) => Some(stopped.clone()),
                (None, words) => words,
            };
            rows.push(Row { published: example.errors[n], note, ..row("error", "%", model, end) });
            rows.push(row("mean error", "%", model, mean));
            rows.push(row("worst error", "%", model, worst));
            rows.push(row("elastic energy over fine", "1", model, energy_ratio));
        }
        for model in MODELS {
            let step = (self.steps.0 > 0).then(|| self.cost(model).step / MILLI);
            rows.push(row("time of a step", "ms", model, step));
            let note = Some(format!("both to the tolerance {:.0e} of Newton's method", self.tolerance));
            let ratio = self.speed_up(model).filter(|_| self.steps.0 > 0);
            rows.extend(ratio.map(|ratio| Row { note, ..row("speed-up over fine", "1", model, Some(ratio)) }));
        }
        for (n, quantity) in ["update, training data", "update, shape functions"].into_iter().enumerate() {
            let published = example.update.map(|update| update.milliseconds[n]);
            let measured = (self.updates.count > 0).then(|| self.updates.seconds[n] / MILLI);
            let note =
                example.update.map(|u| format!("mean of an edit; published for {} cells on one thread", u.cells));
            rows.push(Row {
                published,
                published_over_measured: published.zip(measured).map(|(p, m)| p / m),
                updated_cells: Some(self.updates.updated.round() as usize),
                note,
                ..row(quantity, "ms", Model::WithUpdate, measured)
            });
        }
        rows
    }
}
