//! Selectors on meshes: planes, boxes, labels, tractions on the faces they pick.

use std::path::Path;

use grosgrain::io::mesh::read_mesh;
use grosgrain::mesh::{Axis, Blade, Brush, Cut, Label, PlaneAt, SelectionError, Selector, VoxelGrid};
use grosgrain::simplex::{
    Boundary, BoundaryFace, BoundingBox, BoxCut, Dimension, SimplexLattice, SimplexMesh, select_cells, select_nodes,
    selected_faces, traction_forces,
};

const SIZE: [f64; 3] = [0.04, 0.03, 0.02];

fn boxes(dimension: Dimension, boxes: [usize; 3], cut: BoxCut) -> SimplexMesh {
    let around = BoundingBox { lower: [0.0; 3], upper: SIZE };
    SimplexLattice { dimension, boxes, around, cut }.mesh().unwrap()
}

fn plane(axis: Axis, at: PlaneAt) -> Selector {
    Selector::Plane { axis, at }
}

#[test]
fn nodes_of_a_box_are_those_that_a_voxel_grid_picks() {
    let mesh = boxes(Dimension::Three, [4, 3, 2], BoxCut::Alternating);
    let grid = VoxelGrid::uniform([4, 3, 2], [0.01; 3], Label(0));
    let ball = Selector::Sphere { centre: [0.02, 0.01, 0.0], radius: 0.01 };
    let slab = Selector::Box { low: [0.01, f64::NEG_INFINITY, 0.0], high: [0.02, f64::INFINITY, 0.01] };
    let swept = Selector::Brush(Brush { path: vec![[0.0; 3], [0.03, 0.0, 0.0]], radius: 0.012 });
    let mut selectors = vec![Selector::All, ball.clone(), slab.clone(), swept];
    for at in [PlaneAt::Min, PlaneAt::Max, PlaneAt::Coordinate(0.0132), PlaneAt::Coordinate(0.015)] {
        selectors.extend([Axis::X, Axis::Y, Axis::Z].map(|axis| plane(axis, at)));
    }
    selectors.push(Selector::And(vec![slab.clone(), Selector::Not(Box::new(ball.clone()))]));
    selectors.push(Selector::Or(vec![slab, ball]));
    for selector in selectors {
        let voxels = selector.nodes(&grid).unwrap().mask;
        assert_eq!(select_nodes(&mesh, &selector).unwrap(), voxels, "{selector:?}");
    }
}

#[test]
fn labels_are_tags_and_planes_pick_the_cells_they_touch() {
    let mesh = boxes(Dimension::Two, [4, 2, 1], BoxCut::Alike).tagged(|x| i32::from(x[0] > 0.02));
    let stiff = Selector::Label(Label(1));
    assert_eq!(select_cells(&mesh, &stiff).unwrap(), mesh.tags().iter().map(|t| *t == 1).collect::<Vec<_>>());
    let right: Vec<bool> = mesh.nodes().iter().map(|x| x[0] > 0.0199).collect();
    assert_eq!(select_nodes(&mesh, &stiff).unwrap(), right);
    let crossed = select_cells(&mesh, &plane(Axis::X, PlaneAt::Coordinate(0.0212))).unwrap();
    let column = |cell: usize| (mesh.centre(cell)[0] / 0.01) as usize;
    assert!((0..mesh.cell_count()).all(|cell| crossed[cell] == (column(cell) == 2)));
    let between = select_cells(&mesh, &plane(Axis::X, PlaneAt::Coordinate(0.02))).unwrap();
    assert!((0..mesh.cell_count()).all(|cell| !between[cell] || (1..3).contains(&column(cell))));
    assert_eq!(select_cells(&mesh, &Selector::Label(Label(5))).unwrap(), vec![false; mesh.cell_count()]);
}

#[test]
fn what_has_no_meaning_is_refused_with_a_reason() {
    let mesh = boxes(Dimension::Three, [2, 2, 2], BoxCut::Alike);
    let cut = Selector::Cut(Cut { point: [0.0; 3], normal: [1.0, 0.0, 0.0], radius: None });
    let blade = Selector::Blade(Blade { edge: [[0.0; 3], [1.0, 0.0, 0.0]], sweep: [0.0, 1.0, 0.0] });
    for (selector, name) in [(Selector::Not(Box::new(cut)), "a cut"), (Selector::And(vec![blade]), "a blade")] {
        let error = select_nodes(&mesh, &selector).unwrap_err();
        assert!(error.to_string().starts_with(name), "{error}");
        assert_eq!(select_cells(&mesh, &selector).unwrap_err(), error);
    }
    let empty = select_nodes(&mesh, &Selector::Sphere { centre: [1.0; 3], radius: 0.1 }).unwrap_err();
    assert_eq!(empty, SelectionError::Empty { low: [0.0; 3], high: SIZE });
    for (dimension, axis) in [(Dimension::Two, Axis::Z), (Dimension::One, Axis::Y)] {
        let flat = boxes(dimension, [2, 2, 2], BoxCut::Alike);
        // All of its nodes are at the least and at the largest coordinate.
        let error = select_nodes(&flat, &Selector::Or(vec![Selector::All, plane(axis, PlaneAt::Min)])).unwrap_err();
        assert!(matches!(error, SelectionError::NoExtent { .. }), "{error}");
        assert_eq!(select_cells(&flat, &plane(axis, PlaneAt::Coordinate(0.0))).map(|_| ()), Err(error));
    }
    let swapped = Selector::Box { low: [1.0; 3], high: [0.0; 3] };
    assert!(matches!(select_nodes(&mesh, &swapped), Err(SelectionError::Box { .. })));
}

