use super::*;
use crate::mesh::Cell;
use crate::mesh::Label;
use faer::{Mat, Side};
use proptest::prelude::*;

fn grid(cells: [usize; 3], solid: &[[usize; 3]]) -> VoxelGrid {
    let mut grid = VoxelGrid::uniform(cells, [0.5, 1.0, 3.0], Label(1));
    grid.void.fill(true);
    solid.iter().for_each(|at| grid.void[grid.lattice.cell(*at).0] = false);
    grid
}

/// Fixes all components of the nodes for which `at` holds.
fn clamp(grid: &VoxelGrid, at: impl Fn([usize; 3]) -> bool) -> Vec<[bool; 3]> {
    (0..grid.lattice.node_count()).map(|n| [at(grid.lattice.node_position(Node(n))); 3]).collect()
}

fn kinds(loose: &[LoosePart]) -> Vec<(HeldBy, usize)> {
    loose.iter().map(|part| (part.held_by, part.free_motions)).collect()
}

#[test]
fn a_clamped_block_is_held_and_an_island_is_not() {
    let body = grid([4, 1, 1], &[[0, 0, 0], [1, 0, 0], [3, 0, 0]]);
    let loose = loose_parts(&body, &clamp(&body, |at| at[0] == 0));
    let island =
        LoosePart { cells: 1, first_cell: [3, 0, 0], held_by: HeldBy::Nothing, free_motions: 6, largest: false };
    assert_eq!(loose, [island]);
    let message = "a part of 1 cell around cell (3, 0, 0) is held by nothing; fix it or leave it out";
    assert_eq!(island.to_string(), message);
}

#[test]
fn a_part_on_one_edge_is_a_hinge_and_on_one_node_a_ball_joint() {
    let hinge = grid([2, 2, 3], &[[0, 0, 0], [1, 1, 0], [1, 1, 1]]);
    let loose = loose_parts(&hinge, &clamp(&hinge, |at| at[0] == 0));
    assert_eq!(kinds(&loose), [(HeldBy::Edge, 1)]);
    let message = loose[0].to_string();
    assert!(message.contains("the largest part, 2 cells around cell (1, 1, 0), is held only by an edge"), "{message}");
    assert!(message.contains("fix more of it"), "{message}");
    let ball = grid([2, 2, 2], &[[0, 0, 0], [1, 1, 1]]);
    let loose = loose_parts(&ball, &clamp(&ball, |at| at[0] == 0));
    assert_eq!(kinds(&loose), [(HeldBy::Node, 3)]);
    assert!(loose[0].to_string().contains("held only by a node"));
}

#[test]
fn two_edges_that_are_not_one_line_hold() {
    let body = grid([3, 2, 1], &[[0, 0, 0], [2, 0, 0], [1, 1, 0]]);
    assert_eq!(loose_parts(&body, &clamp(&body, |at| at[1] == 0)), []);
    let one_foot = loose_parts(&body, &clamp(&body, |at| at[1] == 0 && at[0] <= 1));
    assert_eq!(kinds(&one_foot), [(HeldBy::Edge, 2), (HeldBy::Edge, 1)], "a chain of two hinges");
}

#[test]
fn what_is_fixed_decides_how_a_single_block_can_move() {
    let block = grid([2, 2, 2], &[[0, 0, 0], [1, 0, 0]]);
    let with = |at: fn([usize; 3]) -> bool| kinds(&loose_parts(&block, &clamp(&block, at)));
    assert_eq!(with(|_| false), [(HeldBy::Nothing, 6)]);
    assert_eq!(with(|at| at == [0, 0, 0]), [(HeldBy::Node, 3)]);
    assert_eq!(with(|at| at[0] == 0 && at[1] == 0), [(HeldBy::Edge, 1)]);
    assert_eq!(with(|at| at[0] == 0), []);
    assert_eq!(with(|at| at == [2, 2, 2]), [(HeldBy::Nothing, 6)], "that node touches no solid cell");
    let mut rollers = clamp(&block, |_| false);
    let at = |i, j, k| block.lattice.node([i, j, k]).0;
    (0..2).for_each(|j| (0..2).for_each(|k| rollers[at(0, j, k)] = [true, false, false]));
    assert_eq!(kinds(&loose_parts(&block, &rollers)), [(HeldBy::Partly, 3)]);
}

#[test]
fn parts_that_hold_each_other_are_decided_together() {
    // Four single cells, every two joined along an edge: rigid together, though each pair is a hinge.
    let body = grid([2, 2, 2], &[[0, 0, 0], [1, 1, 0], [1, 0, 1], [0, 1, 1]]);
    let three_points = clamp(&body, |at| [[0, 0, 0], [2, 2, 0], [2, 0, 2]].contains(&at));
    assert_eq!(loose_parts(&body, &three_points), [], "no part is held by its own point alone");
    let two_points = clamp(&body, |at| [[0, 0, 0], [2, 2, 0]].contains(&at));
    assert!(loose_parts(&body, &two_points).iter().all(|p| p.free_motions == 1));
}

