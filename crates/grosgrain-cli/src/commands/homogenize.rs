//! `homogenize`: effective elasticity tensors of a coarse mesh.

use std::path::{Path, PathBuf};

use clap::Args;
use grosgrain::homogenization::{
    BoundaryNormals, Downsampling, HarmonicOptions, HomogenizeOptions, Homogenized, SimplexModel, homogenize,
};
use grosgrain::io::mesh::{AbaqusDeck, AbaqusMaterials, write_abaqus};
use grosgrain::io::vtk::{DataArray, SimplexGrid, Values, write_simplex_vtu};
use grosgrain::io::{write_atomically, write_tensors};
use grosgrain::mesh::{Axis, PlaneAt, Selector};
use grosgrain::simplex::{SimplexMesh, select_nodes};
use serde::Serialize;

use crate::failure::Failure;
use crate::interruption;
use crate::meshes::{
    LEAST_FILLED, NamedMesh, lattice_around, material_table, read_checked, stiffened, tell_doubts, tell_unused,
    worst_of,
};
use crate::output::OutputFolder;
use crate::progress::Progress;
use crate::quantities::{count, number, seconds};
use crate::results;
use crate::scene::read_material_file;

const EXAMPLES: &str = "Examples:
  grosgrain homogenize ct.mesh --onto coarse.mesh --materials ct.toml --scale 0.001 -o ct.inp
  grosgrain homogenize part.msh --cells 600 --materials part.toml --held x=min --downsampling fitted";

/// Arguments of `homogenize`.
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The fine mesh, a tag for the material of each cell
    fine: PathBuf,
    /// The coarse mesh of the same body
    #[arg(long, value_name = "COARSE", required_unless_present = "cells", conflicts_with = "cells")]
    onto: Option<PathBuf>,
    /// Without a coarse mesh: make one of about so many cells, boxes around the body cut into simplices
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    cells: Option<u32>,
    /// A TOML file with the `[materials.*]` tables of a scene; `label` is the tag of the cells
    #[arg(long, value_name = "M.toml")]
    materials: PathBuf,
    /// What lengths in both meshes are multiplied by, 0.001 for millimetres
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = parse_scale)]
    scale: f64,
    /// Load the fine mesh along the normals of the coarse boundary instead of its own, as the paper does
    #[arg(long)]
    coarse_normals: bool,
    /// Nodes that will be held in use, which the harmonic displacements then hold as well: an end of the fine mesh (x=min, z=max) or a
    /// plane (y=0.02, in metres); several may be given
    #[arg(long, value_name = "AXIS=AT", value_parser = parse_plane)]
    held: Vec<Selector>,
    /// How harmonic displacements are taken to the coarse mesh: their values at its nodes, or the closest coarse fields
    #[arg(long, value_name = "HOW", value_enum, default_value_t = How::Nodes)]
    downsampling: How,
    /// Where the coarse mesh with its tensors is written, by its ending: .vtu or .inp (Abaqus); without it the coarse mesh's name (with
    /// --cells that of the fine mesh) with -tensors.vtu, in the current folder
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// Write tensors, masses and harmonic displacements for NumPy
    #[arg(long, value_name = "OUT.npz")]
    npz: Option<PathBuf>,
    /// Write the figures as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// The library's [`Downsampling`] on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
enum How {
    /// Values at the coarse nodes, as published
    Nodes,
    /// The coarse fields closest in the mean over the body
    Fitted,
}

fn parse_plane(text: &str) -> Result<Selector, String> {
    let expected = || "expected x, y or z, then = and min, max or a number of metres, e.g. x=min".to_owned();
    let (axis, at) = text.split_once('=').ok_or_else(expected)?;
    let axis = match axis {
        "x" => Axis::X,
        "y" => Axis::Y,
        "z" => Axis::Z,
        _ => return Err(expected()),
    };
    let at = match at {
        "min" => PlaneAt::Min,
        "max" => PlaneAt::Max,
        number => PlaneAt::Coordinate(number.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(expected)?),
    };
    Ok(Selector::Plane { axis, at })
}

