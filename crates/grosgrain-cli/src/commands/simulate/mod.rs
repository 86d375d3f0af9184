//! `simulate`: the main job. Coarsen, solve, write frames, pictures and the report.

mod mesh_output;
mod meshes;
mod moving;

pub use meshes::steps_of_meshes;
pub use moving::steps_of;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use crate::deformed_volume::{self, ScannedBody};
use crate::failure::Failure;
use crate::frames::Frames;
use crate::interruption;
use crate::method::{AskedMethod, Method};
use crate::outcome::{CoarseRun, solver_of, warn_of_softness};
use crate::output::OutputFolder;
use crate::picture::{self, Drawn};
use crate::problem::Problem;
use crate::progress::Progress;
use crate::quantities::{count, number, seconds};
use crate::report::{self, ModelSize, Report, SCHEMA_VERSION};
use crate::results;
use crate::scene::read_scene;
use crate::sequence::{self, Sequence};

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
    /// fine, trilinear, average, global, one-ring, single-cell, substructured or auto; without it the scene's training. For a
    /// mesh fine, tensor, average, trilinear or sampled; without it tensor
    #[arg(long)]
    method: Option<AskedMethod>,
}

/// Runs the scene and writes the results.
pub fn run(arguments: &Arguments, progress: &Progress) -> Result<(), Failure> {
    let start = Instant::now();
    let scene = read_scene(&arguments.scene)?;
    let output = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.scene));
    if scene.is_mesh() {
        return meshes::run(scene, arguments.method.as_ref(), &output, progress);
    }
    let mut problem = Problem::new(scene, progress)?;
    problem.require_support()?;
    let output = OutputFolder::make(&output)?;
    let folder = output.path();
    let method = problem.method(arguments.method.as_ref())?;
    if !problem.scene.is_linear_static() {
        return moving::run(&mut problem, method, folder, progress);
    }
    let initial = problem.fine_size();
    let schedule = problem.schedule.clone();
    // Before the first edit: what the body is cut from is shown no more, what never belonged to it is its skin.
    let scanned = problem.scene.output.volume.then(|| ScannedBody::new(&problem)).flatten();
    let mut frames = Frames::new(folder);
    let (mut written, mut output_seconds) = (Vec::new(), 0.0);
    let sequence = sequence::run(&mut problem, method, &schedule, progress, |problem, step| {
        let writing = Instant::now();
        if step.number % problem.scene.output.frames == 0 || step.number == schedule.steps() {
            step.shown().map_or(Ok(0), |shown| frames.add(problem, &shown))?;
        }
        if step.number == 0 && schedule.steps() > 0 && problem.scene.output.picture {
            written.extend(draw(problem, method, &step.runs.drawn(), folder.join("picture_0000.png"), progress));
        }
        output_seconds += writing.elapsed().as_secs_f64();
        Ok(())
    })?;
    interruption::check()?;
    let writing = Instant::now();
    written.splice(0..0, frames.written());
    let runs = &sequence.last;
    if problem.scene.output.picture {
        written.extend(draw(&problem, method, &runs.drawn(), folder.join("picture.png"), progress));
    }
    let shown = runs.coarse.as_ref().map(|run| &run.solution.displacement);
    let shown = shown.or(runs.fine.as_ref().map(|run| &run.solution.displacement));
    if let Some(displacement) = shown.filter(|_| problem.scene.output.volume) {
        progress.say("resampling the deformed volume");
        written.extend(write_volumes(&problem, scanned.as_ref(), displacement, folder, progress));
    }
    output_seconds += writing.elapsed().as_secs_f64();
    problem.seconds.insert("output".into(), output_seconds);
    problem.seconds.insert("total".into(), start.elapsed().as_secs_f64());
    let report = make_report(&problem, method, initial, sequence)?;
    let path = folder.join("report.json");
    results::write_json(&path, &report)?;
    written.push(path);
    results::print(&text(&report, &written))?;
    report.error.iter().for_each(|error| warn_of_softness(&report.method, error.energy_ratio, progress));
    Ok(())
}

