//! `convert`: a volume or a mesh from one format to another.

use std::path::{Path, PathBuf};

use clap::Args;
use grosgrain::io::{MeshFormat, read_mesh, read_volume, write_mesh, write_volume};

use super::inspect::mesh::as_mesh;
use crate::failure::Failure;
use crate::interruption;
use crate::progress::Progress;
use crate::quantities::{bytes, count, triple_count};
use crate::results;
use crate::scene::alternatives;

/// The extensions of the formats that are written.
const WRITABLE: [&str; 6] = [".nii", ".nii.gz", ".nrrd", ".mha", ".mhd", ".npy"];
/// Those of meshes.
const WRITABLE_MESHES: [&str; 4] = [".msh", ".mesh", ".vtu", ".inp"];

const EXAMPLES: &str = "Examples:
  grosgrain convert data/ct_torso/example_ct.nii.gz ct.mha --spacing 0.003,0.003,0.004 --overwrite
  grosgrain convert data/meshes/liver_coarse.mesh liver.msh --scale 0.001";

/// Arguments of `convert`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The volume or mesh to read: a file, or a folder of DICOM slices or TIFF pages
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The file to write; its extension names the format
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Replace OUT if it exists
    #[arg(long)]
    overwrite: bool,
    /// Edge lengths of a voxel in metres, in place of what IN says
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_spacing)]
    spacing: Option<[f64; 3]>,
    /// Factor for the coordinates of a mesh, e.g. 0.001 from millimetres to metres
    #[arg(long, value_name = "FACTOR", value_parser = parse_scale)]
    scale: Option<f64>,
}

fn parse_scale(text: &str) -> Result<f64, String> {
    let factor = text.trim().parse::<f64>().ok().filter(|f| f.is_normal() && *f > 0.0);
    factor.ok_or_else(|| "expected a positive number, as 0.001".into())
}

fn parse_spacing(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    let numbers = numbers.ok().filter(|n| n.iter().all(|h| h.is_finite() && *h > 0.0));
    numbers
        .and_then(|n| n.try_into().ok())
        .ok_or_else(|| "expected three positive numbers in metres, as 0.001,0.001,0.002".into())
}

/// Reads IN and writes OUT.
pub fn run(arguments: &Arguments, progress: &Progress) -> Result<(), Failure> {
    let (input, output) = (&arguments.input, &arguments.output);
    let is_mesh = MeshFormat::of_name(input).is_some();
    check_options(arguments, is_mesh)?;
    let writable: &[&str] = if is_mesh { &WRITABLE_MESHES } else { &WRITABLE };
    check_paths(input, output, writable, arguments.overwrite)?;
    if is_mesh {
        return convert_mesh(arguments, progress);
    }
    progress.say(&format!("reading {}", input.display()));
    let mut volume = read_volume(input)?;
    volume.spacing = arguments.spacing.or(volume.spacing);
    interruption::check()?;
    progress.say(&format!("writing {}", output.display()));
    write_volume(output, &volume)?;
    let size = std::fs::metadata(output).map_or(0.0, |m| m.len() as f64);
    results::print(&format!("{}: {} voxels, {}", output.display(), triple_count(volume.cells), bytes(size)))
}

fn check_options(arguments: &Arguments, is_mesh: bool) -> Result<(), Failure> {
    let sentence = match (is_mesh, arguments.spacing, arguments.scale) {
        (true, Some(_), _) => "--spacing is for volumes; a mesh takes --scale",
        (false, _, Some(_)) => "--scale is for meshes; a volume takes --spacing",
        _ => return Ok(()),
    };
    Err(Failure::Unusable(sentence.into()))
}

fn convert_mesh(arguments: &Arguments, progress: &Progress) -> Result<(), Failure> {
    let (input, output) = (&arguments.input, &arguments.output);
    progress.say(&format!("reading {}", input.display()));
    let mut file = read_mesh(input)?;
    file.skipped.iter().for_each(|sentence| progress.say(sentence));
    let names = std::mem::take(&mut file.names);
    let mesh = as_mesh(file.scaled(arguments.scale.unwrap_or(1.0)), input)?;
    interruption::check()?;
    progress.say(&format!("writing {}", output.display()));
    write_mesh(output, &mesh, &names)?;
    let size = std::fs::metadata(output).map_or(0.0, |m| m.len() as f64);
    let (cells, kind, place) = (count(mesh.cell_count()), mesh.dimension(), output.display());
    results::print(&format!("{place}: {cells} {kind}, {}", bytes(size)))
}

fn check_paths(input: &Path, output: &Path, writable: &[&str], overwrite: bool) -> Result<(), Failure> {
    if !input.exists() {
        return Err(Failure::Unusable(format!("{} does not exist; expected a volume or a mesh", input.display())));
    }
    let name = output.to_string_lossy().to_lowercase();
    if !writable.iter().any(|extension| name.ends_with(extension)) {
        return Err(Failure::Unusable(format!(
            "{} has no extension of a format that is written; expected {}",
            output.display(),
            alternatives(&writable.iter().map(|e| (*e).to_owned()).collect::<Vec<_>>())
        )));
    }
    let files = written_files(output, &name);
    files.iter().try_for_each(|file| check_output(input, file, overwrite))
}

/// The files that writing `output` makes: a MetaImage header has its voxels beside it.
fn written_files(output: &Path, name: &str) -> Vec<PathBuf> {
    match name.ends_with(".mhd") {
        true => vec![output.to_path_buf(), output.with_extension("raw")],
        false => vec![output.to_path_buf()],
    }
}

fn check_output(input: &Path, output: &Path, overwrite: bool) -> Result<(), Failure> {
    let place = |path: &Path| std::fs::canonicalize(path).ok();
    let is_input = place(input).zip(place(output)).is_some_and(|(a, b)| a == b);
    let same = is_input || place(&input.with_extension("raw")).zip(place(output)).is_some_and(|(a, b)| a == b);
    if same {
        let sentence = "belongs to the input and is never overwritten; expected another name for the output";
        return Err(Failure::Unusable(format!("{} {sentence}", output.display())));
    }
    if output.exists() && !overwrite {
        return Err(Failure::Unusable(format!("{} exists; --overwrite replaces it", output.display())));
    }
    Ok(())
}
