//! All steps of a run, for all of its tracks.

use std::path::Path;

use grosgrain::dynamics::{LoadPath, relative_error};
use grosgrain::update::Editor;

use super::{Books, Track, Update};
use crate::edits::{self, Made};
use crate::failure::Failure;
use crate::interruption;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::report::{Edit, Frame, Motion};

/// A step that has been made by models of voxels or of meshes.
pub struct TrackStep<'a, T = Track> {
    /// Its number; 0 is the start.
    pub number: usize,
    /// Its time \[s\].
    pub time: f64,
    /// Whether it is the last one.
    pub last: bool,
    /// The tracks.
    pub tracks: &'a [T],
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

/// Momentum \[N s\] and angular momentum about the origin \[N m s\].
pub type Momenta = ([f64; 3], [f64; 3]);

impl Outcome {
    /// Adds a step with the errors of all tracks; books of the first one, and its momenta where the run has inertia.
    pub fn add(
        &mut self,
        (number, time): (usize, f64),
        errors: Vec<Option<f64>>,
        first: Option<(&Books, Option<Momenta>)>,
    ) {
        if let Some((books, momenta)) = first {
            let &Books { kinetic, work, edited, elastic, .. } = books;
            let motion = momenta.map(|(momentum, angular_momentum)| Motion {
                kinetic,
                work,
                edited,
                dissipated: books.dissipated(),
                momentum,
                angular_momentum,
            });
            self.frames.push(Frame { step: number, time, energy: elastic, error: errors[0], motion });
        }
        self.errors.push(errors);
        self.times.push(time);
    }
}

/// RMS errors in percent against the fine displacement, which is one of them; `None` for itself, where it is missing, and before anything has moved.
pub fn errors_against(fine: Option<usize>, displacements: &[Vec<f64>]) -> Vec<Option<f64>> {
    let error = |n: usize| {
        let fine = fine.filter(|fine| *fine != n)?;
        let error = 100.0 * relative_error(&displacements[n], &displacements[fine]);
        error.is_finite().then_some(error)
    };
    (0..displacements.len()).map(error).collect()
}

/// A failed step of one of several models, with the file and the step.
pub fn failed_step(file: &Path, number: usize, name: Option<&str>, failure: Failure) -> Failure {
    let name = name.map_or_else(String::new, |name| format!("{name}: "));
    match failure {
        Failure::Failed(sentence) => Failure::Failed(format!("{}: step {number}: {name}{sentence}", file.display())),
        other => other,
    }
}

/// Why a step was not made.
struct Halt {
    why: Failure,
    /// Whether the tracks can go back to where the step began.
    intact: bool,
}

impl Halt {
    fn broken(why: Failure) -> Self {
        Self { why, intact: false }
    }
}

/// Runs all steps. The first track is that of the report; the first fine one is what others are compared with. `on_step` receives every
/// step with the problem as it is then.
///
/// A step that fails ends the run; what came before it stands in the outcome, and `on_step` receives the step before it once more, as the
/// last one.
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
            Err(Halt { why: Failure::Interrupted, .. }) => return Err(Failure::Interrupted),
            Err(Halt { why, intact }) => {
                outcome.stopped = Some(why);
                progress.close();
                if intact && number > 0 {
                    show(problem, tracks, (number - 1, true), None, &mut on_step)?;
                }
                return Ok(outcome);
            }
        }
        progress.report("steps", number, steps);
        show(problem, tracks, (number, number == steps), Some(&mut outcome), &mut on_step)?;
    }
    progress.close();
    Ok(outcome)
}

