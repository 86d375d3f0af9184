//! What VTK files promise: an independent reader finds the numbers that were written.
//!
//! The parser below follows VTK's description of the XML format and shares no code with the writer. The same files
//! (left in cargo's temporary folder) were read with meshio 5.3.5 and pyvista 0.49.1 on VTK 9.7.2: points, cells,
//! arrays, component names and time agreed, and all cell volumes were positive.

use base64::{Engine, engine::general_purpose::STANDARD};
use grosgrain::io::vtk::{DataArray, Frame, UnstructuredGrid, Values, VtkError, write_pvd, write_vtu};
use grosgrain::mesh::Lattice;
use std::io::Read;

type Failure = Box<dyn std::error::Error>;

struct Grid {
    points: Vec<[f64; 3]>,
    hexahedra: Vec<[usize; 8]>,
}

fn grid(cells: [usize; 3]) -> Grid {
    let lattice = Lattice::new(cells);
    let at = |n| lattice.node_position(grosgrain::mesh::Node(n)).map(|i| i as f64);
    let points = (0..lattice.node_count()).map(at).map(|[x, y, z]| [0.1 * x, 0.2 * y, 0.3 * z + 0.01 * x * y]);
    let corners = |c| lattice.corners(grosgrain::mesh::Cell(c)).map(|n| n.0);
    Grid { points: points.collect(), hexahedra: (0..lattice.cell_count()).map(corners).collect() }
}

/// The element that a marker lies in, as (attributes, inner text).
fn element<'a>(xml: &'a str, marker: &str) -> Option<(&'a str, &'a str)> {
    let at = xml.find(marker)?;
    let start = xml[..at].rfind('<')?;
    let open = start + xml[start..].find('>')?;
    let close = open + xml[open..].find('<')?;
    Some((&xml[start..open], &xml[open + 1..close]))
}

/// Bytes of an inline array: base64 header of UInt64, then base64 of zlib blocks.
fn decode(text: &str) -> Result<Vec<u8>, Failure> {
    let number = |bytes: &[u8], at: usize| -> Result<usize, Failure> {
        Ok(u64::from_le_bytes(bytes[8 * at..8 * at + 8].try_into()?) as usize)
    };
    // The count of blocks is the first number: 8 bytes, within the first 12 letters.
    let blocks = number(&STANDARD.decode(&text[..12])?, 0)?;
    let header_text = (8 * (3 + blocks)).div_ceil(3) * 4;
    let header = STANDARD.decode(&text[..header_text])?;
    let data = STANDARD.decode(&text[header_text..])?;
    let (full, last) = (number(&header, 1)?, number(&header, 2)?);
    let (mut from, mut out) = (0, Vec::new());
    for block in 0..blocks {
        let to = from + number(&header, 3 + block)?;
        let before = out.len();
        flate2::read::ZlibDecoder::new(&data[from..to]).read_to_end(&mut out)?;
        let expected = if block + 1 == blocks && last > 0 { last } else { full };
        assert_eq!(out.len() - before, expected, "block {block} of {blocks}");
        from = to;
    }
    assert_eq!(from, data.len(), "bytes after the last block");
    Ok(out)
}

fn numbers<T, const N: usize>(xml: &str, name: &str, kind: &str, from: fn([u8; N]) -> T) -> Result<Vec<T>, Failure> {
    let (attributes, text) = element(xml, &format!("Name=\"{name}\"")).ok_or(name)?;
    let expected = format!("type=\"{kind}\"");
    assert!(attributes.contains(&expected) && attributes.contains("format=\"binary\""), "{attributes}");
    let bytes = decode(text)?;
    bytes.chunks(N).map(|b| Ok(from(b.try_into()?))).collect()
}

fn floats(xml: &str, name: &str) -> Result<Vec<f64>, Failure> {
    numbers(xml, name, "Float64", f64::from_le_bytes)
}

fn longs(xml: &str, name: &str) -> Result<Vec<i64>, Failure> {
    numbers(xml, name, "Int64", i64::from_le_bytes)
}

fn written(grid: &UnstructuredGrid, name: &str) -> Result<String, Failure> {
    let mut bytes = Vec::new();
    write_vtu(&mut bytes, grid)?;
    std::fs::write(format!("{}/{name}", env!("CARGO_TARGET_TMPDIR")), &bytes)?;
    Ok(String::from_utf8(bytes)?)
}

