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

/// A factor in single precision that needs more iterations than this for its own matrix has lost too many digits.
const SINGLE_PATIENCE: usize = 12;

/// A factor, and the book of what was spent since it was made, in iterations.
#[derive(Debug)]
pub(super) struct LaggedFactor {
    symbolic: Arc<SymbolicCholesky>,
    factor: Factor,
    values: Vec<f64>,
    /// What a factorisation costs, in iterations.
    price: f64,
    spent: f64,
    solves: usize,
}

/// In single precision, at half the bytes and operations, as long as that serves.
#[derive(Debug)]
enum Factor {
    Single(Option<Single>),
    Double(Option<Cholesky>),
}

/// The factor of matrix / scale, so that no unit leaves the range of single precision.
#[derive(Debug)]
struct Single {
    cholesky: Cholesky<f32>,
    values: Vec<f32>,
    scale: f64,
    vector: Vec<f32>,
}

impl Single {
    fn new(symbolic: &Arc<SymbolicCholesky>) -> Result<Self, CholeskyError> {
        // More threads made it slower: the kernels of single precision are too short.
        let cholesky = Cholesky::new(symbolic.clone(), 1)?;
        let values = vec![0.0; symbolic.pattern().entry_count()];
        Ok(Self { cholesky, values, scale: 1.0, vector: vec![0.0; symbolic.order()] })
    }

    fn factor(&mut self, values: &[f64]) -> Result<(), CholeskyError> {
        self.scale = largest(values);
        self.values.iter_mut().zip(values).for_each(|(single, value)| *single = (value / self.scale) as f32);
        self.cholesky.factor(&self.values)
    }

    fn solve(&mut self, r: &[f64], z: &mut [f64]) {
        let size = largest(r);
        self.vector.iter_mut().zip(r).for_each(|(single, r)| *single = (r / size) as f32);
        self.cholesky.solve_in_place(&mut self.vector);
        let back = size / self.scale;
        z.iter_mut().zip(&self.vector).for_each(|(z, single)| *z = back * f64::from(*single));
    }
}

/// The largest magnitude, one where all are zero.
fn largest(values: &[f64]) -> f64 {
    let largest = values.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
    if largest > 0.0 { largest } else { 1.0 }
}

impl LaggedFactor {
    pub fn new<const N: usize>(matrix: &BlockMatrix<f64, N>) -> Result<Self, SolverError> {
        let symbolic = Arc::new(SymbolicCholesky::analyse(Arc::new(matrix.lower_pattern()))?);
        let iteration = 2.0 * symbolic.factor_entries() as f64 + matrix.operations();
        let price = symbolic.factor_flops() / (MEMORY_BOUND * iteration);
        Ok(Self { symbolic, factor: Factor::Single(None), values: Vec::new(), price, spent: 0.0, solves: 0 })
    }

    /// Whether there is a factor, of whichever matrix.
    pub fn exists(&self) -> bool {
        self.spent > 0.0
    }

    /// Factors `matrix`: in single precision, where only that meets a pivot that is not positive in double precision from now on, and with a diagonal shift if only
    /// rounding makes it indefinite.
    pub fn factor<const N: usize>(&mut self, matrix: &BlockMatrix<f64, N>) -> Result<(), SolverError> {
        self.spent = 0.0;
        self.values.resize(self.symbolic.pattern().entry_count(), 0.0);
        let was_single = matches!(self.factor, Factor::Single(_));
        let mut outcome = Ok(());
        for shift in [0.0, SHIFT] {
            matrix.lower_into(shift, &mut self.values);
            outcome = self.factor_values();
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
                // No digits were wanting: the next matrix may well be definite in single precision.
                if was_single {
                    self.factor = Factor::Single(None);
                }
                let evidence = format!("pivot {pivot} of its factorisation");
                Err(SolverError::Indefinite { unknowns: order, evidence })
            }
            Err(other) => Err(other.into()),
        }
    }

    fn factor_values(&mut self) -> Result<(), CholeskyError> {
        if let Factor::Single(single) = &mut self.factor {
            let single = match single {
                Some(single) => single,
                None => single.insert(Single::new(&self.symbolic)?),
            };
            match single.factor(&self.values) {
                Err(CholeskyError::NotPositiveDefinite { .. }) => self.factor = Factor::Double(None),
                outcome => return outcome,
            }
        }
        let Factor::Double(double) = &mut self.factor else { return Ok(()) };
        let double = match double {
            Some(double) => double,
            None => double.insert(Cholesky::for_large(self.symbolic.clone(), 1)?),
        };
        double.factor(&self.values)
    }

    /// Iterations that a factor of the matrix itself is given.
    pub fn patience(&self) -> usize {
        if matches!(self.factor, Factor::Single(_)) { SINGLE_PATIENCE } else { usize::MAX }
    }

    /// From the next factorisation on in double precision.
    pub fn ask_for_double(&mut self) {
        self.factor = Factor::Double(None);
        self.spent = 0.0;
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
        match &mut self.factor {
            Factor::Single(Some(single)) => single.solve(r, z),
            Factor::Double(Some(double)) => {
                z.copy_from_slice(r);
                double.solve_in_place(z);
            }
            Factor::Single(None) | Factor::Double(None) => z.copy_from_slice(r),
        }
    }
}
