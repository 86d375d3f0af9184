//! Films of voxel bodies, coloured by material.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use grosgrain::fine::FineModel;
use grosgrain::io::write_atomically;
use grosgrain::mesh::{Label, Node};
use grosgrain_picture::{
    Animation, Camera, Category, Colouring, Image, Lines, Panel, PictureError, QuadSurface, Rgb, Strip, View,
    category_colour,
};
use rayon::prelude::*;

use super::reel::{Recorded, Reel, delay, note, time_labels};
use crate::body_surface::BodySurface;
use crate::failure::Failure;
use crate::picture::save;

/// Lines of the ground across the longer side of the bodies.
const GROUND_LINES: usize = 10;

/// How a film of bodies looks.
#[derive(Clone, Debug)]
pub struct FilmOptions {
    /// The view; `None` chooses a three-quarter view, z up.
    pub view: Option<View>,
    /// Height of a ground plane \[m\]; drawn as a faint grid.
    pub ground: Option<f64>,
    /// Name and colour of each label in the legend; others are called `label N`.
    pub materials: Vec<(Label, String, Option<Rgb>)>,
    /// Width of the strip in pixels.
    pub strip_width: usize,
    /// Width of the animation in pixels.
    pub animation_width: usize,
    /// The animation shows at most so many frames.
    pub most_frames: usize,
    /// How many times slower than in truth the animation plays.
    pub slowdown: f64,
    /// Small lines under the pictures.
    pub footer: Vec<String>,
}

impl Default for FilmOptions {
    fn default() -> Self {
        Self {
            view: None,
            ground: None,
            materials: Vec::new(),
            strip_width: 1800,
            animation_width: 900,
            most_frames: 90,
            slowdown: 1.0,
            footer: Vec::new(),
        }
    }
}

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
    title: String,
    options: FilmOptions,
    reel: Reel<Shape>,
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
    quads: Vec<[u32; 4]>,
    labels: Vec<Label>,
}

#[derive(Debug)]
struct Shape {
    skin: Arc<Skin>,
    positions: Vec<[f32; 3]>,
}

impl Film {
    /// A film without frames; `runs` are the labels of what stands side by side.
    pub fn new(title: &str, runs: &[&str], options: FilmOptions) -> Self {
        let last = runs.iter().map(|_| None).collect();
        Self { title: title.into(), options, reel: Reel::new(runs), last }
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
        self.reel.push(run, time, Shape { skin, positions });
    }

    /// Sets the line under the frame of a run that was recorded last, such as `error 12.3 %`.
    pub fn set_note(&mut self, run: usize, text: impl Into<String>) {
        if let Some(frame) = self.reel.last_mut(run) {
            frame.note = text.into();
        }
    }

    /// Writes the strip as PNG: a row per run, and at most `columns` times.
    ///
    /// # Errors
    /// No frames, positions that are not finite, a file that cannot be written.
    pub fn write_strip(&self, path: &Path, columns: usize) -> Result<PathBuf, Failure> {
        save(self.strip(columns), path)
    }

    /// Writes the animation as animated PNG: the runs side by side, closest to true speed.
    ///
    /// # Errors
    /// As [`Film::write_strip`].
    pub fn write_animation(&self, path: &Path) -> Result<PathBuf, Failure> {
        let failed = |error: PictureError| Failure::Failed(format!("{}: {error}", path.display()));
        let times = self.reel.times(self.options.most_frames);
        let frames = self.frames(&times).map_err(failed)?;
        let delay = (self.options.slowdown * delay(&times)).clamp(0.02, 1.0);
        let animation = Animation { frames: &frames, delay, hold: 1.0 };
        write_atomically(path, |writer| animation.write_apng(writer)).map_err(failed)?;
        Ok(path.into())
    }

    fn strip(&self, columns: usize) -> Result<Image, PictureError> {
        let times = self.reel.times(columns);
        let ground = self.ground();
        let legend = self.labels();
        let runs = 0..self.reel.runs.len();
        let panel = |run: usize, time: f64| Some(self.panel(self.reel.at(run, time)?, &legend, &ground));
        let strip = Strip {
            title: self.title.clone(),
            rows: self.reel.runs.clone(),
            columns: time_labels(&times),
            panels: runs.flat_map(|run| times.iter().map(move |t| panel(run, *t))).collect(),
            footer: self.options.footer.clone(),
            camera: Some(self.camera(&ground)?),
            width: self.options.strip_width,
            ..Strip::default()
        };
        strip.render()
    }

