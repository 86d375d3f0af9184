//! Mesh files that cannot be read give a sentence, never a panic.

use grosgrain::io::mesh::{read_gmsh, read_medit, read_tetgen};
use grosgrain::io::{MeshFile, MeshReadError, read_mesh};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name)
}

#[test]
fn files_of_other_kinds_are_refused_with_what_to_do() {
    let wanted = [
        ("version_1.msh", "version 1 of Gmsh's mesh format cannot be read; save it as version 4.1"),
        ("version_4_0.msh", "version 4 of Gmsh's mesh format cannot be read; save it as version 4.1"),
        ("partitioned.msh", "a partitioned Gmsh mesh cannot be read; open it in Gmsh, choose Mesh > Unpartition"),
        ("second_order.msh", "the body has 132 tetrahedra of second order; only segments, triangles and tetrahedra"),
        ("quadrilaterals.msh", "quadrilaterals; only segments, triangles and tetrahedra"),
        ("hexahedra.mesh", "the body has 1 hexahedra; only segments, triangles and tetrahedra"),
        ("binary.meshb", "a binary Medit mesh (.meshb) cannot be read; save it as text"),
        ("skin.mesh", "the file holds a surface or curve, not a body: its triangles do not lie in the plane z = 0"),
    ];
    let files = std::fs::read_dir(folder("meshes/refused")).unwrap().count();
    assert_eq!(files, wanted.len(), "every file of the folder is tried");
    for (name, sentence) in wanted {
        let error = read_mesh(folder("meshes/refused").join(name)).and_then(MeshFile::into_mesh).unwrap_err();
        assert!(error.to_string().contains(sentence), "{name}: {error}");
    }
}

#[test]
fn an_mfem_mesh_is_refused_by_its_name() {
    let error = read_medit(b"MFEM mesh v1.0\n\ndimension\n3\n").unwrap_err().to_string();
    assert!(error.starts_with("an MFEM mesh cannot be read; save it from MFEM as VTK or Gmsh"), "{error}");
}

const FORMAT: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const NODES: &str = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";

#[test]
fn damage_in_gmsh_text_is_told_with_its_line() {
    let wanted = [
        ("$Elements\n1\n1 4 0 1 2 3 9\n", "line 13: an element names node 9, which the file does not list"),
        ("$Elements\n1\n1 4 0 1 2 3 x\n", "line 13: `x` stands where the number of a node of an element is expected"),
        ("$Elements\n1\n1 77 0 1 2 3 4\n", "line 13: `77` stands where a kind of element of Gmsh"),
        ("$Elements\n1\n1 4 -2 1 2 3 4\n", "line 13: `-2` stands where the number of tags of an element is expected"),
        ("$Elements\n9\n1 4 0 1 2 3 4\n", "line 14: the file ends where the number of an element is expected"),
        ("$Elements\n0\n$EndElements\n", "the file lists 4 nodes and no segments, triangles or tetrahedra"),
        ("stray\n", "line 11: `stray` stands where a section, e.g. $Nodes is expected"),
        ("$Data\n", "the file ends where the end of a section is expected"),
        (NODES, "a Gmsh file with several $Nodes sections cannot be read"),
    ];
    for (rest, sentence) in wanted {
        let error = read_gmsh(format!("{FORMAT}{NODES}{rest}").as_bytes()).unwrap_err().to_string();
        assert!(error.contains(sentence), "{rest}: {error}");
    }
    let early = read_gmsh(format!("{FORMAT}$Elements\n1\n1 4 0 1 2 3 4\n").as_bytes()).unwrap_err();
    assert!(matches!(early, MeshReadError::Missing { section: "$Nodes before $Elements", .. }), "{early}");
    let twice = NODES.replace("\n2 1", "\n3 1");
    let twice = read_gmsh(format!("{FORMAT}{twice}").as_bytes()).unwrap_err();
    assert!(matches!(twice, MeshReadError::RepeatedNode { node: 3 }), "{twice}");
    let version = read_gmsh(b"$MeshFormat\n5 0 8\n$EndMeshFormat\n").unwrap_err().to_string();
    assert!(version.starts_with("version 5 of Gmsh's mesh format cannot be read"), "{version}");
}

