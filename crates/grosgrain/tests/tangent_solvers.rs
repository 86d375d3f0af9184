//! Newton systems with matrices that change: factors and hierarchies that lag behind, against solvers that start anew.

mod bodies;

use std::sync::Arc;

use bodies::{Uniform, dot, norm, random_tensor, relative};
use grosgrain::assembly::{CellStiffness, Constraints, LatticePattern};
use grosgrain::element::{CellMatrix, Hex8};
use grosgrain::linalg::matrix3::{Matrix3, polar, product, transposed};
use grosgrain::mesh::{Cell, Lattice, Node};
use grosgrain::partition::{CoarseMesh, Partition};
use grosgrain::solver::{
    AnalysedLattice, DirectSolver, ElementCells, ElementSystem, ElementTangent, LatticeTangent, SolverError, Support,
};

const SPACING: [f64; 3] = [1.0, 0.8, 1.1];

/// Cells with a matrix each.
#[derive(Clone)]
struct Cells {
    lattice: Lattice,
    matrices: Vec<Option<CellMatrix>>,
}

impl CellStiffness for Cells {
    fn lattice(&self) -> Lattice {
        self.lattice
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        self.matrices[cell].as_ref().map(|matrix| (1.0, matrix))
    }
}

/// A rotation about a random axis by an angle of the order of `angle`.
fn rotation(random: &mut Uniform, angle: f64) -> Matrix3 {
    let [x, y, z] = [0, 1, 2].map(|_| angle * random.signed());
    polar(&[[1.0, -z, y], [z, 1.0, -x], [-y, x, 1.0]]).0
}

/// T K Tᵀ with the same rotation at all corners.
fn rotated(matrix: &CellMatrix, r: &Matrix3) -> CellMatrix {
    let mut result = [0.0; 576];
    for (a, b) in (0..64).map(|n| (n / 8, n % 8)) {
        let at = |i: usize, j: usize| 24 * (3 * a + i) + 3 * b + j;
        let block: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|j| matrix[at(i, j)]));
        let turned = product(&product(r, &block), &transposed(r));
        (0..9).for_each(|e| result[at(e / 3, e % 3)] = turned[e / 3][e % 3]);
    }
    result
}

fn shifted(mut matrix: CellMatrix, shift: f64) -> CellMatrix {
    (0..24).for_each(|i| matrix[25 * i] += shift);
    matrix
}

/// Anisotropic matrices of two moduli, turned at random, with inertia.
fn matrices(count: usize, contrast: f64, (seed, angle): (u64, f64)) -> Vec<CellMatrix> {
    let (mut kind, mut turn) = (Uniform(3), Uniform(seed));
    let kinds: [CellMatrix; 4] = std::array::from_fn(|n| Hex8::new(SPACING).stiffness(&random_tensor(n as u64)));
    let matrix = |_| {
        let factor = if kind.next() < 0.5 { 1.0 } else { contrast };
        let scaled = kinds[(4.0 * kind.next()) as usize].map(|v| factor * v);
        shifted(rotated(&scaled, &rotation(&mut turn, angle)), 1e-3)
    };
    (0..count).map(matrix).collect()
}

/// A fifth of the cells are void, those at x = 0 are not.
fn lattice_cells(cells: [usize; 3], contrast: f64, (seed, angle): (u64, f64)) -> Cells {
    let lattice = Lattice::new(cells);
    let mut random = Uniform(17);
    let matrices = matrices(lattice.cell_count(), contrast, (seed, angle)).into_iter().enumerate();
    let keep = |(c, matrix): (usize, CellMatrix)| {
        (random.next() < 0.8 || lattice.cell_position(Cell(c))[0] == 0).then_some(matrix)
    };
    Cells { lattice, matrices: matrices.map(keep).collect() }
}

fn clamp(lattice: Lattice, axis: usize) -> Constraints {
    let mask: Vec<bool> = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[axis] == 0).collect();
    let mut constraints = Constraints::nodes(&mask);
    constraints.fix(lattice.node_count() - 1, 1);
    constraints
}

fn loads(n: usize) -> Vec<f64> {
    let mut random = Uniform(91);
    (0..n).map(|_| random.signed()).collect()
}

/// ‖f − K x‖ / ‖f‖ over the unknowns of elements with these corners.
fn residual(elements: &[([usize; 8], CellMatrix)], constraints: &Constraints, f: &[f64], x: &[f64]) -> f64 {
    let mut active = vec![false; constraints.node_count()];
    let mut r = f.to_vec();
    for (corners, matrix) in elements {
        corners.iter().for_each(|n| active[*n] = true);
        for i in 0..24 {
            let force: f64 = (0..24).map(|j| matrix[24 * i + j] * x[3 * corners[j / 3] + j % 3]).sum();
            r[3 * corners[i / 3] + i % 3] -= force;
        }
    }
    let is_free = |i: &usize| active[i / 3] && !constraints.is_fixed(i / 3, i % 3);
    let over_free = |v: &[f64]| norm(&(0..v.len()).filter(is_free).map(|i| v[i]).collect::<Vec<_>>());
    assert!((0..x.len()).all(|i| is_free(&i) || x[i] == 0.0), "what is no unknown is zero");
    over_free(&r) / over_free(f)
}

