//! Sparse Cholesky entry by entry in approximate-minimum-degree order: what the papers' factorisation does.

#![allow(dead_code, reason = "not every benchmark compares with it")]

use std::error::Error;
use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use grosgrain::linalg::SparsePattern;

/// An analysed pattern with its factor and workspace.
pub struct Simplicial {
    pattern: Arc<SparsePattern>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    factor_scratch: MemBuffer,
    solve_scratch: MemBuffer,
}

impl Simplicial {
    pub fn new(pattern: Arc<SparsePattern>, columns: usize) -> Result<Self, Box<dyn Error>> {
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..CholeskySymbolicParams::default()
        };
        let symbolic = factorize_symbolic_cholesky(shape(&pattern), Side::Lower, SymmetricOrdering::Amd, parameters)
            .map_err(|error| format!("the baseline's analysis failed: {error:?}"))?;
        Ok(Self {
            factor: vec![0.0; symbolic.len_val()],
            factor_scratch: MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())),
            solve_scratch: MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq)),
            symbolic,
            pattern,
        })
    }

    /// False if the matrix is not positive definite.
    pub fn factor(&mut self, values: &[f64]) -> bool {
        let matrix = SparseColMatRef::new(shape(&self.pattern), values);
        let outcome = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            matrix,
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.factor_scratch),
            Default::default(),
        );
        outcome.is_ok()
    }

    /// Solves for the columns of `block`, one after the other.
    pub fn solve_in_place(&mut self, block: &mut [f64]) {
        let order = self.pattern.order();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(block, order, block.len() / order),
            Par::Seq,
            MemStack::new(&mut self.solve_scratch),
        );
    }
}

fn shape(pattern: &SparsePattern) -> SymbolicSparseColMatRef<'_, u32> {
    let order = pattern.order();
    SymbolicSparseColMatRef::new_checked(order, order, &pattern.column_starts, None, &pattern.rows)
}