#[test]
fn a_count_that_no_file_can_hold_takes_no_memory() {
    let claims = [
        (b"$MeshFormat\n2.2 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n18446744073709551615\n".to_vec(), "byte 68"),
        (b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 1 1 1\n3 1 0 9223372036854775807\n1\n".to_vec(), "line 8"),
        (
            [b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Entities\n".as_slice(), &[0xff; 7], &[0x7f; 30]]
                .concat(),
            "byte",
        ),
    ];
    for (bytes, place) in claims {
        let error = read_gmsh(&bytes).unwrap_err();
        assert!(matches!(error, MeshReadError::CutOff { .. }) && error.to_string().starts_with(place), "{error}");
    }
    let medit = b"MeshVersionFormatted 1 Dimension 3 Vertices 18446744073709551615 0 0 0 0";
    assert!(matches!(read_medit(medit).unwrap_err(), MeshReadError::CutOff { .. }));
    assert!(matches!(read_tetgen(b"99999999999 3 0 0\n1 0 0 0\n", b"").unwrap_err(), MeshReadError::CutOff { .. }));
}

#[test]
fn damage_in_medit_text_is_told_with_its_line() {
    const HEAD: &str = "MeshVersionFormatted 1\nDimension 3\nVertices\n4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n";
    let wanted = [
        ("Tetrahedra\n1\n1 2 3 5 0\n", "line 11: an element names node 5"),
        ("Tetrahedra\n1\n1 2 3 0 0\n", "line 11: an element names node 0"),
        ("Tetrahedra\n1\n1 2 3 4 3000000000\n", "line 11: `3000000000` stands where the reference of an element"),
        ("Tetrahedra\n2\n1 2 3 4 0\nEnd\n", "line 12: `End` stands where the number of a vertex is expected"),
        ("12\n", "line 9: `12` stands where a keyword, e.g. Tetrahedra is expected"),
        ("Vertices\n0\n", "line 9: `Vertices` stands where no second list of vertices is expected"),
        ("Tetrahedra\n1\n1 2 3 3 0\n", "cell 0 names node 2 twice"),
        ("Tetrahedra\n1\n1 2 3 1\n", "line 12: the file ends where the reference of an element"),
    ];
    for (rest, sentence) in wanted {
        let file = read_medit(format!("{HEAD}{rest}").as_bytes());
        let error = file.and_then(MeshFile::into_mesh).unwrap_err().to_string();
        assert!(error.contains(sentence), "{rest}: {error}");
    }
    let no_dimension = read_medit(HEAD.replace("Dimension 3\n", "").as_bytes()).unwrap_err();
    assert!(matches!(no_dimension, MeshReadError::Missing { .. }), "{no_dimension}");
    let four = read_medit(HEAD.replace("Dimension 3", "Dimension 4").as_bytes()).unwrap_err().to_string();
    assert!(four.starts_with("line 2: `4` stands where a dimension, 2 or 3 is expected"), "{four}");
}

#[test]
fn damage_in_tetgen_files_is_told_with_file_and_line() {
    const NODES: &[u8] = b"4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n";
    let wanted: [(&[u8], &str); 5] = [
        (b"1 4 0\n0 0 1 2 4\n", "line 2: an element names node 4"),
        (b"1 4 1\n0 0 1 2 3 1.5\n", "line 2: `1.5` stands where a whole number of 32 bits"),
        (b"1 4 1\n0 0 1 2 3\n", "line 2: `(end of line)` stands where a whole number of 32 bits"),
        (b"1 10 0\n0 0 1 2 3 0 0 0 0 0 0\n", "elements of 10 nodes in 3 dimensions cannot be read; mesh without"),
        (b"", "line 1: the file ends where the first line of an .ele file"),
    ];
    for (elements, sentence) in wanted {
        let error = read_tetgen(NODES, elements).unwrap_err().to_string();
        assert!(error.starts_with(sentence), "{error}");
    }
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("a.node"), NODES).unwrap();
    let missing = read_mesh(place.path().join("a.node")).unwrap_err().to_string();
    assert!(missing.contains("a.ele: cannot be read"), "{missing}");
    std::fs::write(place.path().join("a.ele"), "1 4 0\n0 0 1 2 7\n").unwrap();
    let error = read_mesh(place.path().join("a.node")).unwrap_err().to_string();
    assert!(error.contains("a.ele: line 2: an element names node 7"), "{error}");
}

#[test]
fn what_is_no_mesh_is_told_so() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("a.stl");
    std::fs::write(&path, "solid a\n").unwrap();
    for path in [path.as_path(), place.path()] {
        let error = read_mesh(path).unwrap_err().to_string();
        assert!(error.contains("is in no mesh format that is read; known are Gmsh (.msh)"), "{error}");
    }
    let absent = read_mesh(place.path().join("absent.msh")).unwrap_err().to_string();
    assert!(absent.contains("absent.msh: cannot be read"), "{absent}");
}

/// All fixtures and all inputs that fuzzing found.
fn seeds() -> Vec<(String, Vec<u8>)> {
    let mut seeds = Vec::new();
    for name in ["meshes", "meshes/refused", "fuzz/gmsh", "fuzz/medit", "fuzz/tetgen"] {
        for entry in std::fs::read_dir(folder(name)).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_file() {
                seeds.push((path.display().to_string(), std::fs::read(path).unwrap()));
            }
        }
    }
    seeds.sort();
    seeds
}

/// Whatever is read names only nodes that are there; whatever is not is refused in a printable sentence.
fn check(result: Result<MeshFile, MeshReadError>) {
    match result {
        Ok(file) => {
            assert_eq!(file.tags.len(), file.cells.len());
            let corners = file.dimension.corners();
            let nodes = file.nodes.len();
            assert!(file.cells.iter().flat_map(|cell| &cell[..corners]).all(|node| (*node as usize) < nodes));
            let _ = file.into_mesh();
        }
        Err(error) => {
            let sentence = error.to_string();
            assert!(!sentence.is_empty() && !sentence.contains(char::is_control), "{sentence:?}");
        }
    }
}

fn check_all(bytes: &[u8]) {
    check(read_gmsh(bytes));
    check(read_medit(bytes));
    let half = bytes.split(|b| *b == 0).next().map_or(0, <[u8]>::len);
    check(read_tetgen(&bytes[..half], bytes.get(half + 1..).unwrap_or_default()));
}

#[test]
fn inputs_that_fuzzing_found_are_read_or_refused() {
    let seeds = seeds();
    assert!(seeds.len() > 30);
    seeds.iter().for_each(|(_, bytes)| check_all(bytes));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn damaged_files_are_read_or_refused(
        seed in any::<prop::sample::Index>(),
        keep in any::<prop::sample::Index>(),
        cut in any::<bool>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 1u8..), 0..6),
    ) {
        let seeds = seeds();
        let bytes = &seeds[seed.index(seeds.len())].1;
        let length = if cut { keep.index(bytes.len() + 1) } else { bytes.len() };
        let mut bytes = bytes[..length].to_vec();
        for (at, mask) in flips.iter().filter(|_| length > 0) {
            bytes[at.index(length)] ^= mask;
        }
        check_all(&bytes);
    }
}
