//! What a model file (`.npz`) holds.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Serialize;
use zip::ZipArchive;

use super::row;
use crate::failure::Failure;
use crate::quantities::{count, counted};

/// Longest header of an array that is read \[B\]; NumPy writes some hundred.
const LONGEST_HEADER: usize = 65_536;

/// What a model file holds.
#[derive(Debug, Serialize)]
pub struct ModelSummary {
    degree: Option<i64>,
    cells: Option<usize>,
    nodes: Option<usize>,
    arrays: Vec<ArraySummary>,
}

/// An array of the archive.
#[derive(Debug, PartialEq, Serialize)]
struct ArraySummary {
    name: String,
    #[serde(rename = "type")]
    descr: String,
    shape: Vec<usize>,
    #[serde(skip)]
    scalar: Option<i64>,
}

/// Reads the headers of all arrays in `file`.
pub fn summarise(file: &Path) -> Result<ModelSummary, Failure> {
    let failed = |what: String| Failure::Failed(format!("{}: {what}", file.display()));
    let opened = File::open(file).map_err(|error| failed(error.to_string()))?;
    let mut archive = ZipArchive::new(opened).map_err(|error| failed(format!("this is no NPZ archive: {error}")))?;
    let mut arrays = Vec::new();
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(|error| failed(error.to_string()))?;
        let name = entry.name().to_string();
        let read = read_array(name.trim_end_matches(".npy"), &mut entry);
        arrays.push(read.ok_or_else(|| failed(format!("{name} is no NumPy array")))?);
    }
    let rows = |name: &str| arrays.iter().find(|a| a.name == name).and_then(|a| a.shape.first().copied());
    let degree = arrays.iter().find(|a| a.name == "degree").and_then(|a| a.scalar);
    Ok(ModelSummary { degree, cells: rows("cells").or_else(|| rows("tets")), nodes: rows("nodes"), arrays })
}

/// The header of an NPY stream, and the value of an integer without axes; `None` if it is no such stream.
fn read_array(name: &str, stream: &mut impl Read) -> Option<ArraySummary> {
    let mut start = [0; 8];
    stream.read_exact(&mut start).ok()?;
    if &start[..6] != b"\x93NUMPY" {
        return None;
    }
    let mut length = [0; 4];
    let width = if start[6] == 1 { 2 } else { 4 };
    stream.read_exact(&mut length[..width]).ok()?;
    let length = u32::from_le_bytes(length) as usize;
    let mut header = vec![0; length.min(LONGEST_HEADER)];
    stream.read_exact(&mut header).ok()?;
    let header = String::from_utf8(header).ok()?;
    let descr = after(&header, "'descr':")?.trim_start().strip_prefix('\'')?.split('\'').next()?.to_string();
    let inside = after(&header, "'shape':")?.trim_start().strip_prefix('(')?.split(')').next()?;
    let axes = inside.split(',').map(str::trim).filter(|axis| !axis.is_empty());
    let shape: Vec<usize> = axes.map(|axis| axis.parse().ok()).collect::<Option<_>>()?;
    let scalar = if shape.is_empty() { read_integer(&descr, stream) } else { None };
    Some(ArraySummary { name: name.into(), descr, shape, scalar })
}

fn after<'t>(text: &'t str, mark: &str) -> Option<&'t str> {
    text.split_once(mark).map(|(_, rest)| rest)
}

fn read_integer(descr: &str, stream: &mut impl Read) -> Option<i64> {
    let size = match descr {
        "<i8" | "<u8" => 8,
        "<i4" | "<u4" => 4,
        _ => return None,
    };
    let mut bytes = [0; 8];
    stream.read_exact(&mut bytes[..size]).ok()?;
    match descr {
        "<i4" => Some(i64::from(i32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))),
        _ => Some(i64::from_le_bytes(bytes)),
    }
}

impl ModelSummary {
    /// The summary for people.
    pub fn rows(&self) -> Vec<(String, String)> {
        let mut rows = Vec::new();
        if let (Some(cells), Some(nodes)) = (self.cells, self.nodes) {
            let degree = self.degree.map_or_else(String::new, |degree| format!(" of degree {degree}"));
            let size = format!("{}{degree}, {}", counted(cells, "coarse cell"), counted(nodes, "node"));
            rows.push(row("model", size));
        }
        rows.extend(self.arrays.iter().map(|array| {
            let shape: Vec<String> = array.shape.iter().map(|n| count(*n)).collect();
            let shape = if shape.is_empty() { "one value".into() } else { shape.join(" × ") };
            let value = array.scalar.map_or_else(String::new, |value| format!(" = {value}"));
            row(&array.name, format!("{}, {shape}{value}", array.descr))
        }));
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stream that `numpy.save` writes for `value` of `descr`.
    fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
        while (header.len() + 11) % 64 != 0 {
            header.push(' ');
        }
        header.push('\n');
        let mut stream = b"\x93NUMPY\x01\x00".to_vec();
        stream.extend((header.len() as u16).to_le_bytes());
        stream.extend(header.as_bytes());
        stream.extend(data);
        stream
    }

    #[test]
    fn headers_give_type_shape_and_the_value_of_a_lone_integer() {
        let array = read_array("cells", &mut npy("<i8", "(512, 3)", &[]).as_slice()).unwrap();
        assert_eq!((array.descr.as_str(), array.shape, array.scalar), ("<i8", vec![512, 3], None));
        let array = read_array("mass", &mut npy("<f8", "(5,)", &[]).as_slice()).unwrap();
        assert_eq!(array.shape, [5]);
        let array = read_array("degree", &mut npy("<i4", "()", &(-3i32).to_le_bytes()).as_slice()).unwrap();
        assert_eq!((array.shape, array.scalar), (vec![], Some(-3)));
    }

    #[test]
    fn streams_that_are_no_arrays_are_refused() {
        let whole = npy("<f8", "(5,)", &[]);
        for stream in [b"PK\x03\x04 no array".to_vec(), whole[..40].to_vec(), npy("<f8", "(5,x)", &[])] {
            assert_eq!(read_array("mass", &mut stream.as_slice()), None);
        }
    }
}
