//! Meshes of simplices and their tensors in VTU and Abaqus files: what is written is there, and is read back.
//!
//! The files are left in the folder that `GROSGRAIN_WRITTEN` names, if it is set; `fixtures/make_simplices.py --check` reads them with meshio, pyvista and gmsh.

use grosgrain::io::mesh::{AbaqusDeck, AbaqusMaterials, AbaqusWriteError, read_abaqus, write_abaqus};
use grosgrain::io::vtk::{DataArray, SimplexGrid, Values, VtkError, read_vtk_legacy, read_vtu, write_simplex_vtu};
use grosgrain::io::{MeshFile, MeshReadError, read_mesh};
use grosgrain::simplex::{Dimension, MandelTensor, SimplexMesh};

type Failure = Box<dyn std::error::Error>;

/// Two cells that share a facet, with tags −3 and 7.
fn pair(dimension: Dimension) -> SimplexMesh {
    let (nodes, cells): (&[[f64; 3]], _) = match dimension {
        Dimension::One => (&[[0.0; 3], [0.5, 0.0, 0.0], [2.0, 0.0, 0.0]], [[0, 1, 0, 0], [1, 2, 0, 0]]),
        Dimension::Two => {
            (&[[0.0; 3], [1.0, 0.1, 0.0], [0.2, 0.7, 0.0], [1.1, 1.3, 0.0]], [[0, 1, 2, 0], [1, 3, 2, 0]])
        }
        Dimension::Three => (
            &[[0.0; 3], [1.0, 0.1, 0.0], [0.2, 0.7, 0.1], [0.3, 0.2, 1.0 / 3.0], [1.0, 1.0, 1.0]],
            [[0, 1, 2, 3], [1, 4, 2, 3]],
        ),
    };
    SimplexMesh::new(dimension, nodes.to_vec(), cells.to_vec(), vec![-3, 7]).unwrap()
}

/// A symmetric matrix with no two independent entries alike, positive definite.
fn tensor(dimension: Dimension, scale: f64) -> MandelTensor {
    let n = dimension.strains();
    let entry = |i: usize, j: usize| match i.max(j) < n {
        true => scale * ((0.05 * (6 * i.min(j) + i.max(j)) as f64).exp() + if i == j { 20.0 } else { 0.0 }),
        false => 0.0,
    };
    MandelTensor { dimension, matrix: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))) }
}

fn tensors(dimension: Dimension) -> [MandelTensor; 2] {
    [tensor(dimension, 1e9), tensor(dimension, 3e5)]
}

fn keep(name: &str, bytes: &[u8]) -> Result<(), Failure> {
    match std::env::var_os("GROSGRAIN_WRITTEN") {
        Some(folder) => {
            std::fs::create_dir_all(&folder)?;
            Ok(std::fs::write(std::path::Path::new(&folder).join(name), bytes)?)
        }
        None => Ok(()),
    }
}

const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];

fn vtu(mesh: &SimplexMesh, name: &str) -> Result<String, Failure> {
    let tensors = tensors(mesh.dimension());
    let (density, condition) = ([1000.0, 1.25], [3.5, 1e7]);
    let mass: Vec<f64> = (0..mesh.nodes().len()).map(|n| 0.1 * n as f64).collect();
    let moved: Vec<[f64; 3]> = mesh.nodes().iter().map(|[x, y, z]| [0.1 * y, x - z, 1.0 / 3.0]).collect();
    let grid = SimplexGrid {
        point_data: vec![
            DataArray { name: "mass", values: Values::Scalar(&mass) },
            DataArray { name: "displacement", values: Values::Vector(&moved) },
        ],
        cell_data: vec![
            DataArray { name: "effective-stiffness", values: Values::Stiffness(&tensors) },
            DataArray { name: "density", values: Values::Scalar(&density) },
            DataArray { name: "condition", values: Values::Scalar(&condition) },
        ],
        time: Some(0.5),
        ..SimplexGrid::new(mesh)
    };
    let mut bytes = Vec::new();
    write_simplex_vtu(&mut bytes, &grid)?;
    keep(name, &bytes)?;
    Ok(String::from_utf8(bytes)?)
}

