//! `homogenize`: effective elasticity tensors of a coarse mesh.

use std::path::{Path, PathBuf};

use clap::Args;
use grosgrain::homogenization::{BoundaryNormals, HomogenizeOptions, Homogenized, SimplexModel, homogenize};
use grosgrain::io::mesh::{AbaqusDeck, AbaqusMaterials, read_mesh, write_abaqus};
use grosgrain::io::vtk::{DataArray, SimplexGrid, Values, write_simplex_vtu};
use grosgrain::io::{write_atomically, write_tensors};
use grosgrain::material::{Material, MaterialTable};
use grosgrain::simplex::{Severity, SimplexMesh, check_mesh};
use serde::Serialize;

use crate::failure::Failure;
use crate::interruption;
use crate::output::OutputFolder;
use crate::progress::Progress;
use crate::quantities::{count, number, seconds};
use crate::results;
use crate::scene::read_material_file;

const EXAMPLES: &str = "Examples:
  grosgrain homogenize bar.msh --onto coarse.msh --materials bar.toml -o tensors.vtu
  grosgrain homogenize ct.mesh --onto coarse.mesh --materials ct.toml --scale 0.001 -o ct.inp";

/// Arguments of `homogenize`.
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The fine mesh, a tag for the material of each cell
    fine: PathBuf,
    /// The coarse mesh of the same body
    #[arg(long, value_name = "COARSE")]
    onto: PathBuf,
    /// A TOML file with the `[materials.*]` tables of a scene; `label` is the tag of the cells
    #[arg(long, value_name = "M.toml")]
    materials: PathBuf,
    /// What lengths in both meshes are multiplied by, 0.001 for millimetres
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = parse_scale)]
    scale: f64,
    /// Load the fine mesh along the normals of the coarse boundary instead of its own, as the paper does
    #[arg(long)]
    coarse_normals: bool,
    /// Where the coarse mesh with its tensors is written, by its ending: .vtu or .inp (Abaqus); without it the coarse mesh's name with
    /// -tensors.vtu, in the current folder
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// Write tensors, masses and harmonic displacements for NumPy
    #[arg(long, value_name = "OUT.npz")]
    npz: Option<PathBuf>,
    /// Write the figures as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
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
    seconds: Stages,
    /// Total mass of the coarse nodes [kg].
    mass: f64,
    /// Difference of that from the mass of the fine mesh, relative.
    mass_difference: f64,
    worst_condition: Option<f64>,
    worst_condition_cell: usize,
    /// Coarse nodes outside the fine mesh.
    extrapolated_nodes: usize,
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
    let output = arguments.output.clone().unwrap_or_else(|| default_output(&arguments.onto));
    let format = TensorFormat::of(&output)?;
    let start = std::time::Instant::now();
    let table = material_table(&arguments.materials, progress)?;
    let (fine, names) = read(&arguments.fine, arguments.scale, progress)?;
    let (coarse, coarse_names) = read(&arguments.onto, arguments.scale, progress)?;
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
    let options = HomogenizeOptions { normals, ..HomogenizeOptions::default() };
    let found = homogenize(&model, &coarse, &options, &report).map_err(|error| {
        Failure::Failed(format!("{} onto {}: {error}", arguments.fine.display(), arguments.onto.display()))
    })?;
    progress.close();
    let figures = Figures::new(&model, &coarse, &found, reading);
    figures.warn(progress);
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

fn default_output(coarse: &Path) -> PathBuf {
    let mut name = coarse.file_stem().unwrap_or_default().to_owned();
    name.push("-tensors.vtu");
    PathBuf::from(name)
}

/// The materials by tag. Coarse tensors are those of linear elasticity, whatever law the material has beyond.
fn material_table(file: &Path, progress: &Progress) -> Result<MaterialTable, Failure> {
    let materials = read_material_file(file)?;
    let mut table = MaterialTable::new();
    for material in &materials {
        let Some(elasticity) = material.own_elasticity() else { continue };
        if material.density.is_none() {
            progress.warn(&format!("materials.{} has no density; its cells count as without mass", material.name));
        }
        let density = material.density.unwrap_or(0.0);
        table.insert(material.label, Material::linear(material.name.clone(), *elasticity, density));
    }
    Ok(table)
}

