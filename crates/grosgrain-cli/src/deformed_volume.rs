//! The deformed body as a volume file.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use grosgrain::fine::FineModel;
use grosgrain::io::write_volume;
use grosgrain::mesh::{Cell, Label, Volume, warp};

use crate::failure::Failure;
use crate::problem::Problem;

/// Writes the labels (or the moduli, where there is one per voxel) of the deformed body into `deformed.nii.gz`.
///
/// # Errors
/// A deformation too large for voxels; a file that cannot be written.
pub fn write(problem: &Problem, displacement: &[f64], folder: &Path) -> Result<PathBuf, Failure> {
    let path = folder.join("deformed.nii.gz");
    let Some(volume) = deformed(problem, displacement) else {
        let sentence = "the displacements are too large to draw the deformed body as voxels; leave out output.volume";
        return Err(Failure::Failed(sentence.into()));
    };
    write_volume(&path, &volume)?;
    Ok(path)
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
    let world = problem.volume.as_ref().and_then(|volume| moved_world(problem, volume, warped.offset));
    Some(Volume {
        cells: warped.lattice.cells,
        spacing: Some(grid.spacing),
        voxel_to_world: world,
        integral: values.iter().all(|v| v.fract() == 0.0),
        values,
    })
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
    // Fine voxel i has its centre at (i + offset + 1/2) ratio − 1/2 voxels of the source.
    let shift: [f64; 3] = std::array::from_fn(|a| (offset[a] as f64 + 0.5) * ratio[a] - 0.5);
    // A spacing in the scene replaces the file's: columns get its length.
    let given = problem.scene.body.spacing;
    let stretch: [f64; 3] = std::array::from_fn(|a| match given {
        Some(spacing) => 1e3 * spacing[a] / (0..3).map(|row| old[row][a].powi(2)).sum::<f64>().sqrt(),
        None => 1.0,
    });
    let old: [[f64; 4]; 4] =
        std::array::from_fn(|row| std::array::from_fn(|a| if a < 3 { old[row][a] * stretch[a] } else { old[row][a] }));
    let mut world = old;
    for row in 0..3 {
        (0..3).for_each(|a| world[row][a] = old[row][a] * ratio[a]);
        world[row][3] = old[row][3] + (0..3).map(|a| old[row][a] * shift[a]).sum::<f64>();
    }
    Some(world)
}
