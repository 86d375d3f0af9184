//! Training on a ring or on a cell equals a brute-force solution of that domain.

mod bodies;

use bodies::*;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use grosgrain::element::Hex8;
use grosgrain::fine::{FineModel, HARMONIC_FIELDS, constant_stress};
use grosgrain::mesh::{Cell, Node, VoxelGrid};
use grosgrain::partition::{CellBox, CellPart, CoarseCell, CoarseMesh, Partition};
use grosgrain::progress::silent;
use grosgrain::training::{Training, TrainingKind, train};

const SPACING: [f64; 3] = [1.0, 0.5, 1.5];
const DEGREE: usize = 2;

/// Orthonormal rigid motions of the marked nodes of a grid, as columns.
fn rigid_motions(grid: &VoxelGrid, nodes: &[Node]) -> Mat<f64> {
    let motions = Mat::from_fn(3 * nodes.len(), 6, |i, m| {
        let x = grid.position(grid.lattice.node_position(nodes[i / 3]));
        let r = i % 3;
        match m {
            0..3 => f64::from(u8::from(r == m)),
            _ if r == (m + 1) % 3 => -x[(m + 2) % 3],
            _ if r == (m + 2) % 3 => x[(m + 1) % 3],
            _ => 0.0,
        }
    });
    motions.qr().compute_thin_Q()
}

/// Traction σ n on the faces of the box that bounds the grid, a quarter of each face's force at each of its nodes.
fn box_traction(grid: &VoxelGrid, stress: [[f64; 3]; 3]) -> Vec<f64> {
    let lattice = grid.lattice;
    let mut loads = vec![0.0; 3 * lattice.node_count()];
    for cell in (0..lattice.cell_count()).map(Cell) {
        let at = lattice.cell_position(cell);
        for (axis, side) in (0..6).map(|f| (f / 2, f % 2)) {
            if at[axis] != side * (lattice.cells[axis] - 1) {
                continue;
            }
            let force = (2.0 * side as f64 - 1.0) * grid.cell_volume() / grid.spacing[axis] / 4.0;
            for (_, node) in lattice.corners(cell).iter().enumerate().filter(|(a, _)| a >> axis & 1 == side) {
                (0..3).for_each(|r| loads[3 * node.0 + r] += force * stress[r][axis]);
            }
        }
    }
    loads
}

/// Six harmonic displacements on the solid nodes by a dense factorisation of K + Σ s q qᵀ over the rigid motions q.
fn dense_harmonic(model: &FineModel) -> Vec<Vec<f64>> {
    let grid = model.grid();
    let lattice = grid.lattice;
    let nodes: Vec<Node> = (0..lattice.node_count()).filter(|n| model.active()[*n]).map(Node).collect();
    let mut rank = vec![usize::MAX; lattice.node_count()];
    nodes.iter().enumerate().for_each(|(i, n)| rank[n.0] = i);
    let mut k = Mat::<f64>::zeros(3 * nodes.len(), 3 * nodes.len());
    for cell in (0..lattice.cell_count()).map(Cell) {
        let Some(tensor) = model.elasticity(cell) else { continue };
        let matrix = Hex8::new(grid.spacing).stiffness(&tensor);
        let corners = lattice.corners(cell);
        let unknown = |i: usize| 3 * rank[corners[i / 3].0] + i % 3;
        (0..576).for_each(|n| k[(unknown(n / 24), unknown(n % 24))] += matrix[n]);
    }
    let motions = rigid_motions(grid, &nodes);
    let size = (0..3 * nodes.len()).fold(0.0f64, |m, i| m.max(k[(i, i)]));
    k += faer::Scale(size) * &motions * motions.transpose();
    let factor = k.llt(Side::Lower).unwrap();
    let solve = |field: usize| {
        let loads = box_traction(grid, constant_stress(field));
        let right = Mat::from_fn(3 * nodes.len(), 1, |i, _| loads[3 * nodes[i / 3].0 + i % 3]);
        let solution = factor.solve(&right);
        let mut u = vec![0.0; 3 * lattice.node_count()];
        (0..3 * nodes.len()).for_each(|i| u[3 * nodes[i / 3].0 + i % 3] = solution[(i, 0)]);
        u
    };
    (0..HARMONIC_FIELDS).map(solve).collect()
}