#[test]
fn what_is_written_is_read_back() -> Result<(), Failure> {
    let Grid { points, hexahedra } = grid([3, 2, 2]);
    let displacement: Vec<[f64; 3]> = points.iter().map(|p| [p[0] * p[1], -p[2], 1.0 / 3.0]).collect();
    let young: Vec<f64> = (0..12).map(|c| 1e5 * 10f64.powi(c)).collect();
    let stress: Vec<[f64; 6]> =
        (0..12).map(|c| [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|s| s + f64::from(10 * c))).collect();
    let label: Vec<i32> = (0..12).map(|c| c - 3).collect();
    let vtu = UnstructuredGrid {
        points: &points,
        hexahedra: &hexahedra,
        point_data: vec![DataArray { name: "displacement", values: Values::Vector(&displacement) }],
        cell_data: vec![
            DataArray { name: "label", values: Values::Integer(&label) },
            DataArray { name: "young", values: Values::Scalar(&young) },
            DataArray { name: "stress", values: Values::Tensor(&stress) },
        ],
        time: Some(0.25),
    };
    let xml = written(&vtu, "small.vtu")?;
    assert!(xml.contains("header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\""));
    assert!(xml.contains("<Piece NumberOfPoints=\"36\" NumberOfCells=\"12\">"));
    assert_eq!(floats(&xml, "TimeValue")?, [0.25]);
    assert_eq!(floats(&xml, "Points")?, points.as_flattened());
    assert_eq!(floats(&xml, "displacement")?, displacement.as_flattened());
    assert_eq!(floats(&xml, "young")?, young);
    assert_eq!(numbers(&xml, "label", "Int32", i32::from_le_bytes)?, label);
    // Ours is xx yy zz yz xz xy, VTK's XX YY ZZ XY YZ XZ.
    assert_eq!(floats(&xml, "stress")?[6..12], [11.0, 12.0, 13.0, 16.0, 14.0, 15.0]);
    let (attributes, _) = element(&xml, "Name=\"stress\"").ok_or("stress")?;
    assert!(attributes.contains("ComponentName3=\"XY\" ComponentName4=\"YZ\" ComponentName5=\"XZ\""), "{attributes}");
    Ok(())
}

#[test]
fn hexahedra_have_vtk_order_and_positive_volume() -> Result<(), Failure> {
    let Grid { points, hexahedra } = grid([2, 2, 1]);
    let vtu = UnstructuredGrid { points: &points, hexahedra: &hexahedra, ..UnstructuredGrid::default() };
    let xml = written(&vtu, "order.vtu")?;
    assert_eq!(longs(&xml, "offsets")?, [8, 16, 24, 32]);
    assert_eq!(numbers(&xml, "types", "UInt8", u8::from_le_bytes)?, [12; 4]);
    for cell in longs(&xml, "connectivity")?.chunks_exact(8) {
        let p: Vec<[f64; 3]> = cell.iter().map(|i| points[*i as usize]).collect();
        let edge = |a: usize, b: usize| -> [f64; 3] { std::array::from_fn(|k| p[b][k] - p[a][k]) };
        // VTK: 0 1 2 3 run around the bottom, 4 to 7 lie above them.
        for corner in 0..4 {
            let (u, v, w) = (edge(corner, (corner + 1) % 4), edge(corner, (corner + 3) % 4), edge(corner, corner + 4));
            let across = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let volume: f64 = (0..3).map(|k| across[k] * w[k]).sum();
            // The shear in z leaves every corner's box at 0.1 · 0.2 · 0.3, up to the rounding of some ten operations
            // on numbers below one.
            assert!((volume - 0.006).abs() < 20.0 * f64::EPSILON, "corner {corner}: {volume}");
        }
    }
    Ok(())
}

#[test]
fn arrays_of_several_whole_blocks_are_read_back() -> Result<(), Failure> {
    // 131072 cells: one Float64 each fills exactly one block of 1 MiB, connectivity eight.
    let Grid { points, hexahedra } = grid([64, 64, 32]);
    let values: Vec<f64> = (0..hexahedra.len()).map(|c| (c as f64).sqrt()).collect();
    let cell_data = vec![DataArray { name: "young", values: Values::Scalar(&values) }];
    let vtu = UnstructuredGrid { points: &points, hexahedra: &hexahedra, cell_data, ..UnstructuredGrid::default() };
    let xml = written(&vtu, "large.vtu")?;
    assert_eq!(floats(&xml, "young")?, values);
    assert_eq!(floats(&xml, "Points")?, points.as_flattened());
    let connectivity = longs(&xml, "connectivity")?;
    assert_eq!(connectivity.len(), 8 * hexahedra.len());
    assert!(connectivity.chunks_exact(8).zip(&hexahedra).all(|(v, h)| v[2] == h[3] as i64 && v[7] == h[6] as i64));
    Ok(())
}

