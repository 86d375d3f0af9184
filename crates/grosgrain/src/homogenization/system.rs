//! Linear statics of a body of simplices.

use std::sync::Arc;

use super::SimplexModel;
use super::block_columns::BlockColumns;
use crate::linalg::{GraphOrderError, SymbolicCholesky, clique_order};
use crate::progress::Progress;
use crate::simplex::SimplexMesh;
use crate::solver::{RefinedCholesky, SolverError};

/// The rank of a node that no cell uses.
const NO_RANK: u32 = u32::MAX;

/// A vector per node for each of several loads.
pub type NodalVectors = Vec<Vec<[f64; 3]>>;

/// Why a system of simplices was not solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplexSystemError {
    /// The system was not solved, or not accurately enough.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// The nodes were not ordered.
    #[error(transparent)]
    Order(#[from] GraphOrderError),
    /// The progress callback asked to stop.
    #[error("interrupted while {stage}")]
    Interrupted {
        /// The stage.
        stage: &'static str,
    },
}

/// Whether the held components exclude every motion without strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holding {
    /// They do.
    Complete,
    /// They may not: loads must do no work on motions without strain. The matrix is shifted by a small share of its diagonal, and solutions are refined to those of the
    /// unshifted system.
    Incomplete,
}

/// The factored stiffness of a body of simplices with linear displacements per cell.
///
/// Unknowns are ordered by nested dissection of the node graph; the Cholesky factor is in double precision, solutions are refined. Nodes that no cell uses do not move.
#[derive(Debug)]
pub struct SimplexSystem {
    axes: usize,
    rank_of: Vec<u32>,
    node_at: Vec<u32>,
    symbolic: Arc<SymbolicCholesky>,
    solver: RefinedCholesky,
    columns: usize,
}

impl SimplexSystem {
    /// Assembles and factors the stiffness, held to zero at the components marked in `fixed[node]` (components beyond the dimension do not count), for solves with up to `columns`
    /// right-hand sides.
    ///
    /// # Errors
    /// Stiffness that is not positive definite, a factor that does not fit into memory, interruption by `progress`.
    ///
    /// # Panics
    /// When `fixed` has not one entry per node.
    pub fn new(
        model: &SimplexModel,
        fixed: &[[bool; 3]],
        holding: Holding,
        columns: usize,
        progress: Progress<'_>,
    ) -> Result<Self, SimplexSystemError> {
        let mesh = model.mesh();
        assert_eq!(fixed.len(), mesh.nodes().len(), "one entry per node");
        let axes = mesh.dimension().axes();
        start("ordering nodes", progress)?;
        let node_at = elimination_order(mesh)?;
        let mut rank_of = vec![NO_RANK; fixed.len()];
        node_at.iter().enumerate().for_each(|(rank, node)| rank_of[*node as usize] = rank as u32);
        let blocks = BlockColumns::new(node_at.len(), &cliques(mesh, &rank_of), axes)?;
        start("assembling", progress)?;
        let symbolic = Arc::new(SymbolicCholesky::analyse(blocks.pattern.clone()).map_err(SolverError::from)?);
        let mut solver = RefinedCholesky::for_large(symbolic.clone(), columns)?;
        let is_fixed = |unknown: usize| fixed[node_at[unknown / axes] as usize][unknown % axes];
        solver.refill(|values, marks| {
            marks.iter_mut().enumerate().for_each(|(unknown, mark)| *mark = is_fixed(unknown));
            blocks.assemble(model, &rank_of, marks, values);
        });
        start("factoring", progress)?;
        solver.factor(holding == Holding::Incomplete)?;
        Ok(Self { axes, rank_of, node_at, symbolic, solver, columns })
    }

    /// Displacements \[m\] under nodal forces \[N\], a column per load, and the largest relative residual.
    ///
    /// # Errors
    /// A relative residual above [`TOLERANCE`](crate::solver::TOLERANCE).
    ///
    /// # Panics
    /// When there are more loads than were reserved, or one has not an entry per node.
    pub fn solve(&mut self, loads: &[Vec<[f64; 3]>]) -> Result<(NodalVectors, f64), SimplexSystemError> {
        assert!(loads.len() <= self.columns, "more loads than reserved");
        let axes = self.axes;
        for (column, load) in loads.iter().enumerate() {
            assert_eq!(load.len(), self.rank_of.len(), "one force per node");
            let unknowns = self.solver.loads_mut(column);
            for (at, node) in unknowns.chunks_exact_mut(axes).zip(&self.node_at) {
                at.copy_from_slice(&load[*node as usize][..axes]);
            }
        }
        let residual = SolverError::check(self.solver.solve(loads.len()), self.unknowns())?;
        let displacement = |column: usize| -> Vec<[f64; 3]> {
            let (mut nodes, solution) = (vec![[0.0; 3]; self.rank_of.len()], self.solver.solution(column));
            for (values, node) in solution.chunks_exact(axes).zip(&self.node_at) {
                nodes[*node as usize][..axes].copy_from_slice(values);
            }
            nodes
        };
        Ok(((0..loads.len()).map(displacement).collect(), residual))
    }

    /// Number of unknowns, held ones included.
    pub fn unknowns(&self) -> usize {
        self.symbolic.order()
    }

    /// Number of entries of the factor.
    pub fn factor_entries(&self) -> usize {
        self.symbolic.factor_entries()
    }

    /// Multiplications and additions of the factorisation.
    pub fn factor_flops(&self) -> f64 {
        self.symbolic.factor_flops()
    }
}

/// Reports the start of a stage.
pub(super) fn start(stage: &'static str, progress: Progress<'_>) -> Result<(), SimplexSystemError> {
    match progress(stage, 0, 1) {
        true => Ok(()),
        false => Err(SimplexSystemError::Interrupted { stage }),
    }
}

/// The nodes that cells use, in elimination order.
fn elimination_order(mesh: &SimplexMesh) -> Result<Vec<u32>, GraphOrderError> {
    let mut number_of = vec![NO_RANK; mesh.nodes().len()];
    (0..mesh.cell_count()).flat_map(|cell| mesh.cell(cell)).for_each(|node| number_of[*node as usize] = 0);
    let used: Vec<u32> = (0..mesh.nodes().len() as u32).filter(|node| number_of[*node as usize] == 0).collect();
    used.iter().enumerate().for_each(|(number, node)| number_of[*node as usize] = number as u32);
    let order = clique_order(used.len(), &cliques(mesh, &number_of))?;
    Ok(order.into_iter().map(|number| used[number as usize]).collect())
}

/// The cells by the numbers of their nodes; corners beyond the dimension repeat the first.
pub(super) fn cliques(mesh: &SimplexMesh, number_of: &[u32]) -> Vec<[u32; 4]> {
    let corner = |cell: usize, n: usize| *mesh.cell(cell).get(n).unwrap_or(&mesh.cell(cell)[0]);
    let clique = |cell| std::array::from_fn(|n| number_of[corner(cell, n) as usize]);
    (0..mesh.cell_count()).map(clique).collect()
}
