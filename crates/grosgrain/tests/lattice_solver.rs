//! The iterative path: matrix-free operator, multigrid cycle and conjugate gradients on small lattices.

use grosgrain::assembly::{CellStiffness, Constraints, MatrixFree, active_nodes};
use grosgrain::element::{CellMatrix, Hex8};
use grosgrain::linalg::{
    ConjugateGradientError, ConjugateGradientParameters, ConjugateGradients, DenseCholesky, LinearOperator,
    Preconditioner, Projector, dot, norm,
};
use grosgrain::material::IsotropicMaterial;
use grosgrain::mesh::{Cell, Lattice, Node};
use grosgrain::solver::{Cycle, Multigrid, MultigridError, MultigridParameters, RigidMotions};
use proptest::prelude::*;

/// Cells that choose among matrices.
struct Body {
    lattice: Lattice,
    matrices: Vec<CellMatrix>,
    cells: Vec<Option<(f64, usize)>>,
}

impl CellStiffness for Body {
    fn lattice(&self) -> Lattice {
        self.lattice
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        self.cells[cell].map(|(factor, m)| (factor, &self.matrices[m]))
    }
}

const SPACING: [f64; 3] = [1.0, 1.0, 1.0];

fn matrix(poisson: f64) -> CellMatrix {
    Hex8::new(SPACING).stiffness(&IsotropicMaterial::new(1.0, poisson).unwrap().tensor())
}

fn noise(seed: usize, i: usize) -> f64 {
    ((seed + 1) as f64 * 12.9898 + i as f64 * 78.233).sin().mul_add(43758.5453, 0.0).rem_euclid(1.0)
}

/// Two materials, a contrast, and holes where the noise is above `solid`; x = 0 is solid.
fn mixture(cells: [usize; 3], contrast: f64, solid: f64, seed: usize) -> Body {
    let lattice = Lattice::new(cells);
    let choose = |c: usize| {
        let kept = lattice.cell_position(Cell(c))[0] == 0 || noise(seed, c) < solid;
        let soft = noise(seed + 7, c) < 0.5;
        kept.then_some((if soft { 1.0 } else { contrast }, usize::from(noise(seed + 13, c) < 0.5)))
    };
    let cells = (0..lattice.cell_count()).map(choose).collect();
    Body { lattice, matrices: vec![matrix(0.3), matrix(0.1)], cells }
}

fn uniform(cells: [usize; 3], poisson: f64) -> Body {
    let lattice = Lattice::new(cells);
    Body { lattice, matrices: vec![matrix(poisson)], cells: vec![Some((1.0, 0)); lattice.cell_count()] }
}

/// All components at x = 0, and one component of the last node.
fn clamp(lattice: Lattice) -> Constraints {
    let mask: Vec<bool> = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 0).collect();
    let mut constraints = Constraints::nodes(&mask);
    constraints.fix(lattice.node_count() - 1, 1);
    constraints
}

/// Row-major K with identity rows and columns where there is no unknown, and the mask of unknowns.
fn dense(body: &Body, constraints: &Constraints) -> (Vec<f64>, Vec<bool>) {
    let size = 3 * body.lattice.node_count();
    let active = active_nodes(body);
    let free: Vec<bool> = (0..size).map(|i| active[i / 3] && !constraints.is_fixed(i / 3, i % 3)).collect();
    let mut k = vec![0.0; size * size];
    for c in 0..body.lattice.cell_count() {
        let Some((factor, matrix)) = body.stiffness(c) else { continue };
        let corners = body.lattice.corners(Cell(c));
        let global = |i: usize| 3 * corners[i / 3].0 + i % 3;
        for (e, value) in matrix.iter().enumerate() {
            let (row, column) = (global(e / 24), global(e % 24));
            if free[row] && free[column] {
                k[size * row + column] += factor * value;
            }
        }
    }
    (0..size).filter(|i| !free[*i]).for_each(|i| k[size * i + i] = 1.0);
    (k, free)
}

fn load(operator: &MatrixFree) -> Vec<f64> {
    let free = operator.free();
    (0..3 * free.len()).map(|i| if free[i / 3] >> (i % 3) & 1 == 1 { noise(3, i) - 0.7 } else { 0.0 }).collect()
}

