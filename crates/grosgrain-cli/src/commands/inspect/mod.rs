//! `inspect`: what volumes, meshes, scenes and models hold.

pub(super) mod mesh;
mod mesh_scene;
mod model;
mod scene;
mod volume;

use std::path::{Path, PathBuf};

use clap::Args;
use grosgrain::io::MeshFormat;
use serde::Serialize;

use crate::failure::Failure;
use crate::interruption;
use crate::progress::Progress;
use crate::results;
use crate::scene::{Scene, read_scene};

const EXAMPLES: &str = "Examples:
  grosgrain inspect data/ct_torso/example_ct.nii.gz
  grosgrain inspect --json scenes/torso.toml data/meshes/bimetal.msh";

/// Arguments of `inspect`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Volumes, meshes (.msh, .mesh, .node, .vtu, .vtk, .inp), scenes (.toml) or models (.npz)
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Write a list of JSON objects to stdout, one for each file
    #[arg(long)]
    json: bool,
}

/// What a file holds.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Contents {
    Volume(volume::VolumeSummary),
    Mesh(mesh::MeshSummary),
    Scene(Box<scene::SceneSummary>),
    #[serde(rename = "scene")]
    MeshScene(Box<mesh_scene::MeshSceneSummary>),
    Model(model::ModelSummary),
}

#[derive(Serialize)]
struct Entry {
    file: PathBuf,
    #[serde(flatten)]
    contents: Contents,
}

/// Inspects every file; what cannot be read is told at the end.
pub fn run(arguments: &Arguments, progress: &Progress) -> Result<(), Failure> {
    let mut entries = Vec::new();
    let mut failures = Vec::new();
    for file in &arguments.files {
        interruption::check()?;
        match inspect(file, progress) {
            Ok(contents) if arguments.json => entries.push(Entry { file: file.clone(), contents }),
            Ok(contents) => results::print(&format!("{}\n{}", file.display(), results::table(&contents.rows())))?,
            Err(failure) => failures.push(failure),
        }
    }
    if arguments.json {
        results::print_json(&entries)?;
    }
    joined(failures)
}

fn inspect(file: &Path, progress: &Progress) -> Result<Contents, Failure> {
    if !file.exists() {
        return Err(Failure::Unusable(format!(
            "{} does not exist; expected a volume, a mesh, a scene or a model",
            file.display()
        )));
    }
    let extension = file.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase());
    match extension.as_str() {
        "toml" => inspect_scene(read_scene(file)?, progress),
        "npz" => model::summarise(file).map(Contents::Model),
        _ if MeshFormat::of_name(file).is_some() => mesh::summarise(file).map(Contents::Mesh),
        _ => volume::summarise(file).map(Contents::Volume),
    }
}

fn inspect_scene(scene: Scene, progress: &Progress) -> Result<Contents, Failure> {
    match scene.is_mesh() {
        true => mesh_scene::summarise(scene, progress).map(|summary| Contents::MeshScene(Box::new(summary))),
        false => scene::summarise(&scene, progress).map(|summary| Contents::Scene(Box::new(summary))),
    }
}

impl Contents {
    fn rows(&self) -> Vec<(String, String)> {
        match self {
            Self::Volume(summary) => summary.rows(),
            Self::Mesh(summary) => summary.rows(),
            Self::Scene(summary) => summary.rows(),
            Self::MeshScene(summary) => summary.rows(),
            Self::Model(summary) => summary.rows(),
        }
    }
}

/// One failure with all sentences: a failed run if any is one, unusable input otherwise.
fn joined(failures: Vec<Failure>) -> Result<(), Failure> {
    if failures.is_empty() {
        return Ok(());
    }
    let sentences: Vec<String> = failures.iter().map(Failure::to_string).collect();
    match failures.iter().any(|failure| matches!(failure, Failure::Failed(_))) {
        true => Err(Failure::Failed(sentences.join("\n"))),
        false => Err(Failure::Unusable(sentences.join("\n"))),
    }
}

/// A row of the table.
fn row(name: &str, value: impl Into<String>) -> (String, String) {
    (name.into(), value.into())
}
