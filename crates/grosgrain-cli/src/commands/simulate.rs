//! `simulate`: the main job. Coarsen, solve, write frames, pictures and the report.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use crate::deformed_volume;
use crate::failure::Failure;
use crate::frames;
use crate::interruption;
use crate::method::Method;
use crate::outcome::{CoarseRun, FineRun, run_coarse, run_fine, solver_of, warn_of_softness};
use crate::output::OutputFolder;
use crate::picture;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::quantities::{count, number, seconds};
use crate::report::{self, Frame, Report, SCHEMA_VERSION};
use crate::results;

const EXAMPLES: &str = "Examples:
  grosgrain simulate scenes/torso.toml -o out/torso
  grosgrain simulate scenes/beam-across.toml --method global";

/// Arguments of `simulate`.
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The scene, a TOML file
    scene: PathBuf,
    /// The folder that receives frames, picture and report.json; out/NAME without it
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// fine, trilinear, average, global, one-ring or single-cell; without it the scene's training
    #[arg(long)]
    method: Option<Method>,
}

/// What was run.
struct Runs {
    coarse: Option<CoarseRun>,
    fine: Option<FineRun>,
}

/// Runs the scene and writes the results.
pub fn run(arguments: &Arguments, progress: &Progress) -> Result<(), Failure> {
    let start = Instant::now();
    let mut problem = Problem::read(&arguments.scene, progress)?;
    problem.require_support()?;
    let output = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.scene));
    let output = OutputFolder::make(&output)?;
    let folder = output.path();
    let method = problem.method(arguments.method);
    let runs = solve(&problem, method, progress)?;
    interruption::check()?;
    let writing = Instant::now();
    let mut written = frames::write(&problem, runs.coarse.as_ref(), runs.fine.as_ref(), folder)?;
    if problem.scene.output.picture {
        progress.say("drawing the picture");
        let drawn = picture::write(&problem, method, (runs.coarse.as_ref(), runs.fine.as_ref()), folder);
        written.extend(keep_or_warn(drawn, progress));
    }
    let shown = runs.coarse.as_ref().map(|run| &run.solution.displacement);
    let shown = shown.or(runs.fine.as_ref().map(|run| &run.solution.displacement));
    if let Some(displacement) = shown.filter(|_| problem.scene.output.volume) {
        progress.say("resampling the deformed volume");
        written.extend(keep_or_warn(deformed_volume::write(&problem, displacement, folder), progress));
    }
    problem.seconds.insert("output".into(), writing.elapsed().as_secs_f64());
    problem.seconds.insert("total".into(), start.elapsed().as_secs_f64());
    let report = make_report(&problem, method, &runs)?;
    let path = folder.join("report.json");
    results::write_json(&path, &report)?;
    written.push(path);
    results::print(&text(&report, &written))?;
    report.error.iter().for_each(|error| warn_of_softness(&report.method, error.energy_ratio, progress));
    Ok(())
}

/// A picture or volume that cannot be made is a warning: the results that were computed stay.
fn keep_or_warn(file: Result<PathBuf, Failure>, progress: &Progress) -> Option<PathBuf> {
    file.inspect_err(|failure| progress.warn(&failure.to_string())).ok()
}

fn default_folder(scene: &Path) -> PathBuf {
    Path::new("out").join(scene.file_stem().unwrap_or_default())
}

fn solve(problem: &Problem, method: Method, progress: &Progress) -> Result<Runs, Failure> {
    let coarse = match method {
        Method::Fine => None,
        _ => {
            progress.say(&format!("building the coarse model: {method}"));
            Some(run_coarse(problem, method, progress)?)
        }
    };
    let fine = match method == Method::Fine || problem.scene.output.compare_with_fine {
        true => {
            progress.say("solving the fine model");
            Some(run_fine(problem, progress)?)
        }
        false => None,
    };
    Ok(Runs { coarse, fine })
}

fn make_report(problem: &Problem, method: Method, runs: &Runs) -> Result<Report, Failure> {
    let files = problem.input_files();
    let error = runs.coarse.as_ref().zip(runs.fine.as_ref()).map(|(coarse, fine)| coarse.error(fine));
    let mut seconds = problem.seconds.clone();
    seconds.extend(runs.coarse.iter().flat_map(|run| run.seconds.clone()));
    seconds.extend(runs.fine.iter().map(|run| ("fine".to_owned(), run.seconds)));
    let coarse = runs.coarse.as_ref().map(|run| (&run.solution.report, run.solution.energy));
    let fine = runs.fine.as_ref().map(|run| (&run.solution.report, run.solution.energy));
    let Some((solved, energy)) = coarse.or(fine) else {
        return Err(Failure::Failed("nothing was solved".into()));
    };
    Ok(Report {
        schema_version: SCHEMA_VERSION,
        program_version: env!("CARGO_PKG_VERSION"),
        title: problem.scene.title.clone(),
        method: method.name().into(),
        input_hash: report::input_hash(&files.iter().map(PathBuf::as_path).collect::<Vec<_>>())?,
        threads: rayon::current_num_threads(),
        fine: problem.fine_size(),
        coarse: runs.coarse.as_ref().map(CoarseRun::size),
        seconds,
        solver: solver_of(solved),
        fine_solver: runs.fine.as_ref().map(|run| solver_of(&run.solution.report)),
        training_solver: runs.coarse.as_ref().and_then(|run| run.built.report.training_solver.as_ref()).map(solver_of),
        edits: Vec::new(),
        frames: vec![Frame { step: 0, time: 0.0, energy, error: error.map(|e| e.rms_percent) }],
        error,
    })
}

fn text(report: &Report, written: &[PathBuf]) -> String {
    let row = |name: &str, value: String| (name.to_owned(), value);
    let mut rows = vec![row("method", report.method.clone())];
    if let Some(coarse) = &report.coarse {
        let share = report.fine.unknowns as f64 / coarse.unknowns as f64;
        let value =
            format!("{} unknowns, {} times fewer", count(coarse.unknowns), number((10.0 * share).round() / 10.0));
        rows.push(row("coarse model", value));
    }
    let fine_solver =
        report.fine_solver.as_ref().map_or(String::new(), |s| format!(", solved by {}: {}", s.kind, s.reason));
    rows.push(row("fine model", format!("{} unknowns{fine_solver}", count(report.fine.unknowns))));
    let stages = report.seconds.iter().map(|(stage, s)| format!("{stage} {}", seconds(*s)));
    rows.push(row("time", stages.collect::<Vec<_>>().join(", ")));
    if let Some(error) = &report.error {
        let value = format!("{:.1} % RMS, energy ratio {}", error.rms_percent, number(error.energy_ratio));
        rows.push(row("error against the fine model", value));
    }
    let files: Vec<String> = written.iter().map(|path| format!("wrote {}", path.display())).collect();
    format!("{}\n{}\n{}", report.title, results::table(&rows), files.join("\n"))
}