#[test]
fn names_are_escaped() -> Result<(), Failure> {
    let Grid { points, hexahedra } = grid([1, 1, 1]);
    let cell_data = vec![DataArray { name: "|u| < \"5\" & µ", values: Values::Integer(&[1]) }];
    let vtu = UnstructuredGrid { points: &points, hexahedra: &hexahedra, cell_data, ..UnstructuredGrid::default() };
    assert!(written(&vtu, "names.vtu")?.contains("Name=\"|u| &lt; &quot;5&quot; &amp; µ\""));
    Ok(())
}

/// The sentence with which a grid is refused.
fn refusal(grid: UnstructuredGrid) -> String {
    let mut bytes = Vec::new();
    let outcome = write_vtu(&mut bytes, &grid);
    assert!(bytes.is_empty(), "{} bytes written", bytes.len());
    outcome.map_or_else(|e| e.to_string(), |()| "written".into())
}

#[test]
fn grids_that_no_viewer_shows_are_refused_before_anything_is_written() {
    let Grid { points, hexahedra } = grid([1, 1, 2]);
    let whole = || UnstructuredGrid { points: &points, hexahedra: &hexahedra, ..UnstructuredGrid::default() };
    let with = |name, values| UnstructuredGrid { cell_data: vec![DataArray { name, values }], ..whole() };
    assert!(refusal(UnstructuredGrid { hexahedra: &[], ..whole() }).contains("no cells"));
    let short = UnstructuredGrid { points: &points[..11], ..whole() };
    assert_eq!(refusal(short), "cell 1 names point 11, but there are only 11");
    let short = with("young", Values::Scalar(&[1.0]));
    assert_eq!(refusal(short), "array \"young\" holds 1 entries for 2 cells; one each is needed");
    let nan = with("young", Values::Scalar(&[1.0, f64::NAN]));
    assert!(refusal(nan).starts_with("entry 1 of \"young\" is NaN"));
    let mut twice = with("label", Values::Integer(&[1, 2]));
    twice.cell_data.push(twice.cell_data[0]);
    assert!(refusal(twice).starts_with("two arrays of cells are named \"label\""));
    let late = UnstructuredGrid { time: Some(f64::INFINITY), ..whole() };
    assert!(refusal(late).starts_with("entry 0 of \"TimeValue\" is inf"));
}

#[test]
fn a_series_lists_its_frames_with_relative_paths() -> Result<(), Failure> {
    let mut bytes = Vec::new();
    let frames = [Frame { time: 0.0, file: "frames/a&b_0000.vtu" }, Frame { time: 0.1, file: "frames/a&b_0001.vtu" }];
    write_pvd(&mut bytes, &frames)?;
    let xml = String::from_utf8(bytes)?;
    assert!(xml.contains("<VTKFile type=\"Collection\""));
    assert!(xml.contains("timestep=\"0.1\" group=\"\" part=\"0\" file=\"frames/a&amp;b_0001.vtu\""));
    let mut series = Vec::new();
    write_pvd(&mut series, &[Frame { time: 0.25, file: "small.vtu" }, Frame { time: 0.5, file: "order.vtu" }])?;
    Ok(std::fs::write(format!("{}/series.pvd", env!("CARGO_TARGET_TMPDIR")), series)?)
}

#[test]
fn series_that_break_when_moved_or_run_backwards_are_refused() {
    for file in ["/home/a.vtu", "C:/a.vtu", "frames\\a.vtu", ""] {
        let outcome = write_pvd(std::io::sink(), &[Frame { time: 0.0, file }]);
        assert!(matches!(outcome, Err(VtkError::Path(_))), "{file}");
    }
    let backwards = [Frame { time: 1.0, file: "a.vtu" }, Frame { time: 0.5, file: "b.vtu" }];
    assert!(matches!(write_pvd(std::io::sink(), &backwards), Err(VtkError::Time { frame: 1, .. })));
}
