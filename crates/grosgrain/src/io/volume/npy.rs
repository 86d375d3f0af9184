//! NumPy arrays: axes [k][j][i], that is z, y, x, in C or Fortran order.
//!
//! Own code because `ndarray-npy` must be told the number type beforehand.

use super::geometry::Geometry;
use super::read_error::excerpt;
use super::samples::{ByteOrder, SampleLayout, ScalarType};
use super::write::WriteError;
use super::{ReadError, VolumeFormat};
use crate::mesh::Volume;
use std::io::Write;

const MAGIC: &[u8] = b"\x93NUMPY";

/// Reads a `.npy` file from its bytes; NPY carries no spacing.
///
/// # Errors
/// Not NPY, truncated, not three axes, a type that is not a real number or bool, NaN.
pub fn read_npy(bytes: &[u8]) -> Result<Volume, ReadError> {
    let (dictionary, data) = split(bytes)?;
    let (scalar, order) = scalar(value_of(dictionary, "descr")?)?;
    let (z, y, x) = extents(value_of(dictionary, "shape")?)?;
    let layout = SampleLayout::new([x, y, z], scalar, order)?;
    let stored = layout.decode(data)?;
    let values = match value_of(dictionary, "fortran_order")? {
        text if text.starts_with("False") => stored,
        text if text.starts_with("True") => c_order(&stored, layout.cells),
        text => return Err(field_error("fortran_order", text, "True or False")),
    };
    Geometry { cells: layout.cells, spacing: None, voxel_to_world: None }.with_values(values)
}

/// Writes the values as a C-ordered array of shape (nz, ny, nx).
pub(super) fn write(mut out: impl Write, volume: &Volume) -> Result<(), WriteError> {
    let scalar = ScalarType::smallest_for(&volume.values);
    let descr = match scalar {
        ScalarType::U8 => "|u1",
        ScalarType::I16 => "<i2",
        ScalarType::I32 => "<i4",
        _ => "<f8",
    };
    let [nx, ny, nz] = volume.cells;
    let dictionary = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({nz}, {ny}, {nx}), }}");
    // Magic, version and length take ten bytes; the whole is padded to a multiple of 64 and ends with a newline.
    let padded = (10 + dictionary.len() + 1).next_multiple_of(64) - 10;
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&(padded as u16).to_le_bytes())?;
    writeln!(out, "{dictionary:<width$}", width = padded - 1)?;
    out.write_all(&scalar.encode(&volume.values))?;
    Ok(())
}

/// The header's dictionary as text, and the data.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), ReadError> {
    let truncated =
        |needed: usize| ReadError::Truncated { part: "header bytes", needed: needed as u64, found: bytes.len() as u64 };
    if !bytes.starts_with(MAGIC) {
        let found = bytes[..bytes.len().min(MAGIC.len())].escape_ascii().to_string();
        return Err(field_error("magic", &found, "\\x93NUMPY"));
    }
    let (start, length) = match bytes.get(6..12) {
        Some([1, _, a, b, ..]) => (10, usize::from(u16::from_le_bytes([*a, *b]))),
        Some([2 | 3, _, a, b, c, d]) => (12, u32::from_le_bytes([*a, *b, *c, *d]) as usize),
        Some([version, ..]) => return Err(field_error("version", &version.to_string(), "1, 2 or 3")),
        _ => return Err(truncated(12)),
    };
    let end = start + length;
    let dictionary = bytes.get(start..end).ok_or_else(|| truncated(end))?;
    match std::str::from_utf8(dictionary) {
        Ok(text) => Ok((text, &bytes[end..])),
        Err(_) => Err(field_error("dictionary", "not text", "a Python dictionary")),
    }
}

/// What follows `'key':` in the dictionary.
fn value_of<'a>(dictionary: &'a str, key: &'static str) -> Result<&'a str, ReadError> {
    let quoted = [format!("'{key}'"), format!("\"{key}\"")];
    let after = quoted.iter().find_map(|q| dictionary.split_once(q.as_str())).map(|(_, after)| after.trim_start());
    match after.and_then(|after| after.strip_prefix(':')) {
        Some(value) => Ok(value.trim_start()),
        None => Err(ReadError::MissingField { format: VolumeFormat::Npy, field: key }),
    }
}

fn scalar(text: &str) -> Result<(ScalarType, ByteOrder), ReadError> {
    let unsupported = |name: &str| ReadError::Unsupported {
        what: format!("the NumPy type `{}`", excerpt(name)),
        remedy: "convert it to one real number per voxel, e.g. `array.astype('float32')`",
    };
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"')).ok_or_else(|| unsupported(text))?;
    let name = text[1..].split(quote).next().unwrap_or_default();
    let (order, code) = match name.split_at_checked(1) {
        Some(("<" | "|" | "=", code)) => (ByteOrder::Little, code),
        Some((">", code)) => (ByteOrder::Big, code),
        _ => return Err(unsupported(name)),
    };
    let scalar = match code {
        "b1" | "u1" => ScalarType::U8,
        "i1" => ScalarType::I8,
        "u2" => ScalarType::U16,
        "i2" => ScalarType::I16,
        "u4" => ScalarType::U32,
        "i4" => ScalarType::I32,
        "u8" => ScalarType::U64,
        "i8" => ScalarType::I64,
        "f2" => ScalarType::F16,
        "f4" => ScalarType::F32,
        "f8" => ScalarType::F64,
        _ => return Err(unsupported(name)),
    };
    Ok((scalar, order))
}

/// The shape (nz, ny, nx); leading or trailing axes of length 1 are dropped where there are more than three.
fn extents(text: &str) -> Result<(u64, u64, u64), ReadError> {
    let refuse = || field_error("shape", text, "a tuple of three whole numbers");
    let inner = text.strip_prefix('(').and_then(|t| t.split_once(')')).map(|(inner, _)| inner).ok_or_else(refuse)?;
    let numbers = inner.split(',').map(str::trim).filter(|n| !n.is_empty());
    let shape: Vec<u64> =
        numbers.map(|n| n.trim_end_matches('L').parse()).collect::<Result<_, _>>().map_err(|_| refuse())?;
    let mut shape = shape.as_slice();
    while shape.len() > 3 {
        shape = match shape {
            [1, rest @ ..] | [rest @ .., 1] => rest,
            _ => return Err(several(shape)),
        };
    }
    match shape {
        [z, y, x] => Ok((*z, *y, *x)),
        _ => Err(ReadError::Axes { found: shape.len() as u64 }),
    }
}

/// The shorter end of the shape is taken for the axis that is not space.
fn several(shape: &[u64]) -> ReadError {
    let (first, last) = (shape.first().copied().unwrap_or(0), shape.last().copied().unwrap_or(0));
    let (count, kind, example) = match last < first {
        true => (last, "components per voxel", "`numpy.save(name, array[..., 0])`"),
        false => (first, "time points", "`numpy.save(name, array[0])`"),
    };
    ReadError::SeveralVolumes { count, kind, example }
}

/// From first axis fastest to last axis fastest.
fn c_order(stored: &[f64], [nx, ny, nz]: [usize; 3]) -> Vec<f64> {
    let mut values = Vec::with_capacity(stored.len());
    for k in 0..nz {
        for j in 0..ny {
            values.extend((0..nx).map(|i| stored[k + nz * (j + ny * i)]));
        }
    }
    values
}

fn field_error(field: &str, value: &str, expected: &'static str) -> ReadError {
    let value = excerpt(value);
    ReadError::Field { format: VolumeFormat::Npy, field: field.into(), value, expected }
}
