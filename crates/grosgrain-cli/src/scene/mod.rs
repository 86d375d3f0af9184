//! Scene files: TOML in, a checked [`Scene`] or a list of problems out.
//!
//! The text is walked with its spans rather than deserialised, so that every problem of a scene is found at
//! once and each names its full key and its line.

mod body;
mod coarsening;
mod conditions;
mod consistency;
mod document;
mod edits;
mod labels;
mod material_file;
mod materials;
mod mesh_body;
mod motion;
mod output;
mod pattern;
mod problem;
mod run_kind;
mod section;
mod selector;
mod span;
mod surroundings;
mod time;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::de::DeTable;

pub use body::{Body, Keep, Source, VoxelModulus};
pub use coarsening::{Coarsening, Training};
pub use conditions::{Fix, Load, LoadKind, Spring};
pub use edits::{Repeat, SceneChange, SceneEdit, When};
pub use labels::Labelling;
pub use material_file::read_material_file;
pub use materials::{Constants, SceneMaterial};
pub use mesh_body::{CoarseMeshSource, MeshCoarsening, MeshSource};
pub use motion::{SceneMotion, SceneTwist};
pub use output::Output;
pub use pattern::{Filling, Grid};
pub use problem::{Problem, SceneError};
pub use section::{alternatives, enumeration, nearest};
pub use span::Span;
pub use surroundings::{Ground, Start};
pub use time::{Mode, Time};

use document::{Document, Item, Reading};
use section::Section;

/// A scene that passed every check that needs no volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The file it was read from.
    pub file: PathBuf,
    /// Its title; the file's name where it has none.
    pub title: String,
    /// The body.
    pub body: Body,
    /// The materials, by name.
    pub materials: Vec<SceneMaterial>,
    /// How a voxel body is coarsened; the default where the body is a mesh.
    pub coarsening: Coarsening,
    /// How a body is coarsened that is a mesh.
    pub mesh_coarsening: MeshCoarsening,
    /// What holds the body.
    pub fixes: Vec<Fix>,
    /// What loads it.
    pub loads: Vec<Load>,
    /// What changes during the run.
    pub edits: Vec<SceneEdit>,
    /// The kind of run and its steps.
    pub time: Time,
    /// How the body moves at time zero.
    pub start: Start,
    /// The ground that it may land on.
    pub contact: Option<Ground>,
    /// What a run writes.
    pub output: Output,
    /// The line of every key, so that what only the files show can name its place.
    pub lines: BTreeMap<String, usize>,
    /// Sentences for the user about what is accepted but not as it may seem.
    pub warnings: Vec<String>,
}

const KEYS: &[&str] =
    &["title", "body", "materials", "coarsening", "time", "start", "fix", "load", "edit", "contact", "output"];

/// Reads and checks the scene in `file`.
///
/// # Errors
/// A file that cannot be read; every problem of one that can, each with its key, its line and what is expected.
pub fn read_scene(file: &Path) -> Result<Scene, SceneError> {
    read_document(file, |document, table| read_root(document, table, file))
}

/// Reads a TOML file and collects what `read` notes.
fn read_document<T>(
    file: &Path,
    read: impl for<'s> FnOnce(&'s Document<'s>, &'s toml::Spanned<DeTable<'s>>) -> Reading<T>,
) -> Result<T, SceneError> {
    let text =
        std::fs::read_to_string(file).map_err(|reason| SceneError::Unreadable { file: file.to_path_buf(), reason })?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let document = Document::new(&text, folder);
    let table = match DeTable::parse(&text) {
        Ok(table) => table,
        Err(error) => {
            let at = error.span().unwrap_or(0..0);
            let near = text.get(at.clone()).filter(|near| !near.trim().is_empty() && !near.contains('\n'));
            let near = near.map_or_else(String::new, |near| format!(" at {near:?}"));
            document.note(at, format!("this is not TOML: {}{near}", error.message().replace('\n', "; ")));
            return Err(SceneError::Unusable { file: file.to_path_buf(), problems: document.into_problems() });
        }
    };
    let reading = read(&document, &table);
    let problems = document.into_problems();
    match reading {
        Ok(value) if problems.is_empty() => Ok(value),
        _ => Err(SceneError::Unusable { file: file.to_path_buf(), problems }),
    }
}

