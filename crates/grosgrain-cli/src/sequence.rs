//! The steps of a run: at each the due edits, then a new equilibrium.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use grosgrain::mesh::Cell;
use grosgrain::update::{Applied, Batch, Editor, LooseReport};

use crate::failure::Failure;
use crate::interruption;
use crate::method::Method;
use crate::models::Models;
use crate::outcome::{CoarseRun, FineRun};
use crate::problem::Problem;
use crate::progress::Progress;
use crate::quantities::counted;
use crate::report::{Edit, Frame};
use crate::schedule::EditSchedule;

/// The equilibria of one step.
#[derive(Debug)]
pub struct Runs {
    /// That of the coarse model.
    pub coarse: Option<CoarseRun>,
    /// That of the fine model.
    pub fine: Option<FineRun>,
}

/// What is known of one step.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// Its number; 0 is the unedited body.
    pub number: usize,
    /// Its time \[s\].
    pub time: f64,
    /// Its equilibria.
    pub runs: &'a Runs,
}

/// What a run of all steps leaves.
#[derive(Debug)]
pub struct Sequence {
    /// The equilibria of the last step.
    pub last: Runs,
    /// One for each step.
    pub frames: Vec<Frame>,
    /// One for each step that had edits.
    pub edits: Vec<Edit>,
    /// Seconds per stage over all steps.
    pub seconds: BTreeMap<String, f64>,
}

/// Runs all steps; `on_step` receives each with the problem as it is then.
///
/// # Errors
/// Edits that the body refuses; models that cannot be built or solved; what `on_step` returns; an interruption.
pub fn run(
    problem: &mut Problem,
    method: Method,
    schedule: &EditSchedule,
    progress: &Progress,
    mut on_step: impl FnMut(&Problem, Step<'_>) -> Result<(), Failure>,
) -> Result<Sequence, Failure> {
    let mut editor = Editor::new(0, problem.scene.body.loose);
    let mut models = Models::new(problem, method, schedule, progress)?;
    let last = models.solve(problem, progress)?;
    let mut sequence = Sequence { last, frames: Vec::new(), edits: Vec::new(), seconds: BTreeMap::new() };
    sequence.add_seconds();
    for number in 0..=schedule.steps() {
        interruption::check()?;
        if number > 0 {
            sequence.edit((problem, &mut models), (schedule, number), &mut editor, progress)?;
        }
        let step = Step { number, time: schedule.time(number), runs: &sequence.last };
        on_step(problem, step)?;
        sequence.frames.push(step.frame());
    }
    Ok(sequence)
}

impl Step<'_> {
    fn frame(&self) -> Frame {
        let Runs { coarse, fine } = self.runs;
        let energy = coarse.as_ref().map(|run| run.solution.energy).or(fine.as_ref().map(|run| run.solution.energy));
        let error = coarse.as_ref().zip(fine.as_ref()).map(|(coarse, fine)| coarse.error(fine).rms_percent);
        Frame { step: self.number, time: self.time, energy: energy.unwrap_or_default(), error }
    }
}

impl Sequence {
    /// Makes the edits of a step and solves anew if they changed anything.
    fn edit(
        &mut self,
        (problem, models): (&mut Problem, &mut Models),
        (schedule, number): (&EditSchedule, usize),
        editor: &mut Editor,
        progress: &Progress,
    ) -> Result<(), Failure> {
        let due = schedule.due(number);
        if due.is_empty() {
            return Ok(());
        }
        let start = Instant::now();
        let refuse = |problem: &Problem, key: &str, error: &dyn std::fmt::Display| {
            Failure::Failed(format!("{}: step {number}: {key}: {error}", problem.scene.file.display()))
        };
        let mut warnings = Vec::new();
        let mut batch = Batch::new(&problem.model);
        for edit in &due {
            match batch.add(&edit.edit) {
                Ok(()) => {}
                Err(error) if error.finds_nothing() => warnings.push(format!("step {number}: {}: {error}", edit.key)),
                Err(error) => return Err(refuse(problem, &edit.key, &error)),
            }
        }
        let resolved = batch.finish().map_err(|error| refuse(problem, "edit", &error))?;
        let Problem { model, fixed, .. } = problem;
        let applied = editor.apply(model, &resolved, fixed);
        let (changed, loose) = match applied {
            Ok(Applied { changed, loose }) => (changed.to_vec(), loose),
            Err(error) => return Err(refuse(problem, "edit", &error)),
        };
        warnings.extend(told(number, &loose));
        warnings.iter().for_each(|warning| progress.warn(warning));
        let mut row = Edit {
            step: number,
            changed_cells: coarse_cells(problem, &changed),
            changed_fine_cells: changed.len(),
            dirty_cells: 0,
            loose_parts: loose.parts,
            loose_cells: loose.cells,
            warnings,
            seconds: BTreeMap::new(),
        };
        let mut total = start.elapsed().as_secs_f64();
        if !changed.is_empty() {
            self.last = models.update(problem, &changed, editor, progress)?;
            self.add_seconds();
            if let Some(run) = &self.last.coarse {
                row.dirty_cells = models.dirty;
                let stages = run.seconds.iter().filter(|(stage, _)| *stage != "solve");
                row.seconds = stages.map(|(stage, s)| (stage.clone(), *s)).collect();
                total += run.build_seconds();
            }
        }
        row.seconds.insert("total".into(), total);
        self.edits.push(row);
        Ok(())
    }

    fn add_seconds(&mut self) {
        let coarse = self.last.coarse.iter().flat_map(|run| run.seconds.clone());
        let fine = self.last.fine.iter().map(|run| ("fine".to_owned(), run.seconds));
        for (stage, seconds) in coarse.chain(fine) {
            *self.seconds.entry(stage).or_default() += seconds;
        }
    }
}

/// Number of coarse cells that hold any of these fine cells.
fn coarse_cells(problem: &Problem, changed: &[Cell]) -> usize {
    let (lattice, degree) = (problem.model.grid().lattice, problem.scene.coarsening.degree);
    let holder = |cell: &Cell| lattice.cell_position(*cell).map(|x| x / degree);
    changed.iter().map(holder).collect::<BTreeSet<_>>().len()
}

/// What the user should know of parts that were cut loose.
fn told(step: usize, loose: &LooseReport) -> Option<String> {
    let (parts, cells) = (counted(loose.parts, "part"), counted(loose.cells, "cell"));
    let verb = if loose.parts == 1 { "hangs" } else { "hang" };
    let then = match loose.dropped {
        true => "left out from now on (body.loose = \"keep\" keeps them)",
        false => "kept where they are, without displacement, since nothing static holds them",
    };
    (loose.parts > 0).then(|| format!("step {step}: {parts} with {cells} {verb} on nothing; {then}"))
}
