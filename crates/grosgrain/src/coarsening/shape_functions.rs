//! Shape functions of all coarse cells of a model.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::base::MaterialBase;
use super::{BaseFunctions, BaseKind, COLUMNS, CoupledError, FittedCell, Fitter, fit_coupled};
use crate::assembly::Window;
use crate::fine::FineModel;
use crate::mesh::Cell;
use crate::partition::{CoarseCell, Partition};
use crate::progress::Progress;
use crate::solver::SolverError;
use crate::training::Training;

/// How the constrained optimisation is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Objective {
    /// In closed form ([`Fitter`]).
    #[default]
    ClosedForm,
    /// As one sparse saddle-point system per cell ([`fit_coupled`]), the baseline.
    Coupled,
}

/// Why shape functions were not found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeFunctionError {
    /// The base functions were not found.
    #[error("the base functions of coarse cell ({}, {}, {}) were not found: {source}", at[0], at[1], at[2])]
    Base {
        /// Position of the coarse cell.
        at: [usize; 3],
        /// Why.
        source: SolverError,
    },
    /// The coupled system was not solved.
    #[error("coarse cell ({}, {}, {}): {source}", at[0], at[1], at[2])]
    Coupled {
        /// Position of the coarse cell.
        at: [usize; 3],
        /// Why.
        source: CoupledError,
    },
    /// The coupled optimisation is stated for the harmonic base only.
    #[error(
        "the coupled objective minimises the Dirichlet energy, whose base is \"harmonic\"; choose base = \"harmonic\" or objective = \"closed-form\""
    )]
    CoupledBase,
    /// The caller's progress callback asked to stop.
    #[error("interrupted while fitting shape functions")]
    Interrupted,
}

/// Matrix shape functions of coarse cells: per cell W of `3 (d + 1)³ × 24`, row-major, so that the fine displacement is
/// u = W ū with ū the displacements of the eight corners.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeFunctions {
    cells: Vec<CoarseCell>,
    size: usize,
    data: Vec<f64>,
    /// Rank and condition of each cell's fit; empty for functions without training.
    pub fits: Vec<FittedCell>,
}

impl ShapeFunctions {
    /// Trilinear functions in every listed cell.
    pub fn trilinear(partition: &Partition, cells: &[CoarseCell]) -> Self {
        let base = BaseFunctions::trilinear(partition.degree());
        let size = base.functions().len();
        Self { cells: cells.to_vec(), size, data: base.functions().repeat(cells.len()), fits: Vec::new() }
    }

    /// Functions fitted to training data, in parallel over cells.
    ///
    /// # Errors
    /// When a base or a coupled system is not solved, or the callback interrupts.
    pub fn fit(
        model: &FineModel,
        partition: &Partition,
        training: &Training,
        (kind, objective): (BaseKind, Objective),
        progress: Progress<'_>,
    ) -> Result<Self, ShapeFunctionError> {
        let cell_fit = CellFit::new(model, partition, kind, objective)?;
        let size = cell_fit.fitter.len();
        let cells = training.cells();
        let mut data = vec![0.0; size * cells.len()];
        let (done, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
        let fits: Result<Vec<FittedCell>, ShapeFunctionError> = data
            .par_chunks_exact_mut(size)
            .enumerate()
            .map(|(index, functions)| {
                if stop.load(Ordering::Relaxed) {
                    return Err(ShapeFunctionError::Interrupted);
                }
                let fit = cell_fit.fit(cells[index], training.of(index), functions)?;
                let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                if !progress("fitting", count, cells.len()) {
                    stop.store(true, Ordering::Relaxed);
                }
                Ok(fit)
            })
            .collect();
        Ok(Self { cells: cells.to_vec(), size, data, fits: fits? })
    }

    /// The coarse cells, in the order of their functions.
    pub fn cells(&self) -> &[CoarseCell] {
        &self.cells
    }

    /// The functions of cell number `index`, `3 (d + 1)³ × 24` row-major.
    pub fn of(&self, index: usize) -> &[f64] {
        &self.data[self.size * index..][..self.size]
    }

    /// All functions, one cell after the other.
    pub fn data(&self) -> &[f64] {
        &self.data
    }

    /// Rows of one cell's matrix, 3 (d + 1)³.
    pub fn rows(&self) -> usize {
        self.size / COLUMNS
    }
}

struct CellFit<'a> {
    model: &'a FineModel,
    partition: &'a Partition,
    kind: BaseKind,
    objective: Objective,
    fitter: Fitter,
    /// Extension problems with their analysis and workspace, waiting for the next cell.
    idle: Mutex<Vec<MaterialBase>>,
}

impl<'a> CellFit<'a> {
    fn new(
        model: &'a FineModel,
        partition: &'a Partition,
        kind: BaseKind,
        objective: Objective,
    ) -> Result<Self, ShapeFunctionError> {
        if objective == Objective::Coupled && kind != BaseKind::Harmonic {
            return Err(ShapeFunctionError::CoupledBase);
        }
        let spacing = model.grid().spacing;
        let base = match kind {
            BaseKind::Harmonic => BaseFunctions::harmonic(partition.degree(), spacing)
                .map_err(|source| ShapeFunctionError::Base { at: [0; 3], source })?,
            BaseKind::Trilinear | BaseKind::Material => BaseFunctions::trilinear(partition.degree()),
        };
        let fitter = Fitter::new(partition, spacing, &Arc::new(base));
        Ok(Self { model, partition, kind, objective, fitter, idle: Mutex::default() })
    }

    fn fit(&self, cell: CoarseCell, training: &[f64], functions: &mut [f64]) -> Result<FittedCell, ShapeFunctionError> {
        let at = self.partition.coarse().cell_position(Cell(cell.0));
        match (self.objective, self.kind) {
            (Objective::Coupled, _) => {
                let (solution, fit) = fit_coupled(self.partition, self.model.grid().spacing, training)
                    .map_err(|source| ShapeFunctionError::Coupled { at, source })?;
                functions.copy_from_slice(&solution);
                Ok(fit)
            }
            (_, BaseKind::Material) => {
                let cells = self.partition.cell_box(cell);
                let window = Window::new(self.model, cells.start, cells.cells);
                let own = self.material_functions(&window);
                functions.copy_from_slice(&own.map_err(|source| ShapeFunctionError::Base { at, source })?);
                Ok(self.fitter.fit_own_base(training, functions))
            }
            _ => Ok(self.fitter.fit_into(training, functions)),
        }
    }

    fn material_functions(&self, cells: &Window<'_>) -> Result<Vec<f64>, SolverError> {
        // A thread that panicked leaves the list as it was: it holds finished values only.
        let waiting = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut base = waiting.map_or_else(|| MaterialBase::new(self.partition.degree()), Ok)?;
        let functions = base.functions(cells);
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(base);
        functions
    }
}
