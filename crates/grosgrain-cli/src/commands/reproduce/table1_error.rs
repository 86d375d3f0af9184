//! One figure of Table 1: the error that a training leaves on a beam.

use grosgrain::coarse::{BuildOptions, Method, build};
use grosgrain::dynamics::{FineSolution, relative_error, solve_coarse, solve_fine};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::mesh::Node;
use grosgrain::solver::SolverChoice;
use grosgrain::training::TrainingKind;

use super::bodies::{Heterogeneity, fine_model};
use super::setting::Setting;
use crate::failure::Failure;
use crate::outcome::failed;
use crate::progress::Progress;

/// A way to get training data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trainer {
    /// Harmonic displacements of the whole body, of the one-ring or of the cell: they see the body as it is.
    Stateless(TrainingKind),
    /// The published update: substructures coupled by forces that belong to the body of initialisation.
    Substructured,
    /// The default of updates during a run.
    Auto,
}

impl Trainer {
    /// All of them, in the order of the table.
    pub const ALL: [Self; 5] = [
        Self::Stateless(TrainingKind::Global),
        Self::Stateless(TrainingKind::OneRing),
        Self::Substructured,
        Self::Stateless(TrainingKind::SingleCell),
        Self::Auto,
    ];

    /// The one that others are compared with.
    pub const REFERENCE: Self = Self::Stateless(TrainingKind::OneRing);

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stateless(TrainingKind::Global) => "global",
            Self::Stateless(TrainingKind::OneRing) => "one-ring",
            Self::Stateless(TrainingKind::SingleCell) => "single-cell",
            Self::Substructured => "substructured",
            Self::Auto => "auto",
        }
    }

    /// Whether its error can depend on the [`Setting`].
    pub const fn has_history(self) -> bool {
        !matches!(self, Self::Stateless(_))
    }
}

/// A beam held at x = 0 under gravity, with its fine solution.
pub struct Case {
    /// Its degree.
    pub degree: usize,
    /// The fine model.
    pub model: FineModel,
    /// Which fine nodes are held.
    pub fixed: Vec<bool>,
    /// Weights of the fine nodes \[N\].
    pub loads: Vec<f64>,
    /// What coarse models are compared with.
    pub fine: FineSolution,
}

impl Case {
    /// Makes the beam and solves its fine model.
    pub fn solve(pattern: Heterogeneity, degree: usize, progress: &Progress) -> Result<Self, Failure> {
        let model = fine_model(pattern.beam(degree)?)?;
        let lattice = model.grid().lattice;
        let fixed: Vec<bool> = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 0).collect();
        let loads = gravity(&model, [0.0, 0.0, -9.81]);
        let report = |stage, done, total| progress.report(stage, done, total);
        let fine = solve_fine(&model, &fixed, &loads, SolverChoice::Auto, &report);
        progress.close();
        let fine = fine.map_err(|error| failed(&format!("the fine model: {error}")))?;
        Ok(Self { degree, model, fixed, loads, fine })
    }
}

/// RMS error in percent of the coarse model with this training, initialised as `setting` says and updated to the case; `None`
/// where this version does not have the training.
///
/// Every figure of Table 1 comes from here. A training with history needs an arm that initialises it on
/// [`Setting::initial`] and updates [`Setting::changed_cells`].
pub fn error(case: &Case, setting: Setting, trainer: Trainer, progress: &Progress) -> Result<Option<f64>, Failure> {
    match (trainer, setting) {
        (Trainer::Stateless(kind), _) => rebuilt(case, kind, progress).map(Some),
        (Trainer::Substructured | Trainer::Auto, _) => Ok(None),
    }
}

/// The error of a model that is built on the case from scratch.
fn rebuilt(case: &Case, kind: TrainingKind, progress: &Progress) -> Result<f64, Failure> {
    let report = |stage, done, total| progress.report(stage, done, total);
    let options = BuildOptions { method: Method::Trained(kind), ..BuildOptions::default() };
    let built = build(&case.model, case.degree, &options, &report);
    progress.close();
    let built = built.map_err(|error| failed(&error))?;
    let coarse = solve_coarse(&built.model, &case.fixed, &case.loads, &report);
    progress.close();
    let coarse = coarse.map_err(|error| failed(&format!("the coarse model: {error}")))?;
    Ok(100.0 * relative_error(&coarse.displacement, &case.fine.displacement))
}
