//! The multigrid cycle on meshes of elements in the cells of a lattice, split ones included.
//!
//! W cycles, because meshes that keep the topology have stiff layers too that coarse cells do not resolve, and a second visit of the
//! coarser meshes costs a seventh of a cycle (`examples/tangent_solvers.rs`).

use std::sync::Arc;

use rayon::prelude::*;

use super::chebyshev::Chebyshev;
use super::galerkin::{CellMatrices, held};
use super::grid::Layout;
use super::level::{BlockJacobi, Level};
use super::mesh_grid::{MeshCoarsening, MeshGrid};
use crate::linalg::{Cholesky, CholeskyError, LinearOperator, Preconditioner, SymbolicCholesky};
use crate::solver::SolverError;
use crate::solver::block_matrix::BlockMatrix;

/// Smoothing steps before and after each coarse correction.
pub(super) const SMOOTHING_STEPS: usize = 3;
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
        Self::down_to(COARSEST_UNKNOWNS, finest, spacing)
    }

    fn down_to(coarsest_unknowns: usize, finest: MeshGrid, spacing: [f64; 3]) -> Result<Self, SolverError> {
        let (mut stages, mut grid, mut edges) = (Vec::new(), finest, spacing);
        while stages.is_empty() || 3 * grid.vertices > coarsest_unknowns && grid.lattice.cell_count() > 1 {
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

    /// Takes over the tangents of the elements; bit r of an entry of `free` is set if component r of the vertex is an unknown.
    ///
    /// # Errors
    /// [`SolverError::Indefinite`] when the coarsest matrix is not positive definite.
    pub fn update<'k>(
        &mut self,
        free: &[u8],
        stiffness: &(impl Fn(usize) -> (f64, &'k [f64]) + Sync),
    ) -> Result<(), SolverError> {
        let Some((first, rest)) = self.stages.split_first_mut() else { return Ok(()) };
        first.level.matrix.set_free(free);
        first.level.matrix.assemble(stiffness);
        let corners = first.level.matrix.corners();
        let mut elements: CellMatrices = first.coarsening.galerkin(&|element| {
            let (factor, matrix) = stiffness(element);
            held(matrix, &corners[element].map(|v| free[v as usize])).map(|value| factor * value)
        });
        first.prepare();
        for stage in rest {
            stage.level.matrix.assemble(&|element| (1.0, elements[element].as_slice()));
            elements = stage.coarsening.galerkin(&|element| elements[element]);
            stage.prepare();
        }
        self.coarsest.assemble(&|element| (1.0, elements[element].as_slice()));
        self.coarsest.lower_into(SHIFT, &mut self.values);
        self.cholesky.factor(&self.values).map_err(|error| match error {
            CholeskyError::NotPositiveDefinite { pivot, order } => SolverError::Indefinite {
                unknowns: 3 * free.len(),
                evidence: format!("pivot {pivot} of {order} on the coarsest mesh"),
            },
            other => other.into(),
        })
    }

    /// One W-cycle on A x = b; x is overwritten, or improved if it is a `revisit`.
    pub(super) fn improve(&mut self, b: &[f64], x: &mut [f64], revisit: bool) {
        descend(&mut self.stages, &mut self.cholesky, b, x, revisit);
    }
}

impl Preconditioner for MeshCycle {
    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.improve(r, z, false);
    }
}

fn descend(stages: &mut [Stage], coarsest: &mut Cholesky, b: &[f64], x: &mut [f64], revisit: bool) {
    let Some((stage, rest)) = stages.split_first_mut() else {
        x.copy_from_slice(b);
        return coarsest.solve_in_place(x);
    };
    stage.smooth(b, x, !revisit);
    stage.level.apply(x, &mut stage.ax);
    stage.ax.par_iter_mut().zip(b).with_min_len(4096).for_each(|(ax, b)| *ax = b - *ax);
    stage.coarsening.restrict(&stage.ax, &mut stage.coarse_b);
    descend(rest, coarsest, &stage.coarse_b, &mut stage.coarse_x, false);
    if !rest.is_empty() {
        descend(rest, coarsest, &stage.coarse_b, &mut stage.coarse_x, true);
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellMatrix;
    use crate::linalg::dot;
    use crate::mesh::{Cell, Lattice};
    use crate::solver::multigrid::mesh_grid::tests::{noise, slit};

    /// Anything symmetric and positive definite serves: a Laplacian of each component with a mass, stiffer in every third cell.
    fn matrix(cell: u32) -> CellMatrix {
        let factor = if cell.is_multiple_of(3) { 100.0 } else { 1.0 };
        std::array::from_fn(|e| {
            let (row, column) = (e / 24, e % 24);
            match (row % 3 == column % 3, row == column) {
                (true, true) => factor * 7.0 + 0.01,
                (true, false) => -factor,
                _ => 0.0,
            }
        })
    }

    #[test]
    fn the_cycle_is_a_symmetric_positive_definite_map_on_a_body_with_a_slit() {
        let grid = slit([9, 8, 6]);
        let matrices: Vec<CellMatrix> = grid.cells.iter().map(|cell| matrix(*cell)).collect();
        let mut cycle = MeshCycle::down_to(60, grid.clone(), [1.0; 3]).unwrap();
        assert!(cycle.stages.len() >= 3, "{} stages", cycle.stages.len());
        let free: Vec<u8> = (0..grid.vertices).map(|v| if v % 11 == 0 { 5 } else { 7 }).collect();
        cycle.update(&free, &|element| (1.0, matrices[element].as_slice())).unwrap();
        let keep = |v: Vec<f64>| -> Vec<f64> {
            v.iter().enumerate().map(|(i, v)| if free[i / 3] >> (i % 3) & 1 == 1 { *v } else { 0.0 }).collect()
        };
        let [x, y] = [1, 2].map(|seed| keep(noise(seed, 3 * grid.vertices)));
        let [mut mx, mut my] = [vec![f64::NAN; x.len()], vec![f64::NAN; x.len()]];
        cycle.apply(&x, &mut mx);
        cycle.apply(&y, &mut my);
        let (xx, yy, xy, yx) = (dot(&mx, &x), dot(&my, &y), dot(&mx, &y), dot(&x, &my));
        assert!(xx > 0.0 && yy > 0.0, "{xx:e} {yy:e}");
        // Matrices are rounded to single precision, 6e-8, entry by entry.
        assert!((xy - yx).abs() <= 1e-5 * (xx * yy).sqrt(), "{xy:e} against {yx:e}");
        assert_eq!(keep(mx.clone()), mx, "components that are no unknowns stay zero");
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let lattice = Lattice::new([4, 4, 4]);
        let corners = (0..64).map(|c| lattice.corners(Cell(c)).map(|n| n.0 as u32)).collect();
        let grid = MeshGrid { lattice, cells: (0..64).collect(), corners, vertices: lattice.node_count() };
        let mut cycle = MeshCycle::new(grid, [1.0; 3]).unwrap();
        let mut negative = matrix(1);
        (0..24).for_each(|i| negative[25 * i] -= 0.02);
        let outcome = cycle.update(&[7; 125], &|_| (1.0, negative.as_slice()));
        assert!(matches!(outcome, Err(SolverError::Indefinite { .. })), "{outcome:?}");
    }
}
