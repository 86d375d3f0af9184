//! The model file holds what its documentation promises.

use std::fs::File;
use std::path::Path;

use ndarray::{Array0, Array1, Array2, Array3, Array4, Dimension};
use ndarray_npy::{NpzReader, ReadableElement};

use super::program::{SMALL, changed, grosgrain, json};

/// 15 × 4 × 4 cells of unequal edges, padded to 16 × 4 × 4: n = 32 coarse cells, m = 81 coarse nodes.
fn coarsened(folder: &Path) -> NpzReader<File> {
    let grid = ["cells = [16, 4, 4], size = [0.16, 0.04, 0.04]", "cells = [15, 4, 4], size = [0.15, 0.08, 0.02]"];
    std::fs::write(folder.join("scene.toml"), changed(SMALL, [grid])).unwrap();
    grosgrain(folder, &["coarsen", "scene.toml", "-o", "new/model.npz", "--json", "new/figures.json"]).done();
    NpzReader::new(File::open(folder.join("new/model.npz")).unwrap()).unwrap()
}

fn array<T: ReadableElement, D: Dimension>(
    file: &mut NpzReader<File>,
    name: &str,
    shape: &[usize],
) -> ndarray::Array<T, D> {
    let array: ndarray::Array<T, D> = file.by_name(name).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert_eq!(array.shape(), shape, "{name}");
    array
}

#[test]
fn the_model_file_has_the_documented_arrays_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = coarsened(folder.path());
    let mut names = file.names().unwrap();
    names.sort();
    let documented = [
        "cells",
        "corners",
        "degree",
        "labels",
        "mass",
        "nodes",
        "origin",
        "part",
        "shape_functions",
        "spacing",
        "stiffness",
        "training",
        "version",
        "void",
    ];
    assert_eq!(names, documented);
    let degree: Array0<i64> = array(&mut file, "degree", &[]);
    let version: Array0<i64> = array(&mut file, "version", &[]);
    assert_eq!((degree.into_scalar(), version.into_scalar()), (2, 1));
    let labels: Array3<i32> = array(&mut file, "labels", &[4, 4, 16]);
    let void: Array3<bool> = array(&mut file, "void", &[4, 4, 16]);
    for ((at, label), void) in labels.indexed_iter().zip(&void) {
        assert_eq!(*void, at.2 == 15, "the last layer is padding: {at:?}");
        assert!(*void || [0, 1].contains(label), "{at:?}: {label}");
    }
    let _: Array3<f64> = array(&mut file, "training", &[32, 81, 6]);
    let figures = json(&folder.path().join("new/figures.json"));
    assert_eq!((figures["cells"].as_u64(), figures["degree"].as_u64()), (Some(32), Some(2)), "{figures}");
    for stage in ["training", "fitting", "assembly"] {
        assert!(figures["seconds"][stage].as_f64().is_some_and(|s| s >= 0.0), "{stage} in {figures}");
    }
}

#[test]
fn corners_lead_to_nodes_that_stand_where_the_cells_say() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = coarsened(folder.path());
    let cells: Array2<i64> = array(&mut file, "cells", &[32, 3]);
    let corners: Array2<i64> = array(&mut file, "corners", &[32, 8]);
    let nodes: Array2<f64> = array(&mut file, "nodes", &[81, 3]);
    let spacing: Array1<f64> = array(&mut file, "spacing", &[3]);
    let origin: Array1<f64> = array(&mut file, "origin", &[3]);
    for (a, h) in [0.01, 0.02, 0.005].into_iter().enumerate() {
        assert!((spacing[a] - h).abs() < 1e-15 && origin[a] == 0.0, "{spacing} {origin}");
    }
    for (cell, row) in cells.rows().into_iter().zip(corners.rows()) {
        for (corner, &node) in row.iter().enumerate() {
            for a in 0..3 {
                let expected = 2.0 * spacing[a] * (cell[a] + (corner as i64 >> a & 1)) as f64;
                // A few roundings of numbers up to 0.16.
                let found = nodes[[node as usize, a]];
                assert!((found - expected).abs() < 1e-15, "cell {cell} corner {corner}: {found} {expected}");
            }
        }
    }
}

#[test]
fn shape_functions_sum_to_the_identity_and_stiffness_ignores_translations() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = coarsened(folder.path());
    let functions: Array4<f64> = array(&mut file, "shape_functions", &[32, 27, 3, 24]);
    for cell in 0..32 {
        for (node, row, column) in (0..27).flat_map(|n| (0..9).map(move |rc| (n, rc / 3, rc % 3))) {
            let sum: f64 = (0..8).map(|corner| functions[[cell, node, row, 3 * corner + column]]).sum();
            let identity = f64::from(u8::from(row == column));
            assert!((sum - identity).abs() < 1e-10, "cell {cell} node {node}, {row} {column}: {sum}");
        }
    }
    let stiffness: Array3<f64> = array(&mut file, "stiffness", &[32, 24, 24]);
    let largest = stiffness.iter().fold(0.0f64, |m, k| m.max(k.abs()));
    for ((cell, row, column), k) in stiffness.indexed_iter() {
        let mirror = stiffness[[cell, column, row]];
        assert!((k - mirror).abs() <= 1e-13 * largest, "cell {cell}: {k} at {row} {column}, {mirror} mirrored");
    }
    for (cell, row, component) in (0..32).flat_map(|c| (0..72).map(move |rc| (c, rc / 3, rc % 3))) {
        let force: f64 = (0..8).map(|corner| stiffness[[cell, row, 3 * corner + component]]).sum();
        assert!(force.abs() < 1e-10 * largest, "cell {cell}: a translation along {component} is resisted by {force}");
    }
}

