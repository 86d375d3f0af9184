//! `compare` under large deformation: all methods go through the scene's steps and edits beside the fine model.

use std::path::Path;

use serde::Serialize;

use crate::commands::simulate::steps_of;
use crate::failure::Failure;
use crate::interruption;
use crate::method::Method;
use crate::outcome::warn_of_softness;
use crate::output::OutputFolder;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::quantities::{count, number, seconds};
use crate::report::Steps;
use crate::results;
use crate::tracks::{self, Books, Kind, Track};

/// One method's row.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    method: String,
    unknowns: usize,
    /// At the end.
    error_percent: f64,
    /// Largest of all steps.
    worst_error_percent: f64,
    energy_ratio: f64,
    build_seconds: f64,
    /// After edits.
    update_seconds: f64,
    /// All steps.
    solve_seconds: f64,
    seconds_per_step: f64,
    /// Over the fine model's step.
    speed_up: f64,
    newton_steps: usize,
    /// Of every step, the start included; zero where nothing has moved.
    errors_percent: Vec<f64>,
}

/// Runs every method and prints the table.
///
/// # Errors
/// Models that cannot be built, steps that cannot be made, a file that cannot be written.
pub fn run(mut problem: Problem, methods: &[Method], json: Option<&Path>, progress: &Progress) -> Result<(), Failure> {
    let _folder = json.map(OutputFolder::around).transpose()?;
    let update = problem.scene.coarsening.update;
    let mut kinds = vec![Kind::Fine];
    kinds.extend(methods.iter().filter(|m| **m != Method::Fine).map(|method| Kind::Coarse { method: *method, update }));
    let mut tracks =
        kinds.into_iter().map(|kind| Track::new(&problem, kind, progress)).collect::<Result<Vec<_>, _>>()?;
    let outcome = tracks::run(&mut problem, &mut tracks, progress, |_, _| Ok(()))?;
    interruption::check()?;
    let mut rows: Vec<Row> = (0..tracks.len()).map(|n| row(&problem, &tracks, n, &outcome.errors)).collect();
    if !methods.contains(&Method::Fine) {
        rows.remove(0);
    }
    if let Some(json) = json {
        results::write_json(json, &rows)?;
    }
    results::print(&format!("{}\n{}", problem.scene.title, table(&rows)))?;
    for track in tracks.iter().skip(1) {
        warn_of_softness(&track.kind.to_string(), track.books.ratio_of_peaks(&tracks[0].books), progress);
    }
    outcome.stopped.map_or(Ok(()), Err)
}

fn row(problem: &Problem, tracks: &[Track], n: usize, errors: &[Vec<Option<f64>>]) -> Row {
    let (track, fine) = (&tracks[n], &tracks[0]);
    let errors = errors.iter().map(|errors| errors[n].unwrap_or(0.0)).collect();
    Row::new(&steps_of(tracks)[n], track.size(problem).unknowns, [&track.books, &fine.books], errors)
}

impl Row {
    /// What the steps of a method, its books and those of the fine model say, with the errors of all steps in percent.
    pub(super) fn new(steps: &Steps, unknowns: usize, [books, fine]: [&Books; 2], errors: Vec<f64>) -> Self {
        let ratio = books.elastic / fine.elastic;
        Self {
            method: steps.method.clone(),
            unknowns,
            error_percent: errors.last().copied().unwrap_or_default(),
            worst_error_percent: errors.iter().fold(0.0, |worst, error| error.max(worst)),
            energy_ratio: if ratio.is_finite() { ratio } else { 1.0 },
            build_seconds: books.build.iter().sum(),
            update_seconds: books.updates[2],
            solve_seconds: books.solving,
            seconds_per_step: steps.seconds_per_step,
            speed_up: steps.speed_up.unwrap_or(1.0),
            newton_steps: steps.newton_steps,
            errors_percent: errors,
        }
    }
}

pub(super) fn table(rows: &[Row]) -> String {
    let heading =
        ["method", "unknowns", "error at the end", "worst", "energy ratio", "build", "updates", "step", "speed-up"];
    let or_dash = |s: f64| if s > 0.0 { seconds(s) } else { "–".into() };
    let cells = rows.iter().map(|row| {
        [
            row.method.clone(),
            count(row.unknowns),
            format!("{:.2} %", row.error_percent),
            format!("{:.2} %", row.worst_error_percent),
            number(row.energy_ratio),
            or_dash(row.build_seconds),
            or_dash(row.update_seconds),
            seconds(row.seconds_per_step),
            format!("{:.1}", row.speed_up),
        ]
    });
    results::columns(&std::iter::once(heading.map(String::from)).chain(cells).collect::<Vec<_>>())
}
