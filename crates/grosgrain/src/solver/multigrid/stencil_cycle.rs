//! The multigrid cycle on a lattice whose coarser meshes keep the topology of the body.

use rayon::prelude::*;

use super::chebyshev::Chebyshev;
use super::grid::Layout;
use super::lattice_matrix::{add, fill, scatter};
use super::level::Level;
use super::mesh_cycle::{MeshCycle, SMOOTHING_STEPS};
use super::mesh_grid::{MeshCoarsening, MeshGrid};
use super::stencil::StencilLevel;
use crate::assembly::CellStiffness;
use crate::linalg::{LinearOperator, Preconditioner};
use crate::mesh::{Cell, Lattice};
use crate::solver::SolverError;

/// The finest lattice as 27 blocks per node in single precision; below it meshes of elements, split where the body is.
/// Vectors are those of [`super::LatticeMatrix`].
pub(in crate::solver) struct StencilCycle {
    lattice: Lattice,
    level: StencilLevel,
    smoother: Chebyshev,
    coarsening: MeshCoarsening,
    below: MeshCycle,
    /// The cell of each element of the finest lattice.
    solid: Vec<u32>,
    free: Vec<u8>,
    d: Vec<f64>,
    ax: Vec<f64>,
    /// Three entries per node.
    of_nodes: Vec<f64>,
    coarse_b: Vec<f64>,
    coarse_x: Vec<f64>,
}

impl StencilCycle {
    /// The meshes below the cells `solid` of a lattice with edges `spacing`, without matrices; [`Self::update`] brings them.
    pub fn new(lattice: Lattice, solid: Vec<u32>, spacing: [f64; 3]) -> Result<Self, SolverError> {
        let corners = solid.iter().map(|c| lattice.corners(Cell(*c as usize)).map(|n| n.0 as u32)).collect();
        let grid = MeshGrid { lattice, cells: solid.clone(), corners, vertices: lattice.node_count() };
        let coarsening = MeshCoarsening::new(&grid, spacing);
        let below = MeshCycle::new(coarsening.coarse.clone(), coarsening.edges)?;
        let level = StencilLevel::new(lattice);
        let zeros = vec![0.0; level.layout().length()];
        let coarse = vec![0.0; 3 * coarsening.coarse.vertices];
        Ok(Self {
            smoother: Chebyshev { eigenvalue: 1.0, steps: SMOOTHING_STEPS },
            free: vec![7; lattice.node_count()],
            d: zeros.clone(),
            ax: zeros,
            of_nodes: vec![0.0; 3 * lattice.node_count()],
            coarse_b: coarse.clone(),
            coarse_x: coarse,
            lattice,
            level,
            coarsening,
            below,
            solid,
        })
    }

    /// Takes over the tangents of the cells; bit r of an entry of `free` is set if component r of the node is an unknown.
    ///
    /// # Errors
    /// [`SolverError::Indefinite`] when the coarsest matrix is not positive definite.
    pub fn update(&mut self, cells: &dyn CellStiffness, free: &[u8]) -> Result<(), SolverError> {
        self.free.copy_from_slice(free);
        fill(&mut self.level, cells, free);
        let mut x = vec![0.0; self.d.len()];
        self.smoother = Chebyshev::new(&self.level, SMOOTHING_STEPS, [&mut x, &mut self.ax, &mut self.d]);
        let (solid, lattice) = (&self.solid, self.lattice);
        let elements = self.coarsening.galerkin(&|element| held_cell(cells, lattice, solid[element] as usize, free));
        let all = vec![7; self.coarsening.coarse.vertices];
        self.below.update(&all, &|element| (1.0, &elements[element]))
    }

    fn places(&self) -> (Layout, Lattice) {
        (self.level.layout(), self.lattice)
    }

    fn smooth(&mut self, b: &[f64], x: &mut [f64], from_zero: bool) {
        self.smoother.smooth(&self.level, b, [x, &mut self.d, &mut self.ax], from_zero);
    }
}

impl Preconditioner for StencilCycle {
    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.smooth(r, z, true);
        self.level.apply(z, &mut self.ax);
        self.ax.par_iter_mut().zip(r).with_min_len(4096).for_each(|(ax, r)| *ax = r - *ax);
        scatter(self.places(), &self.ax, &mut self.of_nodes);
        self.coarsening.restrict(&self.of_nodes, &mut self.coarse_b);
        self.below.improve(&self.coarse_b, &mut self.coarse_x, false);
        self.below.improve(&self.coarse_b, &mut self.coarse_x, true);
        self.of_nodes.fill(0.0);
        self.coarsening.prolong(&self.coarse_x, &self.free, &mut self.of_nodes);
        add(self.places(), &self.of_nodes, z);
        self.smooth(r, z, false);
    }
}

/// The matrix of a cell with zero rows and columns where a component is no unknown.
fn held_cell(cells: &dyn CellStiffness, lattice: Lattice, cell: usize, free: &[u8]) -> crate::element::CellMatrix {
    let Some((factor, matrix)) = cells.stiffness(cell) else { return [0.0; 576] };
    super::galerkin::held(matrix, &lattice.corners(Cell(cell)).map(|n| free[n.0])).map(|value| factor * value)
}

impl std::fmt::Debug for StencilCycle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("StencilCycle").field("lattice", &self.lattice).field("below", &self.below).finish()
    }
}
