//! Newton systems of lattices of cells.

use super::super::SolverError;
use super::lattice_cycle::LatticeCycle;
use super::{ElementTangent, FACTOR_LIMIT, LinearReport};
use crate::assembly::{CellStiffness, Constraints};
use crate::linalg::nested_dissection;
use crate::mesh::{Cell, Lattice};

/// The tangent stiffness of a lattice of cells whose matrices change from one Newton iteration to the next.
///
/// Up to [`FACTOR_LIMIT`] unknowns (three per node that touches a solid cell) it is an [`ElementTangent`] with a factor. Beyond,
/// conjugate gradients on the current matrix, kept as 27 blocks of 3×3 per node in double precision, with a multigrid cycle in
/// single precision whose coarser meshes are split where the body is. The cycle may be that of an earlier matrix; the next update
/// renews it after a solve that needs more than 1.5 n + 5 iterations, n being those of the first solve with it, per decimal digit.
///
/// Memory beyond [`FACTOR_LIMIT`]: about 3.4 kB per lattice node (1.9 kB for the matrix, 1 kB for the finest level of the cycle, the rest for
/// coarser meshes), 200 B for vectors, and while a cycle is renewed 0.6 kB for the tangents of coarse elements.
#[derive(Debug)]
pub struct LatticeTangent {
    lattice: Lattice,
    spacing: [f64; 3],
    direct_limit: usize,
    void: Vec<bool>,
    method: Method,
}

#[derive(Debug)]
enum Method {
    Factor(Box<Factored>),
    Cycle(Box<LatticeCycle>),
}

/// The solid cells as elements, the nodes that touch them as vertices.
#[derive(Debug)]
struct Factored {
    tangent: ElementTangent,
    /// The cell of each element.
    cells: Vec<u32>,
    /// The node of each vertex.
    nodes: Vec<u32>,
    vector: Vec<f64>,
}

impl LatticeTangent {
    /// Room for the tangents of a lattice of cells with edges `spacing` \[m\] that are void where `cells` are; their matrices are not read.
    ///
    /// # Errors
    /// When the factor does not fit into indices.
    pub fn new(cells: &dyn CellStiffness, spacing: [f64; 3]) -> Result<Self, SolverError> {
        Self::with_direct_limit(cells, spacing, FACTOR_LIMIT)
    }

    /// The same with a factor up to `limit` unknowns instead of [`FACTOR_LIMIT`].
    ///
    /// # Errors
    /// When the factor does not fit into indices.
    pub fn with_direct_limit(cells: &dyn CellStiffness, spacing: [f64; 3], limit: usize) -> Result<Self, SolverError> {
        let lattice = cells.lattice();
        let void = void(cells);
        let solid: Vec<u32> = (0..lattice.cell_count() as u32).filter(|c| !void[*c as usize]).collect();
        let mut is_active = vec![false; lattice.node_count()];
        solid.iter().flat_map(|c| lattice.corners(Cell(*c as usize))).for_each(|n| is_active[n.0] = true);
        let unknowns = 3 * is_active.iter().filter(|a| **a).count();
        let method = match unknowns <= limit {
            true => Method::Factor(Box::new(Factored::new(lattice, solid, &is_active)?)),
            false => Method::Cycle(Box::new(LatticeCycle::new(lattice, solid, spacing, unknowns)?)),
        };
        Ok(Self { lattice, spacing, direct_limit: limit, void, method })
    }

    /// Takes over the tangents \[N/m\] of the cells; prescribed components and nodes without a solid cell are left out. With `lagged` the
    /// preconditioner may stay that of an earlier matrix; without, and where other components are prescribed than before, it is renewed now. Where other cells are void than
    /// before, everything is made anew.
    ///
    /// # Errors
    /// [`SolverError::Indefinite`] when a factorisation meets a pivot that is not positive.
    ///
    /// # Panics
    /// Panics when the lattice is another one.
    pub fn update(
        &mut self,
        cells: &dyn CellStiffness,
        constraints: &Constraints,
        lagged: bool,
    ) -> Result<(), SolverError> {
        assert_eq!(cells.lattice(), self.lattice, "the lattice of the tangents");
        if (0..self.void.len()).any(|c| cells.stiffness(c).is_none() != self.void[c]) {
            *self = Self::with_direct_limit(cells, self.spacing, self.direct_limit)?;
        }
        match &mut self.method {
            Method::Factor(factored) => factored.update(cells, constraints, lagged),
            Method::Cycle(cycle) => cycle.update(cells, constraints, lagged),
        }
    }

