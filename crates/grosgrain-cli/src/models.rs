//! The models of a run, kept up to date while the body is edited.

use grosgrain::coarse::{BuildReport, Built};
use grosgrain::coarsening::Objective;
use grosgrain::fine::CellState;
use grosgrain::mesh::Cell;
use grosgrain::training::RunTimeTraining;
use grosgrain::update::{Editor, LiveCoarse, LiveOptions, UpdateReport};

use crate::failure::Failure;
use crate::method::Method;
use crate::outcome::{CoarseRun, failed, run_coarse, run_fine, solve_built};
use crate::problem::{END_OF_RAMPS, Problem};
use crate::progress::Progress;
use crate::schedule::EditSchedule;
use crate::sequence::Runs;

/// What a method needs to solve the body step after step.
///
/// Where there are edits, shape functions are renewed only where an edit reaches; methods without training, and fits by the coupled baseline,
/// are built anew.
pub struct Models {
    method: Method,
    live: Option<LiveCoarse>,
    /// What the last build or update of the live model did.
    report: UpdateReport,
    /// Cells of loose parts that were kept: they are void in the live model, because nothing static holds them.
    aside: Vec<Cell>,
    /// Elements of the coarse model that the last update renewed.
    pub dirty: usize,
}

impl Models {
    /// The models of the unedited body.
    ///
    /// # Errors
    /// A coarse model that is not built; an interruption.
    pub fn new(
        problem: &Problem,
        method: Method,
        schedule: &EditSchedule,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let coarsening = &problem.scene.coarsening;
        let mut models = Self { method, live: None, report: UpdateReport::default(), aside: Vec::new(), dirty: 0 };
        let kind = problem.run_time_training(method).filter(|_| coarsening.objective == Objective::ClosedForm);
        let Some(kind) = kind.filter(|_| schedule.steps() > 0) else { return Ok(models) };
        if method == Method::Auto {
            progress.say(&format!("training at run time: {}", Method::Coarsened(kind)));
        }
        progress.say(&format!("building the coarse model: {method}"));
        let options = LiveOptions {
            training: RunTimeTraining::Fixed(kind),
            data_tolerance: coarsening.data_tolerance,
            base: coarsening.base,
            split: coarsening.split,
            ..LiveOptions::default()
        };
        let callback = |stage, done, total| progress.report(stage, done, total);
        let live = LiveCoarse::new(&problem.model, coarsening.degree, &options, &mut models.report, &callback);
        progress.close();
        models.live = Some(live.map_err(|error| failed(&error))?);
        Ok(models)
    }

    /// Brings the models up to date with a fine model that has changed in these cells, and solves them.
    ///
    /// Loose parts that were kept have no static equilibrium: they are set aside for the solution and do not move.
    ///
    /// # Errors
    /// A body that is held nowhere; training, fits or systems that fail; an interruption.
    pub fn update(
        &mut self,
        problem: &mut Problem,
        changed: &[Cell],
        editor: &mut Editor,
        progress: &Progress,
    ) -> Result<Runs, Failure> {
        let (_, loose) = editor.loose(&problem.model, &problem.fixed);
        let void = |cell: &Cell| (*cell, CellState { void: true, ..problem.model.state(*cell) });
        let states: Vec<(Cell, CellState)> = loose.iter().map(void).collect();
        let aside = loose.to_vec();
        let mut previous = Vec::new();
        if problem.model.change(&states, &mut previous).is_err() {
            let sentence =
                "after the edit nothing of the body is held, so it has no static equilibrium; keep a held part";
            return Err(Failure::Failed(sentence.into()));
        }
        problem.loads = problem.placed.assemble(&problem.model, END_OF_RAMPS);
        let renewed = self.renew(problem, changed, &aside, progress);
        let runs = renewed.and_then(|()| self.solve(problem, progress));
        problem.model.restore(&previous).map_err(|error| Failure::Failed(error.to_string()))?;
        self.aside = aside;
        runs
    }

    fn renew(
        &mut self,
        problem: &Problem,
        changed: &[Cell],
        aside: &[Cell],
        progress: &Progress,
    ) -> Result<(), Failure> {
        let Some(live) = &mut self.live else { return Ok(()) };
        let mut cells: Vec<Cell> = changed.iter().chain(aside).chain(&self.aside).copied().collect();
        cells.sort_unstable();
        cells.dedup();
        let callback = |stage, done, total| progress.report(stage, done, total);
        let renewed = live.renew(&problem.model, &cells, true, &mut self.report, &callback);
        progress.close();
        renewed.map_err(|error| failed(&error))?;
        self.dirty = self.report.dirty;
        Ok(())
    }

    /// Solves what the method needs.
    ///
    /// # Errors
    /// Models that cannot be built or solved; an interruption.
    pub fn solve(&mut self, problem: &Problem, progress: &Progress) -> Result<Runs, Failure> {
        let coarse = match (&self.live, self.method) {
            (_, Method::Fine) => None,
            (Some(live), _) => Some(self.solve_live(live, problem, progress)?),
            (None, method) => {
                progress.say(&format!("building the coarse model: {method}"));
                let run = run_coarse(problem, method, progress)?;
                self.dirty = run.size().cells;
                Some(run)
            }
        };
        let fine = match self.method == Method::Fine || problem.scene.output.compare_with_fine {
            true => {
                progress.say("solving the fine model");
                Some(run_fine(problem, progress)?)
            }
            false => None,
        };
        Ok(Runs { coarse, fine })
    }

    fn solve_live(&self, live: &LiveCoarse, problem: &Problem, progress: &Progress) -> Result<CoarseRun, Failure> {
        let seconds = &self.report.seconds;
        let report = BuildReport {
            training_seconds: seconds.training,
            fitting_seconds: seconds.fitting,
            assembly_seconds: seconds.topology + seconds.assembly,
            ..BuildReport::default()
        };
        solve_built(problem, Built { model: live.model().clone(), training: None, report }, progress)
    }
}
