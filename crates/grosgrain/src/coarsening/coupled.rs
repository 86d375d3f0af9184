//! The coupled constrained optimisation, solved as one sparse saddle-point system per cell.

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};

use super::{COLUMNS, FIELDS, FittedCell};
use crate::element::{gauss_2x2x2, trilinear_gradients};
use crate::mesh::{Cell, Lattice, Node};
use crate::partition::Partition;

/// Constraints per fine node: 9 for partition of unity, 9 for rotation, 3 per training field.
const CONSTRAINTS: usize = 18 + 3 * FIELDS;

/// Why the coupled system was not solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CoupledError {
    /// The saddle-point matrix is singular.
    #[error(
        "the coupled saddle-point system of {unknowns} unknowns is singular: the training fields depend on each other at the corners; use objective = \"closed-form\", which drops dependent fields"
    )]
    Singular {
        /// Shape function coefficients and multipliers.
        unknowns: usize,
    },
}

/// Shape functions of one cell as the minimiser of Σ_i ∫ |∇N_i|² under partition of unity, rotation and data constraints
/// at every fine node but the corners (`chen2018numerical`): 72 ((d+1)³ − 8) coefficients and 36 ((d+1)³ − 8) multipliers in one
/// sparse symmetric indefinite system, solved by LU.
///
/// `training` is the 3(d+1)³ × 6 matrix of the cell; the result is W (3(d+1)³ × 24), row-major. This is the baseline
/// that the closed form is compared with; it is slow on purpose.
///
/// # Errors
/// When the system is singular.
pub fn fit_coupled(
    partition: &Partition,
    spacing: [f64; 3],
    training: &[f64],
) -> Result<(Vec<f64>, FittedCell), CoupledError> {
    let problem = CoupledProblem::new(partition, spacing, training);
    let unknowns = (COLUMNS * 3 + CONSTRAINTS) * problem.free.len();
    let singular = || CoupledError::Singular { unknowns };
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(unknowns, unknowns, &problem.matrix())
        .map_err(|_| singular())?;
    let mut solution = faer::Mat::from_fn(unknowns, 1, |i, _| problem.right[i]);
    if unknowns > 0 {
        matrix.sp_lu().map_err(|_| singular())?.solve_in_place(&mut solution);
    }
    let functions = problem.functions(|i| solution[(i, 0)]);
    match functions.iter().all(|v| v.is_finite()) {
        true => Ok((functions, FittedCell { rank: FIELDS, condition: f64::NAN })),
        false => Err(singular()),
    }
}

struct CoupledProblem<'a> {
    lattice: Lattice,
    spacing: [f64; 3],
    training: &'a [f64],
    corners: [usize; 8],
    free: Vec<usize>,
    index_of: Vec<Option<usize>>,
    right: Vec<f64>,
}

impl<'a> CoupledProblem<'a> {
    fn new(partition: &Partition, spacing: [f64; 3], training: &'a [f64]) -> Self {
        let lattice = partition.cell_lattice();
        let corners = partition.local_corners();
        let free: Vec<usize> = (0..lattice.node_count()).filter(|n| !corners.contains(n)).collect();
        let mut index_of = vec![None; lattice.node_count()];
        free.iter().enumerate().for_each(|(i, &n)| index_of[n] = Some(i));
        let mut this = Self { lattice, spacing, training, corners, free, index_of, right: Vec::new() };
        this.right = this.right_side();
        this
    }

    /// Coefficient of row `r`, column `c` of the functions at free node `i`.
    fn coefficient(&self, i: usize, r: usize, c: usize) -> usize {
        (3 * i + r) * COLUMNS + c
    }

    fn multiplier(&self, i: usize, r: usize, constraint: usize) -> usize {
        3 * COLUMNS * self.free.len() + (3 * i + r) * (CONSTRAINTS / 3) + constraint
    }

    fn offset(&self, node: usize) -> [f64; 3] {
        let at = self.lattice.node_position(Node(node));
        std::array::from_fn(|a| (at[a] as f64 - 0.5 * self.lattice.cells[a] as f64) * self.spacing[a])
    }