/// The training matrix of the cell at `own` inside the domain, free of rigid motion over the cell's nodes.
fn dense_training(model: &FineModel, domain: CellBox, own: CellBox) -> Vec<f64> {
    let grid = cut_out(model.grid(), domain.start, domain.cells);
    let cut = FineModel::new(grid.clone(), &table(&[isotropic(1.0, 0.35)])).unwrap();
    let edge = own.cells[0] + 1;
    let nodes: Vec<Node> = (0..edge.pow(3))
        .map(|n| [n % edge, n / edge % edge, n / (edge * edge)])
        .map(|at| grid.lattice.node(std::array::from_fn(|a| at[a] + own.start[a] - domain.start[a])))
        .collect();
    let motions = rigid_motions(&grid, &nodes);
    let mut training = vec![0.0; 3 * nodes.len() * HARMONIC_FIELDS];
    for (field, u) in dense_harmonic(&cut).iter().enumerate() {
        let values = Mat::from_fn(3 * nodes.len(), 1, |i, _| u[3 * nodes[i / 3].0 + i % 3]);
        let rest = &values - &motions * (motions.transpose() * &values);
        (0..3 * nodes.len()).for_each(|i| training[HARMONIC_FIELDS * i + field] = rest[(i, 0)]);
    }
    training
}

fn trained(model: &FineModel, partition: &Partition, cell: CoarseCell, kind: TrainingKind) -> Training {
    // Unsplit, so that data are cut from all nodes of the cell, those that only neighbours touch included.
    let mesh = CoarseMesh::unsplit(&model.grid().void, partition);
    train(model, &mesh, &[CellPart::whole(cell)], kind, &silent).unwrap().0
}

/// A random body; if asked for, seven of the eight fine cells around the node (2, 2, 2) are void.
fn body(cells: [usize; 3], with_voids: bool) -> FineModel {
    let model = random_model(cells, SPACING, 1e3, 0.35, 17);
    if !with_voids {
        return model;
    }
    let mut grid = model.grid().clone();
    for c in 0..grid.lattice.cell_count() {
        let at = grid.lattice.cell_position(Cell(c));
        grid.void[c] = at.iter().all(|x| *x == 1 || *x == 2) && at != [2, 2, 2];
    }
    FineModel::new(grid, &table(&[isotropic(1.0, 0.35)])).unwrap()
}

#[test]
fn one_ring_training_is_the_dense_solution_of_the_clipped_ring() {
    let model = body([8, 6, 4], false);
    let partition = Partition::new(model.grid().lattice, DEGREE).unwrap();
    for at in [[0, 0, 0], [1, 1, 0], [2, 1, 1], [3, 2, 1]] {
        let cell = CoarseCell(partition.coarse().cell(at).0);
        let exact = dense_training(&model, partition.one_ring(cell), partition.cell_box(cell));
        let error = relative(trained(&model, &partition, cell, TrainingKind::OneRing).of(0), &exact);
        assert!(error < 1e-10, "cell {at:?}: {error:.1e}");
    }
}

#[test]
fn interior_voids_of_a_ring_carry_no_traction() {
    let model = body([6, 6, 6], true);
    let partition = Partition::new(model.grid().lattice, DEGREE).unwrap();
    for at in [[0, 0, 0], [1, 0, 0], [1, 1, 1]] {
        let cell = CoarseCell(partition.coarse().cell(at).0);
        let exact = dense_training(&model, partition.one_ring(cell), partition.cell_box(cell));
        let error = relative(trained(&model, &partition, cell, TrainingKind::OneRing).of(0), &exact);
        assert!(error < 1e-10, "cell {at:?}: {error:.1e}");
    }
}

#[test]
fn single_cell_training_is_the_dense_solution_of_the_cell() {
    let model = body([4, 2, 2], false);
    let partition = Partition::new(model.grid().lattice, DEGREE).unwrap();
    for cell in [CoarseCell(0), CoarseCell(1)] {
        let own = partition.cell_box(cell);
        let exact = dense_training(&model, own, own);
        let error = relative(trained(&model, &partition, cell, TrainingKind::SingleCell).of(0), &exact);
        assert!(error < 1e-11, "{cell:?}: {error:.1e}");
    }
}

#[test]
fn on_a_body_of_one_ring_the_centre_is_trained_alike_by_ring_and_object() {
    let model = body([6, 6, 6], false);
    let partition = Partition::new(model.grid().lattice, DEGREE).unwrap();
    let centre = CoarseCell(13);
    let ring = trained(&model, &partition, centre, TrainingKind::OneRing);
    let global = trained(&model, &partition, centre, TrainingKind::Global);
    let error = relative(ring.of(0), global.of(0));
    assert!(error < 1e-10, "{error:.1e}");
    let corner = trained(&model, &partition, CoarseCell(0), TrainingKind::OneRing);
    let difference = relative(corner.of(0), trained(&model, &partition, CoarseCell(0), TrainingKind::Global).of(0));
    assert!(difference > 1e-3, "the clipped ring of a corner is smaller than the body: {difference:.1e}");
}
