//! MetaImage as written: little-endian, LPS millimetres as ITK has it; zlib in one file, plain beside a header.

use super::super::geometry::{LPS_TO_RAS, METRES_PER_MM, affine_to_write, column_norms, mirrored};
use super::super::samples::ScalarType;
use super::super::write::WriteError;
use crate::mesh::Volume;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

/// Writes header and compressed voxels into one file (`.mha`).
pub(in super::super) fn write_local(mut out: impl Write, volume: &Volume) -> Result<(), WriteError> {
    let scalar = ScalarType::smallest_for(&volume.values);
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::default());
    zlib.write_all(&scalar.encode(&volume.values))?;
    let voxels = zlib.finish()?;
    write_fields(&mut out, volume, Some(voxels.len()))?;
    writeln!(out, "ElementDataFile = LOCAL")?;
    out.write_all(&voxels)?;
    Ok(())
}

/// Writes the header (`.mhd`) of voxels that stand uncompressed in the file `data`.
pub(in super::super) fn write_header(mut out: impl Write, volume: &Volume, data: &str) -> Result<(), WriteError> {
    write_fields(&mut out, volume, None)?;
    writeln!(out, "ElementDataFile = {data}")?;
    Ok(())
}

/// Writes the voxels that belong to `write_header`.
pub(in super::super) fn write_voxels(mut out: impl Write, volume: &Volume) -> Result<(), WriteError> {
    Ok(out.write_all(&ScalarType::smallest_for(&volume.values).encode(&volume.values))?)
}

fn write_fields(out: &mut impl Write, volume: &Volume, compressed: Option<usize>) -> Result<(), WriteError> {
    writeln!(out, "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False")?;
    match compressed {
        Some(bytes) => writeln!(out, "CompressedData = True\nCompressedDataSize = {bytes}")?,
        None => writeln!(out, "CompressedData = False")?,
    }
    if let Some(spacing) = volume.spacing {
        write_axes(out, volume, spacing)?;
    }
    let [nx, ny, nz] = volume.cells;
    writeln!(out, "DimSize = {nx} {ny} {nz}")?;
    writeln!(out, "ElementType = {}", type_name(ScalarType::smallest_for(&volume.values)))?;
    Ok(())
}

fn write_axes(out: &mut impl Write, volume: &Volume, spacing: [f64; 3]) -> Result<(), WriteError> {
    if volume.voxel_to_world.is_some() {
        let world = mirrored(affine_to_write(volume, spacing), LPS_TO_RAS);
        let lengths = column_norms(&world);
        let axis = |c: usize| [0, 1, 2].map(|r| format!("{}", world[r][c] / lengths[c])).join(" ");
        writeln!(out, "TransformMatrix = {} {} {}", axis(0), axis(1), axis(2))?;
        writeln!(out, "Offset = {} {} {}", world[0][3], world[1][3], world[2][3])?;
    }
    let [x, y, z] = spacing.map(|h| h / METRES_PER_MM);
    writeln!(out, "ElementSpacing = {x} {y} {z}")?;
    Ok(())
}

const fn type_name(scalar: ScalarType) -> &'static str {
    match scalar {
        ScalarType::U8 => "MET_UCHAR",
        ScalarType::I16 => "MET_SHORT",
        ScalarType::I32 => "MET_INT",
        _ => "MET_DOUBLE",
    }
}