/// Reads a mesh and tells what is odd about it; what cannot be computed with is refused.
fn read(file: &Path, scale: f64, progress: &Progress) -> Result<(SimplexMesh, Vec<(i32, String)>), Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::Failed(format!("{}: {error}", file.display()));
    let contents = read_mesh(file).map_err(|error| failed(&error))?;
    for sentence in &contents.skipped {
        progress.say(&format!("{}: {sentence}", file.display()));
    }
    let names = contents.names.clone();
    let mesh = contents.scaled(scale).into_mesh().map_err(|error| failed(&error))?;
    for finding in check_mesh(&mesh) {
        match finding.severity() {
            Severity::Warning => progress.warn(&format!("{}: {finding}", file.display())),
            Severity::Error => return Err(failed(&finding)),
        }
    }
    Ok((mesh, names))
}

/// Materials that no cell has: often a slip in a label.
fn tell_unused(table: &MaterialTable, model: &SimplexModel, names: &[(i32, String)], progress: &Progress) {
    for (label, material) in table.iter().filter(|(label, _)| !model.mesh().tags().contains(&label.0)) {
        let named: Vec<String> = names.iter().map(|(tag, name)| format!("{tag} is {name}")).collect();
        let hint = if named.is_empty() { String::new() } else { format!(" (in the file {})", named.join(", ")) };
        progress.warn(&format!("materials.{} has label {label}, which no cell has{hint}", material.name));
    }
}

impl Figures {
    fn new(model: &SimplexModel, coarse: &SimplexMesh, found: &Homogenized, reading: f64) -> Self {
        let Homogenized { downsampled, effective, mass, filled, .. } = found;
        let [harmonic, intersections, tensors] = found.seconds;
        let size = |mesh: &SimplexMesh| Size { cells: mesh.cell_count(), nodes: mesh.nodes().len() };
        let worst = (0..).zip(&effective.condition).max_by(|a, b| a.1.total_cmp(b.1));
        let (worst_condition_cell, worst_condition) =
            worst.map_or((0, f64::INFINITY), |(cell, condition)| (cell, *condition));
        let total: f64 = mass.iter().sum();
        let mass_difference = if model.mass() > 0.0 { total / model.mass() - 1.0 } else { 0.0 };
        Self {
            fine: size(model.mesh()),
            coarse: size(coarse),
            seconds: Stages { reading, harmonic, intersections, tensors },
            mass: total,
            mass_difference,
            worst_condition: Some(worst_condition).filter(|condition| condition.is_finite()),
            worst_condition_cell,
            extrapolated_nodes: downsampled.extrapolated.len(),
            averaged_cells: effective.averaged.clone(),
            least_filled: filled.iter().copied().fold(f64::INFINITY, f64::min),
        }
    }

    fn warn(&self, progress: &Progress) {
        if let [first, ..] = self.averaged_cells[..] {
            let cells = self.averaged_cells.len();
            progress.warn(&format!(
                "in {} coarse cells, the first being cell {first}, the harmonic displacements do not determine all strains; the volume average stands in for them", count(cells)
            ));
        }
        if self.extrapolated_nodes > 0 {
            progress.say(&format!(
                "{} of {} coarse nodes lie outside the fine mesh; displacements are extrapolated to them",
                count(self.extrapolated_nodes),
                count(self.coarse.nodes)
            ));
        }
    }

    fn text(&self, written: &[PathBuf]) -> String {
        let row = |name: &str, value: String| (name.to_owned(), value);
        let size = |size: &Size| format!("{} cells, {} nodes", count(size.cells), count(size.nodes));
        let condition = self.worst_condition.map_or_else(|| "singular".into(), number);
        let Stages { reading, harmonic, intersections, tensors } = self.seconds;
        let rows = [
            row("fine mesh", size(&self.fine)),
            row("coarse mesh", size(&self.coarse)),
            row("mass", format!("{} kg", number(self.mass))),
            row("condition", format!("{condition} at worst, in coarse cell {}", self.worst_condition_cell)),
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
