//! The coarse model as an `.npz` archive that `numpy.load` opens.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use ndarray::{Array0, Array1, Array2, ArrayView1, ArrayView3, ArrayView4, ShapeError, arr0};
use ndarray_npy::{NpzWriter, WriteNpzError};
use zip::CompressionMethod;
use zip::write::SimpleFileOptions;

use super::write_atomically;
use crate::coarse::CoarseModel;
use crate::coarsening::COLUMNS;
use crate::fine::FineModel;
use crate::mesh::Cell;
use crate::training::Training;

/// Layout of the archive; it grows when an array changes its meaning or goes.
pub const MODEL_VERSION: u32 = 1;

/// Why a model was not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelWriteError {
    /// The file system refused.
    #[error("the model cannot be written: {0}")]
    Io(#[from] io::Error),
    /// The archive could not be made.
    #[error("the model cannot be written: {0}")]
    Archive(#[from] WriteNpzError),
    /// The parts of the model do not fit each other.
    #[error("the model's arrays do not fit each other: {0}")]
    Shape(#[from] ShapeError),
}

/// Writes a coarse model of n elements and m vertices with degree d. A coarse cell in several parts has several elements, which follow
/// each other; vertices may stand at the same place.
///
/// | array | shape | |
/// |---|---|---|
/// | `degree` | () | d |
/// | `spacing`, `origin` | (3,) | fine cell size and position of the lattice's first node \[m\] |
/// | `cells` | (n, 3) | coarse indices i, j, k |
/// | `part` | (n,) | number of the part of that coarse cell |
/// | `corners` | (n, 8) | rows of `nodes`, x fastest |
/// | `nodes` | (m, 3) | positions \[m\] |
/// | `labels`, `void` | (nz, ny, nx) | of the fine cells |
/// | `shape_functions` | (n, (d+1)³, 3, 24) | row = component of the fine displacement, column = 3·corner + component |
/// | `stiffness` | (n, 24, 24) | \[N/m\] |
/// | `mass` | (m,) | \[kg\] |
/// | `training` | (n, 3(d+1)³, fields) | training displacements; no fields where there was no training |
/// | `version` | () | [`MODEL_VERSION`] |
///
/// # Errors
/// When the file cannot be written; nothing is left behind then.
pub fn write_model(
    path: &Path,
    model: &FineModel,
    coarse: &CoarseModel,
    training: Option<&Training>,
) -> Result<(), ModelWriteError> {
    write_atomically(path, |writer| write_arrays(writer, model, coarse, training))
}

fn write_arrays(
    writer: &mut BufWriter<File>,
    model: &FineModel,
    coarse: &CoarseModel,
    training: Option<&Training>,
) -> Result<(), ModelWriteError> {
    let mut archive = NpzWriter::new_with_options(writer, stored());
    let grid = model.grid();
    let [nx, ny, nz] = grid.lattice.cells;
    let labels: Vec<i32> = grid.labels.iter().map(|label| label.0).collect();
    archive.add_array("degree", &scalar(coarse.partition().degree() as i64))?;
    archive.add_array("version", &scalar(i64::from(MODEL_VERSION)))?;
    archive.add_array("spacing", &Array1::from(grid.spacing.to_vec()))?;
    archive.add_array("origin", &Array1::from(grid.origin.to_vec()))?;
    archive.add_array("labels", &ArrayView3::from_shape((nz, ny, nx), &labels)?)?;
    archive.add_array("void", &ArrayView3::from_shape((nz, ny, nx), &grid.void)?)?;
    write_topology(&mut archive, model, coarse)?;
    let (n, rows) = (coarse.elements().len(), coarse.functions().rows());
    let functions: Vec<f64> = coarse.functions().iter().flatten().copied().collect();
    archive.add_array("shape_functions", &ArrayView4::from_shape((n, rows / 3, 3, COLUMNS), &functions)?)?;
    let stiffness: Vec<f64> = (0..n).flat_map(|index| coarse.stiffness(index).iter().copied()).collect();
    archive.add_array("stiffness", &ArrayView3::from_shape((n, COLUMNS, COLUMNS), &stiffness)?)?;
    let data: Vec<f64> = training.iter().flat_map(|t| t.iter().flatten().copied()).collect();
    let fields = training.map_or(0, Training::fields);
    archive.add_array("training", &ArrayView3::from_shape((n, rows, fields), &data)?)?;
    archive.finish()?;
    Ok(())
}

fn write_topology(
    archive: &mut NpzWriter<&mut BufWriter<File>>,
    model: &FineModel,
    coarse: &CoarseModel,
) -> Result<(), ModelWriteError> {
    let (mesh, partition) = (coarse.mesh(), coarse.partition());
    let (n, m) = (mesh.elements().len(), mesh.vertices().len());
    let at = mesh.elements().iter().flat_map(|e| partition.coarse().cell_position(Cell(e.cell.0)).map(|x| x as i64));
    let part = mesh.elements().iter().map(|e| i64::from(e.part));
    let corners = mesh.corners().iter().flatten().map(|vertex| i64::from(*vertex));
    let position = mesh.vertices().iter().flat_map(|v| model.node_position(partition.coincident_node(v.node)));
    archive.add_array("cells", &Array2::from_shape_vec((n, 3), at.collect())?)?;
    archive.add_array("part", &Array1::from_iter(part))?;
    archive.add_array("corners", &Array2::from_shape_vec((n, 8), corners.collect())?)?;
    archive.add_array("nodes", &Array2::from_shape_vec((m, 3), position.collect())?)?;
    archive.add_array("mass", &ArrayView1::from(coarse.mass()))?;
    Ok(())
}

/// Uncompressed entries that may exceed 4 GiB.
pub(super) fn stored() -> SimpleFileOptions {
    SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true)
}

fn scalar(value: i64) -> Array0<i64> {
    arr0(value)
}
