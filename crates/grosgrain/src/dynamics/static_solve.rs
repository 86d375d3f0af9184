//! Static equilibrium of the fine and of the coarse model under the same loads.

use crate::assembly::Constraints;
use crate::coarse::{CoarseModel, Embedding, SupportedCoarse};
use crate::fine::FineModel;
use crate::partition::CoarseMesh;
use crate::progress::Progress;
use crate::solver::{ElementSystem, Hold, LatticeSystem, SolveReport, SolverChoice, SolverError};

/// Equilibrium of the fine model.
#[derive(Clone, Debug)]
pub struct FineSolution {
    /// Displacement \[m\], 3 entries per fine lattice node, zero at void nodes.
    pub displacement: Vec<f64>,
    /// Elastic energy ½ uᵀ K u = ½ fᵀ u \[J\].
    pub energy: f64,
    /// How it was solved.
    pub report: SolveReport,
}

/// Equilibrium of a coarse model.
#[derive(Clone, Debug)]
pub struct CoarseSolution {
    /// Displacement \[m\], 3 entries per vertex.
    pub coarse_displacement: Vec<f64>,
    /// The same on the fine nodes, averaged where elements meet \[m\].
    pub displacement: Vec<f64>,
    /// Work ½ f̄ᵀ ū of the loads: the elastic energy ½ ūᵀ K̄ ū, and the little that a penalty holds where there is one \[J\].
    pub energy: f64,
    /// Number of fixed fine nodes that no fixed vertex holds and that a penalty holds on average.
    pub held_by_penalty: usize,
    /// How it was solved.
    pub report: SolveReport,
}

/// Solves K u = f with the marked fine nodes fixed; `loads` has 3 forces \[N\] per fine lattice node.
///
/// # Errors
/// When the system is singular or not solved to a relative residual of 1e-8.
pub fn solve_fine(
    model: &FineModel,
    fixed: &[bool],
    loads: &[f64],
    choice: SolverChoice,
    progress: Progress<'_>,
) -> Result<FineSolution, SolverError> {
    let constraints = Constraints::nodes(fixed);
    let system = LatticeSystem { cells: model, spacing: model.grid().spacing, hold: Hold::Fixed(&constraints) };
    let mut displacement = loads.to_vec();
    let report = system.solve(choice, &mut displacement, progress)?;
    let energy = 0.5 * work(loads, &displacement);
    Ok(FineSolution { displacement, energy, report })
}

/// Solves K̄ ū = Aᵀ f on the coarse model, held where the marked fine nodes are, and embeds the result.
///
/// Where the coarse mesh is a lattice the solvers of lattices serve; else the elements are assembled and factored.
///
/// # Errors
/// When a part of the model is held by nothing, or the system is singular or not solved to a relative residual of 1e-8.
pub fn solve_coarse(
    coarse: &CoarseModel,
    fixed: &[bool],
    loads: &[f64],
    progress: Progress<'_>,
) -> Result<CoarseSolution, SolverError> {
    let embedding = Embedding::new(coarse);
    let supported = SupportedCoarse::new(coarse, &embedding, fixed);
    let coarse_loads = embedding.restrict(loads);
    let (coarse_displacement, report) = match supported.as_lattice() {
        Some(lattice) => {
            let constraints = lattice.constraints(&supported.constraints);
            let system = LatticeSystem { cells: &lattice, spacing: coarse.spacing(), hold: Hold::Fixed(&constraints) };
            let mut solution = lattice.from_vertices(&coarse_loads);
            let report = system.solve(SolverChoice::Auto, &mut solution, progress)?;
            (lattice.to_vertices(&solution), report)
        }
        None => solve_elements(&supported, coarse.mesh(), &coarse_loads)?,
    };
    Ok(CoarseSolution {
        displacement: embedding.prolong(&coarse_displacement),
        energy: 0.5 * work(&coarse_loads, &coarse_displacement),
        held_by_penalty: supported.held_by_penalty,
        coarse_displacement,
        report,
    })
}

fn solve_elements(
    supported: &SupportedCoarse<'_>,
    mesh: &CoarseMesh,
    loads: &[f64],
) -> Result<(Vec<f64>, SolveReport), SolverError> {
    supported.require_held()?;
    let mut system = ElementSystem::new(mesh.elimination_order(), mesh.corners())?;
    system.factor(|index| supported.stiffness(index), &supported.constraints)?;
    let mut solution = loads.to_vec();
    let report = SolveReport {
        kind: "cholesky",
        reason: "coarse cells or nodes are split".into(),
        unknowns: system.unknowns(),
        iterations: 0,
        relative_residual: system.solve(&mut solution)?,
    };
    Ok((solution, report))
}

fn work(loads: &[f64], displacement: &[f64]) -> f64 {
    loads.iter().zip(displacement).map(|(f, u)| f * u).sum()
}

/// ‖u − v‖ / ‖v‖ over the entries of two displacement fields; 0 where both vanish, infinite where only v does.
pub fn relative_error(displacement: &[f64], reference: &[f64]) -> f64 {
    let (mut difference, mut size) = (0.0, 0.0);
    for (u, v) in displacement.iter().zip(reference) {
        difference += (u - v) * (u - v);
        size += v * v;
    }
    match difference == 0.0 {
        true => 0.0,
        false => (difference / size).sqrt(),
    }
}
