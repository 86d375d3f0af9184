use super::super::{Cell, Label, Selector};
use super::*;
use proptest::prelude::*;

const CELLS: [usize; 3] = [6, 5, 4];

fn grid() -> VoxelGrid {
    let mut grid = VoxelGrid::uniform(CELLS, [0.1, 0.2, 0.3], Label(0));
    grid.origin = [-0.3, 0.7, 10.0];
    grid
}

/// Lattice nodes, lattice planes, and points between.
fn point() -> impl Strategy<Value = [f64; 3]> {
    let node = [0..=6usize, 0..=5, 0..=4].prop_map(|at| grid().position(at));
    let any = [0.0..6.0f64, 0.0..5.0, 0.0..4.0].prop_map(|t| {
        let grid = grid();
        std::array::from_fn(|a| grid.origin[a] + grid.spacing[a] * t[a])
    });
    prop_oneof![node, any]
}

/// Along axes, through diagonals of nodes, and any.
fn direction() -> impl Strategy<Value = [f64; 3]> {
    let whole = [-2..3i32, -2..3, -2..3].prop_map(|n| {
        let grid = grid();
        std::array::from_fn(|a| f64::from(n[a]) / grid.spacing[a])
    });
    prop_oneof![whole, [-1.0..1.0f64, -1.0..1.0, -1.0..1.0]].prop_filter("not zero", |n| dot(*n, *n) > 1e-4)
}

/// Whether every node of the voxel is on the side of the normal, in exact terms the sign of δ beyond the slack.
fn side(grid: &VoxelGrid, at: [usize; 3], point: [f64; 3], normal: [f64; 3]) -> [bool; 2] {
    let corners = grid.lattice.corners(grid.lattice.cell(at));
    let above = corners.map(|n| {
        let x = grid.position(grid.lattice.node_position(n));
        (0..3).map(|a| normal[a] * (x[a] - point[a])).sum::<f64>() / dot(normal, normal).sqrt() > 1e-8
    });
    [above.iter().any(|a| *a), above.iter().any(|a| !a)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn the_two_sides_of_a_cut_share_no_node(point in point(), normal in direction()) {
        let grid = grid();
        let removed = Selector::Cut(Cut { point, normal, radius: None }).cells(&grid);
        let mut sides = vec![[false; 2]; grid.lattice.node_count()];
        for cell in (0..removed.len()).filter(|c| !removed[*c]).map(Cell) {
            let [above, below] = side(&grid, grid.lattice.cell_position(cell), point, normal);
            prop_assert!(above != below, "a voxel that stays lies on one side");
            for node in grid.lattice.corners(cell) {
                sides[node.0][usize::from(above)] = true;
            }
        }
        prop_assert!(sides.iter().all(|s| *s != [true, true]));
        // No more than needed: every voxel that goes has nodes on both sides.
        for cell in (0..removed.len()).filter(|c| removed[*c]).map(Cell) {
            prop_assert_eq!(side(&grid, grid.lattice.cell_position(cell), point, normal), [true, true]);
        }
    }

    #[test]
    fn along_a_plane_of_nodes_exactly_the_layer_on_the_side_of_the_normal_goes(
        axis in 0..3usize, layer in 0..7usize, up in any::<bool>(), size in 1e-3..1e3f64, elsewhere in point(),
    ) {
        let grid = grid();
        prop_assume!(layer <= CELLS[axis]);
        let mut point = elsewhere;
        point[axis] = grid.origin[axis] + grid.spacing[axis] * layer as f64;
        let mut normal = [0.0; 3];
        normal[axis] = if up { size } else { -size };
        let removed = Selector::Cut(Cut { point, normal, radius: None }).cells(&grid);
        let gone = if up { Some(layer) } else { layer.checked_sub(1) };
        for (c, removed) in removed.iter().enumerate() {
            prop_assert_eq!(*removed, Some(grid.lattice.cell_position(Cell(c))[axis]) == gone);
        }
    }

    #[test]
    fn a_blade_through_the_whole_body_is_a_cut(point in point(), u in direction(), v in direction()) {
        let grid = grid();
        let size = |x: [f64; 3]| dot(x, x).sqrt();
        prop_assume!(size(cross(u, v)) > 0.05 * size(u) * size(v));
        // In the plane's own orthogonal directions, longer than the body's diagonal on all sides.
        let normal = cross(u, v);
        let w = cross(normal, u);
        let (u, w) = (u.map(|x| 20.0 * x / size(u)), w.map(|x| 20.0 * x / size(w)));
        let from: [f64; 3] = std::array::from_fn(|a| point[a] - 0.5 * (u[a] + w[a]));
        let blade = Blade { edge: [from, plus(from, u)], sweep: w };
        let cut = Cut { point: from, normal: blade.normal(), radius: None };
        prop_assert_eq!(Selector::Blade(blade).cells(&grid), Selector::Cut(cut).cells(&grid));
    }

    #[test]
    fn a_blade_cuts_what_its_clipped_parallelogram_reaches(from in point(), u in direction(), v in direction(), t in 0.1..0.8f64) {
        let grid = grid();
        let size = |x: [f64; 3]| dot(x, x).sqrt();
        prop_assume!(size(cross(u, v)) > 0.05 * size(u) * size(v));
        let (u, v) = (u.map(|x| t * x / size(u)), v.map(|x| 0.5 * x / size(v)));
        let blade = Blade { edge: [from, plus(from, u)], sweep: v };
        let cut = Selector::Cut(Cut { point: from, normal: blade.normal(), radius: None }).cells(&grid);
        let found = Selector::Blade(blade).cells(&grid);
        for c in 0..found.len() {
            let reaches = |grown: f64| cut[c] && clipped(&grid, grid.lattice.cell_position(Cell(c)), [from, u, v], grown);
            prop_assert!(found[c] || !reaches(-1e-5), "voxel {c} holds a piece of the blade and stays");
            prop_assert!(!found[c] || reaches(1e-5), "voxel {c} holds nothing of the blade and goes");
        }
    }
}

/// Whether anything of the parallelogram is left when the six planes of the voxel, grown by `grown` cells, clip it.
fn clipped(grid: &VoxelGrid, at: [usize; 3], [from, u, v]: [[f64; 3]; 3], grown: f64) -> bool {
    let mut polygon = vec![from, plus(from, u), plus(plus(from, u), v), plus(from, v)];
    for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
        let half = (0.5 + grown) * grid.spacing[axis];
        let inside = |x: &[f64; 3]| half - side * (x[axis] - grid.centre(at)[axis]);
        let corners = std::mem::take(&mut polygon);
        for (n, a) in corners.iter().enumerate() {
            let b = &corners[(n + 1) % corners.len()];
            let (p, q) = (inside(a), inside(b));
            if p >= 0.0 {
                polygon.push(*a);
            }
            if (p < 0.0) != (q < 0.0) {
                polygon.push(std::array::from_fn(|r| a[r] + p / (p - q) * (b[r] - a[r])));
            }
        }
    }
    !polygon.is_empty()
}

