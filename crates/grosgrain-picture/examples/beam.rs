//! A bent beam of two materials: fine body, coarse body with its grid, and the error between them.
//!
//! ```sh
//! cargo run --release -p grosgrain-picture --example beam -- out
//! ```
//!
//! writes `out/beam.png` (two panels), `out/beam-three.png` (three panels) and `out/convergence.png` (a chart).
//!
//! The beam is clamped at x = 0 and hangs down under its weight. The displacement is the Euler-Bernoulli curve of a
//! uniformly loaded cantilever, w(x) = w_L (x⁴ − 4 L x³ + 6 L² x²) / (3 L⁴), with sections that turn with the axis.
//! "Coarse" is the same field interpolated trilinearly between the corners of coarse cells.

use grosgrain_picture::{
    Axis, Category, Chart, ColourMap, ColourScale, Colouring, Figure, Image, Panel, QuadSurface, Series,
};
use std::{collections::BTreeMap, error::Error, fs::File, path::Path};

const CELLS: [usize; 3] = [64, 16, 16];
const LENGTH: f64 = 0.16;
const DEGREE: usize = 4;
type Point = [f64; 3];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "out".into());
    std::fs::create_dir_all(&folder)?;
    save(&two_panels().render()?, &Path::new(&folder).join("beam.png"))?;
    save(&three_panels().render()?, &Path::new(&folder).join("beam-three.png"))?;
    save(&convergence().render()?, &Path::new(&folder).join("convergence.png"))
}

fn save(image: &Image, path: &Path) -> Result<(), Box<dyn Error>> {
    image.write_png(File::create(path)?)?;
    println!("{} ({} × {})", path.display(), image.width(), image.height());
    Ok(())
}

/// The body by material, and the interpolated body by error.
pub fn two_panels() -> Figure {
    Figure {
        title: "A two-material beam, fine and interpolated on a coarse grid".into(),
        panels: vec![fine_panel(), coarse_panel()],
        footer: footer(),
        ..Figure::default()
    }
}

/// The same with the displacement between them, somewhat wider.
pub fn three_panels() -> Figure {
    Figure {
        title: "A two-material beam: body, displacement, interpolation error".into(),
        panels: vec![fine_panel(), size_panel(), coarse_panel()],
        footer: footer(),
        width: 2000,
        ..Figure::default()
    }
}

fn footer() -> Vec<String> {
    vec!["Beam 160 × 40 × 40 mm, clamped at the left end, bent as under its own weight. Layers at 45°.".into()]
}

fn fine_panel() -> Panel {
    let (surface, layers) = beam_surface(deformed);
    let legend = vec![Category::named("soft layer"), Category::named("stiff layer")];
    Panel {
        caption: "Fine model".into(),
        detail: "56,355 unknowns".into(),
        surface,
        colouring: Colouring::Category { of_quad: layers, legend },
        ghost: box_edges(),
        ..Panel::default()
    }
}

fn size_panel() -> Panel {
    let (surface, _) = beam_surface(deformed);
    let (rest, _) = beam_surface(|x| x);
    let size = surface.positions.iter().zip(&rest.positions).map(|(x, at)| distance(*x, *at)).collect();
    let scale = ColourScale { label: "|u| [m]".into(), ..ColourScale::default() };
    Panel {
        caption: "Fine model: displacement".into(),
        detail: "56,355 unknowns".into(),
        surface,
        colouring: Colouring::Scalar { at_vertex: size, scale },
        ghost: box_edges(),
        ..Panel::default()
    }
}

fn coarse_panel() -> Panel {
    let (surface, _) = beam_surface(|p| interpolated(p, DEGREE));
    let (fine, _) = beam_surface(deformed);
    let largest = distance(deformed([LENGTH, 0.0, 0.0]), [LENGTH, 0.0, 0.0]);
    let error =
        surface.positions.iter().zip(&fine.positions).map(|(a, b)| 100.0 * distance(*a, *b) / largest).collect();
    let label = "|u coarse − u fine| [% of max |u fine|]".into();
    let scale = ColourScale { label, map: ColourMap::Magma, reversed: true, range: None };
    Panel {
        caption: "On a coarse grid, degree 4".into(),
        detail: "1,275 unknowns".into(),
        surface,
        colouring: Colouring::Scalar { at_vertex: error, scale },
        grid: coarse_edges(),
        ghost: box_edges(),
        ..Panel::default()
    }
}

