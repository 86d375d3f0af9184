//! NRRD as written: attached, gzip, little-endian, right-anterior-superior millimetres.

use super::super::geometry::{METRES_PER_MM, affine_to_write};
use super::super::samples::ScalarType;
use super::super::write::WriteError;
use crate::mesh::Volume;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

/// Writes a volume as NRRD with attached data.
pub(in super::super) fn write(mut out: impl Write, volume: &Volume) -> Result<(), WriteError> {
    let scalar = ScalarType::smallest_for(&volume.values);
    let [nx, ny, nz] = volume.cells;
    writeln!(out, "NRRD0005\ntype: {}\ndimension: 3\nsizes: {nx} {ny} {nz}", type_name(scalar))?;
    writeln!(out, "endian: little\nencoding: gzip")?;
    write_axes(&mut out, volume)?;
    writeln!(out)?;
    let mut gzip = GzEncoder::new(out, Compression::default());
    gzip.write_all(&scalar.encode(&volume.values))?;
    gzip.finish()?.flush()?;
    Ok(())
}

fn write_axes(out: &mut impl Write, volume: &Volume) -> Result<(), WriteError> {
    let Some(spacing) = volume.spacing else { return Ok(()) };
    if volume.voxel_to_world.is_none() {
        let [x, y, z] = spacing.map(|h| h / METRES_PER_MM);
        writeln!(out, "spacings: {x} {y} {z}\nunits: \"mm\" \"mm\" \"mm\"")?;
        return Ok(());
    }
    let world = affine_to_write(volume, spacing);
    let column = |c: usize| format!("({},{},{})", world[0][c], world[1][c], world[2][c]);
    writeln!(out, "space: right-anterior-superior")?;
    writeln!(out, "space directions: {} {} {}", column(0), column(1), column(2))?;
    writeln!(out, "space origin: {}\nspace units: \"mm\" \"mm\" \"mm\"", column(3))?;
    Ok(())
}

const fn type_name(scalar: ScalarType) -> &'static str {
    match scalar {
        ScalarType::U8 => "uint8",
        ScalarType::I16 => "int16",
        ScalarType::I32 => "int32",
        _ => "double",
    }
}
