//! The whole chain from a fine mesh to the tensors of a coarse one.

use std::time::Instant;

use super::averages::mean_densities;
use super::{
    Downsampled, EffectiveError, EffectiveOptions, EffectiveTensors, HarmonicDisplacements, HarmonicError,
    HarmonicOptions, HarmonicReport, SimplexEmbedding, SimplexModel, bounding_normals, downsample, effective_tensors,
    fit_downsampled, harmonic_displacements, lumped_mass,
};
use crate::linalg::CholeskyError;
use crate::progress::Progress;
use crate::simplex::{BoundaryError, Locator, OverlapError, Overlaps, SimplexMesh};

/// Along which normals the boundary is loaded for harmonic displacements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BoundaryNormals {
    /// Those of the fine mesh itself, or what [`HarmonicOptions::normals`] holds: a homogeneous body keeps its material wherever the coarse nodes lie.
    #[default]
    Fine,
    /// Those of the bounding faces of the coarse mesh, whose basis functions test the solution there (KMOD09 §4.2). They balance only where the two boundaries
    /// are parallel.
    Coarse,
}

/// How harmonic displacements are taken to the coarse mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Downsampling {
    /// Their values at the coarse nodes, as published: exact where coarse nodes cut a fine structure where it repeats, and for soft slices between stiff blocks.
    #[default]
    AtNodes,
    /// The coarse fields closest to them in the mean over the body ([`fit_downsampled`]): for fine structures that coarse nodes meet anywhere.
    Fitted,
}

/// Options of [`homogenize`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HomogenizeOptions {
    /// Along which normals the boundary is loaded.
    pub normals: BoundaryNormals,
    /// How harmonic displacements are held; its normals serve with [`BoundaryNormals::Fine`] only.
    pub harmonic: HarmonicOptions,
    /// How they are taken to the coarse mesh.
    pub downsampling: Downsampling,
    /// When a coarse mollifier counts as singular.
    pub effective: EffectiveOptions,
}

/// A coarse mesh with the properties of a fine one.
#[derive(Clone, Debug, PartialEq)]
pub struct Homogenized {
    /// Harmonic displacements of the fine mesh.
    pub harmonic: HarmonicDisplacements,
    /// What it took to find them.
    pub report: HarmonicReport,
    /// The same on the coarse mesh.
    pub downsampled: Downsampled,
    /// Elasticity of the coarse cells.
    pub effective: EffectiveTensors,
    /// Mass \[kg\] of the coarse nodes.
    pub mass: Vec<f64>,
    /// Mean density \[kg/m³\] of each coarse cell, voids included.
    pub density: Vec<f64>,
    /// Share of each coarse cell that the fine mesh fills.
    pub filled: Vec<f64>,
    /// Seconds: harmonic displacements; intersections; everything else.
    pub seconds: [f64; 3],
}

/// Why a mesh was not homogenized.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HomogenizeError {
    /// The meshes have nothing in common.
    #[error(transparent)]
    Overlap(#[from] OverlapError),
    /// A boundary is none.
    #[error(transparent)]
    Boundary(#[from] BoundaryError),
    /// Harmonic displacements were not found.
    #[error(transparent)]
    Harmonic(#[from] HarmonicError),
    /// The coarse fields closest to the harmonic displacements were not found.
    #[error("the harmonic displacements were not fitted on the coarse mesh: {0}")]
    Fit(#[from] CholeskyError),
    /// Tensors were not found.
    #[error(transparent)]
    Effective(#[from] EffectiveError),
}

/// Effective tensors and masses of the cells of `coarse`: harmonic displacements of the fine model, taken at the coarse nodes, and energies averaged over exact
/// intersections (KMOD09, `kharevych2009numerical`).
///
/// # Errors
/// Meshes of different kinds or places; what [`harmonic_displacements`] and [`effective_tensors`] refuse; an interruption.
pub fn homogenize(
    model: &SimplexModel,
    coarse: &SimplexMesh,
    options: &HomogenizeOptions,
    progress: Progress<'_>,
) -> Result<Homogenized, HomogenizeError> {
    let fine = model.mesh();
    let start = Instant::now();
    let overlaps = Overlaps::new(fine, coarse)?;
    let intersecting = start.elapsed().as_secs_f64();
    let mut loading = options.harmonic.clone();
    if options.normals == BoundaryNormals::Coarse {
        loading.normals = bounding_normals(fine, coarse)?;
    }
    let (harmonic, report) = harmonic_displacements(model, &loading, progress)?;
    let solved = start.elapsed().as_secs_f64();
    let locator = Locator::new(coarse);
    let mut downsampled = downsample(&Locator::new(fine), &harmonic, coarse);
    if options.downsampling == Downsampling::Fitted {
        let embedding = SimplexEmbedding::new(fine, &locator);
        downsampled = fit_downsampled((fine, &harmonic), (coarse, &embedding), &downsampled)?;
    }
    let effective =
        effective_tensors((model, &harmonic), (coarse, &downsampled.fields), &overlaps, &options.effective)?;
    let mass = lumped_mass(model, &locator, &overlaps);
    let filled = (0..coarse.cell_count()).map(|q| overlaps.filled(q)).collect();
    let density = mean_densities(model, coarse, &overlaps);
    let rest = start.elapsed().as_secs_f64() - solved;
    Ok(Homogenized {
        harmonic,
        report,
        downsampled,
        effective,
        mass,
        density,
        filled,
        seconds: [solved - intersecting, intersecting, rest],
    })
}
