//! Tractions by the normals of a coarse mesh around a rough fine one.

mod simplices;

use grosgrain::homogenization::{HarmonicOptions, bounding_normals, harmonic_displacements};
use grosgrain::progress::silent;
use grosgrain::simplex::{Boundary, Dimension, SimplexMesh};
use simplices::{box_of, full_matrix, model};

/// A unit square or cube whose upper side, by the last axis, is wavy, with a slot cut into that side.
fn rough(dimension: Dimension) -> SimplexMesh {
    let last = dimension.axes() - 1;
    let solid = |at: [usize; 3]| (at[0] != 5 || at[last] < 5).then_some(0);
    let mesh = box_of(dimension, [10; 3], [1.0; 3], 0.0, &solid);
    let wavy = |x: &[f64; 3]| {
        let mut x = *x;
        let wave = (37.0 * x[0]).sin() + if last > 1 { (41.0 * x[1]).cos() } else { 0.0 };
        x[last] += if x[last] > 0.95 { 0.02 * wave } else { 0.0 };
        x
    };
    let cells = (0..mesh.cell_count()).map(|cell| std::array::from_fn(|n| *mesh.cell(cell).get(n).unwrap_or(&0)));
    let nodes = mesh.nodes().iter().map(wavy).collect();
    SimplexMesh::new(dimension, nodes, cells.collect(), mesh.tags().to_vec()).unwrap()
}

#[test]
fn a_rough_side_is_pulled_along_the_coarse_normal_and_a_slot_along_its_own() {
    for dimension in [Dimension::Two, Dimension::Three] {
        let last = dimension.axes() - 1;
        let fine = rough(dimension);
        let coarse = box_of(dimension, [2; 3], [1.0; 3], 0.0, &|_| Some(0));
        let normals = bounding_normals(&fine, &coarse).unwrap();
        let boundary = Boundary::of_mesh(&fine).unwrap();
        let (mut of_side, mut of_slot) = (0, 0);
        for (face, normal) in boundary.outer().zip(&normals) {
            let mean = |r: usize| {
                face.nodes().iter().map(|n| fine.nodes()[*n as usize][r]).sum::<f64>() / face.nodes().len() as f64
            };
            let own = face.normal.map(|n| n / face.measure());
            let axis = (0..3).fold(0, |best, r| if normal[r].abs() > normal[best].abs() { r } else { best });
            let unit: [f64; 3] = std::array::from_fn(|r| if r == axis { normal[axis].signum() } else { 0.0 });
            assert!((0..3).all(|r| (unit[r] - normal[r]).abs() < 1e-12) || *normal == own, "{dimension}: {normal:?}");
            let in_slot = mean(0) > 0.4999 && mean(0) < 0.6001 && mean(last) > 0.4999 && mean(last) < 0.92;
            if in_slot {
                assert!((0..3).all(|r| (own[r] - normal[r]).abs() < 1e-12), "{dimension}: {normal:?}, own {own:?}");
                of_slot += 1;
            } else if mean(last) > 0.95 && own[last] > 0.7 {
                assert!(normal[last] > 1.0 - 1e-14 && own[last] < 1.0 - 1e-6, "{dimension}: {normal:?}, own {own:?}");
                of_side += 1;
            }
        }
        assert!(of_side >= 9 && of_slot >= 9, "{dimension}: {of_side} faces of the side, {of_slot} of the slot");
        let stiffness = full_matrix(dimension, 4);
        let options = HarmonicOptions { normals, ..HarmonicOptions::default() };
        let (_, report) = harmonic_displacements(&model(fine, &|_| stiffness), &options, &silent).unwrap();
        assert!(report.unbalanced > 1e-4 && report.unbalanced < 0.1 && report.residual < 1e-11, "{report:?}");
    }
}
