//! MetaImage, in one file (`.mha`) or with its data in another (`.mhd` with `.raw`); plain, text and zlib.

mod header;
mod write;

use super::ReadError;
use super::inflate::inflate;
use super::read_error::excerpt;
use super::samples::SampleLayout;
use crate::mesh::Volume;
use header::{DataFile, Header};

pub(super) use write::{write_header, write_local, write_voxels};

/// Reads a MetaImage file with its own data (`ElementDataFile = LOCAL`) from its bytes.
///
/// Spacing comes from `ElementSpacing`, else `ElementSize`, in millimetres; the world is LPS as ITK has it
/// and `voxel_to_world` is turned to RAS.
///
/// # Errors
/// Not MetaImage, detached data, truncated, an unsupported type, a time or vector axis longer than 1,
/// bad spacing, NaN.
pub fn read_metaimage(bytes: &[u8]) -> Result<Volume, ReadError> {
    read(bytes, |name| {
        let what = format!("a MetaImage header whose voxels stand in `{}`", excerpt(name));
        Err(ReadError::Unsupported { what, remedy: "read it by its path, with that file in place" })
    })
}

/// Reads MetaImage; `detached` gives the content of the data file that the header names.
pub(super) fn read(
    bytes: &[u8],
    detached: impl FnOnce(&str) -> Result<Vec<u8>, ReadError>,
) -> Result<Volume, ReadError> {
    let (header, attached) = Header::parse(bytes)?;
    let layout = header.layout()?;
    let geometry = header.geometry(layout.cells)?;
    let values = match &header.data_file {
        DataFile::Local => voxels(&header, &layout, attached)?,
        DataFile::Beside(name) => voxels(&header, &layout, &detached(name)?)?,
    };
    geometry.with_values(values)
}

fn voxels(header: &Header, layout: &SampleLayout, data: &[u8]) -> Result<Vec<f64>, ReadError> {
    if header.compressed {
        let skip = header.data_skip.unwrap_or(0);
        let stream = data.get(skip..).unwrap_or_default();
        return layout.decode(&inflate(stream, layout.byte_count(), "voxel data")?);
    }
    let skip = header.data_skip.unwrap_or(data.len().saturating_sub(layout.byte_count()));
    let data = data.get(skip..).unwrap_or_default();
    match header.binary {
        true => layout.decode(data),
        false => layout.decode_text(data),
    }
}
