use super::*;
use crate::mesh::Node;
use proptest::prelude::*;

/// 4 × 3 × 2 cells of 1 × 2 × 4 m from (10, 0, 0) on; the first and last x layers are void.
fn body() -> VoxelGrid {
    let mut grid = VoxelGrid::uniform([4, 3, 2], [1.0, 2.0, 4.0], Label(1));
    grid.origin = [10.0, 0.0, 0.0];
    for c in 0..24 {
        grid.void[c] = c % 4 == 0 || c % 4 == 3;
        grid.labels[c] = Label((c % 4) as i32);
    }
    grid
}

fn layers(mask: &[bool], extent: [usize; 3], axis: usize) -> Vec<usize> {
    let layer = |n: usize| [n % extent[0], n / extent[0] % extent[1], n / (extent[0] * extent[1])][axis];
    let full = |l: usize| (0..mask.len()).filter(|n| layer(*n) == l).all(|n| mask[n]);
    let found: Vec<usize> = (0..extent[axis]).filter(|l| full(*l)).collect();
    let area = mask.len() / extent[axis];
    assert_eq!(mask.iter().filter(|m| **m).count(), found.len() * area, "whole layers only");
    found
}

fn plane(axis: Axis, at: PlaneAt) -> Selector {
    Selector::Plane { axis, at }
}

#[test]
fn planes_at_min_and_max_are_those_of_the_body_not_of_the_box() {
    let grid = body();
    let pick = |at| {
        let selector = plane(Axis::X, at);
        let nodes = selector.nodes(&grid).unwrap();
        assert_eq!(nodes.active, 12);
        (layers(&nodes.mask, grid.lattice.nodes(), 0), layers(&selector.cells(&grid), grid.lattice.cells, 0))
    };
    assert_eq!(pick(PlaneAt::Min), (vec![1], vec![1]));
    assert_eq!(pick(PlaneAt::Max), (vec![3], vec![2]));
}

#[test]
fn a_coordinate_plane_picks_the_nearest_nodes_and_the_cells_it_touches() {
    let grid = body();
    let pick = |y| {
        let selector = plane(Axis::Y, PlaneAt::Coordinate(y));
        let nodes = selector.nodes(&grid).unwrap().mask;
        (layers(&nodes, grid.lattice.nodes(), 1), layers(&selector.cells(&grid), grid.lattice.cells, 1))
    };
    assert_eq!(pick(2.0), (vec![1], vec![0, 1]));
    assert_eq!(pick(2.9), (vec![1], vec![1]));
    assert_eq!(pick(3.0), (vec![1, 2], vec![1]));
    assert_eq!(pick(6.9), (vec![3], vec![]));
}

#[test]
fn boxes_and_spheres_are_closed_in_metres() {
    let grid = body();
    let cube = Selector::Box { low: [11.0, 2.0, 0.0], high: [12.0, 4.0, 4.0] };
    let nodes = cube.nodes(&grid).unwrap();
    assert_eq!(nodes.mask.iter().filter(|m| **m).count(), 8);
    assert_eq!(nodes.active, 8);
    let cells = cube.cells(&grid);
    assert_eq!((0..24).filter(|c| cells[*c]).collect::<Vec<_>>(), [grid.lattice.cell([1, 1, 0]).0]);
    let ball = Selector::Sphere { centre: [12.0, 4.0, 4.0], radius: 2.0 };
    let nodes = ball.nodes(&grid).unwrap();
    let expected = [[0, 2, 1], [1, 2, 1], [2, 2, 1], [3, 2, 1], [4, 2, 1], [2, 1, 1], [2, 3, 1]];
    let picked: Vec<Node> = (0..nodes.mask.len()).filter(|n| nodes.mask[*n]).map(Node).collect();
    let mut expected = expected.map(|at| grid.lattice.node(at));
    expected.sort();
    assert_eq!(picked, expected);
    assert_eq!(nodes.active, 5);
}

#[test]
fn a_label_picks_its_solid_cells_and_their_nodes() {
    let grid = body();
    let nodes = Selector::Label(Label(1)).nodes(&grid).unwrap();
    assert_eq!(layers(&nodes.mask, grid.lattice.nodes(), 0), [1, 2]);
    assert_eq!(layers(&Selector::Label(Label(1)).cells(&grid), grid.lattice.cells, 0), [1]);
    assert!(Selector::Label(Label(0)).cells(&grid).iter().all(|m| !m), "label 0 is void here");
    assert!(matches!(Selector::Label(Label(0)).nodes(&grid), Err(SelectionError::Empty { .. })));
}

