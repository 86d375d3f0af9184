//! The steps of a run: at each the due edits, then a new equilibrium.

use std::collections::BTreeMap;

use grosgrain::update::Editor;

use crate::edits::{self, Made};
use crate::failure::Failure;
use crate::frames::{Shown, ShownCoarse};
use crate::interruption;
use crate::method::Method;
use crate::models::Models;
use crate::outcome::{CoarseRun, FineRun};
use crate::picture::Drawn;
use crate::problem::Problem;
use crate::progress::Progress;
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

impl Runs {
    /// What a picture shows of them.
    pub fn drawn(&self) -> Drawn<'_> {
        let Self { coarse, fine } = self;
        Drawn {
            coarse: coarse.as_ref().map(|run| (run.size().unknowns, run.solution.displacement.as_slice())),
            fine: fine.as_ref().map(|run| run.solution.displacement.as_slice()),
            error: coarse.as_ref().zip(fine.as_ref()).map(|(coarse, fine)| coarse.error(fine).rms_percent),
            remark: "",
        }
    }
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
            sequence.edit((problem, &mut models), number, &mut editor, progress)?;
        }
        let step = Step { number, time: schedule.time(number), runs: &sequence.last };
        on_step(problem, step)?;
        sequence.frames.push(step.frame());
    }
    Ok(sequence)
}

impl<'a> Step<'a> {
    /// What a frame shows of it; `None` where nothing was solved.
    pub fn shown(&self) -> Option<Shown<'a>> {
        let Runs { coarse, fine } = self.runs;
        let reference = fine.as_ref().map(|run| run.solution.displacement.as_slice());
        let embedded = coarse.as_ref().map(|run| run.solution.displacement.as_slice());
        Some(Shown {
            number: self.number,
            time: self.time,
            displacement: embedded.or(reference)?,
            velocity: None,
            reference: embedded.and(reference),
            coarse: coarse.as_ref().map(|run| ShownCoarse {
                model: &run.built.model,
                displacement: &run.solution.coarse_displacement,
                velocity: None,
            }),
        })
    }

    fn frame(&self) -> Frame {
        let Runs { coarse, fine } = self.runs;
        let energy = coarse.as_ref().map(|run| run.solution.energy).or(fine.as_ref().map(|run| run.solution.energy));
        let error = coarse.as_ref().zip(fine.as_ref()).map(|(coarse, fine)| coarse.error(fine).rms_percent);
        Frame { step: self.number, time: self.time, energy: energy.unwrap_or_default(), error, motion: None }
    }
}

impl Sequence {
    /// Makes the edits of a step and solves anew if they changed anything.
    fn edit(
        &mut self,
        (problem, models): (&mut Problem, &mut Models),
        number: usize,
        editor: &mut Editor,
        progress: &Progress,
    ) -> Result<(), Failure> {
        let Some(Made { changed, mut row, seconds, .. }) = edits::make(problem, number, (editor, [0; 2]), progress)?
        else {
            return Ok(());
        };
        let mut total = seconds;
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
