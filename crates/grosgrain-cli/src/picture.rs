//! The picture of a run: the deformed body, fine and coarse side by side.

use std::path::{Path, PathBuf};

use grosgrain::io::write_atomically;
use grosgrain::mesh::Node;
use grosgrain_picture::{Category, ColourMap, ColourScale, Colouring, Figure, Image, Lines, Panel, PictureError};

use crate::body_surface::BodySurface;
use crate::failure::Failure;
use crate::method::Method;
use crate::problem::Problem;
use crate::quantities::{count, number};

/// Displacements between these shares of the body's size are drawn as they are; others are scaled to [`DRAWN_SHARE`].
const TRUE_SHARES: [f64; 2] = [0.05, 0.3];
const DRAWN_SHARE: f64 = 0.12;

/// What a picture shows: displacements \[m\] of the fine nodes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drawn<'a> {
    /// The coarse model's, with its number of unknowns.
    pub coarse: Option<(usize, &'a [f64])>,
    /// The fine model's.
    pub fine: Option<&'a [f64]>,
    /// RMS error of the one against the other, in percent.
    pub error: Option<f64>,
    /// What is added to the title.
    pub remark: &'a str,
}

/// Draws the picture into the file at `path`.
///
/// # Errors
/// A picture that cannot be drawn or written.
pub fn write(problem: &Problem, method: Method, drawn: &Drawn<'_>, path: PathBuf) -> Result<PathBuf, Failure> {
    save(figure(problem, method, drawn).render(), &path)
}

/// Writes a picture that was drawn as PNG, whole or not at all; returns its path.
///
/// # Errors
/// A picture that could not be drawn or cannot be written.
pub fn save(image: Result<Image, PictureError>, path: &Path) -> Result<PathBuf, Failure> {
    let failed = |error: PictureError| Failure::Failed(format!("{}: {error}", path.display()));
    let image = image.map_err(failed)?;
    write_atomically(path, |writer| image.write_png(writer)).map_err(failed)?;
    Ok(path.into())
}

fn figure(problem: &Problem, method: Method, drawn: &Drawn<'_>) -> Figure {
    let exact = drawn.fine;
    let embedded = drawn.coarse.map(|(_, u)| u);
    let drawing = Drawing::new(problem, exact.or(embedded).unwrap_or(&[]));
    let mut panels = Vec::new();
    if let Some(u) = exact {
        panels.push(Panel {
            caption: "Fine model".into(),
            detail: format!("{} unknowns", count(problem.fine_size().unknowns)),
            colouring: drawing.materials(),
            ..drawing.panel(u)
        });
    }
    if let Some((unknowns, u)) = drawn.coarse {
        panels.push(Panel {
            caption: format!("Coarse model: {method}, degree {}", problem.scene.coarsening.degree),
            detail: coarse_detail(unknowns, drawn.error),
            colouring: exact.map_or_else(|| drawing.materials(), |exact| drawing.error(u, exact)),
            grid: drawing.coarse_grid(u),
            ..drawing.panel(u)
        });
    }
    let footer = vec![match drawing.scale == 1.0 {
        true => "Displacements to scale.".to_owned(),
        false => format!("Displacements drawn × {}.", number(drawing.scale)),
    }];
    Figure { title: format!("{}{}", problem.scene.title, drawn.remark), panels, footer, ..Figure::default() }
}

fn coarse_detail(unknowns: usize, error: Option<f64>) -> String {
    let unknowns = count(unknowns);
    match error {
        Some(error) => format!("{unknowns} unknowns, RMS error {error:.1} %"),
        None => format!("{unknowns} unknowns"),
    }
}

/// The body's surface and how displacements are drawn on it.
struct Drawing<'a> {
    problem: &'a Problem,
    surface: BodySurface<'a>,
    scale: f64,
}

impl<'a> Drawing<'a> {
    fn new(problem: &'a Problem, displacement: &[f64]) -> Self {
        let grid = problem.model.grid();
        let mut hidden = grid.void.clone();
        if let Some(hide) = &problem.scene.output.hide {
            hidden.iter_mut().zip(hide.cells(grid)).for_each(|(hidden, cut)| *hidden |= cut);
        }
        if hidden.iter().all(|h| *h) {
            hidden.clone_from(&grid.void);
        }
        let surface = BodySurface::new(grid, &hidden);
        let scale = scale_of(problem, displacement);
        Self { problem, surface, scale }
    }

    fn position(&self, u: &[f64], node: Node) -> [f64; 3] {
        let x = self.problem.model.node_position(node);
        [0, 1, 2].map(|r| x[r] + self.scale * u[3 * node.0 + r])
    }