fn solve(body: &Body, constraints: &Constraints, settings: MultigridParameters) -> (Vec<f64>, usize) {
    let operator = MatrixFree::new(body, constraints);
    let mut multigrid = Multigrid::new(&operator, body, settings).unwrap();
    let b = load(&operator);
    let mut x = vec![0.0; b.len()];
    let parameters = ConjugateGradientParameters { tolerance: 1e-10, max_iterations: 500 };
    let info = ConjugateGradients::new(&operator, parameters).solve(&b, &mut x, &mut multigrid, &|_, _| true).unwrap();
    assert!(info.relative_residual <= 1e-10, "{info:?}");
    (x, info.iterations)
}

/// Few unknowns on the coarsest lattice, so that small tests have several lattices.
fn deep() -> MultigridParameters {
    MultigridParameters { coarsest_unknowns: 100, ..Default::default() }
}

fn in_pool<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

#[test]
fn the_matrix_free_operator_equals_the_assembled_matrix() {
    for cells in [[4, 3, 5], [3, 4, 4], [1, 1, 1], [7, 2, 1]] {
        let body = mixture(cells, 1e3, 0.7, 5);
        let constraints = clamp(body.lattice);
        let operator = MatrixFree::new(&body, &constraints);
        let (k, _) = dense(&body, &constraints);
        let size = 3 * body.lattice.node_count();
        let x: Vec<f64> = (0..size).map(|i| noise(1, i) - 0.5).collect();
        let mut y = vec![f64::NAN; size];
        operator.apply(&x, &mut y);
        for i in 0..size {
            let row = &k[size * i..size * (i + 1)];
            let magnitude: f64 = row.iter().zip(&x).map(|(k, x)| (k * x).abs()).sum();
            let error = (y[i] - dot(row, &x)).abs();
            // At most 192 products meet in a row.
            assert!(error <= 192.0 * f64::EPSILON * magnitude.max(1.0), "{cells:?}, row {i}: {error:e}");
        }
        for (n, block) in operator.diagonal_blocks().iter().enumerate() {
            for e in 0..9 {
                let expected = k[size * (3 * n + e / 3) + 3 * n + e % 3];
                assert!((block[e] - expected).abs() <= 8.0 * f64::EPSILON * 1e3, "node {n}, entry {e}");
            }
        }
    }
}

#[test]
fn the_solution_equals_that_of_a_dense_factor() {
    for cells in [[6, 5, 4], [9, 3, 1], [5, 7, 2]] {
        let body = mixture(cells, 30.0, 0.95, 2);
        let constraints = clamp(body.lattice);
        let (k, _) = dense(&body, &constraints);
        let operator = MatrixFree::new(&body, &constraints);
        let b = load(&operator);
        let mut expected = b.clone();
        DenseCholesky::new(b.len(), k).unwrap().solve_in_place(&mut expected);
        let (x, _) = solve(&body, &constraints, deep());
        let error = x.iter().zip(&expected).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() / norm(&expected);
        // Relative residual 1e-10 times the condition number, below 1e5 for a beam of nine soft and stiff cells.
        assert!(error < 1e-5, "{cells:?}: {error:e}");
    }
}

#[test]
fn iterations_do_not_grow_when_the_lattice_is_refined() {
    let iterations = [12, 24].map(|n| {
        let body = uniform([n, n, n], 0.3);
        solve(&body, &clamp(body.lattice), deep()).1
    });
    assert!(iterations[1] <= iterations[0] + 2 && iterations[1] <= 14, "{iterations:?}");
}

