//! What KMOD09 (`kharevych2009numerical`) shows of effective tensors.

pub mod composite;
pub mod crack;
mod errors;
mod falling;
pub mod homogeneous;
mod laminate;
pub mod layers;
mod pair;
mod pictures;
mod played;
pub mod springs;

pub use falling::{cheese, liver};

use grosgrain::homogenization::{HomogenizeOptions, Homogenized, SimplexModel, homogenize};
use grosgrain::simplex::{MandelTensor, SimplexMesh};

use super::Study;
use crate::failure::Failure;

/// A body with this tensor per cell, of density 1000.
fn body(mesh: SimplexMesh, tensors: Vec<MandelTensor>) -> Result<SimplexModel, Failure> {
    let densities = vec![1000.0; mesh.cell_count()];
    SimplexModel::with_tensors(mesh, tensors, densities).map_err(|error| Failure::Failed(error.to_string()))
}

fn homogenized(study: &Study, model: &SimplexModel, coarse: &SimplexMesh) -> Result<Homogenized, Failure> {
    let report = |name, done, total| study.progress.report(name, done, total);
    homogenize(model, coarse, &HomogenizeOptions::default(), &report)
        .map_err(|error| Failure::Failed(error.to_string()))
}

/// The largest entry of the difference over the largest of the second.
fn difference(a: &MandelTensor, b: &MandelTensor) -> f64 {
    let largest =
        |m: &dyn Fn(usize, usize) -> f64| (0..36).fold(0.0f64, |largest, e| largest.max(m(e / 6, e % 6).abs()));
    largest(&|i, j| a.matrix[i][j] - b.matrix[i][j]) / largest(&|i, j| b.matrix[i][j])
}
