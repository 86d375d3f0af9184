//! Meshes written by other programs are read as those programs read them, and ours are read back.

use grosgrain::io::mesh::{read_gmsh, read_medit, read_tetgen};
use grosgrain::io::{MeshFile, read_mesh, write_mesh};
use grosgrain::simplex::{Dimension, SimplexMesh};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/meshes")
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/meshes").join(name)
}

/// Number of cells of a tag, their measure and its first moments.
type Shares = BTreeMap<i32, (usize, [f64; 4])>;

/// One block of `expected.txt`.
#[derive(Default)]
struct Expected {
    file: String,
    counts: [usize; 3],
    shares: Shares,
    names: Vec<(i32, String)>,
}

fn expected() -> Vec<Expected> {
    let text = std::fs::read_to_string(fixtures().join("expected.txt")).unwrap();
    text.trim_end().split("\n\n").map(|block| block.lines().fold(Expected::default(), with_line)).collect()
}

fn with_line(mut expected: Expected, line: &str) -> Expected {
    let words: Vec<&str> = line.split(' ').collect();
    match words[0] {
        "file" => expected.file = words[1].into(),
        "dimension" => expected.counts[0] = words[1].parse().unwrap(),
        "nodes" => expected.counts[1] = words[1].parse().unwrap(),
        "cells" => expected.counts[2] = words[1].parse().unwrap(),
        "tag" => {
            let numbers = std::array::from_fn(|n| words[3 + n].parse().unwrap());
            expected.shares.insert(words[1].parse().unwrap(), (words[2].parse().unwrap(), numbers));
        }
        _ => expected.names.push((words[1].parse().unwrap(), words[2..].join(" "))),
    }
    expected
}

fn shares(mesh: &SimplexMesh) -> Shares {
    let mut shares = Shares::new();
    for (cell, tag) in mesh.tags().iter().enumerate() {
        let (count, numbers) = shares.entry(*tag).or_default();
        let (measure, corners) = (mesh.measure(cell), mesh.dimension().corners());
        *count += 1;
        numbers[0] += measure;
        for r in 0..3 {
            let sum: f64 = (0..corners).map(|c| mesh.corner(cell, c)[r]).sum();
            numbers[1 + r] += measure * sum / corners as f64;
        }
    }
    shares
}

/// Measures and moments of bodies of size one in double precision, summed over some hundred cells.
const TOLERANCE: f64 = 1e-13;

fn assert_close(found: &Shares, wanted: &Shares, tolerance: f64, what: &str) {
    assert_eq!(found.keys().collect::<Vec<_>>(), wanted.keys().collect::<Vec<_>>(), "{what}");
    for (tag, (count, numbers)) in wanted {
        assert_eq!(found[tag].0, *count, "{what}: cells of tag {tag}");
        for (a, b) in found[tag].1.iter().zip(numbers) {
            assert!((a - b).abs() <= tolerance, "{what}, tag {tag}: {a} instead of {b}");
        }
    }
}

#[test]
fn every_fixture_is_read_as_by_the_program_that_wrote_it() {
    let all = expected();
    assert!(all.len() >= 29, "{} fixtures", all.len());
    for wanted in all {
        let file = read_mesh(fixtures().join(&wanted.file)).unwrap();
        let name = &wanted.file;
        assert_eq!([file.dimension.axes(), file.nodes.len(), file.cells.len()], wanted.counts, "{name}");
        assert_eq!(file.names, wanted.names, "{name}");
        assert_close(&shares(&file.into_mesh().unwrap()), &wanted.shares, TOLERANCE, name);
    }
}

#[test]
fn both_byte_orders_and_text_give_the_same_mesh() {
    let read = |name: &str| read_mesh(fixtures().join(name)).unwrap();
    for version in ["gmsh22", "gmsh41"] {
        let little = read(&format!("{version}_entities_binary.msh"));
        assert_eq!(read(&format!("{version}_entities_big_endian.msh")), little);
        let text = read(&format!("{version}_entities.msh"));
        assert_eq!((&text.cells, &text.tags), (&little.cells, &little.tags));
    }
}

#[test]
fn what_is_left_out_is_told() {
    let told = |name: &str| read_mesh(fixtures().join(name)).unwrap().skipped;
    assert_eq!(told("gmsh41_two_groups.msh")[0], "entities in several physical groups, of which the first counts: 1");
    assert!(told("gmsh22_two_groups.msh").contains(&"tetrahedra left out that were listed before: 66".into()));
    let all = told("gmsh41_all.msh");
    assert!(all.iter().any(|s| s.starts_with("points left out: ")), "{all:?}");
    assert!(all.iter().any(|s| s.starts_with("segments left out: ")), "{all:?}");
    assert!(all.iter().any(|s| s.starts_with("triangles left out: ")), "{all:?}");
    let entities = told("gmsh41_entities.msh");
    assert_eq!(entities[0], "no cell is in a physical group: tags are the numbers of geometric entities");
}

/// Tag, number of cells and volume of each part.
type Parts = &'static [(i32, usize, f64)];