    fn panel(&self, u: &[f64]) -> Panel {
        Panel { ghost: self.box_edges(), ..self.surface.panel(|node| self.position(u, node)) }
    }

    /// A colour per material, or Young's modulus where it is given voxel by voxel.
    fn materials(&self) -> Colouring {
        let grid = self.problem.model.grid();
        if grid.young.is_some() {
            return self.moduli();
        }
        let mut labels: Vec<i32> = self.surface.faces.iter().map(|face| grid.labels[face.cell.0].0).collect();
        let of_face = labels.clone();
        labels.sort_unstable();
        labels.dedup();
        let name = |label: &i32| {
            let material = self.problem.scene.materials.iter().find(|m| m.label.0 == *label);
            Category::named(material.map_or_else(|| format!("label {label}"), |m| m.name.clone()))
        };
        let of_quad = of_face.iter().map(|label| labels.binary_search(label).unwrap_or_default() as u32).collect();
        Colouring::Category { of_quad, legend: labels.iter().map(name).collect() }
    }

    /// log₁₀ of Young's modulus, averaged over the faces at a node.
    fn moduli(&self) -> Colouring {
        let (mut sum, mut faces) = (vec![0.0; self.surface.nodes.len()], vec![0.0; self.surface.nodes.len()]);
        for face in &self.surface.faces {
            let young = self.problem.model.young(face.cell).log10();
            for node in face.corners {
                let row = self.surface.vertex(node);
                (sum[row], faces[row]) = (sum[row] + young, faces[row] + 1.0);
            }
        }
        let at_vertex = sum.iter().zip(&faces).map(|(s, n)| s / n).collect();
        let scale = ColourScale { label: "log₁₀ E [Pa]".into(), ..ColourScale::default() };
        Colouring::Scalar { at_vertex, scale }
    }

    fn error(&self, u: &[f64], exact: &[f64]) -> Colouring {
        // Before anything moves there is nothing to be relative to, and no error.
        let largest = Some(largest_displacement(exact)).filter(|largest| *largest > 0.0).unwrap_or(1.0);
        let error = |node: &Node| {
            let square: f64 = (0..3).map(|r| (u[3 * node.0 + r] - exact[3 * node.0 + r]).powi(2)).sum();
            100.0 * square.sqrt() / largest
        };
        let at_vertex = self.surface.nodes.iter().map(error).collect();
        let label = "|u coarse − u fine| [% of max |u fine|]".into();
        Colouring::Scalar {
            at_vertex,
            scale: ColourScale { label, map: ColourMap::Magma, reversed: true, range: None },
        }
    }

    /// Edges of surface faces that lie on faces of coarse cells.
    fn coarse_grid(&self, u: &[f64]) -> Lines {
        self.surface.coarse_grid(self.problem.scene.coarsening.degree, |node| self.position(u, node))
    }

    /// The twelve edges of the body's undeformed box.
    fn box_edges(&self) -> Lines {
        let grid = self.problem.model.grid();
        let Some([low, high]) = grid.body_box() else { return Vec::new() };
        let corner = |a: usize| grid.position([0, 1, 2].map(|i| if a >> i & 1 == 1 { high[i] } else { low[i] }));
        let edges = (0..8).flat_map(|a| (0..3).map(move |axis| (a, a | 1 << axis))).filter(|(a, b)| a != b);
        edges.map(|(a, b)| [corner(a), corner(b)]).collect()
    }
}

/// Length of the longest vector of three.
pub fn largest_displacement(u: &[f64]) -> f64 {
    u.chunks_exact(3).map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt()).fold(0.0, f64::max)
}

fn scale_of(problem: &Problem, displacement: &[f64]) -> f64 {
    let grid = problem.model.grid();
    let Some([low, high]) = grid.body_box() else { return 1.0 };
    let size = (0..3).map(|a| grid.spacing[a] * (high[a] - low[a]) as f64).fold(0.0, f64::max);
    drawn_scale(size, largest_displacement(displacement))
}

/// 1 where displacements are of a visible size beside a body of this one \[m\]; else the round factor (1, 2 or 5 times a power of ten) that makes them so.
pub fn drawn_scale(size: f64, largest: f64) -> f64 {
    let share = largest / size;
    match share == 0.0 || (TRUE_SHARES[0]..=TRUE_SHARES[1]).contains(&share) {
        true => 1.0,
        false => rounded_down(DRAWN_SHARE / share),
    }
}

/// The largest number of 1, 2, 5 times a power of ten that is not above this positive one.
fn rounded_down(ideal: f64) -> f64 {
    let power = 10f64.powf(ideal.log10().floor());
    let leading = ideal / power;
    power
        * if leading >= 5.0 {
            5.0
        } else if leading >= 2.0 {
            2.0
        } else {
            1.0
        }
}
