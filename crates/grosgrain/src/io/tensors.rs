//! Effective tensors as an `.npz` archive that `numpy.load` opens.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use ndarray::{Array1, Array2, Array3, ArrayView1, arr0};
use ndarray_npy::NpzWriter;

use super::model::{ModelWriteError, stored};
use super::write_atomically;
use crate::homogenization::Homogenized;
use crate::simplex::SimplexMesh;

/// Layout of the archive; it grows when an array changes its meaning or goes.
pub const TENSORS_VERSION: u32 = 1;

/// Writes the effective tensors of n coarse cells with m nodes, homogenized from a mesh of M nodes, in d dimensions with s = d (d + 1) / 2 strains.
///
/// | array | shape | |
/// |---|---|---|
/// | `nodes` | (m, 3) | positions \[m\] |
/// | `tets` | (n, d + 1) | rows of `nodes` |
/// | `tensors` | (n, s, s) | Voigt, order xx, yy, zz, yz, xz, xy (xx, yy, xy in the plane), engineering shear \[Pa\] |
/// | `mass` | (m,) | \[kg\] |
/// | `condition` | (n,) | of the coarse mollifier |
/// | `filled` | (n,) | share of the cell that the fine mesh fills |
/// | `harmonic` | (M, 3, s) | harmonic displacements of the fine nodes under unit stresses ½ (e_α ⊗ e_β + e_β ⊗ e_α), columns in the order of the strains \[m/Pa\] |
/// | `version` | () | [`TENSORS_VERSION`] |
///
/// # Errors
/// When the file cannot be written; nothing is left behind then.
pub fn write_tensors(path: &Path, coarse: &SimplexMesh, homogenized: &Homogenized) -> Result<(), ModelWriteError> {
    write_atomically(path, |writer| write_arrays(writer, coarse, homogenized))
}

fn write_arrays(
    writer: &mut BufWriter<File>,
    coarse: &SimplexMesh,
    homogenized: &Homogenized,
) -> Result<(), ModelWriteError> {
    let mut archive = NpzWriter::new_with_options(writer, stored());
    let (n, corners, strains) = (coarse.cell_count(), coarse.dimension().corners(), coarse.dimension().strains());
    let nodes = coarse.nodes().as_flattened().to_vec();
    let tets = (0..n).flat_map(|cell| coarse.cell(cell).iter().map(|node| i64::from(*node)));
    let entries = homogenized.effective.tensors.iter().flat_map(|tensor| {
        let voigt = tensor.voigt();
        (0..strains * strains).map(move |e| voigt[e / strains][e % strains])
    });
    let fields = &homogenized.harmonic.fields;
    let harmonic = fields.iter().flat_map(|node| node.iter().flat_map(|row| row[..strains].iter().copied()));
    archive.add_array("version", &arr0(i64::from(TENSORS_VERSION)))?;
    archive.add_array("nodes", &Array2::from_shape_vec((coarse.nodes().len(), 3), nodes)?)?;
    archive.add_array("tets", &Array2::from_shape_vec((n, corners), tets.collect())?)?;
    archive.add_array("tensors", &Array3::from_shape_vec((n, strains, strains), entries.collect())?)?;
    archive.add_array("mass", &ArrayView1::from(&homogenized.mass))?;
    archive.add_array("condition", &Array1::from(homogenized.effective.condition.clone()))?;
    archive.add_array("filled", &ArrayView1::from(&homogenized.filled))?;
    archive.add_array("harmonic", &Array3::from_shape_vec((fields.len(), 3, strains), harmonic.collect())?)?;
    archive.finish()?;
    Ok(())
}
