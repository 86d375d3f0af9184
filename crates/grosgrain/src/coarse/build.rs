//! From a fine model to a coarse one, stage by stage.

use std::time::Instant;

use super::CoarseModel;
use crate::coarsening::{BaseKind, Objective, ShapeFunctionError, ShapeFunctions};
use crate::fine::FineModel;
use crate::partition::{CellPart, CoarseMesh, Partition, PartitionError};
use crate::progress::Progress;
use crate::solver::SolveReport;
use crate::training::{Training, TrainingError, TrainingKind, train};

/// How the coarse cells get their stiffness and shape functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Coarse trilinear elements, materials integrated at the fine quadrature points.
    Trilinear,
    /// Coarse trilinear elements with the volume-averaged material.
    Average,
    /// Matrix shape functions from harmonic displacements.
    Trained(TrainingKind),
}

/// Options of [`build`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// The method.
    pub method: Method,
    /// Base functions of trained methods.
    pub base: BaseKind,
    /// How the fit is solved.
    pub objective: Objective,
    /// Whether coarse cells that fall into several parts get an element for each ([`CoarseMesh`]). If not, what is in one coarse cell
    /// moves together, and so does what meets a coarse node from either side of a gap.
    pub split: bool,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            method: Method::Trained(TrainingKind::OneRing),
            base: BaseKind::Harmonic,
            objective: Objective::ClosedForm,
            split: true,
        }
    }
}

/// Why there is no coarse model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The lattice cannot be cut.
    #[error(transparent)]
    Partition(#[from] PartitionError),
    /// Training failed.
    #[error(transparent)]
    Training(#[from] TrainingError),
    /// Fitting failed.
    #[error(transparent)]
    Fitting(#[from] ShapeFunctionError),
}

/// Where the time went, and what to be careful about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildReport {
    /// Seconds for the training displacements.
    pub training_seconds: f64,
    /// Seconds for the shape functions.
    pub fitting_seconds: f64,
    /// Seconds for the coarse stiffness and mass.
    pub assembly_seconds: f64,
    /// How the global harmonic displacements were solved, where there were any.
    pub training_solver: Option<SolveReport>,
    /// Elements that dropped dependent training fields: element and fields kept.
    pub rank_deficient: Vec<(CellPart, usize)>,
    /// Worst condition of the data constraints, with its element.
    pub worst_condition: Option<(CellPart, f64)>,
}

/// A coarse model with what it was made from.
#[derive(Clone, Debug)]
pub struct Built {
    /// The model.
    pub model: CoarseModel,
    /// The training data, for trained methods.
    pub training: Option<Training>,
    /// Timings and warnings.
    pub report: BuildReport,
}

/// Builds the coarse model of a fine one: train, fit, assemble.
///
/// # Errors
/// When the degree does not divide the lattice, a training problem or a fit is not solved, or the callback interrupts.
pub fn build(
    model: &FineModel,
    degree: usize,
    options: &BuildOptions,
    progress: Progress<'_>,
) -> Result<Built, BuildError> {
    let partition = Partition::new(model.grid().lattice, degree)?;
    let mesh = match options.split {
        true => CoarseMesh::new(&model.grid().void, &partition),
        false => CoarseMesh::unsplit(&model.grid().void, &partition),
    };
    let mut report = BuildReport::default();
    let start = Instant::now();
    let training = match options.method {
        Method::Trained(kind) => {
            let (training, solver) = train(model, &mesh, mesh.elements(), kind, progress)?;
            report.training_solver = solver;
            Some(training)
        }
        Method::Trilinear | Method::Average => None,
    };
    report.training_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let functions = match &training {
        Some(training) => ShapeFunctions::fit(model, &mesh, training, (options.base, options.objective), progress)?,
        None => ShapeFunctions::trilinear(&partition, mesh.elements()),
    };
    report.fitting_seconds = start.elapsed().as_secs_f64();
    report.note_fits(&functions);
    let start = Instant::now();
    let coarse = match options.method {
        Method::Average => CoarseModel::averaged(model, mesh, functions),
        _ => CoarseModel::galerkin(model, mesh, functions),
    };
    report.assembly_seconds = start.elapsed().as_secs_f64();
    Ok(Built { model: coarse, training, report })
}

impl BuildReport {
    fn note_fits(&mut self, functions: &ShapeFunctions) {
        for (index, &element) in functions.elements().iter().enumerate() {
            let Some(fit) = functions.fit_of(index) else { continue };
            if fit.rank < crate::coarsening::FIELDS {
                self.rank_deficient.push((element, fit.rank));
            }
            if self.worst_condition.is_none_or(|(_, worst)| fit.condition > worst) {
                self.worst_condition = Some((element, fit.condition));
            }
        }
    }
}
