//! Geometric multigrid for elasticity on voxel lattices, a preconditioner for conjugate gradients.
//!
//! The lattice is halved (rounding up) until few unknowns are left. Prolongation is trilinear, with zero rows for
//! prescribed components; coarse operators are Galerkin products Pᵀ K P, kept as 27 blocks of 3×3 per node in
//! single precision; the finest operator stays matrix-free. The smoother is a Chebyshev polynomial with block Jacobi;
//! the coarsest lattice is solved by a dense Cholesky factor. The cycle is symmetric, as conjugate gradients need.
//!
//! Defaults are by measurement (`examples/multigrid_study.rs`, 64 cells a side): three smoothing steps take about the
//! time of two; W cycles save a third of the iterations in thin layers of contrast 1e3 and a tenth of the time at most,
//! and cost time elsewhere; coefficients in double precision changed no iteration count at contrast 1e6.
//! Stiff layers thinner than a coarse cell are the hardest case: trilinear prolongation cannot follow them.

mod chebyshev;
mod coarsest;
mod galerkin;
mod grid;
mod lattice_matrix;
mod level;
mod mesh_cycle;
mod mesh_grid;
mod stencil;
mod stencil_cycle;
mod transfer;

use rayon::prelude::*;

use crate::assembly::{CellStiffness, MatrixFree};
use crate::linalg::{DenseCholeskyError, Preconditioner};

pub(super) use lattice_matrix::LatticeMatrix;
pub(super) use mesh_cycle::MeshCycle;
pub(super) use mesh_grid::MeshGrid;
pub(super) use stencil_cycle::StencilCycle;

use chebyshev::Chebyshev;
use coarsest::Coarsest;
use galerkin::{CellMatrices, FineCells, add_layer};
use grid::{Coarsening, Layout};
use level::{FineLevel, Level};
use stencil::StencilLevel;
use transfer::Transfer;

/// How often each coarser lattice is visited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cycle {
    /// Once per visit of the finer one.
    V,
    /// Twice per visit of the finer one, from the second lattice on.
    W,
}

/// How to build and run the cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultigridParameters {
    /// Smoothing steps before and after each coarse correction.
    pub smoothing_steps: usize,
    /// V or W.
    pub cycle: Cycle,
    /// Largest number of unknowns that the coarsest lattice may have.
    pub coarsest_unknowns: usize,
    /// Edge lengths of a fine cell \[m\]; axes with much longer edges are halved later.
    pub spacing: [f64; 3],
    /// Added to the coarsest matrix, relative to its diagonal, so that a free body can be factored.
    pub shift: f64,
}

impl Default for MultigridParameters {
    fn default() -> Self {
        Self { smoothing_steps: 3, cycle: Cycle::V, coarsest_unknowns: 1200, spacing: [1.0; 3], shift: 1e-10 }
    }
}

/// Why there is no hierarchy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MultigridError {
    /// No smoothing steps.
    #[error("multigrid needs at least 1 smoothing step, 0 were asked for")]
    Smoothing,
    /// The coarsest lattice cannot be factored.
    #[error(
        "the coarsest lattice of {cells:?} cells cannot be factored; check moduli for overflow, or raise the shift"
    )]
    Coarsest {
        /// Its number of cells.
        cells: [usize; 3],
        /// What the factorisation met.
        source: DenseCholeskyError,
    },
}

/// A hierarchy of lattices; [`Preconditioner::apply`] runs one cycle from zero.
pub struct Multigrid<'a> {
    levels: Vec<Stage<'a>>,
    coarsest: Coarsest,
    parameters: MultigridParameters,
}

/// A lattice with its way down to the next and its vectors.
struct Stage<'a> {
    level: Box<dyn Level + 'a>,
    transfer: Transfer,
    smoother: Chebyshev,
    d: Vec<f64>,
    ax: Vec<f64>,
    /// Right-hand side and solution of the next coarser lattice.
    coarse_b: Vec<f64>,
    coarse_x: Vec<f64>,
}

impl<'a> Multigrid<'a> {
    /// The hierarchy below `operator`, which must be that of the same `cells`.
    ///
    /// # Errors
    /// No smoothing steps; a coarsest matrix that is not positive definite.
    pub fn new(
        operator: &'a MatrixFree<'a>,
        cells: &'a dyn CellStiffness,
        parameters: MultigridParameters,
    ) -> Result<Self, MultigridError> {
        let MultigridParameters { smoothing_steps, shift, .. } = parameters;
        if smoothing_steps == 0 {
            return Err(MultigridError::Smoothing);
        }
        let mut steps = coarsenings(operator, &parameters);
        let first = steps.remove(0);
        let fine = FineCells::new(cells, operator.free(), first);
        let free = Some(operator.free().to_vec());
        let mut levels = vec![Stage::new(Box::new(FineLevel::new(operator)), first, free, smoothing_steps)];
        let mut layers = Layers::Computed(Box::new(fine));
        let mut last = first.coarse;
        for step in steps {
            let mut level = StencilLevel::new(step.fine);
            let coarse = layers.descend(&step, &mut level);
            levels.push(Stage::new(Box::new(level), step, None, smoothing_steps));
            layers = Layers::Stored(coarse, step.coarse.cells[0] * step.coarse.cells[1]);
            last = step.coarse;
        }
        let coarsest = Coarsest::new(last, |k| layers.layer(k), shift)
            .map_err(|source| MultigridError::Coarsest { cells: last.cells, source })?;
        Ok(Self { levels, coarsest, parameters })
    }