/// Counts and volumes (of millimetres or of a bar of 10 × 1 × 1) as meshio and the Gmsh library find them.
#[test]
fn real_meshes_have_the_sizes_that_other_programs_find() {
    let liver: Parts = &[(1, 20089, 1_123_598.125), (2, 695, 17_603.652_343_75), (3, 784, 12_022.417_968_75)];
    let wanted: [(&str, usize, Parts); 5] = [
        ("liver_veins_mid.mesh", 4773, liver),
        ("liver_coarse.mesh", 264, &[(1, 672, 1_105_366.0)]),
        ("liver_coarse_enclosing.mesh", 354, &[(1, 989, 1_945_030.0)]),
        ("bar.msh", 1088, &[(1, 3646, 10.0)]),
        ("bimetal.msh", 3881, &[(1, 8071, 5.0), (2, 8204, 5.0)]),
    ];
    for (name, nodes, parts) in wanted {
        let file = read_mesh(data(name)).unwrap();
        assert_eq!((file.dimension, file.nodes.len()), (Dimension::Three, nodes), "{name}");
        let found = shares(&file.into_mesh().unwrap());
        assert_eq!(found.len(), parts.len(), "{name}");
        for (tag, cells, volume) in parts {
            let (count, numbers) = found[tag];
            // Volumes of Medit files were summed in single precision: 24 bits.
            assert!(count == *cells && (numbers[0] - volume).abs() < 1e-6 * volume, "{name}: {count}, {numbers:?}");
        }
    }
    let names = read_mesh(data("bimetal.msh")).unwrap().names;
    assert_eq!(names, [(1, "bottom_material".to_owned()), (2, "top_material".to_owned())]);
}

#[test]
fn a_written_mesh_is_read_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    // Other programs check these files: see the README of the fixtures.
    let kept = std::env::var_os("GROSGRAIN_WRITTEN").map(PathBuf::from);
    let folder = kept.as_deref().unwrap_or(folder.path());
    std::fs::create_dir_all(folder).unwrap();
    for (source, stem) in [("gmsh41_groups.msh", "solid"), ("gmsh41_plane.msh", "plane")] {
        let MeshFile { names, .. } = read_mesh(fixtures().join(source)).unwrap();
        let mesh = read_mesh(fixtures().join(source)).unwrap().into_mesh().unwrap();
        for extension in ["msh", "mesh"] {
            let path = folder.join(stem).with_extension(extension);
            write_mesh(&path, &mesh, &names).unwrap();
            let back = read_mesh(&path).unwrap();
            assert_eq!(back.names, if extension == "msh" { names.clone() } else { Vec::new() });
            assert_eq!(back.skipped, Vec::<String>::new());
            assert_eq!(back.into_mesh().unwrap(), mesh, "{}", path.display());
        }
    }
}

#[test]
fn tags_that_gmsh_does_not_have_are_kept_apart_or_refused() {
    let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.5, 0.0, 0.0]];
    let line =
        |tags| SimplexMesh::new(Dimension::One, nodes.clone(), vec![[0, 1, 0, 0], [1, 2, 0, 0], [2, 3, 0, 0]], tags);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line.msh");
    let mesh = line(vec![0, 0, 5]).unwrap();
    write_mesh(&path, &mesh, &[(5, "a \"b\"".into()), (9, "unused".into())]).unwrap();
    let back = read_mesh(&path).unwrap();
    assert_eq!(back.names, [(5, "a 'b'".to_owned())]);
    assert_eq!(back.into_mesh().unwrap(), mesh);
    let negative = line(vec![-2, 1, -2]).unwrap();
    let error = write_mesh(&path, &negative, &[]).unwrap_err().to_string();
    assert!(error.contains("2 cells have the tag -2"), "{error}");
    assert!(read_mesh(&path).is_ok(), "the old file stays");
    write_mesh(path.with_extension("mesh"), &negative, &[]).unwrap();
    assert_eq!(read_mesh(path.with_extension("mesh")).unwrap().into_mesh().unwrap(), negative);
    assert!(write_mesh(path.with_extension("stl"), &mesh, &[]).unwrap_err().to_string().contains(".msh (Gmsh)"));
}

#[test]
fn numbers_may_begin_anywhere_and_comments_stand_between() {
    let tetgen = read_tetgen(
        b"# nodes\n4 3 1 1\n1 0 0 0 9 1\n2 1 0 0 9 1 # corner\n\n3 0 1 0 9 1\n4 0 0 1 9 1\n",
        b"1 4 1\n1 1 2 3 4 -8.0\n",
    );
    let medit = read_medit(
        b"# by hand\nMeshVersionFormatted 1\nDimension\n3\nVertices 4 0 0 0 1 1 0 0 1 0 1 0 1\n 0 0 1 1 # corner\n\
          RequiredVertices 2 1 2\nTetrahedra\n1\n1 2 3 4 -8\nHexahedra 0\nNormals 1 0 0 1\nEnd\n",
    );
    let gmsh = read_gmsh(
        b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Other\nx $ y\n$EndOther\n$Nodes\r\n4\r\n70 0 0 0\r\n60 1 0 0\n50 0 1 0\n7 0 0 1\n\
          $EndNodes\n$Elements\n1\n33 4 3 -8 1 99 70 60 50 7\n$EndElements\n",
    );
    let meshes = [tetgen, medit, gmsh].map(|file| file.unwrap().into_mesh().unwrap());
    assert_eq!(meshes[0].tags(), [-8]);
    assert_eq!(meshes[0].nodes()[1], [1.0, 0.0, 0.0]);
    assert_eq!(meshes[0], meshes[1]);
    assert_eq!(meshes[0], meshes[2]);
}