/// Goes to a step. In a dynamic run its edits are those that were due when the last one ended, so that what happens at a time changes the motion
/// after it; in a static one they come before the equilibrium.
fn make(
    problem: &mut Problem,
    tracks: &mut [Track],
    number: usize,
    editor: &mut Editor,
    (outcome, progress): (&mut Outcome, &Progress),
) -> Result<(), Halt> {
    let dynamic = problem.scene.is_dynamic();
    let edited = if dynamic { number.saturating_sub(1) } else { number };
    let edits = outcome.edits.len();
    edit(problem, tracks, edited, editor, (outcome, progress)).map_err(Halt::broken)?;
    // An equilibrium before the edits is none of the body after them; a motion goes on.
    let intact = dynamic || outcome.edits.len() == edits;
    if dynamic && number == 0 {
        return Ok(());
    }
    let (time, length) = (problem.schedule.time(edited), problem.schedule.time(1));
    let path = path(problem, number);
    for n in 0..tracks.len() {
        let made = interruption::check().and_then(|()| match dynamic {
            true => tracks[n].advance(problem, time, length).map(drop),
            false => tracks[n].balance(problem, &path, progress).map(drop),
        });
        if let Err(failure) = made {
            tracks[..=n].iter_mut().for_each(Track::take_back);
            return Err(Halt { why: told(problem, (tracks, n), number, failure), intact });
        }
    }
    Ok(())
}

/// A failure with the file, the step, and the model where there are several.
fn told(problem: &Problem, (tracks, n): (&[Track], usize), number: usize, failure: Failure) -> Failure {
    let name = (tracks.len() > 1).then(|| tracks[n].kind.to_string());
    failed_step(&problem.scene.file, number, name.as_deref(), failure)
}

/// The way from one equilibrium to the next.
fn path(problem: &Problem, number: usize) -> LoadPath {
    let loads = problem.time_of(number);
    let motion = |time: f64| time.min(problem.holds.end_of_motion());
    match number {
        0 => LoadPath { share: [0.0, 1.0], time: [0.0, motion(loads)], loads: [loads; 2] },
        _ => {
            let before = problem.time_of(number - 1);
            LoadPath { share: [1.0, 1.0], time: [motion(before), motion(loads)], loads: [before, loads] }
        }
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
    let (dynamic, nodes) = (problem.scene.is_dynamic(), problem.fixed.len());
    let time = if dynamic { problem.schedule.time(number) } else { problem.time_of(number - 1) };
    if dynamic {
        // What is let go now holds nothing during the next step.
        problem.fixed = problem.holds.fixed_at(problem.schedule.time(number + 1), nodes);
    }
    let known = outcome.edits.last().filter(|_| dynamic).map_or([0; 2], |row| [row.loose_parts, row.loose_cells]);
    let Some(Made { changed, mut row, loose_kept, .. }) = edits::make(problem, number, (editor, known), progress)?
    else {
        return Ok(());
    };
    if loose_kept && !dynamic {
        let sentence = "parts hang on nothing and have no static equilibrium; expected loose = \"drop\" in [body], \
                        or mode = \"dynamic\" in [time]";
        return Err(Failure::Failed(format!("{}: step {number}: {sentence}", problem.scene.file.display())));
    }
    if !changed.is_empty() {
        for n in 0..tracks.len() {
            let followed = tracks[n].follow(problem, (time, &changed), progress);
            let Update { dirty, seconds } = followed.map_err(|why| told(problem, (tracks, n), number, why))?;
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
    outcome: Option<&mut Outcome>,
    on_step: &mut impl FnMut(&Problem, TrackStep<'_>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let displacements: Vec<Vec<f64>> =
        tracks.iter().map(|track| track.displacement(problem)).collect::<Result<_, _>>()?;
    let fine = tracks.iter().position(|track| track.coarse().is_none());
    let errors = errors_against(fine, &displacements);
    let time = problem.schedule.time(number);
    on_step(problem, TrackStep { number, time, last, tracks, displacements: &displacements, errors: &errors })?;
    let Some(outcome) = outcome else { return Ok(()) };
    let momenta = |track: &Track| problem.scene.is_dynamic().then(|| track.momenta(problem));
    outcome.add((number, time), errors, tracks.first().map(|first| (&first.books, momenta(first))));
    Ok(())
}
