//! Direct solution of lattice systems, supported or free.

use std::sync::Arc;

use super::MultigridError;
use crate::assembly::{CellStiffness, Constraints, LatticePattern};
use crate::linalg::{Cholesky, CholeskyError, ConjugateGradientError, SymbolicCholesky};

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

/// What keeps a body from moving as a rigid whole.
#[derive(Clone, Debug, PartialEq)]
pub enum Support {
    /// Prescribed components; they must exclude every rigid motion. For a free body under loads in
    /// equilibrium six of them, statically determinate, change only the rigid part of the solution.
    Constraints(Constraints),
    /// Nothing: several parts, or parts that hang together by an edge, each free under loads in equilibrium.
    /// The matrix is shifted by a small multiple of its diagonal and the solution refined (proximal point
    /// iteration), which converges to a solution of the unshifted system.
    Free,
}

/// Why a lattice system was not solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolverError {
    /// The factorisation failed.
    #[error(transparent)]
    Cholesky(#[from] CholeskyError),
    /// The multigrid hierarchy could not be built.
    #[error(transparent)]
    Multigrid(#[from] MultigridError),
    /// Conjugate gradients failed or were interrupted.
    #[error(transparent)]
    Iterative(#[from] ConjugateGradientError),
    /// The solution is not accurate enough.
    #[error(
        "the direct solution has a relative residual of {residual:.1e}, above {tolerance:.0e}, and refining it brings no more ({order} unknowns): the stiffness is too ill-conditioned for double precision; lower the contrast of the moduli, keep Poisson's ratio further from 0.5, or hold parts that hang by an edge or a node"
    )]
    Inaccurate {
        /// Relative residual reached.
        residual: f64,
        /// Relative residual asked for.
        tolerance: f64,
        /// Number of unknowns.
        order: usize,
    },
}

impl SolverError {
    /// Whether the caller's progress callback asked to stop.
    pub fn is_interruption(&self) -> bool {
        matches!(self, Self::Iterative(ConjugateGradientError::Interrupted { .. }))
    }
}

/// A lattice pattern and its symbolic factorisation; made once per shape.
#[derive(Debug)]
pub struct AnalysedLattice {
    pattern: LatticePattern,
    symbolic: Arc<SymbolicCholesky>,
}

impl AnalysedLattice {
    /// Analyses a pattern.
    ///
    /// # Errors
    /// When the factor's size overflows.
    pub fn new(pattern: LatticePattern) -> Result<Self, SolverError> {
        let symbolic = Arc::new(SymbolicCholesky::analyse(pattern.pattern().clone())?);
        Ok(Self { pattern, symbolic })
    }

    /// The pattern.
    pub fn pattern(&self) -> &LatticePattern {
        &self.pattern
    }

    /// The symbolic factorisation.
    pub fn symbolic(&self) -> &Arc<SymbolicCholesky> {
        &self.symbolic
    }
}

/// Factor and workspace of one lattice shape, kept between factorisations and solves.
#[derive(Debug)]
pub struct DirectSolver {
    analysed: Arc<AnalysedLattice>,
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

impl DirectSolver {
    /// Room for solves with up to `columns` right-hand sides, on one thread.
    ///
    /// # Errors
    /// When the factor does not fit into memory.
    pub fn new(analysed: Arc<AnalysedLattice>, columns: usize) -> Result<Self, SolverError> {
        let cholesky = Cholesky::new(analysed.symbolic.clone(), columns)?;
        Ok(Self::with_cholesky(analysed, cholesky, columns))
    }

    /// The same for one large system: with threads inside the factorisation, and refined further.
    ///
    /// # Errors
    /// When the factor does not fit into memory.
    pub fn for_large(analysed: Arc<AnalysedLattice>, columns: usize) -> Result<Self, SolverError> {
        let cholesky = Cholesky::for_large(analysed.symbolic.clone(), columns)?;
        Ok(Self { target: REFINED_RESIDUAL, ..Self::with_cholesky(analysed, cholesky, columns) })
    }