/// Error of the interpolation over the unknowns of the coarse grid.
pub fn convergence() -> Chart {
    let (rest, _) = beam_surface(|x| x);
    let largest = distance(deformed([LENGTH, 0.0, 0.0]), [LENGTH, 0.0, 0.0]);
    let (mut worst, mut mean) = (Vec::new(), Vec::new());
    for degree in [16, 8, 4, 2] {
        let unknowns = CELLS.iter().map(|n| (n / degree + 1) as f64).product::<f64>() * 3.0;
        let error = |p: &Point| 100.0 * distance(interpolated(*p, degree), deformed(*p)) / largest;
        let errors: Vec<f64> = rest.positions.iter().map(error).collect();
        worst.push([unknowns, errors.iter().copied().fold(0.0, f64::max)]);
        mean.push([unknowns, (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()]);
    }
    Chart {
        title: "Interpolation error over unknowns".into(),
        x: Axis { label: "unknowns".into(), logarithmic: true, whole: false },
        y: Axis { label: "error on the surface [% of max |u|]".into(), logarithmic: true, whole: false },
        series: vec![
            Series { name: "largest".into(), points: worst },
            Series { name: "root mean square".into(), points: mean },
        ],
        ..Chart::default()
    }
}

fn spacing() -> f64 {
    LENGTH / CELLS[0] as f64
}

/// Position of a point of the beam under its own weight.
fn deformed([x, y, z]: Point) -> Point {
    let (sag, s) = (0.045, x / LENGTH);
    let w = -sag * (s.powi(4) - 4.0 * s.powi(3) + 6.0 * s * s) / 3.0;
    let slope = (-sag / LENGTH * (4.0 * s.powi(3) - 12.0 * s * s + 12.0 * s) / 3.0).atan();
    let height = z - 8.0 * spacing();
    [x - height * slope.sin() - 0.25 * w * w / LENGTH, y, 8.0 * spacing() + w + height * slope.cos()]
}

/// The same field interpolated trilinearly between the corners of coarse cells.
fn interpolated(p: Point, degree: usize) -> Point {
    let size = spacing() * degree as f64;
    let low: Point = std::array::from_fn(|a| (p[a] / size).floor().min((CELLS[a] / degree) as f64 - 1.0) * size);
    let mut sum = [0.0; 3];
    for corner in 0..8 {
        let side: Point = std::array::from_fn(|a| f64::from(corner >> a & 1));
        let at: Point = std::array::from_fn(|a| low[a] + side[a] * size);
        let weight: f64 = (0..3).map(|a| 1.0 - (p[a] - at[a]).abs() / size).product();
        let x = deformed(at);
        sum = std::array::from_fn(|a| sum[a] + weight * x[a]);
    }
    sum
}

/// The outer faces of the voxels, and the layer each belongs to.
fn beam_surface(map: impl Fn(Point) -> Point) -> (QuadSurface, Vec<u32>) {
    let mut surface = QuadSurface::default();
    let mut vertices: BTreeMap<[usize; 3], u32> = BTreeMap::new();
    let mut layers = Vec::new();
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for (side, j, k) in [0, 1].into_iter().flat_map(|s| cells(b, c).map(move |(j, k)| (s, j, k))) {
            let node = |dj: usize, dk: usize| {
                let mut at = [0; 3];
                (at[axis], at[b], at[c]) = (side * CELLS[axis], j + dj, k + dk);
                at
            };
            let around = [node(0, 0), node(1, 0), node(1, 1), node(0, 1)];
            let quad = around.map(|at| {
                *vertices.entry(at).or_insert_with(|| {
                    surface.positions.push(map(at.map(|i| i as f64 * spacing())));
                    surface.positions.len() as u32 - 1
                })
            });
            surface.quads.push(quad);
            let mut cell = node(0, 0);
            cell[axis] -= side;
            layers.push(((cell[0] + cell[2]) / 4 % 2) as u32);
        }
    }
    (surface, layers)
}

fn cells(b: usize, c: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..CELLS[b]).flat_map(move |j| (0..CELLS[c]).map(move |k| (j, k)))
}

/// Edges of the coarse cells on the beam's surface, between coarse corners.
fn coarse_edges() -> Vec<[Point; 2]> {
    let count = CELLS.map(|n| n / DEGREE);
    let at = |i: [usize; 3]| interpolated(i.map(|i| (i * DEGREE) as f64 * spacing()), DEGREE);
    let mut lines = Vec::new();
    for index in 0..(count[0] + 1) * (count[1] + 1) * (count[2] + 1) {
        let i =
            [index % (count[0] + 1), index / (count[0] + 1) % (count[1] + 1), index / (count[0] + 1) / (count[1] + 1)];
        for axis in 0..3 {
            let outside = (0..3).any(|a| a != axis && (i[a] == 0 || i[a] == count[a]));
            if outside && i[axis] < count[axis] {
                let mut next = i;
                next[axis] += 1;
                lines.push([at(i), at(next)]);
            }
        }
    }
    lines
}

/// The twelve edges of the undeformed beam.
fn box_edges() -> Vec<[Point; 2]> {
    let corner = |c: usize| std::array::from_fn(|a| if c >> a & 1 == 1 { CELLS[a] as f64 * spacing() } else { 0.0 });
    let from = |c: usize| (0..3).filter(move |a| c >> a & 1 == 0).map(move |a| [corner(c), corner(c | 1 << a)]);
    (0..8).flat_map(from).collect()
}

fn distance(a: Point, b: Point) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}
