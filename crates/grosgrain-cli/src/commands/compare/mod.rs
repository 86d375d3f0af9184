//! `compare`: the fine model and coarse models of the same scene, side by side.

mod meshes;
mod moving;

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use crate::failure::Failure;
use crate::interruption;
use crate::method::{AskedMethod, Method};
use crate::outcome::{FineRun, run_coarse, run_fine, warn_of_softness};
use crate::output::OutputFolder;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::quantities::{count, number, seconds};
use crate::results;
use crate::scene::read_scene;

const EXAMPLES: &str = "Examples:
  grosgrain compare scenes/beam-oblique.toml
  grosgrain compare scenes/beam-along.toml --methods trilinear,one-ring,global --json errors.json";

/// Arguments of `compare`.
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The scene, a TOML file
    scene: PathBuf,
    /// The methods, with commas between them: fine, trilinear, average, global, one-ring, single-cell, substructured, for a mesh
    /// fine, tensor, average, trilinear, sampled; all without it
    #[arg(long, value_delimiter = ',', value_name = "A,B")]
    methods: Vec<AskedMethod>,
    /// Write the table as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// One method's row.
#[derive(Clone, Debug, Serialize)]
struct Row {
    method: String,
    unknowns: usize,
    error_percent: f64,
    energy_ratio: f64,
    build_seconds: f64,
    solve_seconds: f64,
}

/// Runs every method and prints the table.
pub fn run(arguments: &Arguments, progress: &Progress) -> Result<(), Failure> {
    let scene = read_scene(&arguments.scene)?;
    if scene.is_mesh() {
        return meshes::run(scene, &arguments.methods, arguments.json.as_deref(), progress);
    }
    let problem = Problem::new(scene, progress)?;
    problem.require_support()?;
    let methods: Vec<Method> = match arguments.methods.is_empty() {
        // The method auto is one of the others.
        true => Method::ALL.iter().map(|(_, method)| *method).filter(|method| *method != Method::Auto).collect(),
        false => arguments.methods.iter().map(AskedMethod::for_voxels).collect::<Result<_, _>>()?,
    };
    if !problem.scene.is_linear_static() {
        return moving::run(problem, &methods, arguments.json.as_deref(), progress);
    }
    problem.tell_idle_edits(progress);
    let _folder = arguments.json.as_deref().map(OutputFolder::around).transpose()?;
    progress.say("solving the fine model");
    let fine = run_fine(&problem, progress)?;
    let mut rows = Vec::new();
    for method in methods {
        interruption::check()?;
        rows.push(row(&problem, method, &fine, progress)?);
    }
    if let Some(json) = &arguments.json {
        results::write_json(json, &rows)?;
    }
    let report = &fine.solution.report;
    let solver = format!("fine model solved by {}: {}", report.kind, report.reason);
    results::print(&format!("{}\n{}\n{solver}", problem.scene.title, table(&rows)))?;
    rows.iter().for_each(|row| warn_of_softness(&row.method, row.energy_ratio, progress));
    Ok(())
}

fn row(problem: &Problem, method: Method, fine: &FineRun, progress: &Progress) -> Result<Row, Failure> {
    if method == Method::Fine {
        return Ok(Row {
            method: method.name().into(),
            unknowns: problem.fine_size().unknowns,
            error_percent: 0.0,
            energy_ratio: 1.0,
            build_seconds: 0.0,
            solve_seconds: fine.seconds,
        });
    }
    progress.say(&format!("building the coarse model: {method}"));
    let coarse = run_coarse(problem, method, progress)?;
    let error = coarse.error(fine);
    Ok(Row {
        method: method.name().into(),
        unknowns: coarse.size().unknowns,
        error_percent: error.rms_percent,
        energy_ratio: error.energy_ratio,
        build_seconds: coarse.build_seconds(),
        solve_seconds: coarse.seconds.get("solve").copied().unwrap_or_default(),
    })
}

fn table(rows: &[Row]) -> String {
    let heading = ["method", "unknowns", "error", "energy ratio", "build", "solve"].map(String::from);
    let cells = rows.iter().map(|row| {
        [
            row.method.clone(),
            count(row.unknowns),
            format!("{:.2} %", row.error_percent),
            number(row.energy_ratio),
            if row.build_seconds > 0.0 { seconds(row.build_seconds) } else { "–".into() },
            seconds(row.solve_seconds),
        ]
    });
    results::columns(&std::iter::once(heading).chain(cells).collect::<Vec<_>>())
}
