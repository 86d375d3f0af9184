//! The coarse model of a method.

use std::time::Instant;

use grosgrain::homogenization::{
    Blending, CoarseSimplexModel, Downsampling, HarmonicMap, HarmonicOptions, HomogenizeOptions, Homogenized,
    coarse_model, homogenize,
};

use super::doubts::tell_doubts;
use super::method::MeshMethod;
use super::problem::MeshProblem;
use crate::failure::Failure;
use crate::outcome::failed;
use crate::progress::Progress;
use crate::quantities::counted;

/// A coarse mesh with the materials of a method.
#[derive(Clone, Debug)]
pub struct CoarseMade {
    /// The mesh with its materials, and the masses of its nodes.
    pub coarse: CoarseSimplexModel,
    /// The harmonic map to the fine mesh and its blending, where the scene asks for it and there are harmonic displacements.
    pub map: Option<(HarmonicMap, Blending)>,
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
        return Ok(CoarseMade { coarse, map: map_of(problem, &found, progress), seconds: found.seconds });
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
    Ok(CoarseMade { coarse, map: None, seconds: [0.0, 0.0, start.elapsed().as_secs_f64()] })
}

fn map_of(problem: &MeshProblem, found: &Homogenized, progress: &Progress) -> Option<(HarmonicMap, Blending)> {
    let blending = problem.scene.mesh_coarsening.map?;
    let fields = (&problem.coarse, &found.downsampled.fields);
    let map = HarmonicMap::new(&found.harmonic, fields, problem.embedding.clone());
    let rest = vec![0.0; 3 * problem.coarse.nodes().len()];
    let without = map.map(&rest, blending).barycentric.len();
    if without > 0 {
        progress.say(&format!(
            "the harmonic displacements of {} are not independent: fine nodes there follow the barycentric map",
            counted(without, "coarse cell")
        ));
    }
    Some((map, blending))
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
    let untried = [
        (coarsening.downsampling == Downsampling::AtNodes, "downsampling = \"fitted\" in [coarsening]"),
        (!coarsening.held, "held = true in [coarsening]"),
    ];
    let remedies: Vec<&str> = untried.into_iter().filter(|(is_untried, _)| *is_untried).map(|(_, what)| what).collect();
    tell_doubts(&found, &remedies, progress);
    Ok(found)
}
