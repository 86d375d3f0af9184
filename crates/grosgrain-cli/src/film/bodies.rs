//! Films of voxel bodies, coloured by material.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use grosgrain::fine::FineModel;
use grosgrain::mesh::{Label, Node};

use super::footage::{FilmOptions, Footage, Shape};
use crate::body_surface::BodySurface;
use crate::failure::Failure;

/// A film of one or more runs of a voxel body.
///
/// It keeps the surface only, in single precision: 12 bytes per surface node and frame.
///
/// ```
/// use grosgrain::fine::FineModel;
/// use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
/// use grosgrain::mesh::{Label, VoxelGrid};
/// use grosgrain_cli::film::{Film, FilmOptions};
/// let grid = VoxelGrid::uniform([4, 2, 2], [0.01; 3], Label(1));
/// let mut table = MaterialTable::new();
/// table.insert(Label(1), Material::linear("gel", Elasticity::Isotropic(IsotropicMaterial::new(1e6, 0.3)?), 1000.0));
/// let model = FineModel::new(grid, &table)?;
/// let still = vec![0.0; 3 * model.grid().lattice.node_count()];
/// let mut film = Film::new("A block", &["fine"], FilmOptions::default());
/// film.record(0, 0.0, &model, &still);
/// film.record(0, 0.1, &model, &still.iter().map(|_| 0.002).collect::<Vec<_>>());
/// film.set_note(0, "error 12.3 %");
/// # let folder = tempfile::tempdir()?;
/// # let folder = folder.path();
/// film.write_strip(&folder.join("film.png"), 5)?;
/// film.write_animation(&folder.join("film-animated.png"))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Film {
    footage: Footage,
    /// The body that each run had last, and its surface.
    last: Vec<Option<(Solid, Arc<Skin>)>>,
}

/// Which cells are solid, and their labels.
#[derive(Debug, PartialEq)]
struct Solid {
    void: Vec<bool>,
    labels: Vec<Label>,
}

/// The part of a surface that frames share until the body is cut.
#[derive(Debug)]
struct Skin {
    nodes: Vec<Node>,
    quads: Arc<Vec<[u32; 4]>>,
    labels: Arc<Vec<Label>>,
}

impl Film {
    /// A film without frames; `runs` are the labels of what stands side by side.
    pub fn new(title: &str, runs: &[&str], options: FilmOptions) -> Self {
        let last = runs.iter().map(|_| None).collect();
        Self { footage: Footage::new(title, runs, options, "label"), last }
    }

    /// Adds what a run looks like at a time \[s\]: the solid cells of the model, displaced (3 entries per lattice node \[m\]).
    ///
    /// The model may have other cells than before, as after a cut.
    ///
    /// # Panics
    /// `run` is not one of the film's, or `displacement` has another length.
    pub fn record(&mut self, run: usize, time: f64, model: &FineModel, displacement: &[f64]) {
        let grid = model.grid();
        assert_eq!(displacement.len(), 3 * grid.lattice.node_count(), "three displacements per lattice node");
        let unchanged = |(solid, _): &&(Solid, Arc<Skin>)| solid.void == grid.void && solid.labels == grid.labels;
        let known = self.last[run].as_ref().filter(unchanged).map(|(_, skin)| Arc::clone(skin));
        let skin = known.unwrap_or_else(|| {
            let skin = Arc::new(Skin::new(model));
            let solid = Solid { void: grid.void.clone(), labels: grid.labels.clone() };
            self.last[run] = Some((solid, Arc::clone(&skin)));
            skin
        });
        let place = |node: &Node| {
            let x = model.node_position(*node);
            [0, 1, 2].map(|r| (x[r] + displacement[3 * node.0 + r]) as f32)
        };
        let positions = skin.nodes.iter().map(place).collect();
        let (quads, labels) = (Arc::clone(&skin.quads), Arc::clone(&skin.labels));
        self.footage.push(run, time, Shape { quads, labels, positions, wires: None });
    }

    /// Sets the line under the frame of a run that was recorded last, such as `error 12.3 %`.
    pub fn set_note(&mut self, run: usize, text: impl Into<String>) {
        self.footage.set_note(run, text.into());
    }

    /// Writes the strip as PNG: a row per run, and at most `columns` times.
    ///
    /// # Errors
    /// No frames, positions that are not finite, a file that cannot be written.
    pub fn write_strip(&self, path: &Path, columns: usize) -> Result<PathBuf, Failure> {
        self.footage.write_strip(path, columns)
    }

    /// Writes the animation as animated PNG: the runs side by side, closest to true speed.
    ///
    /// # Errors
    /// As [`Film::write_strip`].
    pub fn write_animation(&self, path: &Path) -> Result<PathBuf, Failure> {
        self.footage.write_animation(path)
    }
}

impl Skin {
    fn new(model: &FineModel) -> Self {
        let surface = BodySurface::new(model.grid(), &model.grid().void);
        let quads = surface.faces.iter().map(|face| face.corners.map(|node| surface.vertex(node) as u32)).collect();
        let labels = surface.faces.iter().map(|face| model.grid().labels[face.cell.0]).collect();
        Self { quads: Arc::new(quads), labels: Arc::new(labels), nodes: surface.nodes }
    }
}
