//! Direct solution of lattice systems, supported or free.

use std::sync::Arc;

use super::MultigridError;
use super::refined_cholesky::RefinedCholesky;
use crate::assembly::{CellStiffness, Constraints, LatticePattern};
use crate::linalg::{CholeskyError, ConjugateGradientError, SymbolicCholesky};

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
    /// A part of a mesh of elements is held nowhere.
    #[error(
        "a part of the coarse model, {elements} of its elements, is held by nothing; fix some of the body around coarse cell ({}, {}, {}), or leave that part out",
        at[0], at[1], at[2]
    )]
    Unheld {
        /// Number of its elements.
        elements: usize,
        /// Position of the coarse cell of its first element.
        at: [usize; 3],
    },
    /// A tangent stiffness is not positive definite.
    #[error(
        "the tangent stiffness of {unknowns} unknowns is not positive definite ({evidence}); take the positive semi-definite projection of the Hessian, a shorter time step, or hold every part of the body"
    )]
    Indefinite {
        /// Number of unknowns.
        unknowns: usize,
        /// The pivot or the curvature that shows it.
        evidence: String,
    },
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
    /// Refuses a relative residual above [`super::TOLERANCE`] of a system of `order` unknowns.
    pub(crate) fn check(residual: f64, order: usize) -> Result<f64, Self> {
        match residual <= super::TOLERANCE {
            true => Ok(residual),
            false => Err(Self::Inaccurate { residual, tolerance: super::TOLERANCE, order }),
        }
    }

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
    system: RefinedCholesky,
}

impl DirectSolver {
    /// Room for solves with up to `columns` right-hand sides, on one thread.
    ///
    /// # Errors
    /// When the factor does not fit into memory.
    pub fn new(analysed: Arc<AnalysedLattice>, columns: usize) -> Result<Self, SolverError> {
        let system = RefinedCholesky::new(analysed.symbolic.clone(), columns)?;
        Ok(Self { analysed, system })
    }

    /// The same for one large system: with threads inside the factorisation, and refined further.
    ///
    /// # Errors
    /// When the factor does not fit into memory.
    pub fn for_large(analysed: Arc<AnalysedLattice>, columns: usize) -> Result<Self, SolverError> {
        let system = RefinedCholesky::for_large(analysed.symbolic.clone(), columns)?;
        Ok(Self { analysed, system })
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
        let free = Constraints::none(cells.lattice().node_count());
        let (constraints, is_free) = match support {
            Support::Constraints(constraints) => (constraints, false),
            Support::Free => (&free, true),
        };
        let pattern = &self.analysed.pattern;
        self.system.refill(|values, fixed| {
            pattern.assemble_into(cells, constraints, values);
            for node in 0..constraints.node_count() {
                let Some(first) = pattern.unknown(crate::mesh::Node(node)) else { continue };
                (0..3).for_each(|r| fixed[first + r] = constraints.is_fixed(node, r));
            }
        });
        self.system.factor(is_free)
    }

    /// Solves K u = f for the columns of `block`, lattice vectors of 3 entries per node one after the other, in
    /// place. Prescribed components come out as zero. Returns the largest relative residual of the columns, infinite where
    /// a load or a solution is not finite.
    ///
    /// # Panics
    /// Panics when `block` holds more columns than were reserved.
    pub fn solve_in_place(&mut self, block: &mut [f64]) -> f64 {
        let pattern = &self.analysed.pattern;
        let stride = 3 * pattern.lattice().node_count();
        let columns = block.len() / stride;
        for (c, column) in block.chunks_exact(stride).enumerate() {
            pattern.gather_into(column, self.system.loads_mut(c));
        }
        let residual = self.system.solve(columns);
        for (c, column) in block.chunks_exact_mut(stride).enumerate() {
            column.fill(0.0);
            pattern.scatter_into(self.system.solution(c), column);
        }
        residual
    }
}
