//! The frames of a film of surfaces, and its pictures: a strip and an animation.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use grosgrain::io::write_atomically;
use grosgrain::mesh::Label;
use grosgrain_picture::{
    Animation, Camera, Category, Colouring, Image, Lines, Panel, PictureError, QuadSurface, Rgb, Strip, View,
    category_colour,
};
use rayon::prelude::*;

use super::reel::{Recorded, Reel, delay, note, time_labels};
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

/// What is seen of a body at a time. Frames share what does not move.
#[derive(Debug)]
pub struct Shape {
    /// Vertices of each face.
    pub quads: Arc<Vec<[u32; 4]>>,
    /// Label of each face.
    pub labels: Arc<Vec<Label>>,
    /// Places \[m\] of the vertices.
    pub positions: Vec<[f32; 3]>,
    /// A surface whose edges are drawn over the body.
    pub wires: Option<Wires>,
}

/// A surface of which the edges are seen.
#[derive(Debug)]
pub struct Wires {
    /// Vertices of each face.
    pub quads: Arc<Vec<[u32; 4]>>,
    /// Places \[m\] of the vertices.
    pub positions: Vec<[f32; 3]>,
}

/// Films keep surfaces only, in single precision.
#[derive(Debug)]
pub struct Footage {
    title: String,
    pub options: FilmOptions,
    reel: Reel<Shape>,
    /// What a label is called in the legend where it has no name.
    unnamed: &'static str,
    /// All labels of the bodies, seen or not, ascending, where they have colours of their own.
    known: Vec<Label>,
}

impl Footage {
    pub fn new(title: &str, runs: &[&str], options: FilmOptions, unnamed: &'static str) -> Self {
        Self { title: title.into(), options, reel: Reel::new(runs), unnamed, known: Vec::new() }
    }

    /// Gives labels the colours that stills of a body with all of them have, whichever of them are seen.
    pub fn know(&mut self, labels: &[Label]) {
        if !labels.iter().all(|label| self.known.binary_search(label).is_ok()) {
            self.known.extend_from_slice(labels);
            self.known.sort_unstable();
            self.known.dedup();
        }
    }

    pub fn push(&mut self, run: usize, time: f64, shape: Shape) {
        self.reel.push(run, time, shape);
    }

    pub fn set_note(&mut self, run: usize, text: String) {
        if let Some(frame) = self.reel.last_mut(run) {
            frame.note = text;
        }
    }

    pub fn write_strip(&self, path: &Path, columns: usize) -> Result<PathBuf, Failure> {
        save(self.strip(columns), path)
    }

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
        let bodies = self.reel.iter().flat_map(|f| f.frame.points().map(|p| p.map(f64::from)));
        Camera::around(self.options.view, bodies.chain(ground.iter().flatten().copied()))
    }

    /// All labels that are ever seen.
    fn labels(&self) -> Vec<Label> {
        let mut labels: Vec<Label> = self.reel.iter().flat_map(|f| f.frame.labels.iter().copied()).collect();
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    fn panel(&self, frame: &Recorded<Shape>, labels: &[Label], ground: &Lines) -> Panel {
        let shape = &frame.frame;
        let category = |label: &Label| labels.binary_search(label).unwrap_or_default() as u32;
        let legend: Vec<Category> = labels.iter().map(|label| self.category(*label)).collect();
        let colouring = match &legend[..] {
            // A legend of one name tells nothing.
            [only] => Colouring::Plain(only.colour.unwrap_or_else(|| category_colour(0))),
            _ => Colouring::Category { of_quad: shape.labels.iter().map(category).collect(), legend },
        };
        Panel {
            caption: note(Some(frame), self.reel.has_notes()),
            surface: surface(&shape.quads, &shape.positions),
            colouring,
            wires: shape.wires.as_ref().map(|wires| surface(&wires.quads, &wires.positions)).unwrap_or_default(),
            ghost: ground.clone(),
            ..Panel::default()
        }
    }

    fn category(&self, label: Label) -> Category {
        let own = self.known.binary_search(&label).ok().map(category_colour);
        match self.options.materials.iter().find(|(known, _, _)| *known == label) {
            Some((_, name, colour)) => Category { name: name.clone(), colour: colour.or(own) },
            None => Category { name: format!("{} {}", self.unnamed, label.0), colour: own },
        }
    }

    /// A grid on the ground below all bodies, somewhat larger than they are.
    fn ground(&self) -> Lines {
        let Some(z) = self.options.ground else { return Lines::new() };
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in self.reel.iter().flat_map(|f| f.frame.points()) {
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

impl Shape {
    /// All that must be in the picture.
    fn points(&self) -> impl Iterator<Item = &[f32; 3]> + Clone {
        self.positions.iter().chain(self.wires.iter().flat_map(|wires| &wires.positions))
    }
}

fn surface(quads: &[[u32; 4]], positions: &[[f32; 3]]) -> QuadSurface {
    QuadSurface { positions: positions.iter().map(|p| p.map(f64::from)).collect(), quads: quads.to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_has_its_colour_whichever_others_are_seen() {
        let mut footage = Footage::new("", &["fine"], FilmOptions::default(), "tag");
        let tags = [3, 5, 9].map(Label);
        footage.know(&tags);
        footage.know(&tags[1..]);
        let shape = |labels: &[Label]| Shape {
            quads: Arc::new(vec![[0, 1, 2, 2]; labels.len()]),
            labels: Arc::new(labels.to_vec()),
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            wires: None,
        };
        let colouring = |footage: &Footage| {
            let seen = footage.labels();
            footage.panel(footage.reel.at(0, 0.0).unwrap(), &seen, &Lines::new()).colouring
        };
        footage.push(0, 0.0, shape(&tags[1..2]));
        assert_eq!(colouring(&footage), Colouring::Plain(category_colour(1)));
        footage.push(0, 1.0, shape(&tags[1..]));
        let Colouring::Category { legend, .. } = colouring(&footage) else { unreachable!("two tags are seen") };
        assert_eq!(legend.iter().map(|c| c.colour).collect::<Vec<_>>(), [1, 2].map(|n| Some(category_colour(n))));
        assert_eq!(legend[1].name, "tag 9");
    }
}