#[test]
fn solutions_have_the_same_bits_with_any_number_of_threads() {
    let body = mixture([17, 9, 12], 100.0, 0.9, 4);
    let constraints = clamp(body.lattice);
    let runs = [1, 2, 5].map(|threads| in_pool(threads, || solve(&body, &constraints, deep())));
    for (x, iterations) in &runs[1..] {
        assert_eq!(*iterations, runs[0].1);
        assert!(x.iter().zip(&runs[0].0).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}

#[test]
fn cells_with_a_matrix_each_are_solved_too() {
    let lattice = Lattice::new([11, 8, 9]);
    let count = lattice.cell_count();
    let matrices = (0..count).map(|c| matrix(0.1 + 0.35 * noise(9, c))).collect();
    let cells = (0..count).map(|c| Some((0.1 + noise(8, c), c))).collect();
    let body = Body { lattice, matrices, cells };
    let (_, iterations) = solve(&body, &clamp(lattice), deep());
    assert!(iterations <= 30, "{iterations}");
}

#[test]
fn a_free_body_is_solved_up_to_its_rigid_motions() {
    let body = mixture([10, 9, 8], 10.0, 1.0, 6);
    let constraints = Constraints::none(body.lattice.node_count());
    let operator = MatrixFree::new(&body, &constraints);
    let mut multigrid = Multigrid::new(&operator, &body, deep()).unwrap();
    let motions = RigidMotions::new(body.lattice, SPACING, &active_nodes(&body)).unwrap();
    let b = load(&operator);
    let mut x = vec![0.0; b.len()];
    let parameters = ConjugateGradientParameters { tolerance: 1e-9, max_iterations: 60 };
    let mut solver = ConjugateGradients::new(&operator, parameters).with_projector(&motions);
    let info = solver.solve(&b, &mut x, &mut multigrid, &|_, _| true).unwrap();
    let mut balanced = b.clone();
    motions.project(&mut balanced);
    let mut kx = vec![0.0; b.len()];
    operator.apply(&x, &mut kx);
    let residual: Vec<f64> = kx.iter().zip(&balanced).map(|(a, b)| a - b).collect();
    assert!(norm(&residual) <= 1.1e-9 * norm(&balanced), "{:e}, {info:?}", norm(&residual));
    let mut without = x.clone();
    motions.project(&mut without);
    let rigid: Vec<f64> = x.iter().zip(&without).map(|(a, b)| a - b).collect();
    assert!(norm(&rigid) <= 1e-10 * norm(&x), "{:e} of {:e} is rigid", norm(&rigid), norm(&x));
}

#[test]
fn nearly_incompressible_bodies_of_high_contrast_converge_or_say_how_far_they_came() {
    let mut body = mixture([12, 12, 12], 1e6, 1.0, 3);
    body.matrices = vec![matrix(0.49), matrix(0.49)];
    let constraints = clamp(body.lattice);
    let operator = MatrixFree::new(&body, &constraints);
    let mut multigrid = Multigrid::new(&operator, &body, deep()).unwrap();
    let b = load(&operator);
    for max_iterations in [3, 1000] {
        let mut x = vec![0.0; b.len()];
        let parameters = ConjugateGradientParameters { tolerance: 1e-8, max_iterations };
        let result = ConjugateGradients::new(&operator, parameters).solve(&b, &mut x, &mut multigrid, &|_, _| true);
        match (max_iterations, result) {
            (3, Err(error @ ConjugateGradientError::NotConverged { iterations: 3, .. })) => {
                assert!(error.to_string().contains("after 3 iterations, 1.00e-8 asked for"), "{error}");
            }
            (1000, Ok(info)) => assert!(info.relative_residual <= 1e-8, "{info:?}"),
            (_, other) => panic!("{max_iterations}: {other:?}"),
        }
    }
}

#[test]
fn no_smoothing_is_refused() {
    let body = uniform([2, 2, 2], 0.3);
    let constraints = clamp(body.lattice);
    let operator = MatrixFree::new(&body, &constraints);
    let settings = MultigridParameters { smoothing_steps: 0, ..deep() };
    assert_eq!(Multigrid::new(&operator, &body, settings).err(), Some(MultigridError::Smoothing));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_cycle_is_a_symmetric_positive_definite_map(
        cells in [1usize..9, 1usize..9, 1usize..9],
        seed in 0usize..1000,
        exponent in 0i32..5,
        steps in 1usize..4,
        w in any::<bool>(),
    ) {
        let body = mixture(cells, 10f64.powi(exponent), 0.8, seed);
        let constraints = clamp(body.lattice);
        let operator = MatrixFree::new(&body, &constraints);
        let cycle = if w { Cycle::W } else { Cycle::V };
        let settings = MultigridParameters { smoothing_steps: steps, cycle, ..deep() };
        let mut multigrid = Multigrid::new(&operator, &body, settings).unwrap();
        let size = 3 * body.lattice.node_count();
        let [x, y] = [1, 2].map(|s| (0..size).map(|i| noise(s + seed, i) - 0.5).collect::<Vec<_>>());
        let [mut mx, mut my] = [vec![0.0; size], vec![0.0; size]];
        multigrid.apply(&x, &mut mx);
        multigrid.apply(&y, &mut my);
        let (xx, yy, xy, yx) = (dot(&mx, &x), dot(&my, &y), dot(&mx, &y), dot(&x, &my));
        prop_assert!(xx > 0.0 && yy > 0.0, "{xx:e} {yy:e}");
        // Coarse operators are rounded to single precision, 6e-8, entry by entry.
        prop_assert!((xy - yx).abs() <= 1e-5 * (xx * yy).sqrt(), "{xy:e} against {yx:e}");
    }
}
