//! NRRD, attached (`.nrrd`) or with its data in another file (`.nhdr`); raw, text and gzip encodings.

mod header;
mod write;

use super::ReadError;
use super::inflate::inflate;
use super::read_error::excerpt;
use super::samples::SampleLayout;
use crate::mesh::Volume;
use header::{Encoding, Header};

pub(super) use write::write;

/// Reads an NRRD file with attached data from its bytes.
///
/// Spacing comes from `spacings` or the lengths of the `space directions`, in millimetres unless `units` or
/// `space units` say otherwise. Of the world frames the RAS, LAS and LPS ones give `voxel_to_world`.
///
/// # Errors
/// Not NRRD, detached data, truncated, an unsupported type or encoding, a time or vector axis longer than 1,
/// bad spacing, NaN.
pub fn read_nrrd(bytes: &[u8]) -> Result<Volume, ReadError> {
    read(bytes, |name| {
        let what = format!("an NRRD header whose voxels stand in `{}`", excerpt(name));
        Err(ReadError::Unsupported { what, remedy: "read it by its path, with that file in place" })
    })
}

/// Reads NRRD; `detached` gives the content of the data file that the header names.
pub(super) fn read(
    bytes: &[u8],
    detached: impl FnOnce(&str) -> Result<Vec<u8>, ReadError>,
) -> Result<Volume, ReadError> {
    let (header, attached) = Header::parse(bytes)?;
    let layout = header.layout()?;
    let geometry = header.geometry(layout.cells)?;
    let values = match &header.data_file {
        None => voxels(&header, &layout, attached)?,
        Some(name) => voxels(&header, &layout, &detached(name)?)?,
    };
    geometry.with_values(values)
}

fn voxels(header: &Header, layout: &SampleLayout, mut data: &[u8]) -> Result<Vec<f64>, ReadError> {
    for _ in 0..header.line_skip {
        let line = data.iter().position(|b| *b == b'\n').map_or(data.len(), |end| end + 1);
        data = &data[line..];
        if data.is_empty() {
            break;
        }
    }
    match header.encoding {
        Encoding::Gzip => {
            let skip = header.byte_skip.unwrap_or(0);
            let end = skip.saturating_add(layout.byte_count());
            layout.decode(inflate(data, end, "voxel data")?.get(skip..).unwrap_or_default())
        }
        Encoding::Raw => layout.decode(after_skip(header, layout, data)),
        Encoding::Text => layout.decode_text(after_skip(header, layout, data)),
    }
}

/// The data after `byte skip`; −1 means that the voxels are the last bytes of the file.
fn after_skip<'a>(header: &Header, layout: &SampleLayout, data: &'a [u8]) -> &'a [u8] {
    let skip = header.byte_skip.unwrap_or(data.len().saturating_sub(layout.byte_count()));
    data.get(skip..).unwrap_or_default()
}