#[test]
fn a_blade_that_ends_between_two_voxels_cuts_up_to_there() {
    let grid = VoxelGrid::uniform([4, 2, 2], [0.1; 3], Label(0));
    let blade = |reach: f64| {
        let edge = [[0.0, -1.0, 0.1], [0.0, 1.0, 0.1]];
        let cells = Selector::Blade(Blade { edge, sweep: [reach, 0.0, 0.0] }).cells(&grid);
        (0..16).filter(|c| cells[*c]).map(|c| grid.lattice.cell_position(Cell(c))).collect::<Vec<_>>()
    };
    // The normal (edge × sweep) points down, so the layer below the blade goes.
    assert_eq!(blade(0.2), [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]);
    assert_eq!(blade(0.201).len(), 6);
}

#[test]
fn the_blades_of_a_path_follow_each_other() {
    let edge = [[0.0; 3], [0.0, 1.0, 0.0]];
    let path = Blade::path(edge, &[[1.0, 0.0, 0.0], [0.0, 0.0, 2.0]]);
    assert_eq!(path[1], Blade { edge: [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]], sweep: [0.0, 0.0, 2.0] });
    assert_eq!(path[0], Blade { edge, sweep: [1.0, 0.0, 0.0] });
}

#[test]
fn a_cut_with_a_radius_stays_near_its_point() {
    let grid = VoxelGrid::uniform([5, 5, 5], [1.0; 3], Label(0));
    let cut = Selector::Cut(Cut { point: [2.5; 3], normal: [0.0, 0.0, 1.0], radius: Some(1.0) });
    let cells = cut.cells(&grid);
    let found: Vec<_> = (0..125).filter(|c| cells[*c]).map(|c| grid.lattice.cell_position(Cell(c))).collect();
    assert_eq!(found, [[2, 1, 2], [1, 2, 2], [2, 2, 2], [3, 2, 2], [2, 3, 2]]);
}
