//! `coarsen`: the coarse model of a scene's body.

mod meshes;

use std::path::{Path, PathBuf};

use clap::Args;
use grosgrain::coarse::Built;
use grosgrain::io::write_model;
use serde::Serialize;

use crate::body::loose_from_largest;
use crate::failure::Failure;
use crate::interruption;
use crate::method::{AskedMethod, Method};
use crate::outcome::build_coarse;
use crate::output::OutputFolder;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::quantities::{bytes, count, number, seconds};
use crate::results;
use crate::scene::read_scene;

const EXAMPLES: &str = "Examples:
  grosgrain coarsen scenes/beam-oblique.toml
  grosgrain coarsen scenes/torso.toml -o torso.npz --method global --json torso.json";

/// A fit whose data constraints are worse conditioned than this is told.
const DOUBTFUL_CONDITION: f64 = 1e6;

/// Arguments of `coarsen`.
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The scene, a TOML file
    scene: PathBuf,
    /// Where the model is written; without it the scene's name with .npz, in the current folder
    #[arg(short, long, value_name = "MODEL.npz")]
    output: Option<PathBuf>,
    /// trilinear, average, global, one-ring, single-cell, substructured or auto; without it the scene's training. For a mesh tensor
    #[arg(long)]
    method: Option<AskedMethod>,
    /// Write the figures as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// The figures of a coarsening.
#[derive(Debug, Serialize)]
struct Figures {
    title: String,
    method: String,
    degree: usize,
    cells: usize,
    nodes: usize,
    unknowns: usize,
    fine_unknowns: usize,
    seconds: Stages,
    seconds_per_cell: Stages,
    worst_condition: Option<f64>,
    rank_deficient_cells: usize,
}

#[derive(Debug, Serialize)]
struct Stages {
    training: f64,
    fitting: f64,
    assembly: f64,
}

/// Trains, fits and writes the coarse model.
pub fn run(arguments: &Arguments, progress: &Progress) -> Result<(), Failure> {
    let output = arguments.output.clone().unwrap_or_else(|| default_output(&arguments.scene));
    let scene = read_scene(&arguments.scene)?;
    if scene.is_mesh() {
        return meshes::run(scene, arguments.method.as_ref(), &output, arguments.json.as_deref(), progress);
    }
    let problem = Problem::new(scene, progress)?;
    if let Some(sentence) = loose_from_largest(problem.model.grid()) {
        progress.warn(&sentence);
    }
    let method = problem.method(arguments.method.as_ref())?;
    problem.tell_idle_edits(progress);
    let _folders = (OutputFolder::around(&output)?, arguments.json.as_deref().map(OutputFolder::around).transpose()?);
    let built = build_coarse(&problem, method, progress)?;
    let figures = Figures::new(&problem, method, &built);
    if let Some(condition) = figures.worst_condition.filter(|c| *c > DOUBTFUL_CONDITION) {
        progress.warn(&format!(
            "the training data of a coarse cell are nearly dependent (condition {condition:.0e}); its shape functions may be large"
        ));
    }
    interruption::check()?;
    write_model(&output, &problem.model, &built.model, built.training.as_ref())
        .map_err(|error| Failure::Failed(format!("{}: {error}", output.display())))?;
    if let Some(json) = &arguments.json {
        results::write_json(json, &figures)?;
    }
    results::print(&figures.text(&output))
}

fn default_output(scene: &Path) -> PathBuf {
    PathBuf::from(scene.file_stem().unwrap_or_default()).with_extension("npz")
}

impl Figures {
    fn new(problem: &Problem, method: Method, built: &Built) -> Self {
        let (cells, nodes) = (built.model.elements().len(), built.model.mesh().vertices().len());
        let report = &built.report;
        let stages = |scale: f64| Stages {
            training: report.training_seconds * scale,
            fitting: report.fitting_seconds * scale,
            assembly: report.assembly_seconds * scale,
        };
        Self {
            title: problem.scene.title.clone(),
            method: method.name().into(),
            degree: problem.scene.coarsening.degree,
            cells,
            nodes,
            unknowns: 3 * nodes,
            fine_unknowns: problem.fine_size().unknowns,
            seconds: stages(1.0),
            seconds_per_cell: stages(1.0 / cells as f64),
            worst_condition: report.worst_condition.map(|(_, condition)| condition).filter(|c| c.is_finite()),
            rank_deficient_cells: report.rank_deficient.len(),
        }
    }

    fn text(&self, output: &Path) -> String {
        let size = std::fs::metadata(output).map_or(0.0, |m| m.len() as f64);
        let time = |stage: &str, total: f64, cell: f64| {
            (stage.to_owned(), format!("{}, {} per cell", seconds(total), seconds(cell)))
        };
        let row = |name: &str, value: String| (name.to_owned(), value);
        let mut rows = vec![
            row("method", format!("{}, degree {}", self.method, self.degree)),
            row("coarse model", format!("{} cells, {} unknowns", count(self.cells), count(self.unknowns))),
            row("fine model", format!("{} unknowns", count(self.fine_unknowns))),
            time("training", self.seconds.training, self.seconds_per_cell.training),
            time("fitting", self.seconds.fitting, self.seconds_per_cell.fitting),
            time("assembly", self.seconds.assembly, self.seconds_per_cell.assembly),
        ];
        if let Some(condition) = self.worst_condition {
            rows.push(row("condition", format!("{} at worst", number(condition))));
        }
        format!("{}\n{}\nwrote {} ({})", self.title, results::table(&rows), output.display(), bytes(size))
    }
}
