//! All steps of a run of meshes.

use super::method::MeshMethod;
use super::model::MeshRun;
use super::problem::MeshProblem;
use crate::failure::Failure;
use crate::interruption;
use crate::progress::Progress;
use crate::tracks::{Outcome, TrackStep, errors_against, failed_step};

/// A step that has been made.
pub type MeshStep<'a> = TrackStep<'a, MeshRun>;

/// Runs all steps, or finds the one equilibrium of a static run. The first model is that of the report; the first fine one is what others are compared with.
///
/// A step that fails ends the run; what came before it stands in the outcome, and `on_step` receives the step before it once more, as the last one.
///
/// # Errors
/// What `on_step` returns; an interruption.
pub fn run(
    problem: &MeshProblem,
    runs: &mut [MeshRun],
    progress: &Progress,
    mut on_step: impl FnMut(&MeshStep<'_>) -> Result<(), Failure>,
) -> Result<Outcome, Failure> {
    let steps = problem.steps();
    let mut outcome = Outcome::default();
    for number in 0..=steps {
        interruption::check()?;
        match make(problem, runs, number, progress) {
            Ok(()) => {}
            Err(Failure::Interrupted) => return Err(Failure::Interrupted),
            Err(why) => {
                outcome.stopped = Some(why);
                progress.close();
                if number > 0 {
                    show(problem, runs, (number - 1, true), None, &mut on_step)?;
                }
                return Ok(outcome);
            }
        }
        if steps > 0 {
            progress.report("steps", number, steps);
        }
        show(problem, runs, (number, number == steps), Some(&mut outcome), &mut on_step)?;
    }
    progress.close();
    Ok(outcome)
}

/// Goes to a step: in a dynamic run from the one before it, in a static one to the equilibrium.
fn make(problem: &MeshProblem, runs: &mut [MeshRun], number: usize, progress: &Progress) -> Result<(), Failure> {
    let dynamic = problem.scene.is_dynamic();
    if dynamic && number == 0 {
        return Ok(());
    }
    for n in 0..runs.len() {
        let track = &mut runs[n].track;
        let made = interruption::check().and_then(|()| match dynamic {
            true => track.advance(problem.time(number - 1), problem.time(1)).map(drop),
            false => track.balance(&problem.path(), progress).map(drop),
        });
        if let Err(failure) = made {
            runs[..=n].iter_mut().for_each(|run| run.track.take_back());
            let name = (runs.len() > 1).then(|| runs[n].method.name());
            return Err(failed_step(&problem.scene.file, number, name, failure));
        }
    }
    Ok(())
}

fn show(
    problem: &MeshProblem,
    runs: &[MeshRun],
    (number, last): (usize, bool),
    outcome: Option<&mut Outcome>,
    on_step: &mut impl FnMut(&MeshStep<'_>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let displacements: Vec<Vec<f64>> = runs.iter().map(|run| run.displacement(problem)).collect();
    let fine = runs.iter().position(|run| run.method == MeshMethod::Fine);
    let errors = errors_against(fine, &displacements);
    let time = problem.time(number);
    on_step(&MeshStep { number, time, last, tracks: runs, displacements: &displacements, errors: &errors })?;
    if let Some(outcome) = outcome {
        let momenta = |run: &MeshRun| problem.scene.is_dynamic().then(|| run.momenta(problem));
        outcome.add((number, time), errors, runs.first().map(|first| (&first.track.books, momenta(first))));
    }
    Ok(())
}
