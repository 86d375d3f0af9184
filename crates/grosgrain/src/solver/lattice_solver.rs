//! Cholesky up to the size where it is the faster choice, conjugate gradients beyond.

use std::sync::Arc;

use super::{AnalysedLattice, DirectSolver, Multigrid, MultigridParameters, RigidMotions, SolverError, Support};
use super::{TOLERANCE, free_support};
use crate::assembly::{CellStiffness, Constraints, LatticePattern, MatrixFree, active_nodes};
use crate::linalg::{CholeskyError, ConjugateGradientParameters, ConjugateGradients, LinearOperator};
use crate::progress::{Progress, SOLVING};

/// How to solve a lattice system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolverChoice {
    /// The one that should be faster, and fits into memory.
    #[default]
    Auto,
    /// Sparse Cholesky.
    Direct,
    /// Conjugate gradients with a multigrid preconditioner.
    Iterative,
}

/// What keeps a lattice of cells from moving as a whole.
#[derive(Clone, Copy, Debug)]
pub enum Hold<'a> {
    /// Prescribed components, zero in the solution.
    Fixed(&'a Constraints),
    /// Nothing: the loads are in equilibrium on every part, and the solution is found up to rigid motions.
    Equilibrium,
}

/// A lattice stiffness with what holds it.
#[derive(Clone, Copy)]
pub struct LatticeSystem<'a> {
    /// The cells.
    pub cells: &'a dyn CellStiffness,
    /// Edge lengths of a cell \[m\].
    pub spacing: [f64; 3],
    /// What holds them.
    pub hold: Hold<'a>,
}

/// Which solver was used, why, and how well it did.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveReport {
    /// "cholesky" or "multigrid-pcg".
    pub kind: &'static str,
    /// Why this one.
    pub reason: String,
    /// Number of unknowns: three per node that touches a solid cell, held ones included.
    pub unknowns: usize,
    /// Iterations of the worst right-hand side; 0 for a direct solve.
    pub iterations: usize,
    /// Largest ‖f − K u‖ / ‖f‖ of the right-hand sides.
    pub relative_residual: f64,
}

/// Up to this many unknowns Cholesky is chosen for one right-hand side, and up to [`DIRECT_LIMIT_MANY`] for several.
/// Measured with `examples/solver_choice.rs`.
const DIRECT_LIMIT: usize = 25_000;
const DIRECT_LIMIT_MANY: usize = 150_000;
/// Factors larger than this are not tried when conjugate gradients have failed \[B\].
const FALLBACK_BYTES: usize = 6_000_000_000;
const MAX_ITERATIONS: usize = 3000;
/// With more unknowns than this the entries of the pattern (about 42 per unknown) overflow its 32-bit positions.
const LARGEST_PATTERN: usize = 90_000_000;

