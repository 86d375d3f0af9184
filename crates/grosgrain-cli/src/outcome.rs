//! One method run on a problem: build, solve, measure.

use std::collections::BTreeMap;
use std::time::Instant;

use grosgrain::coarse::{Built, build};
use grosgrain::dynamics::{CoarseSolution, FineSolution, relative_error, solve_coarse, solve_fine};
use grosgrain::solver::{SolveReport, SolverChoice};

use crate::failure::Failure;
use crate::interruption::is_interrupted;
use crate::method::Method;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::report::{ModelSize, RunError, Solver};

/// A coarse model with its equilibrium.
#[derive(Debug)]
pub struct CoarseRun {
    /// The model and what it was made from.
    pub built: Built,
    /// The equilibrium.
    pub solution: CoarseSolution,
    /// Seconds per stage: training, fitting, assembly, solve.
    pub seconds: BTreeMap<String, f64>,
}

/// The fine model's equilibrium.
#[derive(Debug)]
pub struct FineRun {
    /// The equilibrium.
    pub solution: FineSolution,
    /// Seconds for factorisation and solution.
    pub seconds: f64,
}

/// Builds the coarse model of a method.
///
/// # Errors
/// The method `fine`; a model that cannot be built; an interruption.
pub fn build_coarse(problem: &Problem, method: Method, progress: &Progress) -> Result<Built, Failure> {
    let Some(options) = problem.build_options(method) else {
        return Err(Failure::Unusable("the method fine has no coarse model; expected another one".into()));
    };
    let report = |stage, done, total| progress.report(stage, done, total);
    let built = build(&problem.model, problem.scene.coarsening.degree, &options, &report);
    progress.close();
    let built = built.map_err(|error| failed(&error))?;
    warn_of_fits(&built, progress);
    Ok(built)
}

/// Builds and solves the coarse model of a method.
///
/// # Errors
/// As [`build_coarse`]; a system that is not solved.
pub fn run_coarse(problem: &Problem, method: Method, progress: &Progress) -> Result<CoarseRun, Failure> {
    let built = build_coarse(problem, method, progress)?;
    let start = Instant::now();
    let report = |stage, done, total| progress.report(stage, done, total);
    let solution = solve_coarse(&problem.model, &built.model, &problem.fixed, &problem.loads, &report);
    progress.close();
    let solution = solution.map_err(|error| failed(&format!("the coarse model: {error}")))?;
    if solution.held_by_penalty > 0 {
        progress.say(&format!(
            "{} fixed fine nodes lie inside coarse cells; a penalty holds them on average",
            solution.held_by_penalty
        ));
    }
    let seconds = BTreeMap::from([
        ("training".to_owned(), built.report.training_seconds),
        ("fitting".to_owned(), built.report.fitting_seconds),
        ("assembly".to_owned(), built.report.assembly_seconds),
        ("solve".to_owned(), start.elapsed().as_secs_f64()),
    ]);
    Ok(CoarseRun { built, solution, seconds })
}

/// Solves the fine model.
///
/// # Errors
/// A system that is not solved; an interruption.
pub fn run_fine(problem: &Problem, progress: &Progress) -> Result<FineRun, Failure> {
    let start = Instant::now();
    let report = |stage, done, total| progress.report(stage, done, total);
    let solution = solve_fine(&problem.model, &problem.fixed, &problem.loads, SolverChoice::Auto, &report);
    progress.close();
    let solution = solution.map_err(|error| failed(&format!("the fine model: {error}")))?;
    Ok(FineRun { solution, seconds: start.elapsed().as_secs_f64() })
}

impl CoarseRun {
    /// Size of the coarse model.
    pub fn size(&self) -> ModelSize {
        let nodes = self.built.model.nodes().len();
        ModelSize { cells: self.built.model.cells().len(), nodes, unknowns: 3 * nodes }
    }

    /// The difference from the fine model.
    pub fn error(&self, fine: &FineRun) -> RunError {
        RunError {
            rms_percent: 100.0 * relative_error(&self.solution.displacement, &fine.solution.displacement),
            energy_ratio: self.solution.energy / fine.solution.energy,
        }
    }

    /// Seconds for training, fitting and assembly.
    pub fn build_seconds(&self) -> f64 {
        ["training", "fitting", "assembly"].iter().filter_map(|stage| self.seconds.get(*stage)).sum()
    }
}

/// What the report says of a solve.
pub fn solver_of(report: &SolveReport) -> Solver {
    Solver {
        kind: report.kind.into(),
        reason: report.reason.clone(),
        iterations: report.iterations,
        relative_residual: report.relative_residual,
    }
}

fn failed(error: &dyn std::fmt::Display) -> Failure {
    match is_interrupted() {
        true => Failure::Interrupted,
        false => Failure::Failed(error.to_string()),
    }
}

fn warn_of_fits(built: &Built, progress: &Progress) {
    let dropped = &built.report.rank_deficient;
    if let Some((cell, fields)) = dropped.first() {
        let at = built.model.partition().coarse().cell_position(grosgrain::mesh::Cell(cell.0));
        progress.warn(&format!(
            "{} coarse cells had training fields that depend on each other and dropped some; first ({}, {}, {}), which kept {fields} of 6",
            dropped.len(),
            at[0],
            at[1],
            at[2]
        ));
    }
}