#[test]
fn masses_sum_to_that_of_the_body() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = coarsened(folder.path());
    let mass: Array1<f64> = array(&mut file, "mass", &[81]);
    let labels: Array3<i32> = array(&mut file, "labels", &[4, 4, 16]);
    let void: Array3<bool> = array(&mut file, "void", &[4, 4, 16]);
    let density = |(label, void): (&i32, &bool)| if *void { 0.0 } else { [1000.0, 1500.0][*label as usize] };
    let expected: f64 = labels.iter().zip(&void).map(density).sum::<f64>() * 0.01 * 0.02 * 0.005;
    let sum = mass.sum();
    assert!((sum - expected).abs() < 1e-12 * expected, "{sum} kg, {expected} kg");
}

/// Two plates a voxel apart in coarse cells of degree 4: 16 × 4 × 4 cells whose layers along z are solid, void, solid, void.
fn plates(split: bool) -> String {
    let stiff = "[materials.stiff]\nlabel = 1\nyoung = 5e6\npoisson = 0.45\ndensity = 1500.0\n";
    let degree = format!("degree = 4\nsplit = {split}");
    let layers = "direction = [0, 0, 1], period = 2, labels = [0, 1] }\nvoid = [1]";
    let changes = [
        ["direction = [1, 0, 1], period = 4, labels = [0, 1] }", layers],
        [stiff, ""],
        ["degree = 2", degree.as_str()],
    ];
    changed(SMALL, changes)
}

#[test]
fn parts_of_a_coarse_cell_are_rows_of_their_own_unless_splitting_is_off() {
    let folder = tempfile::tempdir().unwrap();
    for (split, elements, vertices) in [(true, 8, 40), (false, 4, 20)] {
        std::fs::write(folder.path().join("scene.toml"), plates(split)).unwrap();
        grosgrain(folder.path(), &["coarsen", "scene.toml", "-o", "model.npz", "--json", "figures.json"]).done();
        let mut file = NpzReader::new(File::open(folder.path().join("model.npz")).unwrap()).unwrap();
        let cells: Array2<i64> = array(&mut file, "cells", &[elements, 3]);
        let part: Array1<i64> = array(&mut file, "part", &[elements]);
        let per_cell = elements / 4;
        for (row, part) in part.iter().enumerate() {
            assert_eq!((cells[[row, 0]], *part), ((row / per_cell) as i64, (row % per_cell) as i64));
        }
        let _: Array2<f64> = array(&mut file, "nodes", &[vertices, 3]);
        let corners: Array2<i64> = array(&mut file, "corners", &[elements, 8]);
        let used: std::collections::BTreeSet<i64> = corners.iter().copied().collect();
        assert_eq!(used, (0..vertices as i64).collect());
        let mass: Array1<f64> = array(&mut file, "mass", &[vertices]);
        let expected = 1000.0 * 0.16 * 0.04 * 0.02;
        assert!((mass.sum() - expected).abs() < 1e-12 * expected, "{} kg, {expected} kg", mass.sum());
        let figures = json(&folder.path().join("figures.json"));
        assert_eq!(
            (figures["cells"].as_u64(), figures["nodes"].as_u64()),
            (Some(elements as u64), Some(vertices as u64))
        );
        let inspected = grosgrain(folder.path(), &["inspect", "scene.toml", "--json"]);
        assert!(inspected.stdout.contains(&format!("\"coarse_nodes\": {vertices}")), "{}", inspected.stdout);
        let run = grosgrain(folder.path(), &["simulate", "scene.toml", "-o", "out"]);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let report = json(&folder.path().join("out/report.json"));
        assert_eq!(report["coarse"]["unknowns"].as_u64(), Some(3 * vertices as u64), "{report}");
    }
}

#[test]
fn results_have_the_same_bytes_with_one_thread_and_with_two() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), SMALL).unwrap();
    let results = |threads: &str| {
        let (model, out) = (format!("{threads}.npz"), format!("out-{threads}"));
        grosgrain(folder.path(), &["--threads", threads, "coarsen", "scene.toml", "-o", &model]).done();
        grosgrain(folder.path(), &["--threads", threads, "simulate", "scene.toml", "-o", &out]).done();
        let bytes = |file: String| std::fs::read(folder.path().join(file)).unwrap();
        [bytes(model), bytes(format!("{out}/body_0000.vtu")), bytes(format!("{out}/coarse_0000.vtu"))]
    };
    let (one, two) = (results("1"), results("2"));
    assert!(one == two, "lengths {:?} and {:?}", one.map(|b| b.len()), two.map(|b| b.len()));
}
