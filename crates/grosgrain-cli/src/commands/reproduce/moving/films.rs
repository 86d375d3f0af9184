//! Pictures of a figure: a strip, an animation, the error over time, and scans where the body comes from one.

use std::path::{Path, PathBuf};

use grosgrain_picture::{Axis, Chart, Series};

use super::scans::ScanRecorder;
use super::{COARSE, Example, MODELS, Model, events};
use crate::commands::simulate::keep_or_warn;
use crate::failure::Failure;
use crate::film::{Film, FilmOptions};
use crate::picture::save;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::tracks::{Outcome, TrackStep};

/// Times in a strip.
pub const COLUMNS: usize = 5;
/// Rows of a strip, and what stands side by side in an animation.
const ROWS: [Model; 3] = [Model::Fine, Model::WithUpdate, Model::WithoutUpdate];

/// Where a model stands among the tracks.
pub fn track(model: Model) -> usize {
    MODELS.iter().position(|m| *m == model).unwrap_or_default()
}

/// What a model is called in a picture.
pub fn caption(model: Model) -> String {
    match model {
        Model::Fine => "fine".into(),
        coarse => format!("coarse, {}", coarse.name()),
    }
}

/// What of a run is drawn, step by step.
pub struct Recorder<'a> {
    example: &'a Example,
    folder: &'a Path,
    film: Film,
    scans: Option<ScanRecorder>,
    /// The last step that was added: that of a run which stops is shown once more.
    added: Option<usize>,
}

impl<'a> Recorder<'a> {
    /// A recorder for the body of a problem, which is not edited yet.
    pub fn new(problem: &Problem, example: &'a Example, folder: &'a Path) -> Self {
        let colour = |name: &str| example.colours.iter().find(|(known, _)| *known == name).map(|(_, colour)| *colour);
        let materials = problem.scene.materials.iter();
        let options = FilmOptions {
            view: example.view,
            materials: materials.map(|m| (m.label, m.name.replace('-', " "), colour(&m.name))).collect(),
            ..FilmOptions::default()
        };
        let names = ROWS.map(caption);
        let film = Film::new(&problem.scene.title, &names.each_ref().map(String::as_str), options);
        let scans = example.scan.then(|| ScanRecorder::new(problem)).flatten();
        Self { example, folder, film, scans, added: None }
    }

    /// Adds a step, if it is one of the scene's frames.
    pub fn add(&mut self, problem: &Problem, step: &TrackStep<'_>) {
        let wanted = step.number.is_multiple_of(problem.scene.output.frames) || step.last;
        if !wanted || self.added.replace(step.number) == Some(step.number) {
            return;
        }
        for (row, model) in ROWS.into_iter().enumerate() {
            let n = track(model);
            self.film.record(row, step.time, &problem.model, &step.displacements[n]);
            if let Some(error) = step.errors[n].filter(|_| step.number > 0) {
                self.film.set_note(row, format!("error {error:.1} %"));
            }
        }
        self.scans.iter_mut().for_each(|scans| scans.add(problem, step));
    }

    /// Writes all pictures; those that cannot be made are told as warnings.
    ///
    /// # Errors
    /// An interruption.
    pub fn write(self, problem: &Problem, outcome: &Outcome, progress: &Progress) -> Result<Vec<PathBuf>, Failure> {
        let Self { example, folder, film, scans, .. } = self;
        let file = |ending: &str| folder.join(format!("{}{ending}.png", example.name));
        progress.say("drawing the film");
        let mut written = Vec::new();
        written.extend(keep_or_warn(film.write_strip(&file(""), COLUMNS), progress));
        written.extend(keep_or_warn(film.write_animation(&file("-animated")), progress));
        written.extend(keep_or_warn(error_chart(problem, example, outcome, &file("-error")), progress).flatten());
        if let Some(scans) = scans {
            written.extend(scans.write(problem, example, folder, progress)?);
        }
        Ok(written)
    }
}

/// The errors of the coarse models over time; none for fewer than two steps.
fn error_chart(
    problem: &Problem,
    example: &Example,
    outcome: &Outcome,
    file: &Path,
) -> Result<Option<PathBuf>, Failure> {
    let curve = |model: Model| {
        let points = outcome.times.iter().zip(&outcome.errors).skip(1);
        let points = points.filter_map(|(time, errors)| Some([*time, errors[track(model)]?]));
        Series { name: model.name().into(), points: points.collect() }
    };
    let series: Vec<Series> = COARSE.map(curve).into_iter().filter(|curve| curve.points.len() > 1).collect();
    if series.is_empty() {
        return Ok(None);
    }
    let axis = |label: &str| Axis { label: label.into(), ..Axis::default() };
    let chart = Chart {
        title: format!("Error: {}", example.title),
        x: axis("time [s]"),
        y: axis("RMS error against the fine model [%]"),
        series,
        events: events(problem, example, outcome),
        ..Chart::default()
    };
    save(chart.render(), file).map(Some)
}
