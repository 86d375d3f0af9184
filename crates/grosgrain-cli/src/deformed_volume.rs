//! The deformed body as volume files: its labels, and the scan that it comes from.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use grosgrain::fine::FineModel;
use grosgrain::io::write_volume;
use grosgrain::mesh::{Cell, Label, Volume, warp};

use crate::failure::Failure;
use crate::problem::Problem;

mod scan;

pub use scan::{DeformedScan, ScannedBody};

/// The files of a deformed body, by the formats that viewers of scans read.
const FORMATS: [&str; 2] = ["nii.gz", "nrrd"];

/// Writes the labels (or the moduli, where there is one per voxel) of the deformed body into `deformed.nii.gz` and `deformed.nrrd`.
///
/// # Errors
/// A deformation too large for voxels; a file that cannot be written.
pub fn write(problem: &Problem, displacement: &[f64], folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let volume = deformed(problem, displacement).ok_or_else(too_large)?;
    write_both(&volume, folder, "deformed")
}

/// Writes a deformed scan into `deformed-scan.nii.gz` and `deformed-scan.nrrd`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_scan(scan: &DeformedScan, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    write_scan_as(scan, folder, "deformed-scan")
}

/// Writes a deformed scan into `NAME.nii.gz` and `NAME.nrrd`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_scan_as(scan: &DeformedScan, folder: &Path, name: &str) -> Result<Vec<PathBuf>, Failure> {
    write_both(&scan.volume(), folder, name)
}

fn write_both(volume: &Volume, folder: &Path, name: &str) -> Result<Vec<PathBuf>, Failure> {
    let write = |ending: &&str| -> Result<PathBuf, Failure> {
        let path = folder.join(format!("{name}.{ending}"));
        write_volume(&path, volume)?;
        Ok(path)
    };
    FORMATS.iter().map(write).collect()
}

fn too_large() -> Failure {
    let sentence = "the displacements are too large to draw the deformed body as voxels; leave out output.volume";
    Failure::Failed(sentence.into())
}

fn deformed(problem: &Problem, displacement: &[f64]) -> Option<Volume> {
    let grid = problem.model.grid();
    let warped = warp(grid, displacement)?;
    let background = void_value(&problem.model);
    let value = |cell: Option<Cell>| {
        cell.map_or(background, |c| match &grid.young {
            Some(young) => young[c.0],
            None => f64::from(grid.labels[c.0].0),
        })
    };
    let values: Vec<f64> = warped.cells.iter().map(|cell| value(*cell)).collect();
    // A body without a scan lies in the world as the scene says; NIfTI and NRRD carry that as the identity in millimetres.
    let own = |offset: [isize; 3]| {
        let start: [f64; 3] =
            std::array::from_fn(|a| 1e3 * (grid.origin[a] + (offset[a] as f64 + 0.5) * grid.spacing[a]));
        axis_parallel(grid.spacing.map(|h| 1e3 * h), start)
    };
    let moved = problem.volume.as_ref().and_then(|volume| moved_world(problem, volume, warped.offset));
    Some(Volume {
        cells: warped.lattice.cells,
        spacing: Some(grid.spacing),
        voxel_to_world: Some(moved.unwrap_or_else(|| own(warped.offset))),
        integral: values.iter().all(|v| v.fract() == 0.0),
        values,
    })
}

/// The voxel-to-world matrix with these edges and the first voxel's centre at `start` \[mm\].
fn axis_parallel(edges: [f64; 3], start: [f64; 3]) -> [[f64; 4]; 4] {
    let row = |r: usize| {
        let mut row = [0.0, 0.0, 0.0, start[r]];
        row[r] = edges[r];
        row
    };
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

/// What voids hold: zero beside moduli; else the label of a void that no solid cell has, or −1.
fn void_value(model: &FineModel) -> f64 {
    let grid = model.grid();
    if grid.young.is_some() {
        return 0.0;
    }
    let labels = |void: bool| (0..grid.void.len()).filter(move |&c| grid.void[c] == void).map(|c| grid.labels[c]);
    let solid: BTreeSet<Label> = labels(false).collect();
    labels(true).find(|label| !solid.contains(label)).map_or(-1.0, |label| f64::from(label.0))
}

/// The voxel-to-world matrix of the source for voxels of the fine lattice, moved by `offset` of them.
fn moved_world(problem: &Problem, source: &Volume, offset: [isize; 3]) -> Option<[[f64; 4]; 4]> {
    let old = source.voxel_to_world?;
    let cells = problem.scene.body.resample.unwrap_or(source.cells);
    let ratio: [f64; 3] = std::array::from_fn(|a| source.cells[a] as f64 / cells[a] as f64);
    Some(moved_world_by(old, ratio, offset, problem.model.grid().spacing))
}

/// The voxel-to-world matrix `old` for voxels that are `ratio` times as long, `spacing` \[m\], the first `offset` of them away.
fn moved_world_by(old: [[f64; 4]; 4], ratio: [f64; 3], offset: [isize; 3], spacing: [f64; 3]) -> [[f64; 4]; 4] {
    // A spacing in the scene replaces the file's: columns get its length.
    let stretch: [f64; 3] = std::array::from_fn(|a| {
        1e3 * spacing[a] / ratio[a] / (0..3).map(|row| old[row][a].powi(2)).sum::<f64>().sqrt()
    });
    // New voxel i has its centre at (i + offset + 1/2) ratio − 1/2 voxels of the source.
    let shift: [f64; 3] = std::array::from_fn(|a| (offset[a] as f64 + 0.5) * ratio[a] - 0.5);
    let mut world = old;
    for row in 0..3 {
        (0..3).for_each(|a| world[row][a] = old[row][a] * stretch[a] * ratio[a]);
        world[row][3] = old[row][3] + (0..3).map(|a| old[row][a] * stretch[a] * shift[a]).sum::<f64>();
    }
    world
}
