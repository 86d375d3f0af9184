//! `coarsen` where the body is a mesh: its effective tensors.

use std::path::Path;

use grosgrain::homogenization::Homogenized;
use grosgrain::io::write_tensors;
use serde::Serialize;

use crate::failure::Failure;
use crate::interruption;
use crate::meshes::{MeshMethod, MeshProblem, homogenized};
use crate::method::AskedMethod;
use crate::output::OutputFolder;
use crate::progress::Progress;
use crate::quantities::{bytes, count, number, seconds};
use crate::results;
use crate::scene::Scene;

/// The figures of a coarsening.
#[derive(Debug, Serialize)]
struct Figures {
    title: String,
    method: &'static str,
    cells: usize,
    nodes: usize,
    unknowns: usize,
    fine_unknowns: usize,
    seconds: Stages,
    worst_condition: Option<f64>,
    /// Coarse cells in which some strains took the volume average.
    averaged_cells: Vec<u32>,
    least_filled: f64,
}

#[derive(Debug, Serialize)]
struct Stages {
    harmonic: f64,
    intersections: f64,
    tensors: f64,
}

/// Homogenizes and writes the tensors.
///
/// # Errors
/// Another method than `tensor`; everything wrong with the scene's files; tensors that are not found; files that cannot be written.
pub fn run(
    scene: Scene,
    asked: Option<&AskedMethod>,
    output: &Path,
    json: Option<&Path>,
    progress: &Progress,
) -> Result<(), Failure> {
    let method = asked.map_or(Ok(MeshMethod::Tensor), AskedMethod::for_mesh)?;
    if method != MeshMethod::Tensor {
        let sentence = format!("{method} leaves nothing to write; expected tensor, whose tensors are the coarse model");
        return Err(Failure::Unusable(sentence));
    }
    let problem = MeshProblem::new(scene, progress)?;
    let _folders = (OutputFolder::around(output)?, json.map(OutputFolder::around).transpose()?);
    let found = homogenized(&problem, progress)?;
    let figures = Figures::new(&problem, &found);
    interruption::check()?;
    write_tensors(output, &problem.coarse, &found)
        .map_err(|error| Failure::Failed(format!("{}: {error}", output.display())))?;
    if let Some(json) = json {
        results::write_json(json, &figures)?;
    }
    results::print(&figures.text(output))
}

impl Figures {
    fn new(problem: &MeshProblem, found: &Homogenized) -> Self {
        let (coarse, [harmonic, intersections, tensors]) = (problem.coarse_size(), found.seconds);
        let worst = found.effective.condition.iter().copied().fold(0.0, f64::max);
        Self {
            title: problem.scene.title.clone(),
            method: MeshMethod::Tensor.name(),
            cells: coarse.cells,
            nodes: coarse.nodes,
            unknowns: coarse.unknowns,
            fine_unknowns: problem.fine_size().unknowns,
            seconds: Stages { harmonic, intersections, tensors },
            worst_condition: Some(worst).filter(|worst| worst.is_finite()),
            averaged_cells: found.effective.averaged.clone(),
            least_filled: found.filled.iter().copied().fold(f64::INFINITY, f64::min),
        }
    }

    fn text(&self, output: &Path) -> String {
        let size = std::fs::metadata(output).map_or(0.0, |m| m.len() as f64);
        let row = |name: &str, value: String| (name.to_owned(), value);
        let rows = vec![
            row("method", self.method.into()),
            row("coarse model", format!("{} cells, {} unknowns", count(self.cells), count(self.unknowns))),
            row("fine model", format!("{} unknowns", count(self.fine_unknowns))),
            row("harmonic displacements", seconds(self.seconds.harmonic)),
            row("intersections", seconds(self.seconds.intersections)),
            row("tensors", seconds(self.seconds.tensors)),
            row("condition", self.worst_condition.map_or_else(|| "singular".into(), number) + " at worst"),
            row("least filled", format!("{:.1} % of a coarse cell", 100.0 * self.least_filled)),
        ];
        format!("{}\n{}\nwrote {} ({})", self.title, results::table(&rows), output.display(), bytes(size))
    }
}
