//! NIfTI-1 as written: little-endian, sform in millimetres, one file.

use super::super::geometry::affine_to_write;
use super::super::samples::ScalarType;
use super::super::write::WriteError;
use crate::mesh::Volume;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

/// Header and the four bytes that say that no extension follows.
const DATA_OFFSET: usize = 352;

/// Writes a volume as NIfTI-1, gzip-compressed if asked.
pub(in super::super) fn write(out: impl Write, volume: &Volume, compressed: bool) -> Result<(), WriteError> {
    let scalar = ScalarType::smallest_for(&volume.values);
    let header = header(volume, scalar)?;
    let voxels = scalar.encode(&volume.values);
    match compressed {
        true => {
            let mut gzip = GzEncoder::new(out, Compression::default());
            gzip.write_all(&header)?;
            gzip.write_all(&voxels)?;
            gzip.finish()?.flush()?;
        }
        false => {
            let mut out = out;
            out.write_all(&header)?;
            out.write_all(&voxels)?;
        }
    }
    Ok(())
}

fn header(volume: &Volume, scalar: ScalarType) -> Result<[u8; DATA_OFFSET], WriteError> {
    let spacing = volume.spacing.ok_or(WriteError::NoSpacing)?;
    let affine = affine_to_write(volume, spacing);
    let mut header = [0; DATA_OFFSET];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348i32.to_le_bytes());
    put(40, &3i16.to_le_bytes());
    for (a, cells) in volume.cells.iter().enumerate() {
        let cells = i16::try_from(*cells).map_err(|_| WriteError::NiftiExtent(volume.cells))?;
        put(42 + 2 * a, &cells.to_le_bytes());
        put(80 + 4 * a, &((spacing[a] * 1e3) as f32).to_le_bytes());
    }
    (4..8).for_each(|a| put(40 + 2 * a, &1i16.to_le_bytes()));
    put(70, &data_type(scalar).to_le_bytes());
    put(72, &(8 * scalar.size() as i16).to_le_bytes());
    put(76, &1f32.to_le_bytes());
    put(108, &(DATA_OFFSET as f32).to_le_bytes());
    put(112, &1f32.to_le_bytes());
    // Millimetres.
    put(123, &[2]);
    // sform code 2: aligned coordinates; no qform.
    put(254, &2i16.to_le_bytes());
    for (n, value) in affine[..3].iter().flatten().enumerate() {
        put(280 + 4 * n, &(*value as f32).to_le_bytes());
    }
    put(344, b"n+1\0");
    Ok(header)
}

const fn data_type(scalar: ScalarType) -> i16 {
    match scalar {
        ScalarType::U8 => 2,
        ScalarType::I16 => 4,
        ScalarType::I32 => 8,
        _ => 64,
    }
}