impl LatticeSystem<'_> {
    /// Solves for the lattice vectors in `block` (3 entries per node, one vector after the other) in place.
    ///
    /// # Errors
    /// When a relative residual of [`TOLERANCE`] is not reached by either solver, or the callback interrupts.
    pub fn solve(
        &self,
        choice: SolverChoice,
        block: &mut [f64],
        progress: Progress<'_>,
    ) -> Result<SolveReport, SolverError> {
        let active = active_nodes(self.cells);
        let unknowns = 3 * active.iter().filter(|a| **a).count();
        let columns = block.len() / (3 * active.len());
        let limit = if columns > 1 { DIRECT_LIMIT_MANY } else { DIRECT_LIMIT };
        match choice {
            SolverChoice::Direct => self.solve_direct(&active, "asked for".into(), block),
            SolverChoice::Iterative => self.solve_iterative(&active, "asked for".into(), block, progress),
            SolverChoice::Auto if unknowns <= limit => {
                self.solve_direct(&active, format!("faster up to {limit} unknowns"), block)
            }
            SolverChoice::Auto => self.solve_large(&active, limit, block, progress),
        }
    }

    /// Iterates, and factors after all if the iteration does not converge and the factor fits into memory.
    fn solve_large(
        &self,
        active: &[bool],
        limit: usize,
        block: &mut [f64],
        progress: Progress<'_>,
    ) -> Result<SolveReport, SolverError> {
        let loads = block.to_vec();
        let failure = match self.solve_iterative(active, format!("faster beyond {limit} unknowns"), block, progress) {
            Err(failure @ (SolverError::Iterative(_) | SolverError::Multigrid(_))) if !failure.is_interruption() => {
                failure
            }
            outcome => return outcome,
        };
        block.copy_from_slice(&loads);
        if factor_bytes(active) > FALLBACK_BYTES as f64 {
            return Err(failure);
        }
        let analysed = Arc::new(AnalysedLattice::new(LatticePattern::on_nodes(self.cells.lattice(), active))?);
        if 8 * analysed.symbolic().factor_entries() > FALLBACK_BYTES {
            return Err(failure);
        }
        self.factor_and_solve(analysed, active, format!("conjugate gradients did not converge ({failure})"), block)
    }

    fn solve_direct(&self, active: &[bool], reason: String, block: &mut [f64]) -> Result<SolveReport, SolverError> {
        let order = 3 * active.iter().filter(|a| **a).count();
        if order > LARGEST_PATTERN {
            return Err(CholeskyError::TooLarge { order }.into());
        }
        let analysed = Arc::new(AnalysedLattice::new(LatticePattern::on_nodes(self.cells.lattice(), active))?);
        self.factor_and_solve(analysed, active, reason, block)
    }

    fn factor_and_solve(
        &self,
        analysed: Arc<AnalysedLattice>,
        active: &[bool],
        reason: String,
        block: &mut [f64],
    ) -> Result<SolveReport, SolverError> {
        let unknowns = analysed.pattern().order();
        let columns = block.len() / (3 * active.len());
        let mut solver = DirectSolver::for_large(analysed, columns)?;
        solver.factor(self.cells, &self.support(active))?;
        let relative_residual = SolverError::check(solver.solve_in_place(block), unknowns)?;
        Ok(SolveReport { kind: "cholesky", reason, unknowns, iterations: 0, relative_residual })
    }

    fn support(&self, active: &[bool]) -> Support {
        match self.hold {
            Hold::Fixed(constraints) => Support::Constraints(constraints.clone()),
            Hold::Equilibrium => free_support(self.cells.lattice(), self.spacing, &self.void(), active),
        }
    }

    fn void(&self) -> Vec<bool> {
        (0..self.cells.lattice().cell_count()).map(|c| self.cells.stiffness(c).is_none()).collect()
    }

    fn solve_iterative(
        &self,
        active: &[bool],
        reason: String,
        block: &mut [f64],
        progress: Progress<'_>,
    ) -> Result<SolveReport, SolverError> {
        let free = Constraints::none(active.len());
        let constraints = match self.hold {
            Hold::Fixed(constraints) => constraints,
            Hold::Equilibrium => &free,
        };
        let operator = MatrixFree::new(self.cells, constraints);
        let parameters = MultigridParameters { spacing: self.spacing, ..MultigridParameters::default() };
        let mut multigrid = Multigrid::new(&operator, self.cells, parameters)?;
        let projector = self.rigid_motions(active);
        let options = ConjugateGradientParameters { tolerance: TOLERANCE, max_iterations: MAX_ITERATIONS };
        let unknowns = 3 * active.iter().filter(|a| **a).count();
        let mut report = SolveReport { kind: "multigrid-pcg", reason, unknowns, iterations: 0, relative_residual: 0.0 };
        let mut solver = ConjugateGradients::new(&operator as &dyn LinearOperator, options);
        if let Some(projector) = &projector {
            solver = solver.with_projector(projector);
        }
        let mut solution = vec![0.0; 3 * active.len()];
        let columns = block.len() / (3 * active.len());
        for (n, column) in block.chunks_exact_mut(3 * active.len()).enumerate() {
            keep_free(column, operator.free());
            solution.fill(0.0);
            let info = solver.solve(column, &mut solution, &mut multigrid, &|_, residual| {
                progress(SOLVING, percent(n, columns, residual), 100)
            })?;
            column.copy_from_slice(&solution);
            report.iterations = report.iterations.max(info.iterations);
            report.relative_residual = report.relative_residual.max(info.relative_residual);
        }
        Ok(report)
    }

    /// The rigid motions of a free body of one part; several parts have no such common kernel and need none removed,
    /// because their loads are in equilibrium.
    fn rigid_motions(&self, active: &[bool]) -> Option<RigidMotions> {
        if let Hold::Fixed(_) = self.hold {
            return None;
        }
        match self.support(active) {
            Support::Constraints(_) => RigidMotions::new(self.cells.lattice(), self.spacing, active).ok(),
            Support::Free => None,
        }
    }
}

/// How far the right-hand sides are solved when `done` of `columns` are, and the next has this relative residual:
/// iteration wins decimal digits at an even pace.
fn percent(done: usize, columns: usize, residual: f64) -> usize {
    let share = (residual.log10() / TOLERANCE.log10()).clamp(0.0, 1.0);
    (100.0 * (done as f64 + share) / columns as f64) as usize
}

/// Sets entries that are no unknowns to zero.
fn keep_free(column: &mut [f64], free: &[u8]) {
    for (node, bits) in free.iter().enumerate() {
        (0..3).filter(|r| bits >> r & 1 == 0).for_each(|r| column[3 * node + r] = 0.0);
    }
}

/// Estimated size of the Cholesky factor \[B\]: 180 n^{4/3} for n unknowns in nested-dissection order.
fn factor_bytes(active: &[bool]) -> f64 {
    180.0 * (3.0 * active.iter().filter(|a| **a).count() as f64).powf(4.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_counts_the_digits_won_of_all_right_hand_sides() {
        assert_eq!([1.0, 1e-4, 1e-8, 1e-12].map(|r| percent(0, 1, r)), [0, 50, 100, 100]);
        assert_eq!([percent(0, 4, 10.0), percent(1, 4, 1e-4), percent(3, 4, 1e-8)], [0, 37, 100]);
    }
}
