//! The coarse model of a method.

use std::time::Instant;

use grosgrain::homogenization::{
    CoarseSimplexModel, HarmonicOptions, HomogenizeOptions, Homogenized, coarse_model, homogenize,
};

use super::method::MeshMethod;
use super::problem::MeshProblem;
use crate::failure::Failure;
use crate::outcome::failed;
use crate::progress::Progress;
use crate::quantities::{counted, number};

/// Tensors that are so many times stiffer than the volume average are told.
pub const SUSPICIOUS_STIFFENING: f64 = 2.0;

/// A coarse mesh with the materials of a method.
#[derive(Clone, Debug)]
pub struct CoarseMade {
    /// The mesh with its materials, and the masses of its nodes.
    pub coarse: CoarseSimplexModel,
    /// Seconds: harmonic displacements; intersections; everything else.
    pub seconds: [f64; 3],
}

/// The coarse model of a method.
///
/// # Errors
/// The method `fine`; what the homogenization refuses; an interruption.
pub fn coarse_of(problem: &MeshProblem, method: MeshMethod, progress: &Progress) -> Result<CoarseMade, Failure> {
    let Some(materials) = method.coarse_materials() else {
        let sentence = "the method fine has no coarse model; expected tensor, average, trilinear or sampled";
        return Err(Failure::Unusable(sentence.into()));
    };
    if method == MeshMethod::Tensor {
        let found = homogenized(problem, progress)?;
        let coarse = CoarseSimplexModel::effective(&problem.coarse, &found).map_err(|error| failed(&error))?;
        return Ok(CoarseMade { coarse, seconds: found.seconds });
    }
    let start = Instant::now();
    let report = |stage, done, total| progress.report(stage, done, total);
    let made = coarse_model(&problem.fine, &problem.coarse, materials, &HomogenizeOptions::default(), &report);
    progress.close();
    let coarse = made.map_err(|error| failed(&format!("{}: {error}", problem.scene.file.display())))?;
    if let [first, ..] = coarse.nearest[..] {
        progress.warn(&format!(
            "no quadrature point of {} lies in the body, the first being cell {first}; the nearest material stands in for them",
            counted(coarse.nearest.len(), "coarse cell")
        ));
    }
    Ok(CoarseMade { coarse, seconds: [0.0, 0.0, start.elapsed().as_secs_f64()] })
}

/// Effective tensors and masses of the coarse mesh, as the scene's `[coarsening]` asks for them.
///
/// # Errors
/// What [`homogenize`] refuses; an interruption.
pub fn homogenized(problem: &MeshProblem, progress: &Progress) -> Result<Homogenized, Failure> {
    let report = |stage, done, total| progress.report(stage, done, total);
    let coarsening = &problem.scene.mesh_coarsening;
    let held = match coarsening.held {
        true => problem.conditions.nodal.holds.fixed_at(0.0, problem.fine.mesh().nodes().len()),
        false => Vec::new(),
    };
    let harmonic = HarmonicOptions { held, ..HarmonicOptions::default() };
    let options = HomogenizeOptions { harmonic, downsampling: coarsening.downsampling, ..HomogenizeOptions::default() };
    let found = homogenize(&problem.fine, &problem.coarse, &options, &report);
    progress.close();
    let found = found.map_err(|error| failed(&format!("{}: {error}", problem.scene.file.display())))?;
    tell_doubts(&found, progress);
    Ok(found)
}

fn tell_doubts(found: &Homogenized, progress: &Progress) {
    let effective = &found.effective;
    if let [first, ..] = effective.averaged[..] {
        progress.warn(&format!(
            "in {}, the first being cell {first}, the harmonic displacements do not determine all strains; the volume average stands in for them",
            counted(effective.averaged.len(), "coarse cell")
        ));
    }
    let stiffened = effective.stiffening.iter().filter(|s| **s > SUSPICIOUS_STIFFENING).count();
    if stiffened > 0 {
        let worst = effective.stiffening.iter().copied().fold(0.0, f64::max);
        progress.warn(&format!(
            "the tensors of {} are more than twice as stiff as the volume average of the material, which nothing can be; at worst {} times: coarse \
             nodes there move less than the body around them. Try downsampling = \"fitted\" or held = true in [coarsening], or other coarse nodes",
            counted(stiffened, "coarse cell"),
            number(worst)
        ));
    }
}
