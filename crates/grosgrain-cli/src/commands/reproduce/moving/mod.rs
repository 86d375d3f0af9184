//! Figs. 1, 4 and 5: bodies that are edited while they move, in three models side by side.
//!
//! Scenes are read from the folder `scenes` of the repository. All that is specific to a figure and no matter of its scene is in
//! [`Example`].

mod examples;
mod figures;
mod films;
mod scans;
mod text;

pub use examples::{Example, FIG1, FIG4, FIG5};

use grosgrain_picture::Event;

use self::figures::Figures;
use self::films::Recorder;
use super::repository::SCENES;
use super::{Findings, Study};
use crate::failure::Failure;
use crate::interruption;
use crate::problem::Problem;
use crate::tracks::{self, Kind, Outcome, Track};

/// The models, in the order of the tracks: the one whose edits are reported first.
const MODELS: [Model; 3] = [Model::WithUpdate, Model::WithoutUpdate, Model::Fine];
/// The coarse ones.
const COARSE: [Model; 2] = [Model::WithUpdate, Model::WithoutUpdate];

/// A model of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Model {
    /// Coarse; edits renew the shape functions.
    WithUpdate,
    /// Coarse; the shape functions are those of the unedited body.
    WithoutUpdate,
    /// The reference.
    Fine,
}

impl Model {
    const fn name(self) -> &'static str {
        match self {
            Self::WithUpdate => "with update",
            Self::WithoutUpdate => "without update",
            Self::Fine => "fine",
        }
    }

    fn kind(self, problem: &Problem) -> Kind {
        let coarse = |update| Kind::Coarse { method: problem.own_method(), update };
        match self {
            Self::WithUpdate => coarse(true),
            Self::WithoutUpdate => coarse(false),
            Self::Fine => Kind::Fine,
        }
    }
}

/// Runs the scene of a figure in all models.
///
/// # Errors
/// A scene that is missing, cannot be read or is not dynamic; models that cannot be built. A step that cannot be made is among the
/// findings, with what came before it.
pub fn run(study: &Study, example: &Example) -> Result<Findings, Failure> {
    let progress = study.progress;
    let file = SCENES.find(example.scene, study.scenes.as_deref())?;
    progress.say(&format!("{}: {}", example.name, file.display()));
    let mut problem = Problem::read(&file, progress)?;
    problem.require_support()?;
    if !problem.scene.is_dynamic() {
        let sentence = format!("is not dynamic; {} is a figure of motion, expected mode = \"dynamic\"", example.name);
        return Err(problem.scene.unusable("time.mode", sentence).into());
    }
    if let Some(steps) = study.steps {
        problem.schedule.end_after(steps);
    }
    let body = figures::Body::of(&problem);
    let models = MODELS.iter().map(|model| Track::new(&problem, model.kind(&problem), progress));
    let mut tracks = models.collect::<Result<Vec<_>, _>>()?;
    let mut recorder = study.folder.as_deref().map(|folder| Recorder::new(&problem, example, folder));
    let outcome = tracks::run(&mut problem, &mut tracks, progress, |problem, step| {
        recorder.iter_mut().for_each(|recorder| recorder.add(problem, &step));
        Ok(())
    })?;
    interruption::check()?;
    let figures = Figures::of(&problem, &tracks, &outcome, body);
    let mut text = text::text(study, example, &figures);
    let mut written = Vec::new();
    match recorder {
        Some(recorder) => written = recorder.write(&problem, &outcome, progress)?,
        None => text.push_str("\n-o DIR draws it"),
    }
    Ok(Findings { rows: figures.rows(study, example), text, written, stopped: outcome.stopped })
}

/// The edits as events along time: those of a body's steps, named where there are few.
fn events(problem: &Problem, example: &Example, outcome: &Outcome) -> Vec<Event> {
    let count = outcome.edits.len();
    let label = |n: usize| match count {
        1 => example.edit.to_owned(),
        2..=5 => format!("{} {}", example.edit, n + 1),
        _ if n == 0 => format!("first {}", example.edit),
        _ if n + 1 == count => format!("last {}", example.edit),
        _ => String::new(),
    };
    let event =
        |(n, edit): (usize, &crate::report::Edit)| Event { at: problem.schedule.time(edit.step), label: label(n) };
    outcome.edits.iter().enumerate().map(event).collect()
}
