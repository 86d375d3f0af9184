//! The multigrid cycle on meshes of elements in the cells of a lattice, split ones included.

use std::sync::Arc;

use rayon::prelude::*;

use super::chebyshev::Chebyshev;
use super::galerkin::{CellMatrices, held};
use super::grid::Layout;
use super::level::{BlockJacobi, Level};
use super::mesh_grid::{MeshCoarsening, MeshGrid};
use crate::element::CellMatrix;
use crate::linalg::{Cholesky, CholeskyError, LinearOperator, Preconditioner, SymbolicCholesky};
use crate::solver::SolverError;
use crate::solver::block_matrix::BlockMatrix;

/// Smoothing steps before and after each coarse correction.
const SMOOTHING_STEPS: usize = 3;
/// Largest number of unknowns of the coarsest mesh.
const COARSEST_UNKNOWNS: usize = 3000;
/// Diagonal shift of the coarsest matrix, relative to its diagonal.
const SHIFT: f64 = 1e-10;

/// A hierarchy of meshes: topology once, matrices in single precision as often as they change.
#[derive(Debug)]
pub(in crate::solver) struct MeshCycle {
    stages: Vec<Stage>,
    coarsest: BlockMatrix,
    values: Vec<f64>,
    cholesky: Cholesky,
}

#[derive(Debug)]
struct Stage {
    level: MeshLevel,
    coarsening: MeshCoarsening,
    smoother: Chebyshev,
    d: Vec<f64>,
    ax: Vec<f64>,
    coarse_b: Vec<f64>,
    coarse_x: Vec<f64>,
}

#[derive(Debug)]
struct MeshLevel {
    matrix: BlockMatrix<f32>,
    jacobi: BlockJacobi,
}

impl MeshCycle {
    /// The meshes below `finest`, whose cells have edges `spacing`, without matrices; [`Self::update`] brings them.
    pub fn new(finest: MeshGrid, spacing: [f64; 3]) -> Result<Self, SolverError> {
        let (mut stages, mut grid, mut edges) = (Vec::new(), finest, spacing);
        while stages.is_empty() || 3 * grid.vertices > COARSEST_UNKNOWNS && grid.lattice.cell_count() > 1 {
            let coarsening = MeshCoarsening::new(&grid, edges);
            let next = coarsening.coarse.clone();
            edges = coarsening.edges;
            stages.push(Stage::new(grid, coarsening)?);
            grid = next;
        }
        let coarsest = BlockMatrix::new(grid.vertices, grid.corners)?;
        let symbolic = Arc::new(SymbolicCholesky::analyse(Arc::new(coarsest.lower_pattern()))?);
        let values = vec![0.0; symbolic.pattern().entry_count()];
        Ok(Self { stages, coarsest, values, cholesky: Cholesky::new(symbolic, 1)? })
    }

    /// Takes over the finest matrix and the elements that it is made of.
    ///
    /// # Errors
    /// [`SolverError::Indefinite`] when the coarsest matrix is not positive definite.
    pub fn update<'k>(
        &mut self,
        finest: &BlockMatrix,
        stiffness: &(impl Fn(usize) -> (f64, &'k CellMatrix) + Sync),
    ) -> Result<(), SolverError> {
        let mut elements: CellMatrices = Vec::new();
        for (n, stage) in self.stages.iter_mut().enumerate() {
            if n == 0 {
                finest.rounded_into(&mut stage.level.matrix);
                elements = stage.coarsening.galerkin(&|element| {
                    let (factor, matrix) = stiffness(element);
                    let free = finest.corners()[element].map(|v| finest.free()[v as usize]);
                    held(matrix, &free).map(|value| factor * value)
                });
            } else {
                stage.level.matrix.assemble(&|element| (1.0, &elements[element]));
                elements = stage.coarsening.galerkin(&|element| elements[element]);
            }
            stage.prepare();
        }
        self.coarsest.assemble(&|element| (1.0, &elements[element]));
        self.coarsest.lower_into(SHIFT, &mut self.values);
        self.cholesky.factor(&self.values).map_err(|error| match error {
            CholeskyError::NotPositiveDefinite { pivot, order } => SolverError::Indefinite {
                unknowns: 3 * finest.vertices(),
                evidence: format!("pivot {pivot} of {order} on the coarsest mesh"),
            },
            other => other.into(),
        })
    }

    /// Multiplications of one cycle.
    pub fn operations(&self) -> f64 {
        let applications = 2.0 * SMOOTHING_STEPS as f64;
        self.stages.iter().map(|stage| applications * stage.level.matrix.operations()).sum()
    }
}

impl Preconditioner for MeshCycle {
    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        descend(&mut self.stages, &mut self.cholesky, r, z);
    }
}

/// One V-cycle on A x = b from zero.
fn descend(stages: &mut [Stage], coarsest: &mut Cholesky, b: &[f64], x: &mut [f64]) {
    let Some((stage, rest)) = stages.split_first_mut() else {
        x.copy_from_slice(b);
        return coarsest.solve_in_place(x);
    };
    stage.smooth(b, x, true);
    stage.level.apply(x, &mut stage.ax);
    stage.ax.par_iter_mut().zip(b).with_min_len(4096).for_each(|(ax, b)| *ax = b - *ax);
    stage.coarsening.restrict(&stage.ax, &mut stage.coarse_b);
    descend(rest, coarsest, &stage.coarse_b, &mut stage.coarse_x);
    stage.coarsening.prolong(&stage.coarse_x, stage.level.matrix.free(), x);
    stage.smooth(b, x, false);
}

impl Stage {
    fn new(grid: MeshGrid, coarsening: MeshCoarsening) -> Result<Self, SolverError> {
        let [fine, coarse] = [grid.vertices, coarsening.coarse.vertices].map(|n| vec![0.0; 3 * n]);
        let level =
            MeshLevel { matrix: BlockMatrix::new(grid.vertices, grid.corners)?, jacobi: BlockJacobi::default() };
        let smoother = Chebyshev { eigenvalue: 1.0, steps: SMOOTHING_STEPS };
        Ok(Self { level, coarsening, smoother, d: fine.clone(), ax: fine, coarse_b: coarse.clone(), coarse_x: coarse })
    }

    /// What the smoother needs of a new matrix.
    fn prepare(&mut self) {
        self.level.jacobi.renew(self.level.matrix.diagonal_blocks());
        let mut x = vec![0.0; self.d.len()];
        self.smoother = Chebyshev::new(&self.level, SMOOTHING_STEPS, [&mut x, &mut self.ax, &mut self.d]);
    }

    fn smooth(&mut self, b: &[f64], x: &mut [f64], from_zero: bool) {
        self.smoother.smooth(&self.level, b, [x, &mut self.d, &mut self.ax], from_zero);
    }
}

impl LinearOperator for MeshLevel {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.matrix.apply(x, y);
    }
}

impl Level for MeshLevel {
    fn layout(&self) -> Layout {
        Layout::list(self.matrix.vertices())
    }

    fn relax(&self, factors: [f64; 2], b: &[f64], ax: Option<&[f64]>, vectors: [&mut [f64]; 2]) {
        self.jacobi.relax(factors, b, ax, vectors);
    }
}
