//! Fitting elements to their training data, again and again.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::base::MaterialBase;
use super::shape_functions::Fitted;
use super::{
    BaseFunctions, BaseKind, COLUMNS, FittedCell, Fitter, Objective, ShapeFunctionError, ShapeFunctions, fit_coupled,
};
use crate::assembly::Window;
use crate::fine::FineModel;
use crate::mesh::Cell;
use crate::partition::{CellPart, CoarseMesh, Partition, PerElement};
use crate::progress::Progress;
use crate::solver::SolverError;
use crate::training::Training;

/// Fits the elements of one partition; the base functions are found once.
pub struct ElementFitter {
    partition: Partition,
    spacing: [f64; 3],
    kind: BaseKind,
    objective: Objective,
    fitter: Fitter,
    /// Extension problems with their analysis and workspace, waiting for the next cell.
    idle: Mutex<Vec<MaterialBase>>,
}

impl ElementFitter {
    /// A fitter for coarse cells of `partition` with fine cells of edge lengths `spacing`.
    ///
    /// # Errors
    /// When the base functions are not found, or the objective is not stated for the base.
    pub fn new(
        partition: &Partition,
        spacing: [f64; 3],
        (kind, objective): (BaseKind, Objective),
    ) -> Result<Self, ShapeFunctionError> {
        if objective == Objective::Coupled && kind != BaseKind::Harmonic {
            return Err(ShapeFunctionError::CoupledBase);
        }
        let base = match kind {
            BaseKind::Harmonic => BaseFunctions::harmonic(partition.degree(), spacing)
                .map_err(|source| ShapeFunctionError::Base { at: [0; 3], source })?,
            BaseKind::Trilinear | BaseKind::Material => BaseFunctions::trilinear(partition.degree()),
        };
        let fitter = Fitter::new(partition, spacing, &Arc::new(base));
        Ok(Self { partition: *partition, spacing, kind, objective, fitter, idle: Mutex::default() })
    }

    /// Functions of the elements of `mesh` that have training data, in parallel over elements.
    ///
    /// # Errors
    /// When a base or a coupled system is not solved, or the callback interrupts.
    pub fn fit(
        &self,
        model: &FineModel,
        mesh: &CoarseMesh,
        training: &Training,
        progress: Progress<'_>,
    ) -> Result<ShapeFunctions, ShapeFunctionError> {
        let elements = training.elements();
        let (done, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
        let fitted: Result<Vec<Fitted>, ShapeFunctionError> = elements
            .par_iter()
            .enumerate()
            .map(|(index, &element)| {
                if stop.load(Ordering::Relaxed) {
                    return Err(ShapeFunctionError::Interrupted);
                }
                let mut functions = vec![0.0; self.fitter.len()].into_boxed_slice();
                let fit = Some(self.fit_element((model, mesh, element), training.of(index), &mut functions)?);
                let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                if !progress("fitting", count, elements.len()) {
                    stop.store(true, Ordering::Relaxed);
                }
                Ok(Fitted { functions, fit })
            })
            .collect();
        let fitted = PerElement::new(elements.to_vec(), fitted?);
        Ok(ShapeFunctions::from_fits(self.fitter.len() / COLUMNS, fitted))
    }

    fn fit_element(
        &self,
        (model, mesh, element): (&FineModel, &CoarseMesh, CellPart),
        training: &[f64],
        functions: &mut [f64],
    ) -> Result<FittedCell, ShapeFunctionError> {
        let at = self.partition.coarse().cell_position(Cell(element.cell.0));
        match (self.objective, self.kind) {
            (Objective::Coupled, _) => {
                let (solution, fit) = fit_coupled(&self.partition, self.spacing, training)
                    .map_err(|source| ShapeFunctionError::Coupled { at, source })?;
                functions.copy_from_slice(&solution);
                Ok(fit)
            }
            (_, BaseKind::Material) => {
                let own = self.material_functions(&mesh.window(model, element));
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
