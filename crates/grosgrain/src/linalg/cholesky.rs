//! Sparse Cholesky factorisation K = L Lᵀ: analyse the pattern once, factor often, solve many.
//!
//! A thin wrapper of faer's supernodal factorisation. The caller numbers the unknowns in elimination
//! order, so nothing is permuted here.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky as FaerSymbolic, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SupernodalThreshold, SymbolicSupernodalParams};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use super::SparsePattern;

/// Two adjacent supernodes are merged when they have at most this many columns and less than this
/// share of explicit zeros together.
const SUPERNODE_MERGING: &[(usize, f64)] = &[(6, 1.0), (24, 0.8), (96, 0.15), (usize::MAX, 0.05)];

/// Why a factorisation failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CholeskyError {
    /// The matrix is singular or indefinite.
    #[error(
        "the stiffness is not positive definite (pivot {pivot} of {order}): a part of the body hangs on nothing, a material has no stiffness, or moduli differ by too much; fix the part, or lower the contrast"
    )]
    NotPositiveDefinite {
        /// Position of the pivot in elimination order.
        pivot: usize,
        /// Number of unknowns.
        order: usize,
    },
    /// The factor does not fit into memory or indices.
    #[error("the Cholesky factor of {order} unknowns does not fit into memory; use the iterative solver")]
    TooLarge {
        /// Number of unknowns.
        order: usize,
    },
}

/// What the pattern alone decides: the pattern of the factor and its cost.
#[derive(Debug)]
pub struct SymbolicCholesky {
    pattern: Arc<SparsePattern>,
    symbolic: FaerSymbolic<u32>,
}

impl SymbolicCholesky {
    /// Analyses the pattern of a matrix whose unknowns stand in elimination order.
    ///
    /// # Errors
    /// [`CholeskyError::TooLarge`] when the factor's size overflows.
    pub fn analyse(pattern: Arc<SparsePattern>) -> Result<Self, CholeskyError> {
        let order = pattern.order();
        let upper = pattern.transposed();
        let matrix = SymbolicSparseColMatRef::new_checked(order, order, &upper.column_starts, None, &upper.rows);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            supernodal_params: SymbolicSupernodalParams { relax: Some(SUPERNODE_MERGING) },
            ..CholeskySymbolicParams::default()
        };
        let symbolic = factorize_symbolic_cholesky(matrix, Side::Upper, SymmetricOrdering::Identity, parameters)
            .map_err(|_| CholeskyError::TooLarge { order })?;
        Ok(Self { pattern, symbolic })
    }

    /// The analysed pattern.
    pub fn pattern(&self) -> &Arc<SparsePattern> {
        &self.pattern
    }

    /// Number of unknowns.
    pub fn order(&self) -> usize {
        self.pattern.order()
    }

    /// Number of stored entries of the factor (explicit zeros of merged supernodes included).
    pub fn factor_entries(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Multiplications and additions of one numeric factorisation.
    pub fn factor_flops(&self) -> f64 {
        let SymbolicCholeskyRaw::Supernodal(supernodes) = self.symbolic.raw() else { return f64::NAN };
        (0..supernodes.n_supernodes())
            .map(|s| {
                let node = supernodes.supernode(s);
                let columns = (supernodes.supernode_end()[s] - supernodes.supernode_begin()[s]) as f64;
                let below = node.pattern().len() as f64;
                columns.powi(3) / 3.0 + columns * columns * below + columns * below * below
            })
            .sum()
    }
}

/// What factors are made of: `f64`, or `f32` for preconditioners, at half the memory and time.
pub trait FactorScalar: faer::traits::RealField + Copy {
    /// Zero.
    const ZERO: Self;
}

impl FactorScalar for f32 {
    const ZERO: Self = 0.0;
}

impl FactorScalar for f64 {
    const ZERO: Self = 0.0;
}

/// A numeric factorisation together with its workspace; refactoring allocates nothing.
pub struct Cholesky<C = f64> {
    symbolic: Arc<SymbolicCholesky>,
    values: Vec<C>,
    factor_scratch: MemBuffer,
    solve_scratch: MemBuffer,
    columns: usize,
    parallelism: Par,
}

impl<C> std::fmt::Debug for Cholesky<C> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cholesky").field("order", &self.symbolic.order()).field("entries", &self.values.len()).finish()
    }
}

impl<C: FactorScalar> Cholesky<C> {
    /// Room for a factorisation on one thread and for solves with up to `columns` right-hand sides.
    ///
    /// # Errors
    /// [`CholeskyError::TooLarge`] when the memory is not to be had.
    pub fn new(symbolic: Arc<SymbolicCholesky>, columns: usize) -> Result<Self, CholeskyError> {
        Self::with_parallelism(symbolic, columns, Par::Seq)
    }

    /// Like [`Cholesky::new`] for one large factorisation: the work is cut into a fixed number of
    /// pieces, so that results do not depend on the number of threads.
    ///
    /// # Errors
    /// [`CholeskyError::TooLarge`] when the memory is not to be had.
    pub fn for_large(symbolic: Arc<SymbolicCholesky>, columns: usize) -> Result<Self, CholeskyError> {
        Self::with_parallelism(symbolic, columns, Par::rayon(4))
    }

