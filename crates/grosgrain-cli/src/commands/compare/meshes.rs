//! `compare` where the body is a mesh.

use std::path::Path;

use super::{Row, moving, table};
use crate::commands::simulate::steps_of_meshes;
use crate::failure::Failure;
use crate::interruption;
use crate::meshes::{self, MeshMethod, MeshProblem, MeshRun};
use crate::method::AskedMethod;
use crate::outcome::warn_of_soft_mesh;
use crate::output::OutputFolder;
use crate::progress::Progress;
use crate::results;
use crate::scene::Scene;

/// Runs every method and prints the table: that of one equilibrium where materials are linear, that of steps otherwise.
///
/// # Errors
/// Everything wrong with the scene's files, models that cannot be built, steps that cannot be made, a file that cannot be written.
pub fn run(scene: Scene, asked: &[AskedMethod], json: Option<&Path>, progress: &Progress) -> Result<(), Failure> {
    let methods: Vec<MeshMethod> = match asked {
        [] => MeshMethod::ALL.to_vec(),
        asked => asked.iter().map(AskedMethod::for_mesh).collect::<Result<_, _>>()?,
    };
    let problem = MeshProblem::new(scene, progress)?;
    problem.require_support()?;
    let _folder = json.map(OutputFolder::around).transpose()?;
    let coarse = methods.iter().filter(|method| **method != MeshMethod::Fine);
    let mut runs: Vec<MeshRun> = std::iter::once(&MeshMethod::Fine)
        .chain(coarse)
        .map(|method| MeshRun::new(&problem, *method, progress))
        .collect::<Result<_, _>>()?;
    let outcome = meshes::run(&problem, &mut runs, progress, |_| Ok(()))?;
    interruption::check()?;
    if outcome.errors.is_empty() {
        return outcome.stopped.map_or(Ok(()), Err);
    }
    let hidden = usize::from(!methods.contains(&MeshMethod::Fine));
    let text = match problem.scene.is_linear_static() {
        true => {
            let errors = outcome.errors.last().cloned().unwrap_or_else(|| vec![None; runs.len()]);
            let rows: Vec<Row> = (hidden..runs.len()).map(|n| still_row(&problem, &runs, n, errors[n])).collect();
            written(&rows, json)?;
            table(&rows)
        }
        false => {
            let steps = steps_of_meshes(&runs);
            let row = |n: usize| {
                let errors = outcome.errors.iter().map(|errors| errors[n].unwrap_or(0.0)).collect();
                let books = [&runs[n].track.books, &runs[0].track.books];
                moving::Row::new(&steps[n], runs[n].size(&problem).unknowns, books, errors)
            };
            let rows: Vec<moving::Row> = (hidden..runs.len()).map(row).collect();
            written(&rows, json)?;
            moving::table(&rows)
        }
    };
    results::print(&format!("{}\n{text}", problem.scene.title))?;
    for run in runs.iter().skip(1) {
        warn_of_soft_mesh(run.method.name(), run.track.books.ratio_of_peaks(&runs[0].track.books), progress);
    }
    outcome.stopped.map_or(Ok(()), Err)
}

fn written(rows: &impl serde::Serialize, json: Option<&Path>) -> Result<(), Failure> {
    json.map_or(Ok(()), |json| results::write_json(json, rows))
}

/// The row of a single equilibrium.
fn still_row(problem: &MeshProblem, runs: &[MeshRun], n: usize, error: Option<f64>) -> Row {
    let (run, fine) = (&runs[n], &runs[0].track.books);
    let books = &run.track.books;
    Row {
        method: run.method.name().into(),
        unknowns: run.size(problem).unknowns,
        error_percent: error.unwrap_or(0.0),
        energy_ratio: if fine.elastic > 0.0 { books.elastic / fine.elastic } else { 1.0 },
        build_seconds: books.build.iter().sum(),
        solve_seconds: books.solving,
    }
}