fn elements(cells: &Cells) -> Vec<([usize; 8], CellMatrix)> {
    let solid = cells.matrices.iter().enumerate().filter_map(|(c, matrix)| Some((c, (*matrix)?)));
    solid.map(|(c, matrix)| (cells.lattice.corners(Cell(c)).map(|n| n.0), matrix)).collect()
}

fn direct(cells: &Cells, constraints: &Constraints, f: &[f64]) -> Vec<f64> {
    let active = grosgrain::assembly::active_nodes(cells);
    let pattern = LatticePattern::on_nodes(cells.lattice, &active);
    let mut solver = DirectSolver::new(Arc::new(AnalysedLattice::new(pattern).unwrap()), 1).unwrap();
    solver.factor(cells, &Support::Constraints(constraints.clone())).unwrap();
    let mut x = f.to_vec();
    assert!(solver.solve_in_place(&mut x) < 1e-9);
    x
}

/// Factors, and cycles on the same lattice.
const LIMITS: [usize; 2] = [1_000_000, 0];

#[test]
fn lattice_tangents_are_solved_to_the_tolerance_while_matrices_and_constraints_change() {
    let shape = [11, 8, 9];
    for limit in LIMITS {
        let start = lattice_cells(shape, 1e3, (0, 0.0));
        let f = loads(3 * start.lattice.node_count());
        let mut tangent = LatticeTangent::with_direct_limit(&start, SPACING, limit).unwrap();
        for (n, axis) in [(0, 0), (1, 0), (2, 2), (3, 2)] {
            let cells = lattice_cells(shape, 1e3, (n, 0.3 * n as f64));
            let constraints = clamp(cells.lattice, axis);
            let exact = direct(&cells, &constraints, &f);
            tangent.update(&cells, &constraints, true).unwrap();
            for tolerance in [1e-2, 1e-6, 1e-10] {
                let mut x = f.clone();
                let report = tangent.solve(&mut x, tolerance).unwrap();
                let true_residual = residual(&elements(&cells), &constraints, &f, &x);
                assert!(true_residual <= 1.000_001 * tolerance + 1e-13, "{limit}, {n}: {true_residual:e}");
                assert!((true_residual - report.relative_residual).abs() <= 1e-6 * tolerance + 1e-13, "{report:?}");
                // The error exceeds the residual by the condition number at most; 1e5 is that of these bodies with inertia.
                let error = relative(&x, &exact);
                assert!(error <= 1e5 * tolerance, "limit {limit}, update {n}, tolerance {tolerance:e}: {error:e}");
            }
        }
    }
}

#[test]
fn a_lagged_preconditioner_costs_iterations_and_no_accuracy() {
    let shape = [12, 9, 10];
    for limit in LIMITS {
        let (first, second) = (lattice_cells(shape, 100.0, (1, 0.1)), lattice_cells(shape, 100.0, (2, 0.1)));
        let constraints = clamp(first.lattice, 0);
        let f = loads(3 * first.lattice.node_count());
        let mut tangent = LatticeTangent::with_direct_limit(&first, SPACING, limit).unwrap();
        tangent.update(&first, &constraints, true).unwrap();
        tangent.solve(&mut f.clone(), 1e-8).unwrap();
        let [mut lagged, mut renewed] = [f.clone(), f.clone()];
        tangent.update(&second, &constraints, true).unwrap();
        let with_lagged = tangent.solve(&mut lagged, 1e-8).unwrap();
        tangent.update(&second, &constraints, false).unwrap();
        let with_renewed = tangent.solve(&mut renewed, 1e-8).unwrap();
        assert!(with_lagged.iterations > with_renewed.iterations, "{with_lagged:?} {with_renewed:?}");
        assert!(relative(&lagged, &renewed) <= 1e-5, "{:e}", relative(&lagged, &renewed));
        assert!(residual(&elements(&second), &constraints, &f, &lagged) <= 1e-8);
    }
}

