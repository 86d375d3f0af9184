//! The deformed body as a volume file.

use std::path::{Path, PathBuf};

use grosgrain::fine::FineModel;
use grosgrain::io::write_volume;
use grosgrain::mesh::{Volume, warp};

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
    let value = |cell: Option<grosgrain::mesh::Cell>| {
        cell.map_or(void_value(&problem.model), |c| match &grid.young {
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

/// What voids hold: zero beside moduli, the label of a void where one is declared, else −1.
fn void_value(model: &FineModel) -> f64 {
    let grid = model.grid();
    let declared = (0..grid.void.len()).find(|&c| grid.void[c]);
    match (&grid.young, declared) {
        (Some(_), _) => 0.0,
        (None, Some(c)) => f64::from(grid.labels[c].0),
        (None, None) => -1.0,
    }
}

/// The voxel-to-world matrix of the source for voxels of the fine lattice, moved by `offset` of them.
fn moved_world(problem: &Problem, source: &Volume, offset: [isize; 3]) -> Option<[[f64; 4]; 4]> {
    let old = source.voxel_to_world?;
    let cells = problem.scene.body.resample.unwrap_or(source.cells);
    let ratio: [f64; 3] = std::array::from_fn(|a| source.cells[a] as f64 / cells[a] as f64);
    // Fine voxel i has its centre at (i + offset + 1/2) ratio − 1/2 voxels of the source.
    let shift: [f64; 3] = std::array::from_fn(|a| (offset[a] as f64 + 0.5) * ratio[a] - 0.5);
    let mut world = old;
    for row in 0..3 {
        (0..3).for_each(|a| world[row][a] = old[row][a] * ratio[a]);
        world[row][3] = old[row][3] + (0..3).map(|a| old[row][a] * shift[a]).sum::<f64>();
    }
    Some(world)
}