#[test]
fn an_empty_selection_says_where_the_body_is() {
    let far = Selector::Box { low: [50.0; 3], high: [60.0; 3] };
    let message = far.nodes(&body()).unwrap_err().to_string();
    assert!(message.contains("x 11.000000..13.000000, y 0.000000..6.000000, z 0.000000..8.000000 m"), "{message}");
    let mut nothing = body();
    nothing.void.fill(true);
    assert_eq!(Selector::All.nodes(&nothing), Err(SelectionError::AllVoid));
    assert!(plane(Axis::Z, PlaneAt::Min).cells(&nothing).iter().all(|m| !m));
}

#[test]
fn selectors_that_make_no_sense_are_refused_wherever_they_stand() {
    for bad in [
        Selector::Box { low: [0.0, 1.0, 0.0], high: [1.0, 0.0, 1.0] },
        Selector::Box { low: [f64::NAN, 1.0, 0.0], high: [1.0; 3] },
        Selector::Sphere { centre: [0.0; 3], radius: 0.0 },
        Selector::Sphere { centre: [0.0, f64::INFINITY, 0.0], radius: 1.0 },
        plane(Axis::X, PlaneAt::Coordinate(f64::NAN)),
        Selector::Cut(Cut { point: [0.0; 3], normal: [0.0; 3], radius: None }),
        Selector::Cut(Cut { point: [f64::NAN; 3], normal: [1.0; 3], radius: None }),
        Selector::Cut(Cut { point: [0.0; 3], normal: [1e200; 3], radius: None }),
        Selector::Cut(Cut { point: [0.0; 3], normal: [1.0; 3], radius: Some(0.0) }),
        Selector::Blade(Blade { edge: [[1.0; 3]; 2], sweep: [1.0, 0.0, 0.0] }),
        Selector::Blade(Blade { edge: [[0.0; 3], [1.0; 3]], sweep: [2.0; 3] }),
        Selector::Blade(Blade { edge: [[0.0; 3], [1.0; 3]], sweep: [0.0; 3] }),
        Selector::Blade(Blade { edge: [[0.0; 3], [1.0, 0.0, f64::INFINITY]], sweep: [0.0, 1.0, 0.0] }),
        Selector::Brush(Brush { path: vec![], radius: 1.0 }),
        Selector::Brush(Brush { path: vec![[0.0; 3], [0.0, f64::NAN, 0.0]], radius: 1.0 }),
        Selector::Brush(Brush { path: vec![[0.0; 3]], radius: -1.0 }),
    ] {
        let nested = Selector::Or(vec![Selector::All, Selector::Not(Box::new(bad.clone()))]);
        assert!(nested.nodes(&body()).is_err(), "{bad:?}");
    }
}

fn selector() -> impl Strategy<Value = Selector> {
    let corner = || [9.0..15.0f64, -1.0..7.0, -1.0..9.0];
    prop_oneof![
        Just(Selector::All),
        (corner(), corner()).prop_map(|(a, b)| Selector::Box {
            low: std::array::from_fn(|x| a[x].min(b[x])),
            high: std::array::from_fn(|x| a[x].max(b[x])),
        }),
        (corner(), 0.1..5.0f64).prop_map(|(centre, radius)| Selector::Sphere { centre, radius }),
        (0.0..8.0f64).prop_map(|z| plane(Axis::Z, PlaneAt::Coordinate(z))),
        (0..4i32).prop_map(|l| Selector::Label(Label(l))),
        prop_oneof![Just(PlaneAt::Min), Just(PlaneAt::Max)].prop_map(|at| plane(Axis::Y, at)),
        (corner(), direction(), prop::option::of(0.5..4.0f64)).prop_map(|(point, normal, radius)| Selector::Cut(Cut {
            point,
            normal,
            radius
        })),
        (corner(), direction(), direction()).prop_map(|(from, along, sweep)| {
            let to = std::array::from_fn(|a| from[a] + 3.0 * along[a]);
            Selector::Blade(Blade { edge: [from, to], sweep: sweep.map(|s| 2.0 * s) })
        }),
        (prop::collection::vec(corner(), 1..4), 0.3..3.0f64)
            .prop_map(|(path, radius)| Selector::Brush(Brush { path, radius })),
    ]
}

