//! Direct solution of a mesh of eight-node elements with any topology.

use std::sync::Arc;

use super::SolverError;
use super::refined_cholesky::RefinedCholesky;
use crate::assembly::Constraints;
use crate::element::CellMatrix;
use crate::linalg::{CholeskyError, SparsePattern, SymbolicCholesky};

/// No block: the other triangle holds it.
const NONE: u32 = u32::MAX;

/// The stiffness of elements that meet at vertices, three unknowns per vertex; analysed once, factored and solved often.
///
/// The topology decides the pattern, so a system is kept as long as elements meet at the same vertices.
#[derive(Debug)]
pub struct ElementSystem {
    /// Vertices in elimination order.
    order: Vec<u32>,
    /// Corners of each element as positions in elimination order.
    corners: Vec<[u32; 8]>,
    /// Per element, for corners a and b, which of the blocks in the columns of a holds the rows of b.
    blocks: Vec<[u32; 64]>,
    symbolic: Arc<SymbolicCholesky>,
    system: RefinedCholesky,
}

impl ElementSystem {
    /// A system of elements with these corners, whose vertices are eliminated in the given `order`, each of them once.
    ///
    /// # Errors
    /// When the factor does not fit into memory.
    ///
    /// # Panics
    /// Panics when a corner is not in `order`.
    pub fn new(order: Vec<u32>, corners: &[[u32; 8]]) -> Result<Self, SolverError> {
        let mut rank = vec![NONE; order.len()];
        order.iter().enumerate().for_each(|(r, v)| rank[*v as usize] = r as u32);
        let corners: Vec<[u32; 8]> = corners.iter().map(|c| c.map(|v| rank[v as usize])).collect();
        let later = later_neighbours(order.len(), &corners);
        let entries: usize = later.iter().map(|list| 9 * list.len() - 3).sum();
        if entries > u32::MAX as usize {
            return Err(CholeskyError::TooLarge { order: 3 * order.len() }.into());
        }
        let symbolic = Arc::new(SymbolicCholesky::analyse(Arc::new(sparse_pattern(&later)))?);
        let system = RefinedCholesky::for_large(symbolic.clone(), 1)?;
        let block = |a: u32, b: u32| match b < a {
            true => NONE,
            false => later[a as usize].binary_search(&b).map_or(NONE, |m| m as u32),
        };
        let blocks = corners.iter().map(|c| std::array::from_fn(|n| block(c[n / 8], c[n % 8]))).collect();
        Ok(Self { order, corners, blocks, symbolic, system })
    }

    /// Number of unknowns, three per vertex.
    pub fn unknowns(&self) -> usize {
        3 * self.order.len()
    }

    /// Adds up the stiffness \[N/m\] of the elements by their numbers and factors it; prescribed components of vertices become
    /// identity rows and columns.
    ///
    /// # Errors
    /// When the stiffness is not positive definite even with its diagonal shifted a little.
    pub fn factor<'k>(
        &mut self,
        stiffness: impl Fn(usize) -> &'k CellMatrix,
        constraints: &Constraints,
    ) -> Result<(), SolverError> {
        let Self { order, corners, blocks, symbolic, system } = self;
        let starts = &symbolic.pattern().column_starts;
        system.refill(|values, fixed| {
            for (rank, vertex) in order.iter().enumerate() {
                (0..3).for_each(|r| fixed[3 * rank + r] = constraints.is_fixed(*vertex as usize, r));
            }
            values.fill(0.0);
            for (element, (corners, blocks)) in corners.iter().zip(blocks.iter()).enumerate() {
                add_element((corners, blocks), stiffness(element), (starts, fixed), values);
            }
            // Prescribed unknowns, and those that nothing resists.
            for start in &starts[..starts.len() - 1] {
                let diagonal = &mut values[*start as usize];
                *diagonal = if *diagonal == 0.0 { 1.0 } else { *diagonal };
            }
        });
        self.system.factor(false)
    }

    /// Solves K u = f for `vector`, three entries per vertex, in place; prescribed components come out as zero. Returns the relative
    /// residual.
    ///
    /// # Errors
    /// When a relative residual of [`super::TOLERANCE`] is not reached.
    ///
    /// # Panics
    /// Panics when `vector` has not three entries per vertex.
    pub fn solve(&mut self, vector: &mut [f64]) -> Result<f64, SolverError> {
        assert_eq!(vector.len(), self.unknowns(), "three entries per vertex");
        let loads = self.system.loads_mut(0);
        for (three, vertex) in loads.chunks_exact_mut(3).zip(&self.order) {
            three.copy_from_slice(&vector[3 * *vertex as usize..][..3]);
        }
        let residual = SolverError::check(self.system.solve(1), self.unknowns())?;
        for (three, vertex) in self.system.solution(0).chunks_exact(3).zip(&self.order) {
            vector[3 * *vertex as usize..][..3].copy_from_slice(three);
        }
        Ok(residual)
    }
}