    /// Row `constraint` of the constraint matrix: value of the constrained field at corner i, component c.
    fn field_at(&self, node: usize, constraint: usize) -> [f64; 3] {
        let mut value = [0.0; 3];
        match constraint {
            0..3 => value[constraint] = 1.0,
            3..6 => {
                let x = self.offset(node);
                let (p, q) = ((constraint - 2) % 3, (constraint - 1) % 3);
                (value[p], value[q]) = (-x[q], x[p]);
            }
            _ => (0..3).for_each(|r| value[r] = self.training[FIELDS * (3 * node + r) + constraint - 6]),
        }
        value
    }

    fn laplacian(&self) -> Vec<(usize, usize, f64)> {
        let mut entries = Vec::new();
        for cell in 0..self.lattice.cell_count() {
            let nodes = self.lattice.corners(Cell(cell));
            for point in gauss_2x2x2() {
                let gradients = trilinear_gradients(point.at);
                for (a, b) in (0..64).map(|n| (n / 8, n % 8)) {
                    let slope = |i: usize| gradients[a][i] * gradients[b][i] / self.spacing[i].powi(2);
                    let entry = point.weight * (slope(0) + slope(1) + slope(2)) * self.spacing[0].powi(2);
                    entries.push((nodes[a].0, nodes[b].0, entry));
                }
            }
        }
        entries
    }

    fn matrix(&self) -> Vec<Triplet<usize, usize, f64>> {
        let mut triplets = Vec::new();
        for (row, column, value) in self.laplacian() {
            let (Some(i), Some(j)) = (self.index_of[row], self.index_of[column]) else { continue };
            for (r, c) in (0..3 * COLUMNS).map(|n| (n / COLUMNS, n % COLUMNS)) {
                triplets.push(Triplet::new(self.coefficient(i, r, c), self.coefficient(j, r, c), value));
            }
        }
        for i in 0..self.free.len() {
            for (r, constraint) in (0..CONSTRAINTS).map(|n| (n / (CONSTRAINTS / 3), n % (CONSTRAINTS / 3))) {
                let multiplier = self.multiplier(i, r, constraint);
                for c in 0..COLUMNS {
                    let value = self.field_at(self.corners[c / 3], constraint)[c % 3];
                    let coefficient = self.coefficient(i, r, c);
                    triplets.push(Triplet::new(multiplier, coefficient, value));
                    triplets.push(Triplet::new(coefficient, multiplier, value));
                }
            }
        }
        triplets
    }

    fn right_side(&self) -> Vec<f64> {
        let mut right = vec![0.0; (3 * COLUMNS + CONSTRAINTS) * self.free.len()];
        for (row, column, value) in self.laplacian() {
            let (Some(i), Some(corner)) = (self.index_of[row], self.corners.iter().position(|n| *n == column)) else {
                continue;
            };
            (0..3).for_each(|r| right[self.coefficient(i, r, 3 * corner + r)] -= value);
        }
        for (i, &node) in self.free.iter().enumerate() {
            for (r, constraint) in (0..CONSTRAINTS).map(|n| (n / (CONSTRAINTS / 3), n % (CONSTRAINTS / 3))) {
                right[self.multiplier(i, r, constraint)] = self.field_at(node, constraint)[r];
            }
        }
        right
    }

    fn functions(&self, solution: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut functions = vec![0.0; 3 * self.lattice.node_count() * COLUMNS];
        for (i, &node) in self.free.iter().enumerate() {
            for (r, c) in (0..3 * COLUMNS).map(|n| (n / COLUMNS, n % COLUMNS)) {
                functions[(3 * node + r) * COLUMNS + c] = solution(self.coefficient(i, r, c));
            }
        }
        for (corner, &node) in self.corners.iter().enumerate() {
            (0..3).for_each(|r| functions[(3 * node + r) * COLUMNS + 3 * corner + r] = 1.0);
        }
        functions
    }
}
