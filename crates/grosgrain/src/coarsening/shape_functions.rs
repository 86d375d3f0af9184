//! Shape functions of all coarse cells of a model.

use super::{BaseFunctions, BaseKind, COLUMNS, CoupledError, ElementFitter, FittedCell};
use crate::fine::FineModel;
use crate::partition::{CellPart, CoarseMesh, Partition, PerElement};
use crate::progress::Progress;
use crate::solver::SolverError;
use crate::training::Training;

/// How the constrained optimisation is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Objective {
    /// In closed form ([`Fitter`](super::Fitter)).
    #[default]
    ClosedForm,
    /// As one sparse saddle-point system per cell ([`fit_coupled`](super::fit_coupled())), the baseline.
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
pub(super) struct Fitted {
    pub functions: Box<[f64]>,
    pub fit: Option<FittedCell>,
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
        let fitter = ElementFitter::new(mesh.partition(), model.grid().spacing, (kind, objective))?;
        fitter.fit(model, mesh, training, progress)
    }

    pub(super) fn from_fits(rows: usize, fitted: PerElement<Fitted>) -> Self {
        Self { rows, fitted }
    }

    /// A copy of the functions of these elements; trilinear ones where an element has none.
    pub fn of_elements(&self, partition: &Partition, elements: &[CellPart]) -> Self {
        let base = BaseFunctions::trilinear(partition.degree());
        let trilinear = || Fitted { functions: base.functions().into(), fit: None };
        let find = |element: &CellPart| self.elements().binary_search(element).ok();
        let fitted = elements.iter().map(|e| find(e).map_or_else(trilinear, |at| self.fitted.values()[at].clone()));
        Self { rows: self.rows, fitted: PerElement::new(elements.to_vec(), fitted.collect()) }
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
