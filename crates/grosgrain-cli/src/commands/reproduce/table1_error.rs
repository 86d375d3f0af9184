//! One figure of Table 1: the error that a training leaves on a beam.

use grosgrain::coarse::{BuildOptions, CoarseModel, Method, build};
use grosgrain::dynamics::{FineSolution, relative_error, solve_coarse, solve_fine};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::mesh::{Cell, Label, Node};
use grosgrain::solver::SolverChoice;
use grosgrain::training::{RunTimeTraining, TrainingKind};
use grosgrain::update::{Change, Edit, LiveModel, LiveOptions, Region};

use super::bodies::{Heterogeneity, PHASES, fine_model};
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
            Self::Substructured | Self::Stateless(TrainingKind::Substructured) => "substructured",
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

/// RMS error in percent of the coarse model with this training, initialised as `setting` says and updated to the case.
///
/// Every figure of Table 1 comes from here.
pub fn error(case: &Case, setting: Setting, trainer: Trainer, progress: &Progress) -> Result<f64, Failure> {
    match trainer {
        Trainer::Stateless(kind) => rebuilt(case, kind, progress),
        Trainer::Substructured => updated(case, setting, RunTimeTraining::Fixed(TrainingKind::Substructured), progress),
        Trainer::Auto => updated(case, setting, RunTimeTraining::default(), progress),
    }
}

/// The error of a model that is built on the body of initialisation and then updated to the case, in one update.
fn updated(case: &Case, setting: Setting, training: RunTimeTraining, progress: &Progress) -> Result<f64, Failure> {
    let report = |stage, done, total| progress.report(stage, done, total);
    let target = case.model.grid();
    let initial = setting.initial(target, case.degree)?;
    let differs = |label: &Label| -> Vec<Cell> {
        let is_new = |c: &usize| target.labels[*c] == *label && initial.labels[*c] != *label;
        (0..target.labels.len()).filter(is_new).map(Cell).collect()
    };
    let edits: Vec<Edit> = PHASES
        .iter()
        .map(|label| Edit { region: Region::Cells(differs(label)), change: Change::Material(*label) })
        .filter(|edit| !matches!(&edit.region, Region::Cells(cells) if cells.is_empty()))
        .collect();
    let options = LiveOptions { training, ..LiveOptions::default() };
    let live = LiveModel::new(fine_model(initial)?, case.degree, &options, case.fixed.clone(), &report);
    progress.close();
    let mut live = live.map_err(|error| failed(&error))?;
    let update = live.apply_all(&edits, &report);
    progress.close();
    update.map_err(|error| failed(&error))?;
    solved(case, live.coarse(), progress)
}

/// The error of a model that is built on the case from scratch.
fn rebuilt(case: &Case, kind: TrainingKind, progress: &Progress) -> Result<f64, Failure> {
    let report = |stage, done, total| progress.report(stage, done, total);
    let options = BuildOptions { method: Method::Trained(kind), ..BuildOptions::default() };
    let built = build(&case.model, case.degree, &options, &report);
    progress.close();
    let built = built.map_err(|error| failed(&error))?;
    solved(case, &built.model, progress)
}

/// The error of a coarse model under the loads of the case.
fn solved(case: &Case, model: &CoarseModel, progress: &Progress) -> Result<f64, Failure> {
    let report = |stage, done, total| progress.report(stage, done, total);
    let coarse = solve_coarse(model, &case.fixed, &case.loads, &report);
    progress.close();
    let coarse = coarse.map_err(|error| failed(&format!("the coarse model: {error}")))?;
    Ok(100.0 * relative_error(&coarse.displacement, &case.fine.displacement))
}
