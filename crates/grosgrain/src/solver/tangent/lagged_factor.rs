//! A Cholesky factor that outlives its matrix: a preconditioner for the matrices that follow.

use std::sync::Arc;

use super::super::SolverError;
use super::super::block_matrix::BlockMatrix;
use crate::linalg::{Cholesky, CholeskyError, Preconditioner, SymbolicCholesky};

/// Diagonal shift, relative to each diagonal entry, where rounding has made the matrix indefinite.
const SHIFT: f64 = 1e-9;
/// Time of a multiplication in triangular solves and products with a vector, which wait for memory, over that of one in a
/// factorisation, whose dense kernels do not. An estimate, not calibrated: it decides when a factor is renewed, never a result.
const MEMORY_BOUND: f64 = 8.0;
/// From this iteration on the pace of convergence is judged.
const JUDGED_FROM: usize = 5;
/// With fewer iterations than this allowed, an old factor is not tried.
const WORTH_TRYING: f64 = 3.0;

/// A factor, and the book of what was spent since it was made, in iterations.
#[derive(Debug)]
pub(super) struct LaggedFactor {
    symbolic: Arc<SymbolicCholesky>,
    cholesky: Option<Cholesky>,
    values: Vec<f64>,
    /// What a factorisation costs, in iterations.
    price: f64,
    spent: f64,
    solves: usize,
}

impl LaggedFactor {
    pub fn new(matrix: &BlockMatrix) -> Result<Self, SolverError> {
        let symbolic = Arc::new(SymbolicCholesky::analyse(Arc::new(matrix.lower_pattern()))?);
        let iteration = 2.0 * symbolic.factor_entries() as f64 + matrix.operations();
        let price = symbolic.factor_flops() / (MEMORY_BOUND * iteration);
        Ok(Self { symbolic, cholesky: None, values: Vec::new(), price, spent: 0.0, solves: 0 })
    }

    /// Whether there is a factor, of whichever matrix.
    pub fn exists(&self) -> bool {
        self.cholesky.is_some() && self.spent > 0.0
    }

    /// Factors `matrix`; with a diagonal shift if only rounding makes it indefinite.
    pub fn factor(&mut self, matrix: &BlockMatrix) -> Result<(), SolverError> {
        let Self { symbolic, cholesky, values, .. } = self;
        self.spent = 0.0;
        values.resize(symbolic.pattern().entry_count(), 0.0);
        if cholesky.is_none() {
            *cholesky = Some(Cholesky::for_large(symbolic.clone(), 1)?);
        }
        let Some(cholesky) = cholesky else { return Ok(()) };
        let mut outcome = Ok(());
        for shift in [0.0, SHIFT] {
            matrix.lower_into(shift, values);
            outcome = cholesky.factor(values);
            if !matches!(outcome, Err(CholeskyError::NotPositiveDefinite { .. })) {
                break;
            }
        }
        match outcome {
            Ok(()) => {
                (self.spent, self.solves) = (self.price.max(1.0), 0);
                Ok(())
            }
            Err(CholeskyError::NotPositiveDefinite { pivot, order }) => {
                let evidence = format!("pivot {pivot} of its factorisation");
                Err(SolverError::Indefinite { unknowns: order, evidence })
            }
            Err(other) => Err(other.into()),
        }
    }

    /// What the next solve may cost: the average of the solves since the factorisation, its price included. A solve that costs
    /// more raises the average, which is when a machine is replaced.
    pub fn allowance(&self) -> Allowance {
        Allowance { iterations: self.spent / self.solves.max(1) as f64 }
    }

    /// Books a solve.
    pub fn book(&mut self, iterations: usize) {
        self.spent += iterations as f64;
        self.solves += 1;
    }
}

/// Iterations that a solve may take before another factorisation is cheaper.
#[derive(Clone, Copy, Debug)]
pub(super) struct Allowance {
    iterations: f64,
}

impl Allowance {
    /// Whether there is enough of it to begin at all.
    pub fn is_enough(&self) -> bool {
        self.iterations >= WORTH_TRYING
    }

    /// Whether to go on after this iteration with this relative residual: within the allowance, and not bound to overdraw it
    /// twofold at the pace so far.
    pub fn covers(&self, iteration: usize, residual: f64, tolerance: f64) -> bool {
        let done = iteration as f64;
        let is_hopeless = || residual >= 1.0 || done * tolerance.ln() / residual.ln() > 2.0 * self.iterations;
        residual <= tolerance || done < self.iterations && !(iteration >= JUDGED_FROM && is_hopeless())
    }
}

impl Preconditioner for LaggedFactor {
    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        z.copy_from_slice(r);
        if let Some(cholesky) = &mut self.cholesky {
            cholesky.solve_in_place(z);
        }
    }
}