#[test]
fn cells_that_become_void_or_solid_are_followed() {
    let shape = [6, 5, 4];
    for limit in LIMITS {
        let mut cells = lattice_cells(shape, 10.0, (1, 0.2));
        let constraints = clamp(cells.lattice, 0);
        let f = loads(3 * cells.lattice.node_count());
        let mut tangent = LatticeTangent::with_direct_limit(&cells, SPACING, limit).unwrap();
        for cell in [3, 27, 64] {
            let now = cells.matrices[cell].take();
            cells.matrices[cell] = if now.is_none() { Some(shifted([0.0; 576], 1.0)) } else { None };
            tangent.update(&cells, &constraints, true).unwrap();
            let mut x = f.clone();
            tangent.solve(&mut x, 1e-9).unwrap();
            assert!(relative(&x, &direct(&cells, &constraints, &f)) <= 1e-6, "cell {cell}");
        }
    }
}

#[test]
fn negative_curvature_is_reported_as_such() {
    let shape = [8, 6, 6];
    for limit in LIMITS {
        let good = lattice_cells(shape, 10.0, (1, 0.2));
        let constraints = clamp(good.lattice, 0);
        let mut bad = good.clone();
        bad.matrices.iter_mut().flatten().for_each(|matrix| *matrix = shifted(*matrix, -0.05));
        let f = loads(3 * good.lattice.node_count());
        for lagged in [true, false] {
            let mut tangent = LatticeTangent::with_direct_limit(&good, SPACING, limit).unwrap();
            tangent.update(&good, &constraints, true).unwrap();
            tangent.solve(&mut f.clone(), 1e-8).unwrap();
            let outcome = tangent.update(&bad, &constraints, lagged).and_then(|()| tangent.solve(&mut f.clone(), 1e-8));
            assert!(matches!(outcome, Err(SolverError::Indefinite { .. })), "{limit}, lagged {lagged}: {outcome:?}");
            // A good matrix is solved again afterwards.
            tangent.update(&good, &constraints, true).unwrap();
            let mut x = f.clone();
            tangent.solve(&mut x, 1e-9).unwrap();
            assert!(relative(&x, &direct(&good, &constraints, &f)) <= 1e-6);
        }
    }
}

/// A mesh of coarse cells that a layer of voids splits, without the cells around one corner.
fn split_mesh() -> CoarseMesh {
    let partition = Partition::new(Lattice::new([16, 10, 8]), 2).unwrap();
    let fine = partition.fine();
    let is_void = |c: usize| {
        let [i, j, k] = fine.cell_position(Cell(c));
        (i < 12 && k == 4) || (j == 3 && k < 3) || i + j + k < 5
    };
    CoarseMesh::new(&(0..fine.cell_count()).map(is_void).collect::<Vec<_>>(), &partition)
}

fn held_vertices(mesh: &CoarseMesh, axis: usize) -> Constraints {
    let lattice = mesh.partition().coarse();
    let last = lattice.cells[axis];
    let mask = mesh.vertices().iter().map(|v| lattice.node_position(Node(v.node.0))[axis] == last);
    Constraints::nodes(&mask.collect::<Vec<_>>())
}

fn element_tangent(mesh: &CoarseMesh, limit: usize) -> ElementTangent {
    let cells = mesh.elements().iter().map(|element| element.cell.0 as u32).collect();
    let place = ElementCells { lattice: mesh.partition().coarse(), spacing: SPACING, cells };
    ElementTangent::on_lattice(mesh.elimination_order(), mesh.corners(), place, limit).unwrap()
}

#[test]
fn element_tangents_of_split_meshes_equal_those_of_the_element_system() {
    let mesh = split_mesh();
    assert!(!mesh.is_lattice());
    for limit in LIMITS {
        check_against_element_system(&mesh, element_tangent(&mesh, limit));
    }
}

fn check_against_element_system(mesh: &CoarseMesh, mut tangent: ElementTangent) {
    let mut system = ElementSystem::new(mesh.elimination_order(), mesh.corners()).unwrap();
    let f = loads(tangent.unknowns());
    for (n, axis) in [(0, 0), (1, 0), (2, 0), (3, 1), (4, 1)] {
        let matrices = matrices(mesh.corners().len(), 1e3, (n, 0.02 * n as f64));
        let constraints = held_vertices(mesh, axis);
        tangent.update(|e| &matrices[e], &constraints, true).unwrap();
        system.factor(|e| &matrices[e], &constraints).unwrap();
        let mut exact = f.clone();
        system.solve(&mut exact).unwrap();
        for tolerance in [1e-3, 1e-10] {
            let mut x = f.clone();
            let report = tangent.solve(&mut x, tolerance).unwrap();
            let corners = mesh.corners().iter().map(|c| c.map(|v| v as usize));
            let elements: Vec<_> = corners.zip(matrices.iter().copied()).collect();
            let true_residual = residual(&elements, &constraints, &f, &x);
            assert!(true_residual <= 1.000_001 * tolerance, "update {n}: {true_residual:e}, {report:?}");
            assert!(relative(&x, &exact) <= 1e5 * tolerance, "update {n}: {:e}", relative(&x, &exact));
        }
    }
}