    fn with_parallelism(
        symbolic: Arc<SymbolicCholesky>,
        columns: usize,
        parallelism: Par,
    ) -> Result<Self, CholeskyError> {
        let too_large = || CholeskyError::TooLarge { order: symbolic.order() };
        let faer_symbolic = &symbolic.symbolic;
        let factor = faer_symbolic.factorize_numeric_llt_scratch::<C>(parallelism, Default::default());
        let solve = faer_symbolic.solve_in_place_scratch::<C>(columns, parallelism);
        let factor_scratch = MemBuffer::try_new(factor).map_err(|_| too_large())?;
        let solve_scratch = MemBuffer::try_new(solve).map_err(|_| too_large())?;
        let mut values = Vec::new();
        values.try_reserve_exact(faer_symbolic.len_val()).map_err(|_| too_large())?;
        values.resize(faer_symbolic.len_val(), C::ZERO);
        Ok(Self { symbolic: symbolic.clone(), values, factor_scratch, solve_scratch, columns, parallelism })
    }

    /// Factors the matrix with these values, one per entry of the analysed pattern.
    ///
    /// # Errors
    /// [`CholeskyError::NotPositiveDefinite`] at the first pivot that is not positive.
    pub fn factor(&mut self, values: &[C]) -> Result<(), CholeskyError> {
        let order = self.symbolic.order();
        let pattern = self.symbolic.pattern();
        let shape = SymbolicSparseColMatRef::new_checked(order, order, &pattern.column_starts, None, &pattern.rows);
        let outcome = self.symbolic.symbolic.factorize_numeric_llt(
            &mut self.values,
            SparseColMatRef::new(shape, values),
            Side::Lower,
            LltRegularization::default(),
            self.parallelism,
            MemStack::new(&mut self.factor_scratch),
            Default::default(),
        );
        let LltError::NonPositivePivot { index } = match outcome {
            Ok(_) => return Ok(()),
            Err(error) => error,
        };
        Err(CholeskyError::NotPositiveDefinite { pivot: index, order })
    }

    /// Solves K X = B in place; `block` holds the columns of B one after the other.
    ///
    /// # Panics
    /// Panics when `block` is not a whole number of columns, or more than were reserved.
    pub fn solve_in_place(&mut self, block: &mut [C]) {
        let order = self.symbolic.order();
        let columns = block.len() / order;
        assert!(columns * order == block.len() && columns <= self.columns, "right-hand side of the wrong shape");
        LltRef::new(&self.symbolic.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(block, order, columns),
            self.parallelism,
            MemStack::new(&mut self.solve_scratch),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The path graph's Laplacian plus a multiple of the identity.
    fn path(n: usize, shift: f64) -> (Arc<SparsePattern>, Vec<f64>) {
        let (mut starts, mut rows, mut values) = (vec![0u32], Vec::new(), Vec::new());
        for j in 0..n {
            rows.push(j as u32);
            values.push(2.0 + shift);
            if j + 1 < n {
                rows.push(j as u32 + 1);
                values.push(-1.0);
            }
            starts.push(rows.len() as u32);
        }
        (Arc::new(SparsePattern { column_starts: starts, rows }), values)
    }

    #[test]
    fn solutions_satisfy_the_system_after_each_refactorisation() {
        let (pattern, _) = path(50, 0.0);
        let symbolic = Arc::new(SymbolicCholesky::analyse(pattern.clone()).unwrap());
        let mut cholesky = Cholesky::new(symbolic, 2).unwrap();
        for shift in [0.0, 1.0, 7.0] {
            let (_, values) = path(50, shift);
            let rhs: Vec<f64> = (0..100).map(|i| (i as f64).sin()).collect();
            let mut x = rhs.clone();
            cholesky.factor(&values).unwrap();
            cholesky.solve_in_place(&mut x);
            for column in 0..2 {
                let mut product = vec![0.0; 50];
                pattern.multiply_into(&values, &x[50 * column..][..50], &mut product);
                let error = product.iter().zip(&rhs[50 * column..]).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
                assert!(error < 1e-12, "shift {shift}: residual {error}");
            }
        }
    }

    #[test]
    fn a_factor_in_single_precision_solves_to_its_rounding() {
        let (pattern, values) = path(50, 0.5);
        let symbolic = Arc::new(SymbolicCholesky::analyse(pattern.clone()).unwrap());
        let mut cholesky = Cholesky::<f32>::new(symbolic, 1).unwrap();
        cholesky.factor(&values.iter().map(|v| *v as f32).collect::<Vec<_>>()).unwrap();
        let rhs: Vec<f64> = (0..50).map(|i| (i as f64).sin()).collect();
        let mut x: Vec<f32> = rhs.iter().map(|b| *b as f32).collect();
        cholesky.solve_in_place(&mut x);
        let (x, mut product): (Vec<f64>, _) = (x.iter().map(|x| f64::from(*x)).collect(), vec![0.0; 50]);
        pattern.multiply_into(&values, &x, &mut product);
        let error = product.iter().zip(&rhs).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(error > 0.0 && error < 1e-6, "residual {error:e}");
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let (pattern, values) = path(10, -3.0);
        let mut cholesky = Cholesky::new(Arc::new(SymbolicCholesky::analyse(pattern).unwrap()), 1).unwrap();
        assert!(matches!(cholesky.factor(&values), Err(CholeskyError::NotPositiveDefinite { .. })));
    }
}
