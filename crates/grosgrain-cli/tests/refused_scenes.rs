//! Every unusable scene is refused before anything is computed, by sentences that name file, line and key.

use std::path::Path;

use assert_cmd::Command;
use grosgrain::io::mesh::write_mesh as write_mesh_file;
use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, SimplexLattice};

const CASES: &str = include_str!("data/bad_scenes.toml");

/// An NPY file of `descr` numbers with `shape` [z, y, x].
fn write_npy(path: &Path, descr: &str, shape: &str, data: &[u8]) {
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    header.push_str(&" ".repeat(63 - (header.len() + 10) % 64));
    header.push('\n');
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(data);
    std::fs::write(path, file).unwrap();
}

/// A box of boxes as a file; cells have tag 1 beyond half of its length.
fn write_mesh(path: &Path, dimension: Dimension, boxes: [usize; 3], [low, high]: [[f64; 3]; 2]) {
    let around = BoundingBox { lower: low, upper: high };
    let mesh = SimplexLattice { dimension, boxes, around, cut: BoxCut::Alike }.mesh().unwrap();
    let mesh = mesh.tagged(|at| i32::from(2.0 * at[0] > low[0] + high[0]));
    write_mesh_file(path, &mesh, &[]).unwrap();
}

fn texts(value: &toml::Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect()
}

#[test]
fn every_bad_scene_is_refused_with_its_sentences_and_exit_code_2() {
    let table: toml::Table = CASES.parse().unwrap();
    let folder = tempfile::tempdir().unwrap();
    write_npy(&folder.path().join("labels.npy"), "|u1", "(2, 2, 4)", &[0, 1, 2, 1].repeat(4));
    write_npy(&folder.path().join("moduli.npy"), "<f8", "(2, 2, 2)", &1e6f64.to_le_bytes().repeat(8));
    let block = [[0.0; 3], [0.08, 0.04, 0.04]];
    let mesh = |name: &str, dimension, boxes, around| write_mesh(&folder.path().join(name), dimension, boxes, around);
    mesh("block.mesh", Dimension::Three, [2, 2, 2], block);
    mesh("far.mesh", Dimension::Three, [1; 3], [[1.0; 3], [2.0; 3]]);
    mesh("long.mesh", Dimension::Three, [2, 1, 1], [[0.0; 3], [0.16, 0.04, 0.04]]);
    mesh("plate.mesh", Dimension::Two, [4, 4, 1], [[0.0; 3], [0.08, 0.04, 0.0]]);
    let cases = table["case"].as_array().unwrap();
    assert!(cases.len() >= 100, "{} cases", cases.len());
    for case in cases {
        let name = case["name"].as_str().unwrap();
        let mut scene = table["base"].as_str().unwrap().to_string();
        for change in case["changes"].as_array().unwrap() {
            let change = texts(change);
            assert!(scene.contains(change[0]), "{name}: the base holds no {:?}", change[0]);
            scene = scene.replacen(change[0], change[1], 1);
        }
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_grosgrain"));
        let output = command.current_dir(folder.path()).args(["inspect", "scene.toml"]).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        let expected: String = texts(&case["says"]).iter().map(|line| format!("scene.toml:{line}\n")).collect();
        assert_eq!(said, expected, "{name}");
        assert_eq!(output.status.code(), Some(2), "{name}");
        assert_eq!(output.stdout, b"", "{name}");
    }
}
