//! Shape functions of all coarse cells of a model.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::base::MaterialBase;
use super::{BaseFunctions, BaseKind, COLUMNS, CoupledError, FittedCell, Fitter, fit_coupled};
use crate::assembly::Window;
use crate::fine::FineModel;
use crate::mesh::Cell;
use crate::partition::{CellPart, CoarseMesh, Partition, PerElement};
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

/// Matrix shape functions of elements: per element W of `3 (d + 1)³ × 24`, row-major, so that the fine displacement is
/// u = W ū with ū the displacements of the eight corners.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeFunctions {
    rows: usize,
    fitted: PerElement<Fitted>,
}

/// The functions of one element, and what their fit had to say where there was one.
#[derive(Clone, Debug, PartialEq)]
struct Fitted {
    functions: Box<[f64]>,
    fit: Option<FittedCell>,
}

impl ShapeFunctions {
    /// Trilinear functions in every listed element.
    pub fn trilinear(partition: &Partition, elements: &[CellPart]) -> Self {
        let base = BaseFunctions::trilinear(partition.degree());
        let fitted = vec![Fitted { functions: base.functions().into(), fit: None }; elements.len()];
        Self { rows: base.functions().len() / COLUMNS, fitted: PerElement::new(elements.to_vec(), fitted) }
    }

    /// Functions fitted to training data of elements of `mesh`, in parallel over elements.
    ///
    /// # Errors
    /// When a base or a coupled system is not solved, or the callback interrupts.
    pub fn fit(
        model: &FineModel,
        mesh: &CoarseMesh,
        training: &Training,
        (kind, objective): (BaseKind, Objective),
        progress: Progress<'_>,
    ) -> Result<Self, ShapeFunctionError> {
        let cell_fit = CellFit::new(model, mesh, kind, objective)?;
        let elements = training.elements();
        let (done, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
        let fitted: Result<Vec<Fitted>, ShapeFunctionError> = elements
            .par_iter()
            .enumerate()
            .map(|(index, &element)| {
                if stop.load(Ordering::Relaxed) {
                    return Err(ShapeFunctionError::Interrupted);
                }
                let mut functions = vec![0.0; cell_fit.fitter.len()].into_boxed_slice();
                let fit = Some(cell_fit.fit(element, training.of(index), &mut functions)?);
                let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                if !progress("fitting", count, elements.len()) {
                    stop.store(true, Ordering::Relaxed);
                }
                Ok(Fitted { functions, fit })
            })
            .collect();
        Ok(Self { rows: cell_fit.fitter.len() / COLUMNS, fitted: PerElement::new(elements.to_vec(), fitted?) })
    }

    /// The elements, in the order of their functions.
    pub fn elements(&self) -> &[CellPart] {
        self.fitted.elements()
    }

    /// The functions of element number `index`, `3 (d + 1)³ × 24` row-major.
    pub fn of(&self, index: usize) -> &[f64] {
        &self.fitted.values()[index].functions
    }

    /// Rank and condition of the fit of element number `index`; `None` for functions without training.
    pub fn fit_of(&self, index: usize) -> Option<FittedCell> {
        self.fitted.values()[index].fit
    }

    /// The functions of all elements.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.fitted.values().iter().map(|fitted| fitted.functions.as_ref())
    }

    /// Rows of one element's matrix, 3 (d + 1)³.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Takes renewed functions into those of a mesh that has the elements `now`, see [`PerElement::replace`].
    ///
    /// # Panics
    /// Panics when an element of `now` has no functions, old or renewed.
    pub fn replace(&mut self, now: &[CellPart], renewed: Self) {
        self.fitted.replace(now, renewed.fitted);
    }
}

struct CellFit<'a> {
    model: &'a FineModel,
    mesh: &'a CoarseMesh,
    kind: BaseKind,
    objective: Objective,
    fitter: Fitter,
    /// Extension problems with their analysis and workspace, waiting for the next cell.
    idle: Mutex<Vec<MaterialBase>>,
}

impl<'a> CellFit<'a> {
    fn new(
        model: &'a FineModel,
        mesh: &'a CoarseMesh,
        kind: BaseKind,
        objective: Objective,
    ) -> Result<Self, ShapeFunctionError> {
        if objective == Objective::Coupled && kind != BaseKind::Harmonic {
            return Err(ShapeFunctionError::CoupledBase);
        }
        let (partition, spacing) = (mesh.partition(), model.grid().spacing);
        let base = match kind {
            BaseKind::Harmonic => BaseFunctions::harmonic(partition.degree(), spacing)
                .map_err(|source| ShapeFunctionError::Base { at: [0; 3], source })?,
            BaseKind::Trilinear | BaseKind::Material => BaseFunctions::trilinear(partition.degree()),
        };
        let fitter = Fitter::new(partition, spacing, &Arc::new(base));
        Ok(Self { model, mesh, kind, objective, fitter, idle: Mutex::default() })
    }

    fn fit(
        &self,
        element: CellPart,
        training: &[f64],
        functions: &mut [f64],
    ) -> Result<FittedCell, ShapeFunctionError> {
        let partition = self.mesh.partition();
        let at = partition.coarse().cell_position(Cell(element.cell.0));
        match (self.objective, self.kind) {
            (Objective::Coupled, _) => {
                let (solution, fit) = fit_coupled(partition, self.model.grid().spacing, training)
                    .map_err(|source| ShapeFunctionError::Coupled { at, source })?;
                functions.copy_from_slice(&solution);
                Ok(fit)
            }
            (_, BaseKind::Material) => {
                let own = self.material_functions(&self.mesh.window(self.model, element));
                functions.copy_from_slice(&own.map_err(|source| ShapeFunctionError::Base { at, source })?);
                Ok(self.fitter.fit_own_base(training, functions))
            }
            _ => Ok(self.fitter.fit_into(training, functions)),
        }
    }

    fn material_functions(&self, cells: &Window<'_>) -> Result<Vec<f64>, SolverError> {
        // A thread that panicked leaves the list as it was: it holds finished values only.
        let waiting = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut base = waiting.map_or_else(|| MaterialBase::new(self.mesh.partition().degree()), Ok)?;
        let functions = base.functions(cells);
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(base);
        functions
    }
}