#[test]
fn tensors_in_vtu_say_the_order_of_their_components() -> Result<(), Failure> {
    for (dimension, order) in DIMENSIONS.into_iter().zip(["xx", "xx yy xy", "xx yy zz yz xz xy"]) {
        let xml = vtu(&pair(dimension), &format!("{dimension}.vtu"))?;
        let n = dimension.strains();
        let note =
            format!("<!-- effective_stiffness: Voigt matrix in Pa, row by row, component_order {order}, engineering");
        assert!(xml.contains(&note), "{dimension}: {xml}");
        assert!(xml.contains(&format!("NumberOfComponents=\"{}\" ComponentName0=\"xx_xx\"", n * n)), "{xml}");
        let names: Vec<&str> = order.split(' ').collect();
        let last = format!("ComponentName{}=\"{}_{}\"", n * n - 1, names[n - 1], names[n - 1]);
        assert!(xml.contains(&last) && xml.contains("Name=\"tag\" type=\"Int32\""), "{xml}");
    }
    Ok(())
}

#[test]
fn tensors_and_arrays_that_do_not_fit_are_refused() {
    let mesh = pair(Dimension::Three);
    let refusal = |name, values| {
        let cell_data = vec![DataArray { name, values }];
        let mut bytes = Vec::new();
        let error = write_simplex_vtu(&mut bytes, &SimplexGrid { cell_data, ..SimplexGrid::new(&mesh) }).unwrap_err();
        assert!(bytes.is_empty());
        error
    };
    let mixed = [tensor(Dimension::Three, 1.0), tensor(Dimension::Two, 1.0)];
    assert!(matches!(refusal("c", Values::Stiffness(&mixed)), VtkError::Dimensions { index: 1, .. }));
    assert!(matches!(refusal("c", Values::Stiffness(&mixed[..1])), VtkError::Length { found: 1, expected: 2, .. }));
    assert!(matches!(refusal("tag", Values::Integer(&[1, 2])), VtkError::Duplicate { .. }));
    let mut odd = tensors(Dimension::Three);
    odd[1].matrix[2][4] = f64::NAN;
    assert!(matches!(refusal("c", Values::Stiffness(&odd)), VtkError::NotFinite { index: 1, .. }));
}

/// Tags −3 and 7, the second with a name.
fn names() -> Vec<(i32, String)> {
    vec![(7, "left lung".into())]
}

fn deck(mesh: &SimplexMesh, name: &str) -> Result<String, Failure> {
    let (stiffness, names) = (tensors(mesh.dimension()), names());
    let materials = Some(AbaqusMaterials { stiffness: &stiffness, density: &[1000.0, 1.25] });
    let mut bytes = Vec::new();
    write_abaqus(&mut bytes, &AbaqusDeck { mesh, names: &names, materials })?;
    keep(name, &bytes)?;
    Ok(String::from_utf8(bytes)?)
}

/// The numbers of the data lines that follow each keyword line that begins so.
fn blocks(deck: &str, keyword: &str) -> Vec<Vec<f64>> {
    let mut blocks = Vec::new();
    let mut inside = false;
    for line in deck.lines() {
        if line.starts_with('*') {
            inside = line.starts_with(keyword);
            blocks.extend(inside.then(Vec::new));
        } else if let (true, Some(block)) = (inside, blocks.last_mut()) {
            block.extend(line.split(',').map(|text| text.trim().parse::<f64>().unwrap()));
        }
    }
    blocks
}