fn parse_scale(text: &str) -> Result<f64, String> {
    let scale: Option<f64> = text.parse().ok();
    scale
        .filter(|s| *s > 0.0 && s.is_finite())
        .ok_or_else(|| "expected a positive number, 0.001 for millimetres".into())
}

/// The format of the coarse mesh with its tensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TensorFormat {
    Vtu,
    Abaqus,
}

impl TensorFormat {
    fn of(path: &Path) -> Result<Self, Failure> {
        match path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("vtu") => Ok(Self::Vtu),
            Some("inp") => Ok(Self::Abaqus),
            _ => Err(Failure::Unusable(format!("{}: expected a name that ends in .vtu or .inp", path.display()))),
        }
    }

    fn write(self, path: &Path, coarse: (&SimplexMesh, &[(i32, String)]), found: &Homogenized) -> Result<(), Failure> {
        let ((mesh, names), effective) = (coarse, &found.effective);
        let outcome = match self {
            Self::Vtu => {
                let averaged: Vec<i32> =
                    (0..mesh.cell_count() as u32).map(|q| i32::from(effective.averaged.contains(&q))).collect();
                let cell = |name, values| DataArray { name, values };
                let grid = SimplexGrid {
                    cell_data: vec![
                        cell("stiffness", Values::Stiffness(&effective.tensors)),
                        cell("density", Values::Scalar(&found.density)),
                        cell("condition", Values::Scalar(&effective.condition)),
                        cell("stiffening", Values::Scalar(&effective.stiffening)),
                        cell("filled", Values::Scalar(&found.filled)),
                        cell("averaged", Values::Integer(&averaged)),
                    ],
                    point_data: vec![cell("mass", Values::Scalar(&found.mass))],
                    ..SimplexGrid::new(mesh)
                };
                write_atomically(path, |writer| write_simplex_vtu(writer, &grid)).map_err(|error| error.to_string())
            }
            Self::Abaqus => {
                let materials = AbaqusMaterials { stiffness: &effective.tensors, density: &found.density };
                let deck = AbaqusDeck { mesh, names, materials: Some(materials) };
                write_atomically(path, |writer| write_abaqus(writer, &deck)).map_err(|error| error.to_string())
            }
        };
        outcome.map_err(|error: String| Failure::Failed(format!("{}: {error}", path.display())))
    }
}

/// The figures of a homogenization.
#[derive(Debug, Serialize)]
struct Figures {
    fine: Size,
    coarse: Size,
    /// How harmonic displacements were taken to the coarse mesh.
    downsampling: How,
    seconds: Stages,
    /// Total mass of the coarse nodes [kg].
    mass: f64,
    /// Difference of that from the mass of the fine mesh, relative.
    mass_difference: f64,
    worst_condition: f64,
    worst_condition_cell: usize,
    /// Largest energy of a strain over that of the volume average.
    worst_stiffening: f64,
    worst_stiffening_cell: usize,
    /// Coarse cells where it is suspicious.
    stiffened_cells: usize,
    /// Coarse nodes outside the fine mesh.
    extrapolated_nodes: usize,
    /// How many times an error of nodal values may grow by extrapolation, at worst.
    worst_amplification: f64,
    /// Coarse cells in which some strains took the volume average.
    averaged_cells: Vec<u32>,
    least_filled: f64,
}

#[derive(Debug, Serialize)]
struct Size {
    cells: usize,
    nodes: usize,
}

#[derive(Debug, Serialize)]
struct Stages {
    reading: f64,
    harmonic: f64,
    intersections: f64,
    tensors: f64,
}