#[test]
fn negative_curvature_of_a_mesh_is_reported_as_such() {
    let mesh = split_mesh();
    let constraints = held_vertices(&mesh, 0);
    let good = matrices(mesh.corners().len(), 10.0, (1, 0.1));
    let bad: Vec<CellMatrix> = good.iter().map(|matrix| shifted(*matrix, -0.05)).collect();
    for (limit, lagged) in LIMITS.iter().flat_map(|limit| [(*limit, true), (*limit, false)]) {
        let mut tangent = element_tangent(&mesh, limit);
        tangent.update(|e| &good[e], &constraints, true).unwrap();
        tangent.solve(&mut loads(tangent.unknowns()), 1e-6).unwrap();
        let outcome = tangent.update(|e| &bad[e], &constraints, lagged);
        let outcome = outcome.and_then(|()| tangent.solve(&mut loads(tangent.unknowns()), 1e-8));
        assert!(matches!(outcome, Err(SolverError::Indefinite { .. })), "{limit}, lagged {lagged}: {outcome:?}");
    }
}

#[test]
fn cycles_on_large_split_meshes_need_few_iterations() {
    let partition = Partition::new(Lattice::new([44, 40, 36]), 2).unwrap();
    let fine = partition.fine();
    let is_cut = |c: usize| {
        let [i, _, k] = fine.cell_position(Cell(c));
        i > 8 && k == 17
    };
    let mesh = CoarseMesh::new(&(0..fine.cell_count()).map(is_cut).collect::<Vec<_>>(), &partition);
    let matrix = Hex8::new([1.0; 3]).stiffness(&random_tensor(5));
    let mut tangent = element_tangent(&mesh, 0);
    tangent.update(|_| &matrix, &held_vertices(&mesh, 0), false).unwrap();
    let report = tangent.solve(&mut loads(tangent.unknowns()), 1e-8).unwrap();
    // As many as on a lattice without the cut; with copies merged on coarser lattices they would grow with the area of the cut.
    assert!(report.iterations <= 25, "{report:?}");
}

#[test]
fn tangents_have_the_same_bits_for_any_number_of_threads() {
    let mesh = split_mesh();
    let run = || {
        let mut bits = Vec::new();
        let mut keep = |x: &[f64], iterations: usize| {
            bits.extend(x.iter().map(|v| v.to_bits()).chain([iterations as u64]));
        };
        let constraints = held_vertices(&mesh, 0);
        let mut tangents = LIMITS.map(|limit| element_tangent(&mesh, limit));
        for (n, split) in (0..3).flat_map(|n| [(n, 0), (n, 1)]) {
            let split = &mut tangents[split];
            let matrices = matrices(mesh.corners().len(), 1e3, (n, 0.1));
            split.update(|e| &matrices[e], &constraints, true).unwrap();
            let mut x = loads(split.unknowns());
            let report = split.solve(&mut x, 1e-7).unwrap();
            keep(&x, report.iterations);
        }
        for limit in LIMITS {
            let mut cells = lattice_cells([14, 9, 12], 1e3, (1, 0.1));
            let constraints = clamp(cells.lattice, 0);
            let mut tangent = LatticeTangent::with_direct_limit(&cells, SPACING, limit).unwrap();
            for n in 0..3 {
                cells = lattice_cells([14, 9, 12], 1e3, (n, 0.1));
                tangent.update(&cells, &constraints, true).unwrap();
                let mut x = loads(3 * cells.lattice.node_count());
                let report = tangent.solve(&mut x, 1e-7).unwrap();
                keep(&x, report.iterations);
            }
        }
        bits
    };
    let with = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run);
    let one = with(1);
    assert!(with(2) == one && with(3) == one);
}

#[test]
fn a_zero_load_and_one_that_is_not_finite_are_told_apart() {
    let cells = lattice_cells([5, 4, 4], 10.0, (1, 0.1));
    let constraints = clamp(cells.lattice, 0);
    for limit in LIMITS {
        let mut tangent = LatticeTangent::with_direct_limit(&cells, SPACING, limit).unwrap();
        tangent.update(&cells, &constraints, false).unwrap();
        let mut zero = vec![0.0; 3 * cells.lattice.node_count()];
        assert_eq!(tangent.solve(&mut zero, 1e-8).unwrap().iterations, 0);
        assert_eq!(dot(&zero, &zero), 0.0);
        let outcome = tangent.solve(&mut vec![f64::NAN; zero.len()], 1e-8);
        assert!(matches!(outcome, Err(SolverError::Iterative(_))), "{outcome:?}");
    }
}