    fn frames(&self, times: &[f64]) -> Result<Vec<Image>, PictureError> {
        let (ground, legend) = (self.ground(), self.labels());
        let camera = self.camera(&ground)?;
        let labels = time_labels(times);
        let frame = |(time, label): (&f64, &String)| {
            let panel = |run: usize| Some(self.panel(self.reel.at(run, *time)?, &legend, &ground));
            let footer = [std::slice::from_ref(label), &self.options.footer].concat();
            let strip = Strip {
                title: self.title.clone(),
                rows: vec![String::new()],
                columns: self.reel.runs.clone(),
                panels: (0..self.reel.runs.len()).map(panel).collect(),
                footer,
                camera: Some(camera.clone()),
                width: self.options.animation_width,
                ..Strip::default()
            };
            strip.render()
        };
        times.par_iter().zip(&labels).map(frame).collect()
    }

    fn camera(&self, ground: &Lines) -> Result<Camera, PictureError> {
        let bodies = self.reel.iter().flat_map(|f| f.frame.positions.iter().map(|p| p.map(f64::from)));
        Camera::around(self.options.view, bodies.chain(ground.iter().flatten().copied()))
    }

    /// All labels that are ever seen.
    fn labels(&self) -> Vec<Label> {
        let mut labels: Vec<Label> = self.reel.iter().flat_map(|f| f.frame.skin.labels.iter().copied()).collect();
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    fn panel(&self, frame: &Recorded<Shape>, labels: &[Label], ground: &Lines) -> Panel {
        let Shape { skin, positions } = &frame.frame;
        let positions = positions.iter().map(|p| p.map(f64::from)).collect();
        let category = |label: &Label| labels.binary_search(label).unwrap_or_default() as u32;
        let legend: Vec<Category> = labels.iter().map(|label| self.category(*label)).collect();
        let colouring = match &legend[..] {
            // A legend of one name tells nothing.
            [only] => Colouring::Plain(only.colour.unwrap_or_else(|| category_colour(0))),
            _ => Colouring::Category { of_quad: skin.labels.iter().map(category).collect(), legend },
        };
        Panel {
            caption: note(Some(frame), self.reel.has_notes()),
            surface: QuadSurface { positions, quads: skin.quads.clone() },
            colouring,
            ghost: ground.clone(),
            ..Panel::default()
        }
    }

    fn category(&self, label: Label) -> Category {
        match self.options.materials.iter().find(|(known, _, _)| *known == label) {
            Some((_, name, colour)) => Category { name: name.clone(), colour: *colour },
            None => Category::named(format!("label {}", label.0)),
        }
    }

    /// A grid on the ground below all bodies, somewhat larger than they are.
    fn ground(&self) -> Lines {
        let Some(z) = self.options.ground else { return Lines::new() };
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in self.reel.iter().flat_map(|f| &f.frame.positions) {
            for a in 0..2 {
                (low[a], high[a]) = (low[a].min(p[a].into()), high[a].max(p[a].into()));
            }
        }
        let side = (0..2).map(|a| high[a] - low[a]).fold(0.0, f64::max) / GROUND_LINES as f64;
        if !(side > 0.0 && side.is_finite()) {
            return Lines::new();
        }
        let first = low.map(|x| (x / side).floor());
        let last = high.map(|x| (x / side).ceil());
        let mut lines = Lines::new();
        for a in 0..2 {
            let other = 1 - a;
            for i in 0..=(last[a] - first[a]) as usize {
                let end = |far: f64| {
                    let mut p = [0.0, 0.0, z];
                    (p[a], p[other]) = ((first[a] + i as f64) * side, far * side);
                    p
                };
                lines.push([end(first[other]), end(last[other])]);
            }
        }
        lines
    }
}

impl Skin {
    fn new(model: &FineModel) -> Self {
        let surface = BodySurface::new(model.grid(), &model.grid().void);
        let quads = surface.faces.iter().map(|face| face.corners.map(|node| surface.vertex(node) as u32)).collect();
        let labels = surface.faces.iter().map(|face| model.grid().labels[face.cell.0]).collect();
        Self { quads, labels, nodes: surface.nodes }
    }
}