    /// Number of lattices, the finest and the coarsest included.
    pub fn level_count(&self) -> usize {
        self.levels.len() + 1
    }

    /// Upper estimates of the largest eigenvalue of D⁻¹A, finest lattice first.
    pub fn eigenvalues(&self) -> Vec<f64> {
        self.levels.iter().map(|l| l.smoother.eigenvalue).collect()
    }
}

impl Preconditioner for Multigrid<'_> {
    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        descend(&mut self.levels, (&self.coarsest, &self.parameters), r, z, false);
    }
}

/// One cycle on A x = b; x is overwritten, or improved if it is a `revisit`.
fn descend(levels: &mut [Stage], settings: (&Coarsest, &MultigridParameters), b: &[f64], x: &mut [f64], revisit: bool) {
    let (coarsest, parameters) = settings;
    let Some((stage, rest)) = levels.split_first_mut() else {
        return coarsest.solve(b, x);
    };
    stage.smooth(b, x, !revisit);
    stage.restrict_residual(b, x);
    descend(rest, settings, &stage.coarse_b, &mut stage.coarse_x, false);
    if parameters.cycle == Cycle::W && !rest.is_empty() {
        descend(rest, settings, &stage.coarse_b, &mut stage.coarse_x, true);
    }
    stage.transfer.prolong(&stage.coarse_x, x);
    stage.smooth(b, x, false);
}

impl<'a> Stage<'a> {
    fn new(level: Box<dyn Level + 'a>, coarsening: Coarsening, free: Option<Vec<u8>>, steps: usize) -> Self {
        let (fine, coarse) = (level.layout(), Layout::rows(coarsening.coarse));
        let zeros = |layout: Layout| vec![0.0; layout.length()];
        let (mut x, mut d, mut ax) = (zeros(fine), zeros(fine), zeros(fine));
        let smoother = Chebyshev::new(level.as_ref(), steps, [&mut x, &mut ax, &mut d]);
        let transfer = Transfer { coarsening, fine, coarse, free };
        Self { level, transfer, smoother, d, ax, coarse_b: zeros(coarse), coarse_x: zeros(coarse) }
    }

    fn smooth(&mut self, b: &[f64], x: &mut [f64], from_zero: bool) {
        let Self { level, smoother, d, ax, .. } = self;
        smoother.smooth(level.as_ref(), b, [x, d, ax], from_zero);
    }

    /// coarse_b = Pᵀ (b − A x).
    fn restrict_residual(&mut self, b: &[f64], x: &[f64]) {
        self.level.apply(x, &mut self.ax);
        self.ax.par_iter_mut().zip(b).with_min_len(4096).for_each(|(ax, b)| *ax = b - *ax);
        self.transfer.restrict(&self.ax, &mut self.coarse_b);
    }
}

/// Halvings until few unknowns or one cell are left; at least one.
fn coarsenings(operator: &MatrixFree, parameters: &MultigridParameters) -> Vec<Coarsening> {
    let (mut steps, mut lattice, mut spacing) = (Vec::new(), operator.lattice(), parameters.spacing);
    while steps.is_empty() || 3 * lattice.node_count() > parameters.coarsest_unknowns && lattice.cell_count() > 1 {
        let (step, edges) = Coarsening::new(lattice, spacing);
        (lattice, spacing) = (step.coarse, edges);
        steps.push(step);
    }
    steps
}

/// The cell matrices of a coarse lattice, layer by layer.
enum Layers<'a> {
    /// Computed from the finest cells when asked for.
    Computed(Box<FineCells<'a>>),
    /// All of them, and the number per layer.
    Stored(CellMatrices, usize),
}

impl Layers<'_> {
    fn layer(&self, k: usize) -> CellMatrices {
        match self {
            Self::Computed(cells) => cells.coarse_layer(k),
            Self::Stored(all, count) => all[k * count..(k + 1) * count].to_vec(),
        }
    }

    /// Fills `level` and returns the matrices of the next coarser cells.
    fn descend(&self, step: &Coarsening, level: &mut StencilLevel) -> CellMatrices {
        let mut coarse = vec![[0.0; 576]; step.coarse.cell_count()];
        let mut below = Vec::new();
        for k in 0..step.fine.cells[2] {
            let above = self.layer(k);
            level.set_layer(k, &below, &above);
            add_layer(step, k, &above, &mut coarse);
            below = above;
        }
        level.set_layer(step.fine.cells[2], &below, &[]);
        coarse
    }
}
