//! All steps of a run, for all of its tracks.

use grosgrain::dynamics::{LoadPath, relative_error};
use grosgrain::update::Editor;

use super::{Track, Update};
use crate::edits::{self, Made};
use crate::failure::Failure;
use crate::interruption;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::report::{Edit, Frame, Motion};

/// A step that has been made.
pub struct TrackStep<'a> {
    /// Its number; 0 is the start.
    pub number: usize,
    /// Its time \[s\].
    pub time: f64,
    /// Whether it is the last one.
    pub last: bool,
    /// The tracks.
    pub tracks: &'a [Track],
    /// Displacement \[m\] of the fine nodes of every track.
    pub displacements: &'a [Vec<f64>],
    /// RMS error of every track against the fine one, in percent; `None` for itself and where it does not run.
    pub errors: &'a [Option<f64>],
}

/// What a run leaves.
#[derive(Debug, Default)]
pub struct Outcome {
    /// One for each step, of the first track.
    pub frames: Vec<Frame>,
    /// Errors of all tracks at every step.
    pub errors: Vec<Vec<Option<f64>>>,
    /// Times of these steps \[s\].
    pub times: Vec<f64>,
    /// One for each step that had edits, of the first track.
    pub edits: Vec<Edit>,
    /// Why the run ended before its last step.
    pub stopped: Option<Failure>,
}

/// Runs all steps. The first track is that of the report; the first fine one is what others are compared with. `on_step` receives every
/// step with the problem as it is then.
///
/// A step that fails ends the run; what came before it stands in the outcome.
///
/// # Errors
/// What `on_step` returns; an interruption.
pub fn run(
    problem: &mut Problem,
    tracks: &mut [Track],
    progress: &Progress,
    mut on_step: impl FnMut(&Problem, TrackStep<'_>) -> Result<(), Failure>,
) -> Result<Outcome, Failure> {
    let mut editor = Editor::new(0, problem.scene.body.loose);
    let steps = problem.schedule.steps();
    let mut outcome = Outcome::default();
    for number in 0..=steps {
        interruption::check()?;
        match make(problem, tracks, number, &mut editor, (&mut outcome, progress)) {
            Ok(()) => {}
            Err(Failure::Interrupted) => return Err(Failure::Interrupted),
            Err(failure) => {
                outcome.stopped = Some(told(problem, number, failure));
                break;
            }
        }
        progress.report("steps", number, steps);
        show(problem, tracks, (number, number == steps), &mut outcome, &mut on_step)?;
    }
    progress.close();
    Ok(outcome)
}

fn told(problem: &Problem, number: usize, failure: Failure) -> Failure {
    match failure {
        Failure::Failed(sentence) => {
            Failure::Failed(format!("{}: step {number}: {sentence}", problem.scene.file.display()))
        }
        other => other,
    }
}

/// Goes to a step. In a dynamic run its edits are those that were due when the last one ended, so that what happens at a time changes the motion
/// after it; in a static one they come before the equilibrium.
fn make(
    problem: &mut Problem,
    tracks: &mut [Track],
    number: usize,
    editor: &mut Editor,
    (outcome, progress): (&mut Outcome, &Progress),
) -> Result<(), Failure> {
    match (problem.scene.is_dynamic(), number) {
        (true, 0) => Ok(()),
        (true, _) => {
            let edited = number - 1;
            edit(problem, tracks, edited, editor, (outcome, progress))?;
            let (time, length) = (problem.schedule.time(edited), problem.schedule.time(1));
            tracks.iter_mut().try_for_each(|track| track.advance(problem, time, length).map(drop))
        }
        (false, _) => {
            edit(problem, tracks, number, editor, (outcome, progress))?;
            let path = path(problem, number);
            tracks.iter_mut().try_for_each(|track| track.balance(problem, &path, progress).map(drop))
        }
    }
}

/// The way from one equilibrium to the next.
fn path(problem: &Problem, number: usize) -> LoadPath {
    let loads = problem.time_of(number);
    let motion = |time: f64| time.min(problem.holds.end_of_motion());
    match number {
        0 => LoadPath { share: [0.0, 1.0], time: [0.0, motion(loads)], loads },
        _ => LoadPath { share: [1.0, 1.0], time: [motion(problem.time_of(number - 1)), motion(loads)], loads },
    }
}

/// Makes the edits of a step, if there are any, and takes the tracks along.
fn edit(
    problem: &mut Problem,
    tracks: &mut [Track],
    number: usize,
    editor: &mut Editor,
    (outcome, progress): (&mut Outcome, &Progress),
) -> Result<(), Failure> {
    if number == 0 {
        return Ok(());
    }
    let Some(Made { changed, mut row, loose_kept, .. }) = edits::make(problem, number, editor, progress)? else {
        return Ok(());
    };
    if loose_kept && !problem.scene.is_dynamic() {
        let sentence = "parts hang on nothing and have no static equilibrium; expected loose = \"drop\" in [body], \
                        or mode = \"dynamic\" in [time]";
        return Err(Failure::Failed(sentence.into()));
    }
    if !changed.is_empty() {
        for (n, track) in tracks.iter_mut().enumerate() {
            let Update { dirty, seconds } = track.follow(problem, &changed, progress)?;
            if n == 0 {
                row.dirty_cells = dirty;
                let names = ["training", "fitting", "total"];
                row.seconds.extend(names.into_iter().map(String::from).zip(seconds));
            }
        }
    }
    outcome.edits.push(row);
    Ok(())
}

fn show(
    problem: &Problem,
    tracks: &[Track],
    (number, last): (usize, bool),
    outcome: &mut Outcome,
    on_step: &mut impl FnMut(&Problem, TrackStep<'_>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let displacements: Vec<Vec<f64>> =
        tracks.iter().map(|track| track.displacement(problem)).collect::<Result<_, _>>()?;
    let fine = tracks.iter().position(|track| track.coarse().is_none());
    let error = |n: usize| {
        let fine = fine.filter(|fine| *fine != n)?;
        let error = 100.0 * relative_error(&displacements[n], &displacements[fine]);
        error.is_finite().then_some(error)
    };
    let errors: Vec<Option<f64>> = (0..tracks.len()).map(error).collect();
    let time = problem.schedule.time(number);
    if let Some(first) = tracks.first() {
        let books = &first.books;
        let motion = problem.scene.is_dynamic().then(|| {
            let (momentum, angular_momentum) = first.momenta(problem);
            Motion {
                kinetic: books.kinetic,
                work: books.work,
                dissipated: books.dissipated(),
                momentum,
                angular_momentum,
            }
        });
        outcome.frames.push(Frame { step: number, time, energy: books.elastic, error: errors[0], motion });
    }
    on_step(problem, TrackStep { number, time, last, tracks, displacements: &displacements, errors: &errors })?;
    outcome.errors.push(errors);
    outcome.times.push(time);
    Ok(())
}