#[test]
fn a_deck_holds_nodes_cells_sets_and_a_material_for_each_different_tensor() -> Result<(), Failure> {
    for (dimension, kind) in DIMENSIONS.into_iter().zip(["T3D2", "CPE3", "C3D4"]) {
        let mesh = pair(dimension);
        let text = deck(&mesh, &format!("{dimension}.inp"))?;
        let nodes = blocks(&text, "*NODE").remove(0);
        let expected = mesh.nodes().iter().zip(1..).flat_map(|([x, y, z], n)| [f64::from(n), *x, *y, *z]);
        assert_eq!(nodes, expected.collect::<Vec<_>>());
        let cells = (0..2).flat_map(|c| std::iter::once(c as u32).chain(mesh.cell(c).iter().copied()));
        let cells: Vec<f64> = cells.map(|n| f64::from(n + 1)).collect();
        assert_eq!(blocks(&text, &format!("*ELEMENT, TYPE={kind}")), [cells]);
        assert_eq!(blocks(&text, "*ELSET, ELSET=TAG_-3"), [[1.0]]);
        assert_eq!(blocks(&text, "*ELSET, ELSET=left_lung"), [[2.0]]);
        assert_eq!(blocks(&text, "*DENSITY"), [[1000.0], [1.25]]);
        let constants = blocks(&text, "*ELASTIC");
        let voigt = tensors(dimension).map(|tensor| tensor.voigt());
        for (found, voigt) in constants.iter().zip(voigt) {
            // D1111, and with more than one axis D1122 and D2222.
            let first = [(0, 0), (0, 1), (1, 1)].map(|(i, j)| voigt[i][j]);
            let count = if dimension == Dimension::One { 1 } else { 3 };
            for (found, expected) in found.iter().zip(&first[..count]) {
                assert!((found / expected - 1.0).abs() < 1e-13, "{found} is not {expected}");
            }
            assert_eq!(found.len(), if dimension == Dimension::One { 2 } else { 21 });
        }
        assert_eq!(constants.len(), 2);
        assert!(text.lines().all(|line| line.len() < 256), "Abaqus reads lines of up to 256 letters");
    }
    Ok(())
}

#[test]
fn cells_with_equal_constants_share_a_material() -> Result<(), Failure> {
    let mesh = pair(Dimension::Three);
    let stiffness = [tensor(Dimension::Three, 2.0); 2];
    let write = |density: &[f64]| -> Result<String, Failure> {
        let mut bytes = Vec::new();
        let materials = Some(AbaqusMaterials { stiffness: &stiffness, density });
        write_abaqus(&mut bytes, &AbaqusDeck { mesh: &mesh, names: &[], materials })?;
        Ok(String::from_utf8(bytes)?)
    };
    let (one, two) = (write(&[5.0, 5.0])?, write(&[5.0, 6.0])?);
    assert_eq!(blocks(&one, "*ELSET, ELSET=MATERIAL_1"), [[1.0, 2.0]]);
    assert_eq!((blocks(&one, "*MATERIAL").len(), blocks(&two, "*MATERIAL").len()), (1, 2));
    Ok(())
}

#[test]
fn materials_that_do_not_fit_the_mesh_are_refused() {
    let mesh = pair(Dimension::Three);
    let good = tensors(Dimension::Three);
    let refusal = |stiffness: &[MandelTensor], density: &[f64]| {
        let mut bytes = Vec::new();
        let materials = Some(AbaqusMaterials { stiffness, density });
        let error = write_abaqus(&mut bytes, &AbaqusDeck { mesh: &mesh, names: &[], materials }).unwrap_err();
        assert!(bytes.is_empty());
        error
    };
    let few = refusal(&good[..1], &[1.0; 2]);
    assert_eq!(few.to_string(), "1 elasticity tensors for 2 cells; one each is needed");
    assert!(matches!(refusal(&good, &[1.0]), AbaqusWriteError::Length { what: "densities", .. }));
    let flat = refusal(&[good[0], tensor(Dimension::Two, 1.0)], &[1.0; 2]);
    assert!(matches!(flat, AbaqusWriteError::Dimension { cell: 1, .. }), "{flat}");
    assert!(matches!(refusal(&good, &[1.0, f64::NAN]), AbaqusWriteError::NotFinite { cell: 1, .. }));
    let odd = [good[0], good[1].scaled(f64::INFINITY)];
    assert!(matches!(refusal(&odd, &[1.0; 2]), AbaqusWriteError::NotFinite { what: "stiffness", cell: 1, .. }));
}