/// Reads the meshes, homogenizes, writes.
pub fn run(arguments: &Arguments, progress: &Progress) -> Result<(), Failure> {
    let output = arguments.output.clone().unwrap_or_else(|| default_output(arguments));
    let format = TensorFormat::of(&output)?;
    let start = std::time::Instant::now();
    let materials = read_material_file(&arguments.materials)?;
    let table = material_table(&materials);
    for material in materials.iter().filter(|material| material.density.is_none()) {
        progress.warn(&format!("materials.{} has no density; its cells count as without mass", material.name));
    }
    let (fine, names) = read(&arguments.fine, arguments.scale, progress)?;
    let (coarse, coarse_names) = coarse_mesh(arguments, &fine, progress)?;
    let model = SimplexModel::new(fine, &table)
        .map_err(|error| Failure::Unusable(format!("{}: {error}", arguments.materials.display())))?;
    tell_unused(&table, &model, &names, progress);
    let reading = start.elapsed().as_secs_f64();
    let targets = [Some(output.as_path()), arguments.npz.as_deref(), arguments.json.as_deref()];
    let _folders = targets
        .map(|target| target.map(OutputFolder::around).transpose())
        .into_iter()
        .collect::<Result<Vec<_>, _>>()?;
    let report = |name, done, total| progress.report(name, done, total);
    let normals = if arguments.coarse_normals { BoundaryNormals::Coarse } else { BoundaryNormals::Fine };
    let downsampling = match arguments.downsampling {
        How::Nodes => Downsampling::AtNodes,
        How::Fitted => Downsampling::Fitted,
    };
    let harmonic = HarmonicOptions { held: held_nodes(arguments, model.mesh())?, ..HarmonicOptions::default() };
    let options = HomogenizeOptions { normals, harmonic, downsampling, ..HomogenizeOptions::default() };
    let found = homogenize(&model, &coarse, &options, &report).map_err(|error| {
        let onto = arguments.onto.as_ref().map_or_else(String::new, |coarse| format!(" onto {}", coarse.display()));
        Failure::Failed(format!("{}{onto}: {error}", arguments.fine.display()))
    })?;
    progress.close();
    let figures = Figures::new(&model, &coarse, &found, (arguments.downsampling, reading));
    let untried = [
        (arguments.downsampling == How::Nodes, "--downsampling fitted"),
        (arguments.held.is_empty(), "--held where the body will be held"),
    ];
    let remedies: Vec<&str> = untried.into_iter().filter(|(is_untried, _)| *is_untried).map(|(_, what)| what).collect();
    tell_doubts(&found, &remedies, progress);
    figures.tell_outside(progress);
    interruption::check()?;
    format.write(&output, (&coarse, &coarse_names), &found)?;
    let mut written = vec![output];
    if let Some(npz) = &arguments.npz {
        write_tensors(npz, &coarse, &found).map_err(|error| Failure::Failed(format!("{}: {error}", npz.display())))?;
        written.push(npz.clone());
    }
    if let Some(json) = &arguments.json {
        results::write_json(json, &figures)?;
    }
    results::print(&figures.text(&written))
}

fn read(file: &Path, scale: f64, progress: &Progress) -> Result<NamedMesh, Failure> {
    read_checked(file, scale, progress).map_err(Failure::Failed)
}

/// The coarse mesh that was given, or one made around the fine mesh.
fn coarse_mesh(arguments: &Arguments, fine: &SimplexMesh, progress: &Progress) -> Result<NamedMesh, Failure> {
    if let Some(onto) = &arguments.onto {
        return read(onto, arguments.scale, progress);
    }
    let count = arguments.cells.unwrap_or(1) as usize;
    let made = lattice_around(fine, count);
    let mesh = made.map_err(|error| Failure::Unusable(format!("{}: --cells: {error}", arguments.fine.display())))?;
    progress.say(&format!(
        "made a coarse mesh of {} cells, all filled to {:.0} % at least",
        crate::quantities::count(mesh.cell_count()),
        100.0 * LEAST_FILLED
    ));
    Ok((mesh, Vec::new()))
}

/// Which fine nodes any of the planes holds; none without planes.
fn held_nodes(arguments: &Arguments, fine: &SimplexMesh) -> Result<Vec<bool>, Failure> {
    let mut held = Vec::new();
    for plane in &arguments.held {
        let picked = select_nodes(fine, plane)
            .map_err(|error| Failure::Unusable(format!("{}: --held: {error}", arguments.fine.display())))?;
        held.resize(picked.len(), false);
        held.iter_mut().zip(picked).for_each(|(held, here)| *held |= here);
    }
    Ok(held)
}