fn read_root<'s>(document: &'s Document<'s>, table: &'s toml::Spanned<DeTable<'s>>, file: &Path) -> Reading<Scene> {
    let root = Section::new(document, String::new(), 0..0, table.get_ref()).limited_to(KEYS);
    let title = root.optional("title", |title| title.text());
    let body = root.required("body", "the table [body] with volume, grid and pattern, or mesh", |body| {
        body::read_body(body, time::is_dynamic(&root))
    });
    let materials = read_materials(&root);
    let coarsenings = read_coarsenings(&root);
    let time = root.optional("time", time::read_time);
    let fixes = root.optional("fix", conditions::read_fixes);
    let loads = root.optional("load", conditions::read_loads);
    let edits = root.optional("edit", edits::read_edits);
    let start = root.optional("start", surroundings::read_start);
    let contact = root.optional("contact", surroundings::read_contact);
    let output = root.optional("output", output::read_output);
    let title = title?.map_or_else(|| stem(file), String::from);
    let (coarsening, mesh_coarsening) = coarsenings?;
    let mut scene = Scene {
        file: file.to_path_buf(),
        title,
        body: body?,
        materials: materials?,
        coarsening,
        mesh_coarsening,
        fixes: fixes?.unwrap_or_default(),
        loads: loads?.unwrap_or_default(),
        edits: edits?.unwrap_or_default(),
        time: time?.unwrap_or_default(),
        start: start?.unwrap_or_default(),
        contact: contact?,
        output: output?.unwrap_or_default(),
        lines: root.entries().iter().flat_map(|(_, item)| item.lines()).collect(),
        warnings: Vec::new(),
    };
    consistency::check(&root, &scene)?;
    scene.warnings = consistency::warnings(&scene);
    Ok(scene)
}

/// `[coarsening]` of voxels, or of a mesh, which may do without.
fn read_coarsenings(root: &Section) -> Reading<(Coarsening, MeshCoarsening)> {
    match mesh_body::is_mesh(root) {
        true => {
            let mesh_coarsening = root.optional("coarsening", coarsening::read_coarsening_of_mesh)?;
            Ok((Coarsening::default(), mesh_coarsening.unwrap_or_default()))
        }
        false => {
            let expected = "the table [coarsening] with degree";
            let coarsening = root.required("coarsening", expected, coarsening::read_coarsening)?;
            Ok((coarsening, MeshCoarsening::default()))
        }
    }
}

/// Materials may be left out only where the body's modulus law stands in for them.
fn read_materials(root: &Section) -> Reading<Vec<SceneMaterial>> {
    let body = root.get("body");
    let has = |name| body.as_ref().is_some_and(|body: &Item| body.child(name).is_some());
    let read = |item: &Item| materials::read_materials(item, has("young") || has("modulus"));
    match has("modulus") {
        true => root.optional("materials", read).map(Option::unwrap_or_default),
        false => root.required("materials", "one table [materials.NAME] for each label of the body", read),
    }
}

fn stem(file: &Path) -> String {
    file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

impl Scene {
    /// What makes the scene unusable at `key`, with the line of the key or of the nearest table around it.
    pub fn unusable(&self, key: &str, sentence: impl std::fmt::Display) -> SceneError {
        let ends = key.char_indices().filter(|(_, c)| ['.', '['].contains(c)).map(|(at, _)| at);
        let around = std::iter::once(key).chain(ends.collect::<Vec<_>>().into_iter().rev().map(|at| &key[..at]));
        let line = around.filter_map(|key| self.lines.get(key)).next().copied().unwrap_or(1);
        let problems = vec![Problem { line, sentence: format!("{key}: {sentence}") }];
        SceneError::Unusable { file: self.file.clone(), problems }
    }
}