#[test]
fn what_is_written_is_read_back() -> Result<(), Failure> {
    for dimension in DIMENSIONS {
        let mesh = pair(dimension);
        let vtu = read_vtu(vtu(&mesh, &format!("{dimension}.vtu"))?.as_bytes())?;
        assert_eq!(vtu.skipped, ["cell data left out: effective-stiffness, density, condition"], "{dimension}");
        assert_eq!(vtu.into_mesh()?, mesh);
        let mut bytes = Vec::new();
        write_abaqus(&mut bytes, &AbaqusDeck { mesh: &mesh, names: &names(), materials: None })?;
        let deck = read_abaqus(&bytes)?;
        assert_eq!((&deck.names[..], &deck.tags[..]), (&[(1, "left_lung".to_owned())][..], &[-3, 1][..]));
        let back = deck.into_mesh()?;
        assert!(back.nodes() == mesh.nodes() && (0..2).all(|c| back.cell(c) == mesh.cell(c)), "{dimension}");
        // With materials the sections say what a cell consists of.
        let deck = read_abaqus(deck_text(&mesh)?.as_bytes())?;
        assert_eq!(deck.names, [(1, "MATERIAL_1".to_owned()), (2, "MATERIAL_2".to_owned())]);
    }
    Ok(())
}

fn deck_text(mesh: &SimplexMesh) -> Result<String, Failure> {
    deck(mesh, &format!("{}.inp", mesh.dimension()))
}

const FIXTURES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/simplices");

/// Volume, its moments along x, y, z, and the volume of each tag.
fn sums(mesh: &SimplexMesh) -> (f64, [f64; 3], std::collections::BTreeMap<i32, f64>) {
    let (mut volume, mut moment, mut by_tag) = (0.0, [0.0; 3], std::collections::BTreeMap::new());
    for cell in 0..mesh.cell_count() {
        let v = mesh.measure(cell);
        volume += v;
        (0..4).for_each(|c| (0..3).for_each(|r| moment[r] += 0.25 * v * mesh.corner(cell, c)[r]));
        *by_tag.entry(mesh.tags()[cell]).or_default() += v;
    }
    (volume, moment, by_tag)
}

#[test]
fn files_of_other_programs_hold_what_those_read_back() -> Result<(), Failure> {
    let expected = std::fs::read_to_string(format!("{FIXTURES}/expected.txt"))?;
    assert!(expected.lines().count() >= 20);
    for line in expected.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let name = words[0];
        let file = read_mesh(format!("{FIXTURES}/{name}"))?;
        let names: Vec<String> = file.names.iter().map(|(tag, name)| format!("{tag}={name}")).collect();
        let mesh = file.into_mesh().map_err(|e| format!("{name}: {e}"))?;
        assert_eq!([mesh.nodes().len(), mesh.cell_count()].map(|n| n.to_string())[..], words[1..3], "{name}");
        let (volume, moment, by_tag) = sums(&mesh);
        for (found, expected) in [volume].into_iter().chain(moment).zip(&words[3..7]) {
            // Some 200 terms of order one, printed with 15 digits; gmsh prints coordinates of `.inp` with 16.
            assert!((found - expected.parse::<f64>()?).abs() < 1e-12, "{name}: {found} is not {expected}");
        }
        let (volumes, named): (Vec<&str>, Vec<&str>) = words[7..].iter().partition(|word| word.contains(':'));
        assert_eq!(names, named, "{name}");
        assert_eq!(by_tag.len(), volumes.len(), "{name}: {by_tag:?}");
        for ((tag, volume), expected) in by_tag.iter().zip(volumes) {
            let (expected_tag, expected) = expected.split_once(':').ok_or("no colon")?;
            assert_eq!(tag.to_string(), expected_tag, "{name}");
            assert!((volume - expected.parse::<f64>()?).abs() < 1e-12, "{name}: {volume} of tag {tag}");
        }
    }
    Ok(())
}

