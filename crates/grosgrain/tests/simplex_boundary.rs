//! The boundary of a mesh is closed, its normals point outwards, and cavities are told from the outer boundary.

use grosgrain::simplex::{
    Boundary, BoundaryError, BoundingBox, BoxCut, BranchingRidge, Dimension, SimplexLattice, SimplexMesh,
};

const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];

/// Boxes of side 1 except those that are `void`.
fn boxes(dimension: Dimension, count: usize, cut: BoxCut, void: impl Fn([usize; 3]) -> bool) -> SimplexMesh {
    let around = BoundingBox { lower: [0.0; 3], upper: [count as f64; 3] };
    let mesh = SimplexLattice { dimension, boxes: [count; 3], around, cut }.mesh().unwrap();
    mesh.part(|cell| !void(mesh.centre(cell).map(|x| x as usize))).unwrap().0
}

/// Faces and rounded content of each shell.
fn shells(boundary: &Boundary) -> Vec<(usize, f64)> {
    boundary.shells().iter().map(|shell| (shell.faces, (shell.enclosed * 1e9).round() / 1e9)).collect()
}

#[test]
fn normals_of_a_box_point_outwards_and_add_up_to_nothing() {
    for dimension in DIMENSIONS {
        for cut in [BoxCut::Alike, BoxCut::Alternating] {
            let mesh = boxes(dimension, 3, cut, |_| false);
            let boundary = Boundary::of_mesh(&mesh).unwrap();
            assert_eq!(boundary.shells().len(), 1);
            assert!((boundary.shells()[0].enclosed - mesh.total_measure()).abs() < 1e-12, "{dimension}");
            assert!(boundary.branching().is_empty() && boundary.outer().count() == boundary.faces().len());
            let d = dimension.axes();
            for face in boundary.faces() {
                let at = mesh.nodes()[face.nodes()[0] as usize];
                assert_eq!(face.nodes().len(), d);
                // All nodes lie in one side of the box, and the normal points away from its centre.
                let axis = (0..d).find(|r| face.normal[*r].abs() == face.measure()).unwrap();
                assert!(face.nodes().iter().all(|n| mesh.nodes()[*n as usize][axis] == at[axis]));
                assert_eq!(at[axis], if face.normal[axis] > 0.0 { 3.0 } else { 0.0 });
                assert!(face.nodes().iter().all(|n| mesh.cell(face.cell as usize).contains(n)));
            }
            let surface: f64 = boundary.faces().iter().map(|f| f.measure()).sum();
            assert!((surface - [2.0, 12.0, 54.0][d - 1]).abs() < 1e-12);
            let sum = |r: usize| boundary.faces().iter().map(|f| f.normal[r]).sum::<f64>();
            assert!((0..3).all(|r| sum(r).abs() < 1e-12));
        }
    }
}

#[test]
fn a_cavity_is_a_shell_of_its_own() {
    for (dimension, content, outside, inside) in [(Dimension::Two, 24.0, 20, 4), (Dimension::Three, 124.0, 300, 12)] {
        let mesh = boxes(dimension, 5, BoxCut::Alternating, |at| at[..dimension.axes()].iter().all(|x| *x == 2));
        let boundary = Boundary::of_mesh(&mesh).unwrap();
        assert!((mesh.total_measure() - content).abs() < 1e-12);
        assert_eq!(shells(&boundary), [(outside, content + 1.0), (inside, -1.0)], "{dimension}");
        assert_eq!(boundary.outer().count(), outside);
        assert!(boundary.outer().all(|face| !boundary.is_cavity(face)));
    }
}

/// A hole through the body opens to the outside: no cavity.
#[test]
fn a_hole_is_part_of_the_outer_boundary() {
    let mesh = boxes(Dimension::Three, 3, BoxCut::Alike, |at| at[0] == 1 && at[1] == 1);
    let boundary = Boundary::of_mesh(&mesh).unwrap();
    assert_eq!(shells(&boundary), [(2 * (6 * 9 - 2 + 12), 24.0)]);
}

/// Void boxes (0, 0) and (1, 1) touch at an edge: the first is a notch, the second a cavity.
#[test]
fn a_cavity_that_touches_the_outside_at_an_edge_stays_a_cavity() {
    for (dimension, content) in [(Dimension::Two, 7.0), (Dimension::Three, 25.0)] {
        let void = |at: [usize; 3]| (at[0] == at[1]) && at[0] < 2 && (dimension == Dimension::Two || at[2] == 1);
        let mesh = boxes(dimension, 3, BoxCut::Alike, void);
        let boundary = Boundary::of_mesh(&mesh).unwrap();
        assert!((mesh.total_measure() - content).abs() < 1e-12);
        let found: Vec<f64> = shells(&boundary).iter().map(|s| s.1).collect();
        assert_eq!(found, [content + 1.0, -1.0], "{dimension}");
        assert!(matches!(boundary.branching(), [BranchingRidge { faces: 4, .. }]), "{:?}", boundary.branching());
        let [BranchingRidge { nodes, .. }] = *boundary.branching() else { return };
        assert!(nodes.iter().all(|n| mesh.nodes()[*n as usize][..2] == [1.0, 1.0]));
    }
}

/// Solid boxes (0, 0) and (1, 1) touch at an edge: one outer void, one shell.
#[test]
fn bodies_that_touch_at_an_edge_have_one_shell_and_are_reported() {
    for dimension in [Dimension::Two, Dimension::Three] {
        let mesh =
            boxes(dimension, 2, BoxCut::Alike, |at| at[0] != at[1] || (at[2] == 1 && dimension == Dimension::Three));
        let boundary = Boundary::of_mesh(&mesh).unwrap();
        assert_eq!(shells(&boundary).iter().map(|s| s.1).collect::<Vec<_>>(), [2.0], "{dimension}");
        assert_eq!(boundary.branching().len(), 1);
    }
}

#[test]
fn pieces_of_a_line_have_two_ends_each() {
    let mesh = boxes(Dimension::One, 5, BoxCut::Alike, |at| at[0] == 1);
    let boundary = Boundary::of_mesh(&mesh).unwrap();
    assert_eq!(shells(&boundary), [(2, 1.0), (2, 3.0)]);
    let normals: Vec<f64> = boundary.faces().iter().map(|f| f.normal[0]).collect();
    assert_eq!(normals, [-1.0, 1.0, -1.0, 1.0]);
}

#[test]
fn cells_that_overlap_at_a_face_are_named() {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.3, 0.3, 2.0], [0.1, 0.2, -1.0]];
    let mesh = |cells: &[[u32; 4]]| {
        SimplexMesh::new(Dimension::Three, corners.to_vec(), cells.to_vec(), vec![0; cells.len()]).unwrap()
    };
    assert!(Boundary::of_mesh(&mesh(&[[0, 1, 2, 3], [0, 2, 1, 5]])).is_ok());
    let folded = Boundary::of_mesh(&mesh(&[[0, 1, 2, 3], [0, 1, 2, 4]])).unwrap_err();
    assert_eq!(folded, BoundaryError::Folded { nodes: vec![0, 1, 2], cells: [0, 1] });
    let crowded = Boundary::of_mesh(&mesh(&[[0, 1, 2, 3], [0, 1, 2, 4], [0, 2, 1, 5]])).unwrap_err();
    assert_eq!(crowded, BoundaryError::Crowded { nodes: vec![0, 1, 2], cells: [0, 1, 2] });
    let message =
        "cells 0, 1, 2 share one face, that of nodes [0, 1, 2]; at most two can, so remove the cells that overlap";
    assert_eq!(crowded.to_string(), message);
}