#[test]
fn nodes_that_no_cell_uses_are_never_picked() {
    let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 2.0, 0.0]];
    let mesh = SimplexMesh::new(Dimension::Two, nodes, vec![[0, 1, 2, 0]], vec![0]).unwrap();
    assert_eq!(select_nodes(&mesh, &Selector::All).unwrap(), [true, true, true, false]);
    assert_eq!(select_nodes(&mesh, &plane(Axis::Y, PlaneAt::Max)).unwrap(), [false, false, true, false]);
}

#[test]
fn tractions_have_the_force_and_the_moment_of_their_face() {
    for (dimension, boxes_of) in
        [(Dimension::One, [3, 1, 1]), (Dimension::Two, [4, 3, 1]), (Dimension::Three, [4, 3, 2])]
    {
        let mesh = boxes(dimension, boxes_of, BoxCut::Alternating);
        let boundary = Boundary::of_mesh(&mesh).unwrap();
        let picked = select_nodes(&mesh, &plane(Axis::X, PlaneAt::Max)).unwrap();
        let traction = [300.0, -20.0, 7.0];
        let (forces, area) = traction_forces(&mesh, selected_faces(boundary.faces(), &picked), traction);
        let axes = dimension.axes();
        let exact: f64 = SIZE[1..axes.max(1)].iter().product();
        assert!((area - exact).abs() < 1e-15, "{dimension}: {area}");
        let centre: [f64; 3] = std::array::from_fn(|r| {
            if r == 0 {
                SIZE[0]
            } else if r < axes {
                0.5 * SIZE[r]
            } else {
                0.0
            }
        });
        let (mut sum, mut moment) = ([0.0; 3], [0.0; 3]);
        for (x, f) in mesh.nodes().iter().zip(forces.chunks_exact(3)) {
            for r in 0..3 {
                sum[r] += f[r];
                moment[r] += x[(r + 1) % 3] * f[(r + 2) % 3] - x[(r + 2) % 3] * f[(r + 1) % 3];
            }
        }
        for r in 0..3 {
            let (p, q) = ((r + 1) % 3, (r + 2) % 3);
            let turning = exact * (centre[p] * traction[q] - centre[q] * traction[p]);
            assert!((sum[r] - exact * traction[r]).abs() < 1e-13 * 300.0, "{dimension}: {sum:?}");
            assert!((moment[r] - turning).abs() < 1e-13 * 300.0, "{dimension}: {moment:?}");
        }
    }
}

/// The scan of this liver ends at z = 137.3 mm, where its surface is flat to 0.1 mm.
#[test]
fn the_flat_end_of_a_scanned_liver_is_picked_as_a_whole() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/meshes/liver_veins_mid.mesh");
    let mesh = read_mesh(&path).unwrap().into_mesh().unwrap();
    let picked = select_nodes(&mesh, &plane(Axis::Z, PlaneAt::Max)).unwrap();
    let boundary = Boundary::of_mesh(&mesh).unwrap();
    let area = |faces: &mut dyn Iterator<Item = &BoundaryFace>| faces.map(|f| f.measure()).sum::<f64>();
    let is_end = |face: &&BoundaryFace| {
        let lowest = face.nodes().iter().map(|n| mesh.nodes()[*n as usize][2]).fold(f64::INFINITY, f64::min);
        face.normal[2] > 0.98 * face.measure() && lowest > 135.0
    };
    let flat = area(&mut boundary.faces().iter().filter(is_end));
    let found = area(&mut selected_faces(boundary.faces(), &picked));
    println!("flat end {flat:.0} mm², picked {found:.0} mm²");
    assert!(found > 0.95 * flat && found < 1.02 * flat, "{found} of {flat} mm²");
    let lowest = mesh.nodes().iter().zip(&picked).filter(|(_, p)| **p).map(|(x, _)| x[2]).fold(f64::INFINITY, f64::min);
    assert!(lowest > 136.5, "{lowest}");
}