    fn with_cholesky(analysed: Arc<AnalysedLattice>, cholesky: Cholesky, columns: usize) -> Self {
        let order = analysed.pattern.order();
        Self {
            values: vec![0.0; analysed.pattern.pattern().entry_count()],
            shift: Vec::new(),
            fixed: vec![false; order],
            cholesky,
            solution: vec![0.0; order * columns],
            loads: vec![0.0; order * columns],
            residual: vec![0.0; order * columns],
            product: vec![0.0; order],
            target: SMALL_RESIDUAL,
            analysed,
        }
    }

    /// The pattern this solver was made for.
    pub fn analysed(&self) -> &Arc<AnalysedLattice> {
        &self.analysed
    }

    /// Assembles and factors the stiffness of `cells`; with the diagonal shift of a free body where the support is
    /// [`Support::Free`], or where rounding has made a supported stiffness indefinite.
    ///
    /// # Errors
    /// When even the shifted stiffness is not positive definite.
    pub fn factor(&mut self, cells: &dyn CellStiffness, support: &Support) -> Result<(), SolverError> {
        let nodes = cells.lattice().node_count();
        self.shift.clear();
        match support {
            Support::Constraints(constraints) => {
                self.assemble(cells, constraints);
                match self.cholesky.factor(&self.values) {
                    Err(CholeskyError::NotPositiveDefinite { .. }) => {}
                    outcome => return Ok(outcome?),
                }
            }
            Support::Free => self.assemble(cells, &Constraints::none(nodes)),
        }
        self.shift_diagonal();
        Ok(self.cholesky.factor(&self.values)?)
    }

    fn assemble(&mut self, cells: &dyn CellStiffness, constraints: &Constraints) {
        self.analysed.pattern.assemble_into(cells, constraints, &mut self.values);
        self.mark_fixed(constraints);
    }

    fn mark_fixed(&mut self, constraints: &Constraints) {
        let pattern = &self.analysed.pattern;
        for node in 0..constraints.node_count() {
            let Some(first) = pattern.unknown(crate::mesh::Node(node)) else { continue };
            (0..3).for_each(|r| self.fixed[first + r] = constraints.is_fixed(node, r));
        }
    }

    fn shift_diagonal(&mut self) {
        let pattern = self.analysed.pattern.pattern();
        for j in 0..pattern.order() {
            let diagonal = pattern.column(j).start;
            let shift = SHIFT * self.values[diagonal];
            self.values[diagonal] += shift;
            self.shift.push(shift);
        }
    }

    /// Solves K u = f for the columns of `block`, lattice vectors of 3 entries per node one after the other, in
    /// place. Prescribed components come out as zero. Returns the largest relative residual of the columns, infinite where
    /// a load or a solution is not finite.
    ///
    /// # Panics
    /// Panics when `block` holds more columns than were reserved.
    pub fn solve_in_place(&mut self, block: &mut [f64]) -> f64 {
        let stride = 3 * self.analysed.pattern.lattice().node_count();
        let order = self.analysed.pattern.order();
        let columns = block.len() / stride;
        for c in 0..columns {
            let unknowns = &mut self.residual[order * c..][..order];
            self.analysed.pattern.gather_into(&block[stride * c..][..stride], unknowns);
            unknowns.iter_mut().zip(&self.fixed).filter(|(_, fixed)| **fixed).for_each(|(f, _)| *f = 0.0);
        }
        let residual = self.refine(columns);
        for c in 0..columns {
            let column = &mut block[stride * c..][..stride];
            column.fill(0.0);
            self.analysed.pattern.scatter_into(&self.solution[order * c..][..order], column);
        }
        residual
    }

    /// Solves with the loads in `residual`, leaving the solution in `solution`.
    fn refine(&mut self, columns: usize) -> f64 {
        let order = self.analysed.pattern.order();
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
        let order = self.analysed.pattern.order();
        let range = order * column..order * (column + 1);
        let solution = &self.solution[range.clone()];
        self.analysed.pattern.pattern().multiply_into(&self.values, solution, &mut self.product);
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
