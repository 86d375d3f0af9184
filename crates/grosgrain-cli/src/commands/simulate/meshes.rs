//! `simulate` where the body is a mesh.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::mesh_output::MeshWriter;
use crate::failure::Failure;
use crate::interruption;
use crate::meshes::{self, MeshMethod, MeshProblem, MeshRun};
use crate::method::AskedMethod;
use crate::outcome::warn_of_soft_mesh;
use crate::output::OutputFolder;
use crate::progress::Progress;
use crate::report::{self, Report, RunError, SCHEMA_VERSION, Steps};
use crate::results;
use crate::scene::Scene;
use crate::tracks::Outcome;

/// Runs the scene and writes the results into the folder at `output`.
///
/// # Errors
/// Everything wrong with the scene's files; a model that cannot be built; a step that cannot be made, after what came before it has been written.
pub fn run(scene: Scene, asked: Option<&AskedMethod>, output: &Path, progress: &Progress) -> Result<(), Failure> {
    let start = Instant::now();
    let method = asked.map_or(Ok(MeshMethod::Tensor), AskedMethod::for_mesh)?;
    let mut problem = MeshProblem::new(scene, progress)?;
    problem.require_support()?;
    let output = OutputFolder::make(output)?;
    let folder = output.path();
    let mut methods = vec![method];
    if problem.scene.output.compare_with_fine && method != MeshMethod::Fine {
        methods.push(MeshMethod::Fine);
    }
    let mut runs: Vec<MeshRun> =
        methods.into_iter().map(|method| MeshRun::new(&problem, method, progress)).collect::<Result<_, _>>()?;
    let mut writer = MeshWriter::new(&problem, folder, &runs, progress);
    let mut outcome = meshes::run(&problem, &mut runs, progress, |step| writer.add(&problem, step))?;
    interruption::check()?;
    let mut written = writer.finish(&problem, &outcome);
    problem.seconds.insert("output".into(), writer.seconds);
    problem.seconds.insert("total".into(), start.elapsed().as_secs_f64());
    let report = make_report(&problem, &runs, &mut outcome)?;
    let path = folder.join("report.json");
    results::write_json(&path, &report)?;
    written.push(path);
    results::print(&super::text(&report, &written))?;
    if let Some(fine) = runs.iter().skip(1).find(|run| run.method == MeshMethod::Fine) {
        let ratio = runs[0].track.books.ratio_of_peaks(&fine.track.books);
        warn_of_soft_mesh(&report.method, ratio, progress);
    }
    outcome.stopped.map_or(Ok(()), Err)
}

/// The steps of all models, with how much faster than the fine one each is.
pub fn steps_of_meshes(runs: &[MeshRun]) -> Vec<Steps> {
    let fine = runs.iter().find(|run| run.method == MeshMethod::Fine).map(|run| &run.track.books);
    let other = |run: &MeshRun| fine.filter(|_| run.method != MeshMethod::Fine);
    runs.iter().map(|run| Steps::of(run.method.name(), &run.track.books, other(run))).collect()
}

fn make_report(problem: &MeshProblem, runs: &[MeshRun], outcome: &mut Outcome) -> Result<Report, Failure> {
    let files = problem.input_files();
    let main = &runs[0];
    let books = &main.track.books;
    let mut seconds = problem.seconds.clone();
    let stages = match main.method {
        MeshMethod::Fine => 3..3,
        MeshMethod::Tensor => 0..3,
        // Averages take no harmonic displacements.
        _ => 2..3,
    };
    let names = ["harmonic", "intersections", "tensors"];
    seconds.extend(stages.map(|n| (names[n].to_owned(), books.build[n])));
    seconds.insert("solve".into(), books.solving);
    let fine = runs.iter().skip(1).find(|run| run.method == MeshMethod::Fine).map(|run| &run.track.books);
    seconds.extend(fine.map(|fine| ("fine".to_owned(), fine.solving)));
    let error = outcome.errors.last().and_then(|errors| errors[0]).zip(fine);
    Ok(Report {
        schema_version: SCHEMA_VERSION,
        program_version: env!("CARGO_PKG_VERSION"),
        title: problem.scene.title.clone(),
        method: main.method.name().into(),
        input_hash: report::input_hash(&files.iter().map(PathBuf::as_path).collect::<Vec<_>>())?,
        threads: rayon::current_num_threads(),
        fine: problem.fine_size(),
        coarse: main.coarse.as_ref().map(|_| problem.coarse_size()),
        seconds,
        solver: None,
        fine_solver: None,
        training_solver: None,
        steps: steps_of_meshes(runs),
        stopped: outcome.stopped.as_ref().map(ToString::to_string),
        edits: Vec::new(),
        frames: std::mem::take(&mut outcome.frames),
        error: error.map(|(rms_percent, fine)| RunError::of(rms_percent, books, fine)),
    })
}