/// Writes the deformed body, and the scan that it comes from, as volumes.
fn write_volumes(
    problem: &Problem,
    scanned: Option<&ScannedBody>,
    displacement: &[f64],
    folder: &Path,
    progress: &Progress,
) -> Vec<PathBuf> {
    let labels = deformed_volume::write(problem, displacement, folder);
    let mut written = keep_or_warn(labels, progress).unwrap_or_default();
    let deformed = scanned.map(|scan| scan.deformed(&problem.model, displacement));
    let deformed = deformed.and_then(|scan| keep_or_warn(scan, progress));
    let files = deformed.map(|scan| deformed_volume::write_scan(&scan, folder));
    written.extend(files.and_then(|files| keep_or_warn(files, progress)).unwrap_or_default());
    written
}

/// A picture or volume that cannot be made is a warning: the results that were computed stay.
pub fn keep_or_warn<T>(made: Result<T, Failure>, progress: &Progress) -> Option<T> {
    made.inspect_err(|failure| progress.warn(&failure.to_string())).ok()
}

fn default_folder(scene: &Path) -> PathBuf {
    Path::new("out").join(scene.file_stem().unwrap_or_default())
}

fn draw(problem: &Problem, method: Method, drawn: &Drawn<'_>, path: PathBuf, progress: &Progress) -> Option<PathBuf> {
    progress.say("drawing the picture");
    keep_or_warn(picture::write(problem, method, drawn, path), progress)
}

fn make_report(
    problem: &Problem,
    method: Method,
    initial: ModelSize,
    Sequence { last: runs, frames, edits, seconds }: Sequence,
) -> Result<Report, Failure> {
    let files = problem.input_files();
    let error = runs.coarse.as_ref().zip(runs.fine.as_ref()).map(|(coarse, fine)| coarse.error(fine));
    let seconds = problem.seconds.clone().into_iter().chain(seconds).collect();
    let coarse = runs.coarse.as_ref().map(|run| &run.solution.report);
    let Some(solved) = coarse.or(runs.fine.as_ref().map(|run| &run.solution.report)) else {
        return Err(Failure::Failed("nothing was solved".into()));
    };
    Ok(Report {
        schema_version: SCHEMA_VERSION,
        program_version: env!("CARGO_PKG_VERSION"),
        title: problem.scene.title.clone(),
        method: method.name().into(),
        input_hash: report::input_hash(&files.iter().map(PathBuf::as_path).collect::<Vec<_>>())?,
        threads: rayon::current_num_threads(),
        fine: initial,
        coarse: runs.coarse.as_ref().map(CoarseRun::size),
        seconds,
        solver: Some(solver_of(solved)),
        steps: Vec::new(),
        stopped: None,
        fine_solver: runs.fine.as_ref().map(|run| solver_of(&run.solution.report)),
        training_solver: runs.coarse.as_ref().and_then(|run| run.built.report.training_solver.as_ref()).map(solver_of),
        edits,
        frames,
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
    for steps in &report.steps {
        let times = |s: f64| number((10.0 * s).round() / 10.0);
        let faster = steps.speed_up.map_or(String::new(), |s| match s < 1.0 {
            true => format!(", {} times slower than fine", times(1.0 / s)),
            false => format!(", {} times faster than fine", times(s)),
        });
        let value = format!(
            "{} in {} each{faster}; {:.1} Newton steps each",
            count(steps.steps),
            seconds(steps.seconds_per_step),
            steps.newton_steps as f64 / steps.steps.max(1) as f64
        );
        rows.push(row(&format!("steps, {}", steps.method), value));
    }
    let stages = report.seconds.iter().map(|(stage, s)| format!("{stage} {}", seconds(*s)));
    rows.push(row("time", stages.collect::<Vec<_>>().join(", ")));
    if let Some(error) = &report.error {
        let when = if report.steps.is_empty() || report.frames.len() < 2 { "" } else { " at the end" };
        let value = format!("{:.1} % RMS{when}, energy ratio {}", error.rms_percent, number(error.energy_ratio));
        rows.push(row("error against the fine model", value));
    }
    let files: Vec<String> = written.iter().map(|path| format!("wrote {}", path.display())).collect();
    format!("{}\n{}\n{}", report.title, results::table(&rows), files.join("\n"))
}