type Reader = fn(&[u8]) -> Result<MeshFile, MeshReadError>;

/// Every fixture with its reader.
fn fixtures() -> Vec<(String, Reader, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(FIXTURES).unwrap() {
        let path = entry.unwrap().path();
        let reader: Reader = match path.extension().and_then(|e| e.to_str()) {
            Some("vtu") => read_vtu,
            Some("vtk") => read_vtk_legacy,
            Some("inp") => read_abaqus,
            _ => continue,
        };
        found.push((path.display().to_string(), reader, std::fs::read(&path).unwrap()));
    }
    found
}

#[test]
fn files_cut_off_anywhere_and_damaged_bytes_give_an_answer() {
    let mut refused = 0;
    for (name, reader, bytes) in fixtures() {
        let step = bytes.len() / 150 + 1;
        for cut in (0..bytes.len() - step).step_by(step) {
            refused += usize::from(reader(&bytes[..cut]).is_err());
            let mut damaged = bytes.clone();
            for value in [0, b'9', b'-', b'<', 0xff] {
                damaged[cut] = value;
                let _ = reader(&damaged).and_then(MeshFile::into_mesh);
            }
        }
        assert!(reader(&bytes[..bytes.len() / 2]).is_err() || name.ends_with(".inp"), "{name}");
    }
    assert!(refused > 1000, "{refused}");
}

#[test]
fn claims_of_headers_cost_no_memory_and_refusals_say_what_to_do() {
    let refusal = |reader: Reader, text: &str| reader(text.as_bytes()).unwrap_err().to_string();
    let legacy = |rest: &str| refusal(read_vtk_legacy, &format!("# vtk DataFile Version 3.0\ntitle\nASCII\n{rest}"));
    let claim = legacy("DATASET UNSTRUCTURED_GRID\nPOINTS 99999999999999 float\n0 0 0\n");
    assert!(claim.starts_with("line 6: 299999999999997 numbers are announced, but only 6 bytes follow"), "{claim}");
    assert!(legacy("DATASET POLYDATA\n").contains("POLYDATA cannot be read; save the mesh as an unstructured grid"));
    assert!(legacy("DATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n0 zero 0\n").contains("line 6: `zero` stands where"));
    let piece = |attributes: &str, piece: &str| {
        let body = format!("<UnstructuredGrid>{piece}</UnstructuredGrid>");
        refusal(read_vtu, &format!("<VTKFile type=\"UnstructuredGrid\" {attributes}>{body}</VTKFile>"))
    };
    let points = "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"binary\">";
    let huge = format!(
        "<Piece NumberOfPoints=\"700000000000\" NumberOfCells=\"0\">{points}AAAAAA==</DataArray></Points></Piece>"
    );
    assert!(piece("", &huge).contains("an array of 0 bytes where 16800000000000 are needed"), "{}", piece("", &huge));
    let lz4 = piece("compressor=\"vtkLZ4DataCompressor\"", "");
    assert!(lz4.contains("save it with the compressor ZLib"), "{lz4}");
    let image = refusal(read_vtu, "<VTKFile type=\"ImageData\"></VTKFile>");
    assert!(image.contains("type `ImageData` cannot be read; save an unstructured grid"), "{image}");
    let deck = |text: &str| refusal(read_abaqus, text);
    assert!(deck("*PART\n*NODE\n1\n*PART\n").contains("2 parts cannot be read; export a single part"));
    assert!(deck("*Include, input=mesh.inc\n").starts_with("line 1: an input file that refers to another file cannot"));
    assert!(
        deck("*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n").contains("line 4: an element names node 2")
    );
    assert!(deck("*NODE\n1, 0.0.0, 0\n").starts_with("line 2: `0.0.0` stands where a number is expected"));
    assert!(deck("*ELEMENT, TYPE=C3D4\n1, 1, 2,\n*NODE\n").contains("the rest of an element"));
    assert!(deck("*NODE\n1\n*ELEMENT, TYPE=C3D8\n1,1,1,1,1,1,1,1,1\n").contains("1 hexahedra"));
}