    /// Solves K x = f for `vector`, three entries per lattice node, in place until ‖f − K x‖ ≤ tolerance ‖f‖; what is no unknown is left
    /// out of f and comes out as zero.
    ///
    /// # Errors
    /// As [`ElementTangent::solve`].
    ///
    /// # Panics
    /// Panics when `vector` has not three entries per lattice node.
    pub fn solve(&mut self, vector: &mut [f64], tolerance: f64) -> Result<LinearReport, SolverError> {
        assert_eq!(vector.len(), 3 * self.lattice.node_count(), "three entries per lattice node");
        match &mut self.method {
            Method::Factor(factored) => factored.solve(vector, tolerance),
            Method::Cycle(cycle) => cycle.solve(vector, tolerance),
        }
    }

    /// "cholesky" or "multigrid-pcg".
    pub fn kind(&self) -> &'static str {
        match self.method {
            Method::Factor(_) => "cholesky",
            Method::Cycle(_) => "multigrid-pcg",
        }
    }
}

fn void(cells: &dyn CellStiffness) -> Vec<bool> {
    (0..cells.lattice().cell_count()).map(|c| cells.stiffness(c).is_none()).collect()
}

impl Factored {
    fn new(lattice: Lattice, cells: Vec<u32>, is_active: &[bool]) -> Result<Self, SolverError> {
        let nodes: Vec<u32> = (0..is_active.len() as u32).filter(|n| is_active[*n as usize]).collect();
        let mut vertex = vec![u32::MAX; is_active.len()];
        nodes.iter().enumerate().for_each(|(v, n)| vertex[*n as usize] = v as u32);
        let order = nested_dissection(lattice.nodes()).into_iter().map(|n| vertex[n as usize]);
        let order = order.filter(|v| *v != u32::MAX).collect();
        let corners: Vec<[u32; 8]> =
            cells.iter().map(|c| lattice.corners(Cell(*c as usize)).map(|n| vertex[n.0])).collect();
        let tangent = ElementTangent::new(order, &corners)?;
        let vector = vec![0.0; 3 * nodes.len()];
        Ok(Self { tangent, cells, nodes, vector })
    }

    fn update(
        &mut self,
        cells: &dyn CellStiffness,
        constraints: &Constraints,
        lagged: bool,
    ) -> Result<(), SolverError> {
        let mut of_vertices = Constraints::none(self.nodes.len());
        for (vertex, node) in self.nodes.iter().enumerate() {
            (0..3).filter(|r| constraints.is_fixed(*node as usize, *r)).for_each(|r| of_vertices.fix(vertex, r));
        }
        let solid = &self.cells;
        let stiffness = |element: usize| {
            let (factor, matrix) = cells.stiffness(solid[element] as usize).unwrap_or((0.0, &[0.0; 576]));
            (factor, matrix.as_slice())
        };
        self.tangent.update_scaled(stiffness, &of_vertices, lagged)
    }

    fn solve(&mut self, vector: &mut [f64], tolerance: f64) -> Result<LinearReport, SolverError> {
        for (three, node) in self.vector.chunks_exact_mut(3).zip(&self.nodes) {
            three.copy_from_slice(&vector[3 * *node as usize..][..3]);
        }
        let outcome = self.tangent.solve(&mut self.vector, tolerance);
        vector.fill(0.0);
        for (three, node) in self.vector.chunks_exact(3).zip(&self.nodes) {
            vector[3 * *node as usize..][..3].copy_from_slice(three);
        }
        outcome
    }
}