/// Directions along axes and diagonals, and any others.
fn direction() -> impl Strategy<Value = [f64; 3]> {
    let whole = [-1..2i32, -1..2, -1..2].prop_map(|n| n.map(f64::from));
    prop_oneof![whole, [-1.0..1.0f64, -1.0..1.0, -1.0..1.0]]
        .prop_filter("not zero", |n| n.iter().any(|x| x.abs() > 1e-3))
}

fn difference(a: &[bool], b: &[bool]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

#[test]
fn a_small_region_is_picked_without_looking_at_the_whole_body() {
    let grid = VoxelGrid::uniform([60, 50, 40], [1.0; 3], Label(1));
    let asked = std::cell::Cell::new(0);
    let solid = |cell: Cell| {
        asked.set(asked.get() + 1);
        Some(grid.labels[cell.0])
    };
    let ball = Selector::Sphere { centre: [30.0, 20.0, 10.0], radius: 2.0 };
    let brush = Selector::Brush(Brush { path: vec![[30.0, 20.0, 10.0], [33.0, 20.0, 10.0]], radius: 1.5 });
    let edge = [[30.0, 20.0, 10.2], [34.0, 20.0, 10.2]];
    let blade = Selector::Blade(Blade { edge, sweep: [0.0, 5.0, 0.0] });
    let cut = Selector::Cut(Cut { point: [30.2, 0.0, 0.0], normal: [1.0, 0.0, 0.0], radius: None });
    for (region, most) in [(ball, 1000), (brush, 1000), (blade, 1000), (cut, 50 * 40 * 6)] {
        let labelled = Selector::And(vec![Selector::Label(Label(1)), region.clone()]);
        let (mut picked, mut alone) = (Vec::new(), Vec::new());
        asked.set(0);
        labelled.pick_cells_of(&grid, &solid, &mut picked);
        assert!(asked.get() > 0 && asked.get() <= most, "{region:?} asked for {} labels", asked.get());
        region.pick_cells(&grid, &mut alone);
        assert_eq!(picked, alone);
    }
}

proptest! {
    #[test]
    fn not_and_or_obey_the_laws_of_sets(a in selector(), b in selector()) {
        let grid = body();
        let not = |s: &Selector| Selector::Not(Box::new(s.clone()));
        for of in [Of::Nodes, Of::Cells] {
            let mask = |s: &Selector| s.mask_of(&grid, of);
            let both = Selector::And(vec![a.clone(), b.clone()]);
            let either = Selector::Or(vec![not(&a), not(&b)]);
            prop_assert_eq!(mask(&not(&both)), mask(&either), "de Morgan");
            prop_assert_eq!(mask(&not(&not(&a))), mask(&a));
            prop_assert_eq!(mask(&Selector::Or(vec![a.clone(), not(&a)])), mask(&Selector::All));
            prop_assert_eq!(mask(&Selector::And(vec![])), mask(&Selector::All));
            let pointwise: Vec<bool> = mask(&a).iter().zip(mask(&b)).map(|(x, y)| *x && y).collect();
            prop_assert_eq!(mask(&both), pointwise);
        }
    }

    #[test]
    fn picked_cells_are_those_of_the_mask_in_ascending_order(a in selector(), b in selector(), c in selector()) {
        let grid = body();
        let nested = Selector::Or(vec![
            Selector::And(vec![a.clone(), b.clone()]),
            Selector::And(vec![Selector::Not(Box::new(b.clone())), c.clone()]),
        ]);
        let mut picked = vec![Cell(7)];
        for selector in [a, b, c, nested, Selector::Or(vec![]), Selector::And(vec![])] {
            let mask = selector.cells(&grid);
            let expected: Vec<Cell> = (0..mask.len()).filter(|n| mask[*n]).map(Cell).collect();
            selector.pick_cells(&grid, &mut picked);
            prop_assert_eq!(&picked, &expected, "{:?}", selector);
        }
    }

    /// Moving the selector one way is moving the grid the other way.
    #[test]
    fn a_moved_selector_picks_what_it_picks_on_a_grid_moved_back(s in selector(), by in [-3..4i32, -3..4, -3..4]) {
        // Shifts that the coordinates hold exactly, so that nothing is rounded differently.
        let by = by.map(|n| f64::from(n) * 0.5);
        let grid = body();
        let mut back = body();
        (0..3).for_each(|a| back.origin[a] -= by[a]);
        prop_assume!(s.is_geometric());
        prop_assert!(difference(&s.moved(by).cells(&grid), &s.cells(&back)) == 0 || s.validate().is_err());
    }
}
