//! Strips, animations and charts of falling bodies.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use grosgrain::mesh::Label;
use grosgrain_picture::{Axis, Chart, Rgb, Series, View};

use super::Model;
use super::course::{Course, Seen};
use super::pair::{Fall, Pair};
use crate::commands::simulate::keep_or_warn;
use crate::failure::Failure;
use crate::film::{FilmOptions, SimplexFilm};
use crate::meshes::{MeshCut, Posed, SimplexSkin};
use crate::picture::save;
use crate::progress::Progress;

/// Frames in a strip.
const COLUMNS: usize = 5;
/// Seconds that an animation takes.
const LENGTH: f64 = 4.0;

/// How a figure looks.
#[derive(Clone, Copy)]
pub struct Look {
    /// Of the artefact.
    pub name: &'static str,
    pub title: &'static str,
    /// Name and colour of each tag.
    pub materials: &'static [(i32, &'static str, Rgb)],
    pub view: Option<View>,
    /// Directions in which sections look away, with the tags that they spare.
    pub sections: &'static [([f64; 3], &'static [i32], &'static str)],
    /// Whether the edges of the fine mesh are drawn.
    pub edges: bool,
}

impl Look {
    /// Names and colours of tags as pictures take them.
    pub fn legend(&self) -> Vec<(Label, String, Option<Rgb>)> {
        self.materials.iter().map(|(tag, name, colour)| (Label(*tag), (*name).into(), Some(*colour))).collect()
    }

    /// A section looking along one of the directions, through the middle of what it spares, or of the body.
    pub fn section(&self, pair: &Pair, number: usize) -> MeshCut {
        let (away, spared, _) = self.sections[number];
        let mesh = pair.fine.mesh();
        let counts = |cell: &usize| spared.is_empty() || spared.contains(&mesh.tags()[*cell]);
        let cells = || (0..mesh.cell_count()).filter(counts);
        let volume: f64 = cells().map(|cell| mesh.measure(cell)).sum();
        let middle = |r: usize| cells().map(|cell| mesh.measure(cell) * mesh.centre(cell)[r]).sum::<f64>() / volume;
        MeshCut { through: [0, 1, 2].map(middle), away, spared: spared.iter().map(|tag| Label(*tag)).collect() }
    }
}

/// Keeps what a film shows: the body cut open as the fine and as the coarse mesh move it.
pub struct Recorder {
    film: SimplexFilm,
    body: Arc<SimplexSkin>,
    wires: Arc<SimplexSkin>,
    look: Look,
}

impl Recorder {
    /// A film without frames.
    pub fn new(pair: &Pair, fall: &Fall, look: Look) -> Result<Self, Failure> {
        let cut = look.section(pair, 0);
        let options = FilmOptions {
            view: look.view,
            ground: Some(pair.ground(fall)),
            materials: look.legend(),
            slowdown: LENGTH / (fall.step * fall.steps as f64),
            footer: vec![
                "Cut open. Coarse: the body of the fine mesh, carried by the coarse one, whose edges are drawn.".into(),
            ],
            ..FilmOptions::default()
        };
        let runs = ["fine", "coarse"];
        Ok(Self {
            film: SimplexFilm::new(look.title, &runs, options),
            body: Arc::new(SimplexSkin::new(pair.fine.mesh(), Some(&cut))?),
            wires: Arc::new(SimplexSkin::new(pair.coarse_mesh(), Some(&cut))?),
            look,
        })
    }

    /// Adds a moment.
    pub fn add(&mut self, seen: &Seen<'_>) {
        let [fine, tensor] = [&seen.displacements[0], &seen.displacements[1]];
        self.film.record(0, seen.time, Posed { skin: &self.body, displacement: fine }, None);
        let wires = Posed { skin: &self.wires, displacement: seen.coarse };
        self.film.record(1, seen.time, Posed { skin: &self.body, displacement: tensor }, Some(wires));
        if seen.number > 0 {
            self.film.set_note(1, format!("error {:.1} %", seen.errors[0]));
        }
    }

    /// Writes strip, animation and chart; those that cannot be made are told as warnings.
    pub fn write(self, course: &Course, folder: &Path, progress: &Progress) -> Vec<PathBuf> {
        let file = |ending: &str| folder.join(format!("{}{ending}.png", self.look.name));
        progress.say("drawing the film");
        let mut written = Vec::new();
        written.extend(keep_or_warn(self.film.write_strip(&file(""), COLUMNS), progress));
        written.extend(keep_or_warn(self.film.write_animation(&file("-animated")), progress));
        written.extend(keep_or_warn(error_chart(&self.look, course, &file("-error")), progress).flatten());
        written
    }
}

/// The errors of the coarse models over time; none for fewer than two steps.
fn error_chart(look: &Look, course: &Course, file: &Path) -> Result<Option<PathBuf>, Failure> {
    if course.errors.len() < 2 {
        return Ok(None);
    }
    let curve = |(n, model): (usize, Model)| Series {
        name: model.label().into(),
        points: course.errors.iter().map(|(time, errors)| [1e3 * time, errors[n]]).collect(),
    };
    let axis = |label: &str| Axis { label: label.into(), ..Axis::default() };
    let chart = Chart {
        title: format!("Error: {}", look.title),
        x: axis("time [ms]"),
        y: axis("RMS error against the fine model [%]"),
        series: Model::COARSE.into_iter().enumerate().map(curve).collect(),
        ..Chart::default()
    };
    save(chart.render(), file).map(Some)
}
