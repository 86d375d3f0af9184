//! `convert`: a volume from one format to another.

use std::path::{Path, PathBuf};

use clap::Args;
use grosgrain::io::{read_volume, write_volume};

use crate::failure::Failure;
use crate::interruption;
use crate::progress::Progress;
use crate::quantities::{bytes, triple_count};
use crate::results;
use crate::scene::alternatives;

/// The extensions of the formats that are written.
const WRITABLE: [&str; 6] = [".nii", ".nii.gz", ".nrrd", ".mha", ".mhd", ".npy"];

const EXAMPLES: &str = "Examples:
  grosgrain convert data/ct_torso/example_ct.nii.gz ct.nrrd
  grosgrain convert data/ct_torso/example_ct.nii.gz ct.mha --spacing 0.003,0.003,0.004 --overwrite";

/// Arguments of `convert`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The volume to read: a file, or a folder of DICOM slices or TIFF pages
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
    check_paths(input, output, arguments.overwrite)?;
    progress.say(&format!("reading {}", input.display()));
    let mut volume = read_volume(input)?;
    volume.spacing = arguments.spacing.or(volume.spacing);
    interruption::check()?;
    progress.say(&format!("writing {}", output.display()));
    write_volume(output, &volume)?;
    let size = std::fs::metadata(output).map_or(0.0, |m| m.len() as f64);
    results::print(&format!("{}: {} voxels, {}", output.display(), triple_count(volume.cells), bytes(size)))
}

fn check_paths(input: &Path, output: &Path, overwrite: bool) -> Result<(), Failure> {
    if !input.exists() {
        return Err(Failure::Unusable(format!("{} does not exist; expected a volume", input.display())));
    }
    let name = output.to_string_lossy().to_lowercase();
    if !WRITABLE.iter().any(|extension| name.ends_with(extension)) {
        return Err(Failure::Unusable(format!(
            "{} has no extension of a format that is written; expected {}",
            output.display(),
            alternatives(&WRITABLE.map(String::from))
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
