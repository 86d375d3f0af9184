//! Films of meshes of simplices, coloured by tag.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::footage::{FilmOptions, Footage, Shape, Wires};
use crate::failure::Failure;
use crate::meshes::{Posed, simplex_view};

/// A film of one or more runs of bodies of simplices, each run with a mesh of its own.
///
/// It keeps the skins only, in single precision: 12 bytes per vertex and frame. Bodies in the plane are seen from the front unless the options tell a view.
///
/// ```
/// use std::sync::Arc;
/// use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, SimplexLattice};
/// use grosgrain_cli::film::{FilmOptions, SimplexFilm};
/// use grosgrain_cli::meshes::{Posed, SimplexSkin};
/// let around = BoundingBox { lower: [0.0; 3], upper: [0.04, 0.02, 0.02] };
/// let lattice = |boxes| SimplexLattice { dimension: Dimension::Three, boxes, around, cut: BoxCut::Alternating };
/// let (fine, coarse) = (lattice([8, 4, 4]).mesh()?, lattice([4, 2, 2]).mesh()?);
/// let (skin, wires) = (Arc::new(SimplexSkin::new(&fine, None)?), Arc::new(SimplexSkin::new(&coarse, None)?));
/// let mut film = SimplexFilm::new("A block", &["fine", "coarse"], FilmOptions::default());
/// for time in [0.0, 0.1] {
///     let moved = |nodes: usize| vec![0.02 * time; 3 * nodes];
///     let (u, v) = (moved(fine.nodes().len()), moved(coarse.nodes().len()));
///     let body = Posed { skin: &skin, displacement: &u };
///     film.record(0, time, body, None);
///     film.record(1, time, body, Some(Posed { skin: &wires, displacement: &v }));
///     film.set_note(1, "error 0.0 %");
/// }
/// # let folder = tempfile::tempdir()?;
/// # let folder = folder.path();
/// film.write_strip(&folder.join("film.png"), 5)?;
/// film.write_animation(&folder.join("film-animated.png"))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SimplexFilm {
    footage: Footage,
}

impl SimplexFilm {
    /// A film without frames; `runs` are the labels of what stands side by side.
    pub fn new(title: &str, runs: &[&str], options: FilmOptions) -> Self {
        Self { footage: Footage::new(title, runs, options, "tag") }
    }

    /// Adds what a run looks like at a time \[s\]: a skin under the displacements of its mesh, and the edges of another one over it, such as a coarse mesh around the body.
    ///
    /// # Panics
    /// `run` is not one of the film's, or displacements are not three per node.
    pub fn record(&mut self, run: usize, time: f64, body: Posed<'_>, wires: Option<Posed<'_>>) {
        let view = &mut self.footage.options.view;
        *view = view.or(simplex_view(body.skin.dimension()));
        self.footage.know(body.skin.tags_of_mesh());
        let wires = wires.map(|wires| Wires { quads: Arc::clone(wires.skin.faces()), positions: positions(wires) });
        let shape = Shape {
            quads: Arc::clone(body.skin.faces()),
            labels: Arc::clone(body.skin.tags()),
            positions: positions(body),
            wires,
        };
        self.footage.push(run, time, shape);
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
    /// As [`SimplexFilm::write_strip`].
    pub fn write_animation(&self, path: &Path) -> Result<PathBuf, Failure> {
        self.footage.write_animation(path)
    }
}

fn positions(posed: Posed<'_>) -> Vec<[f32; 3]> {
    posed.skin.displaced(posed.displacement, 1.0).map(|p| p.map(|x| x as f32)).collect()
}