fn default_output(arguments: &Arguments) -> PathBuf {
    let mesh = arguments.onto.as_ref().unwrap_or(&arguments.fine);
    let mut name = mesh.file_stem().unwrap_or_default().to_owned();
    name.push("-tensors.vtu");
    PathBuf::from(name)
}

impl Figures {
    fn new(
        model: &SimplexModel,
        coarse: &SimplexMesh,
        found: &Homogenized,
        (downsampling, reading): (How, f64),
    ) -> Self {
        let Homogenized { downsampled, effective, mass, filled, .. } = found;
        let [harmonic, intersections, tensors] = found.seconds;
        let size = |mesh: &SimplexMesh| Size { cells: mesh.cell_count(), nodes: mesh.nodes().len() };
        let (worst_condition_cell, worst_condition) = worst_of(&effective.condition);
        let (worst_stiffening_cell, worst_stiffening) = worst_of(&effective.stiffening);
        let total: f64 = mass.iter().sum();
        let mass_difference = if model.mass() > 0.0 { total / model.mass() - 1.0 } else { 0.0 };
        Self {
            fine: size(model.mesh()),
            coarse: size(coarse),
            downsampling,
            seconds: Stages { reading, harmonic, intersections, tensors },
            mass: total,
            mass_difference,
            worst_condition,
            worst_condition_cell,
            worst_stiffening,
            worst_stiffening_cell,
            stiffened_cells: stiffened(effective),
            extrapolated_nodes: downsampled.extrapolated.len(),
            worst_amplification: downsampled.amplification,
            averaged_cells: effective.averaged.clone(),
            least_filled: filled.iter().copied().fold(f64::INFINITY, f64::min),
        }
    }

    /// Says what the fine mesh does not tell about coarse nodes outside of it.
    fn tell_outside(&self, progress: &Progress) {
        let outside = format!(
            "{} of {} coarse nodes lie outside the fine mesh",
            count(self.extrapolated_nodes),
            count(self.coarse.nodes)
        );
        if self.extrapolated_nodes > 0 && self.downsampling == How::Fitted {
            progress.say(&format!(
                "{outside}; the fit takes their displacements from all of the body in the cells around them"
            ));
        } else if self.extrapolated_nodes > 0 {
            progress.say(&format!(
                "{outside}; displacements are extrapolated to them, errors of which may grow {}-fold",
                number((10.0 * self.worst_amplification).round() / 10.0)
            ));
        }
    }

    fn text(&self, written: &[PathBuf]) -> String {
        let row = |name: &str, value: String| (name.to_owned(), value);
        let size = |size: &Size| format!("{} cells, {} nodes", count(size.cells), count(size.nodes));
        let condition = number(self.worst_condition);
        let Stages { reading, harmonic, intersections, tensors } = self.seconds;
        let rows = [
            row("fine mesh", size(&self.fine)),
            row("coarse mesh", size(&self.coarse)),
            row("mass", format!("{} kg", number(self.mass))),
            row("condition", format!("{condition} at worst, in coarse cell {}", self.worst_condition_cell)),
            row(
                "stiffening",
                format!(
                    "{} times the volume average at worst, in coarse cell {}",
                    number(self.worst_stiffening),
                    self.worst_stiffening_cell
                ),
            ),
            row("least filled", format!("{:.1} % of a coarse cell", 100.0 * self.least_filled)),
            row(
                "time",
                format!(
                    "reading {}, harmonic displacements {}, intersections {}, tensors {}",
                    seconds(reading),
                    seconds(harmonic),
                    seconds(intersections),
                    seconds(tensors)
                ),
            ),
        ];
        let written: Vec<String> = written.iter().map(|path| format!("wrote {}", path.display())).collect();
        format!("{}\n{}", results::table(&rows), written.join("\n"))
    }
}
