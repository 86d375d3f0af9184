//! A sparse Cholesky factorisation whose solutions are refined until their residual is small.

use std::sync::Arc;

use super::SolverError;
use crate::linalg::{Cholesky, CholeskyError, SymbolicCholesky};

/// Diagonal shift of a free body that may have more zero-energy motions than six, relative to each diagonal entry.
const SHIFT: f64 = 1e-9;
/// A shifted solve is refined until its relative residual is below this.
const REFINED_RESIDUAL: f64 = 1e-12;
/// The same for the many small systems of local problems.
const SMALL_RESIDUAL: f64 = 1e-9;
const MAX_REFINEMENTS: usize = 60;
/// Refinement ends when a step leaves more than this share of the residual. A motion of stiffness λ keeps s / (λ + s) of its error
/// under the shift s, which is close to one for slender soft parts beside stiff ones.
const STALLED: f64 = 0.9;

/// A factorisation with its matrix, prescribed unknowns and workspace. All vectors are in elimination order.
#[derive(Debug)]
pub(crate) struct RefinedCholesky {
    symbolic: Arc<SymbolicCholesky>,
    values: Vec<f64>,
    shift: Vec<f64>,
    fixed: Vec<bool>,
    cholesky: Cholesky,
    solution: Vec<f64>,
    loads: Vec<f64>,
    residual: Vec<f64>,
    product: Vec<f64>,
    /// A solution is refined until its relative residual is below this.
    target: f64,
}

impl RefinedCholesky {
    pub(super) fn new(symbolic: Arc<SymbolicCholesky>, columns: usize) -> Result<Self, SolverError> {
        let cholesky = Cholesky::new(symbolic.clone(), columns)?;
        Ok(Self::with_cholesky(symbolic, cholesky, columns))
    }

    /// With threads inside the factorisation, and refined further.
    pub(crate) fn for_large(symbolic: Arc<SymbolicCholesky>, columns: usize) -> Result<Self, SolverError> {
        let cholesky = Cholesky::for_large(symbolic.clone(), columns)?;
        Ok(Self { target: REFINED_RESIDUAL, ..Self::with_cholesky(symbolic, cholesky, columns) })
    }

    fn with_cholesky(symbolic: Arc<SymbolicCholesky>, cholesky: Cholesky, columns: usize) -> Self {
        let order = symbolic.order();
        Self {
            values: vec![0.0; symbolic.pattern().entry_count()],
            shift: Vec::new(),
            fixed: vec![false; order],
            cholesky,
            solution: vec![0.0; order * columns],
            loads: vec![0.0; order * columns],
            residual: vec![0.0; order * columns],
            product: vec![0.0; order],
            target: SMALL_RESIDUAL,
            symbolic,
        }
    }

    fn order(&self) -> usize {
        self.symbolic.order()
    }

    /// Lets `fill` write the matrix, one value per entry of the pattern with identity rows and columns at prescribed
    /// unknowns, and mark these.
    pub(crate) fn refill(&mut self, fill: impl FnOnce(&mut [f64], &mut [bool])) {
        fill(&mut self.values, &mut self.fixed);
    }

    /// Factors the matrix; with a shifted diagonal where it `is_free`, or where rounding has made it indefinite.
    pub(crate) fn factor(&mut self, is_free: bool) -> Result<(), SolverError> {
        self.shift.clear();
        if !is_free {
            match self.cholesky.factor(&self.values) {
                Err(CholeskyError::NotPositiveDefinite { .. }) => {}
                outcome => return Ok(outcome?),
            }
        }
        self.shift_diagonal();
        Ok(self.cholesky.factor(&self.values)?)
    }

    fn shift_diagonal(&mut self) {
        let pattern = self.symbolic.pattern();
        for j in 0..pattern.order() {
            let diagonal = pattern.column(j).start;
            let shift = SHIFT * self.values[diagonal];
            self.values[diagonal] += shift;
            self.shift.push(shift);
        }
    }

    /// Where the loads of a column go before [`RefinedCholesky::solve`].
    pub(crate) fn loads_mut(&mut self, column: usize) -> &mut [f64] {
        let order = self.order();
        &mut self.residual[order * column..][..order]
    }

    /// The solution of a column.
    pub(crate) fn solution(&self, column: usize) -> &[f64] {
        &self.solution[self.order() * column..][..self.order()]
    }

    /// Solves for the loads of the first `columns` columns, zero where prescribed; returns the largest relative residual.
    pub(crate) fn solve(&mut self, columns: usize) -> f64 {
        let order = self.order();
        for c in 0..columns {
            let unknowns = &mut self.residual[order * c..][..order];
            unknowns.iter_mut().zip(&self.fixed).filter(|(_, fixed)| **fixed).for_each(|(f, _)| *f = 0.0);
        }
        self.solution[..order * columns].fill(0.0);
        self.loads[..order * columns].copy_from_slice(&self.residual[..order * columns]);
        let mut reached = f64::INFINITY;
        for _ in 0..MAX_REFINEMENTS {
            self.cholesky.solve_in_place(&mut self.residual[..order * columns]);
            for (u, correction) in self.solution.iter_mut().zip(&self.residual[..order * columns]) {
                *u += correction;
            }
            let worst = (0..columns).fold(0.0f64, |worst, c| worst.max(self.update_residual(c)));
            let stalled = worst > STALLED * reached;
            reached = reached.min(worst);
            if worst <= self.target || stalled {
                break;
            }
        }
        reached
    }

    /// residual = f − K u of one column; returns its norm relative to f.
    fn update_residual(&mut self, column: usize) -> f64 {
        let order = self.order();
        let range = order * column..order * (column + 1);
        let solution = &self.solution[range.clone()];
        self.symbolic.pattern().multiply_into(&self.values, solution, &mut self.product);
        let residual = &mut self.residual[range.clone()];
        for (i, r) in residual.iter_mut().enumerate() {
            let shift = self.shift.get(i).map_or(0.0, |s| s * solution[i]);
            *r = self.loads[range.start + i] - self.product[i] + shift;
        }
        let scale = norm(&self.loads[range.clone()]);
        let relative = if scale == 0.0 { 0.0 } else { norm(residual) / scale };
        if relative.is_finite() && scale.is_finite() { relative } else { f64::INFINITY }
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}
