//! One method run on a problem: build, solve, measure.

use std::collections::BTreeMap;
use std::time::Instant;

use grosgrain::coarse::{Built, build};
use grosgrain::dynamics::{CoarseSolution, FineSolution, relative_error, solve_coarse, solve_fine};
use grosgrain::progress::SOLVING;
use grosgrain::solver::{SolveReport, SolverChoice};

use crate::failure::Failure;
use crate::interruption::is_interrupted;
use crate::method::Method;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::quantities::{counted, number, seconds};
use crate::report::{ModelSize, RunError, Solver};

/// Energy ratios beyond this are told.
const SUSPICIOUS_RATIO: f64 = 2.0;

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
        return Err(Failure::Unusable(
            "the method fine has no coarse model; expected trilinear, average, global, one-ring, single-cell, substructured or auto".into(),
        ));
    };
    let report = |stage, done, total| progress.report(stage, done, total);
    let built = build(&problem.model, problem.scene.coarsening.degree, &options, &report);
    progress.close();
    let built = built.map_err(|error| failed(&error))?;
    if let Some(solver) = &built.report.training_solver {
        tell_iterations(solver, built.report.training_seconds, progress);
    }
    warn_of_fits(&built, progress);
    Ok(built)
}

/// Builds and solves the coarse model of a method.
///
/// # Errors
/// As [`build_coarse`]; a system that is not solved.
pub fn run_coarse(problem: &Problem, method: Method, progress: &Progress) -> Result<CoarseRun, Failure> {
    let built = build_coarse(problem, method, progress)?;
    solve_built(problem, built, progress)
}

/// Solves a coarse model.
///
/// # Errors
/// A system that is not solved; an interruption.
pub fn solve_built(problem: &Problem, built: Built, progress: &Progress) -> Result<CoarseRun, Failure> {
    let start = Instant::now();
    let report = |stage, done, total| progress.report(stage, done, total);
    let solution = solve_coarse(&built.model, &problem.fixed, &problem.loads, &report);
    progress.close();
    let solution = solution.map_err(|error| failed(&format!("the coarse model: {error}")))?;
    let solved = start.elapsed().as_secs_f64();
    tell_iterations(&solution.report, solved, progress);
    if solution.held_by_penalty > 0 {
        progress.say(&format!(
            "a penalty holds {} inside coarse cells on average",
            counted(solution.held_by_penalty, "fixed fine node")
        ));
    }
    let seconds = BTreeMap::from([
        ("training".to_owned(), built.report.training_seconds),
        ("fitting".to_owned(), built.report.fitting_seconds),
        ("assembly".to_owned(), built.report.assembly_seconds),
        ("solve".to_owned(), solved),
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
    let seconds = start.elapsed().as_secs_f64();
    tell_iterations(&solution.report, seconds, progress);
    Ok(FineRun { solution, seconds })
}

fn tell_iterations(report: &SolveReport, duration: f64, progress: &Progress) {
    if report.iterations > 0 {
        progress.say(&format!("{SOLVING}: {} in {}", counted(report.iterations, "iteration"), seconds(duration)));
    }
}

impl CoarseRun {
    /// Size of the coarse model.
    pub fn size(&self) -> ModelSize {
        let nodes = self.built.model.mesh().vertices().len();
        ModelSize { cells: self.built.model.elements().len(), nodes, unknowns: 3 * nodes }
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

/// The end of a run in which something failed: the user's interruption where there was one.
pub fn failed(error: &dyn std::fmt::Display) -> Failure {
    match is_interrupted() {
        true => Failure::Interrupted,
        false => Failure::Failed(error.to_string()),
    }
}

/// Warns of a coarse model of voxels that stores far more energy than the fine one under the same loads.
pub fn warn_of_softness(method: &str, energy_ratio: f64, progress: &Progress) {
    warn_of_energy(method, energy_ratio, "base = \"material\" or a smaller degree", progress);
}

/// The same of a coarse mesh.
pub fn warn_of_soft_mesh(method: &str, energy_ratio: f64, progress: &Progress) {
    warn_of_energy(method, energy_ratio, "smaller coarse cells, or downsampling = \"nodes\"", progress);
}

fn warn_of_energy(method: &str, energy_ratio: f64, remedy: &str, progress: &Progress) {
    if energy_ratio > SUSPICIOUS_RATIO {
        progress.warn(&format!(
            "{method} stores {} times the fine model's energy, so it is much too soft: stiff parts may pass between its \
             corners, or the body fills little of its cells; compare with {remedy}",
            number(energy_ratio)
        ));
    }
}

fn warn_of_fits(built: &Built, progress: &Progress) {
    let dropped = &built.report.rank_deficient;
    if let Some((element, fields)) = dropped.first() {
        let at = built.model.partition().coarse().cell_position(grosgrain::mesh::Cell(element.cell.0));
        progress.warn(&format!(
            "training fields depend on each other in {}, so some were dropped; the first cell, ({}, {}, {}), kept {fields} of 6",
            counted(dropped.len(), "coarse cell"),
            at[0],
            at[1],
            at[2]
        ));
    }
}