#[test]
fn floating_pieces_are_found_without_any_fixed_node() {
    let body = grid([5, 2, 2], &[[0, 0, 0], [1, 0, 0], [2, 1, 0], [4, 1, 1]]);
    let loose = parts_loose_from_largest(&body);
    assert_eq!(kinds(&loose), [(HeldBy::Edge, 1), (HeldBy::Nothing, 6)]);
    assert_eq!(loose.iter().map(|p| p.first_cell).collect::<Vec<_>>(), [[2, 1, 0], [4, 1, 1]]);
    assert_eq!(parts_loose_from_largest(&grid([1, 1, 1], &[])), []);
    let block = VoxelGrid::uniform([3, 3, 3], [1.0; 3], Label(0));
    assert_eq!(parts_loose_from_largest(&block), []);
}

#[test]
fn in_a_cluster_beyond_the_limit_every_part_is_called_loose() {
    let steps: Vec<[usize; 3]> = (0..80).map(|i| [i, i, 0]).collect();
    let chain = grid([80, 80, 1], &steps);
    let loose = loose_parts(&chain, &clamp(&chain, |at| at[0] == 0));
    assert_eq!(loose.len(), 79);
    assert_eq!(kinds(&loose)[0], (HeldBy::Edge, 1));
    assert!(loose[1..78].iter().all(|p| (p.held_by, p.free_motions) == (HeldBy::Partly, 6)));
    assert!(loose[1].to_string().contains("can still move in 6 ways"));
}

/// Row of component `c` of the rigid motion of a cell at the point x \[m\].
fn rigid_row(x: [f64; 3], c: usize) -> [f64; 6] {
    let [x, y, z] = x;
    [[1., 0., 0., 0., z, -y], [0., 1., 0., -z, 0., x], [0., 0., 1., y, -x, 0.]][c]
}

fn gram(rows: &[Vec<(usize, f64)>], n: usize) -> Mat<f64> {
    let mut gram = Mat::zeros(n, n);
    for row in rows {
        row.iter().for_each(|&(i, a)| row.iter().for_each(|&(j, b)| gram[(i, j)] += a * b));
    }
    gram
}

/// Every solid cell a rigid body of its own, in metres and floating point: no components, no lattice arithmetic.
fn free_motions_cell_by_cell(grid: &VoxelGrid, fixed: &[[bool; 3]]) -> BTreeMap<usize, usize> {
    let solid: Vec<usize> = (0..grid.void.len()).filter(|c| !grid.void[*c]).collect();
    let mut rows = Vec::new();
    for node in (0..grid.lattice.node_count()).map(Node) {
        let x = grid.position(grid.lattice.node_position(node));
        let cells: Vec<usize> = grid.lattice.cells_at(node).filter_map(|c| solid.binary_search(&c.0).ok()).collect();
        for (c, is_fixed) in fixed[node.0].into_iter().enumerate() {
            let row =
                |cell: usize, sign: f64| rigid_row(x, c).into_iter().zip(6 * cell..).map(move |(v, i)| (i, sign * v));
            cells.windows(2).for_each(|w| rows.push(row(w[0], 1.0).chain(row(w[1], -1.0)).collect()));
            if let (Some(first), true) = (cells.first(), is_fixed) {
                rows.push(row(*first, 1.0).collect::<Vec<_>>());
            }
        }
    }
    let n = 6 * solid.len();
    let eigen = gram(&rows, n).self_adjoint_eigen(Side::Lower).unwrap();
    let null: Vec<usize> = (0..n).filter(|i| eigen.S()[*i] < 1e-8).collect();
    let own_rank = |cell: usize| {
        let vectors: Vec<Vec<(usize, f64)>> =
            null.iter().map(|v| (0..6).map(|c| (c, eigen.U()[(6 * cell + c, *v)])).collect()).collect();
        let eigen = gram(&vectors, 6).self_adjoint_eigen(Side::Lower).unwrap();
        (0..6).filter(|i| eigen.S()[*i] > 1e-8).count()
    };
    solid.iter().enumerate().map(|(s, c)| (*c, own_rank(s))).filter(|(_, rank)| *rank > 0).collect()
}

fn check_against_cells(grid: &VoxelGrid, fixed: &[[bool; 3]]) -> Result<(), TestCaseError> {
    let parts = Components::new(&grid.void, &grid.lattice, Neighbourhood::Faces);
    let found: BTreeMap<usize, usize> =
        loose_parts(grid, fixed).iter().map(|p| (grid.lattice.cell(p.first_cell).0, p.free_motions)).collect();
    let expected = free_motions_cell_by_cell(grid, fixed);
    for c in (0..grid.void.len()).map(Cell) {
        if let Some(part) = parts.of(c) {
            let first = parts.first_cells()[part].0;
            prop_assert_eq!(found.get(&first), expected.get(&c.0), "cell {:?}", grid.lattice.cell_position(c));
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    #[test]
    fn free_motions_are_those_of_rigid_cells_joined_at_their_nodes(
        void in prop::collection::vec(prop::bool::weighted(0.6), 27),
        fixed in prop::collection::vec(prop::array::uniform3(prop::bool::weighted(0.08)), 64)
    ) {
        let mut body = grid([3, 3, 3], &[]);
        body.void = void;
        check_against_cells(&body, &fixed)?;
    }
}