/// For each vertex in elimination order itself and the vertices it shares an element with that come later, ascending.
fn later_neighbours(vertices: usize, corners: &[[u32; 8]]) -> Vec<Vec<u32>> {
    let mut later: Vec<Vec<u32>> = (0..vertices as u32).map(|v| vec![v]).collect();
    for corners in corners {
        for &a in corners {
            later[a as usize].extend(corners.iter().filter(|b| **b > a));
        }
    }
    for list in &mut later {
        list.sort_unstable();
        list.dedup();
    }
    later
}

fn sparse_pattern(later: &[Vec<u32>]) -> SparsePattern {
    let (mut column_starts, mut rows) = (vec![0], Vec::new());
    for (vertex, list) in later.iter().enumerate() {
        for column in 0..3 {
            rows.extend(list.iter().flat_map(|v| 3 * v..3 * v + 3).filter(|row| *row as usize >= 3 * vertex + column));
            column_starts.push(rows.len() as u32);
        }
    }
    SparsePattern { column_starts, rows }
}

/// Adds an element's matrix to the lower triangle, rows and columns of prescribed unknowns left out.
fn add_element(
    (corners, blocks): (&[u32; 8], &[u32; 64]),
    matrix: &CellMatrix,
    (starts, fixed): (&[u32], &[bool]),
    values: &mut [f64],
) {
    for (n, &block) in blocks.iter().enumerate().filter(|(_, block)| **block != NONE) {
        let (a, b) = (n / 8, n % 8);
        let (column, row) = (3 * corners[a] as usize, 3 * corners[b] as usize);
        for c in (0..3).filter(|c| !fixed[column + c]) {
            let first = if a == b { c } else { 0 };
            for r in (first..3).filter(|r| !fixed[row + r]) {
                // The column of the diagonal block starts at its diagonal, c entries later than those of a full block.
                let entry = starts[column + c] as usize + 3 * block as usize + r - c;
                values[entry] += matrix[24 * (3 * b + r) + 3 * a + c];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::{CellStiffness, LatticePattern};
    use crate::element::Hex8;
    use crate::linalg::nested_dissection;
    use crate::material::IsotropicMaterial;
    use crate::mesh::{Cell, Lattice, Node};
    use crate::solver::{AnalysedLattice, DirectSolver, Support};

    struct Block {
        lattice: Lattice,
        matrices: Vec<CellMatrix>,
    }

    impl Block {
        fn new(cells: [usize; 3]) -> Self {
            let lattice = Lattice::new(cells);
            let young = |c: usize| 1.0 + (c * c % 7) as f64;
            let tensor = |c: usize| IsotropicMaterial::new(young(c), 0.3).unwrap().tensor();
            let matrices = (0..lattice.cell_count()).map(|c| Hex8::new([1.0, 2.0, 0.5]).stiffness(&tensor(c)));
            Self { lattice, matrices: matrices.collect() }
        }

        fn corners(&self) -> Vec<[u32; 8]> {
            (0..self.lattice.cell_count()).map(|c| self.lattice.corners(Cell(c)).map(|n| n.0 as u32)).collect()
        }

        fn held(&self) -> Constraints {
            let nodes = self.lattice.node_count();
            let mut constraints = Constraints::nodes(
                &(0..nodes).map(|n| self.lattice.node_position(Node(n))[0] == 0).collect::<Vec<_>>(),
            );
            constraints.fix(nodes - 1, 1);
            constraints
        }
    }

    impl CellStiffness for Block {
        fn lattice(&self) -> Lattice {
            self.lattice
        }

        fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
            Some((1.0, &self.matrices[cell]))
        }
    }

    fn loads(n: usize) -> Vec<f64> {
        (0..n).map(|i| (0.7 * i as f64).sin()).collect()
    }

    fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
        let scale = b.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        a.iter().zip(b).fold(0.0f64, |m, (x, y)| m.max((x - y).abs())) / scale
    }

    fn lattice_solution(block: &Block, loads: &[f64]) -> Vec<f64> {
        let analysed = Arc::new(AnalysedLattice::new(LatticePattern::full(block.lattice)).unwrap());
        let mut solver = DirectSolver::new(analysed, 1).unwrap();
        solver.factor(block, &Support::Constraints(block.held())).unwrap();
        let mut solution = loads.to_vec();
        solver.solve_in_place(&mut solution);
        solution
    }

    #[test]
    fn on_a_lattice_solutions_are_those_of_the_lattice_solver_in_any_elimination_order() {
        let block = Block::new([4, 3, 2]);
        let nodes = block.lattice.node_count();
        let exact = lattice_solution(&block, &loads(3 * nodes));
        for order in [nested_dissection(block.lattice.nodes()), (0..nodes as u32).rev().collect()] {
            let mut system = ElementSystem::new(order, &block.corners()).unwrap();
            // Factoring again gives the same: nothing of the first matrix is left.
            for _ in 0..2 {
                system.factor(|e| &block.matrices[e], &block.held()).unwrap();
                let mut found = loads(3 * nodes);
                let residual = system.solve(&mut found).unwrap();
                assert!(residual < 1e-12, "residual {residual:.1e}");
                let difference = largest_difference(&found, &exact);
                assert!(difference < 1e-11, "{difference:.1e}");
            }
        }
    }

    #[test]
    fn elements_on_copies_of_the_same_nodes_do_not_feel_each_other() {
        let block = Block::new([3, 2, 2]);
        let nodes = block.lattice.node_count() as u32;
        let mut corners = block.corners();
        corners.extend(block.corners().iter().map(|c| c.map(|v| v + nodes)));
        let order = nested_dissection(block.lattice.nodes()).into_iter().flat_map(|n| [n, n + nodes]).collect();
        let mut constraints = Constraints::none(2 * nodes as usize);
        for (n, r) in (0..3 * nodes as usize).map(|i| (i / 3, i % 3)).filter(|(n, r)| block.held().is_fixed(*n, *r)) {
            constraints.fix(n, r);
            constraints.fix(n + nodes as usize, r);
        }
        let mut system = ElementSystem::new(order, &corners).unwrap();
        system.factor(|e| &block.matrices[e % block.matrices.len()], &constraints).unwrap();
        let mut found = loads(6 * nodes as usize);
        system.solve(&mut found).unwrap();
        for (found, loads) in found.chunks(3 * nodes as usize).zip(loads(6 * nodes as usize).chunks(3 * nodes as usize))
        {
            let difference = largest_difference(found, &lattice_solution(&block, loads));
            assert!(difference < 1e-11, "{difference:.1e}");
        }
    }

    #[test]
    fn a_system_that_nothing_holds_is_refused() {
        let block = Block::new([2, 1, 1]);
        let nodes = block.lattice.node_count();
        let mut system = ElementSystem::new((0..nodes as u32).collect(), &block.corners()).unwrap();
        let factored = system.factor(|e| &block.matrices[e], &Constraints::none(nodes));
        let outcome = factored.and_then(|()| system.solve(&mut vec![1.0; 3 * nodes]));
        assert!(outcome.is_err(), "{outcome:?}");
    }
}
