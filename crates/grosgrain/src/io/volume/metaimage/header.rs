//! The fields of a MetaImage header that matter for a scalar volume.

use super::super::geometry::{self, Geometry, LPS_TO_RAS, spacing_from_mm};
use super::super::read_error::excerpt;
use super::super::samples::{ByteOrder, SampleLayout, ScalarType};
use super::super::text_header::Fields;
use super::super::units::mm_per_unit;
use super::super::{ReadError, VolumeFormat};

/// Longer lines do not occur in headers; without a bound a binary file would be taken for one long line.
const LONGEST_LINE: usize = 4096;

/// Where the voxels stand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum DataFile {
    Local,
    Beside(String),
}

/// What a MetaImage header says about its voxels.
#[derive(Debug)]
pub(super) struct Header {
    extents: [u64; 3],
    axes: usize,
    scalar: ScalarType,
    order: ByteOrder,
    fields: Fields,
    pub data_file: DataFile,
    pub compressed: bool,
    pub binary: bool,
    /// `HeaderSize` of the data file; `None`: the voxels are its last bytes.
    pub data_skip: Option<usize>,
}

impl Header {
    /// The header and the bytes after it.
    pub fn parse(bytes: &[u8]) -> Result<(Self, &[u8]), ReadError> {
        let (fields, rest) = split(bytes)?;
        let (axes, extents) = extents(&fields)?;
        let msb = flag(&fields, &["BinaryDataByteOrderMSB", "ElementByteOrderMSB"], false)?;
        let header = Self {
            extents,
            axes,
            scalar: scalar(&fields)?,
            order: if msb { ByteOrder::Big } else { ByteOrder::Little },
            data_file: data_file(&fields)?,
            compressed: flag(&fields, &["CompressedData"], false)?,
            binary: flag(&fields, &["BinaryData"], true)?,
            data_skip: data_skip(&fields)?,
            fields,
        };
        Ok((header, rest))
    }

    pub fn layout(&self) -> Result<SampleLayout, ReadError> {
        SampleLayout::new(self.extents, self.scalar, self.order)
    }

    pub fn geometry(&self, cells: [usize; 3]) -> Result<Geometry, ReadError> {
        let unit = match self.fields.get(&["DistanceUnits"]) {
            None | Some("" | "?") => 1.0,
            Some(name) => {
                mm_per_unit(name).ok_or_else(|| self.fields.error("DistanceUnits", name, "um, mm, cm or m"))?
            }
        };
        let Some(sizes) = self.numbers(&["ElementSpacing", "ElementSize"], "ElementSpacing", self.axes)? else {
            return Ok(Geometry { cells, spacing: None, voxel_to_world: None });
        };
        let mm = [0, 1, 2].map(|a| sizes[a] * unit);
        let spacing = spacing_from_mm(mm, "ElementSpacing")?;
        let voxel_to_world = self.world(mm, unit)?;
        Ok(Geometry { cells, spacing: Some(spacing), voxel_to_world })
    }

    /// `TransformMatrix` holds the direction of axis a in the a-th run of its numbers.
    fn world(&self, mm: [f64; 3], unit: f64) -> Result<Option<geometry::Affine>, ReadError> {
        let n = self.axes;
        let matrix = self.numbers(&["TransformMatrix", "Rotation", "Orientation"], "TransformMatrix", n * n)?;
        let offset = self.numbers(&["Offset", "Position", "Origin"], "Offset", n)?;
        if matrix.is_none() && offset.is_none() {
            return Ok(None);
        }
        let direction = |axis: usize, row: usize| match &matrix {
            Some(matrix) => matrix[axis * n + row],
            None => f64::from(u8::from(axis == row)),
        };
        let axis = |a: usize| std::array::from_fn(|r| direction(a, r) * mm[a]);
        let origin = offset.map_or([0.0; 3], |o| [0, 1, 2].map(|a| o[a] * unit));
        let world = geometry::affine([axis(0), axis(1), axis(2)], origin);
        match geometry::is_finite(&world) {
            true => Ok(Some(geometry::mirrored(world, LPS_TO_RAS))),
            false => Err(self.fields.error("Offset", &format!("{origin:?}"), "three finite numbers")),
        }
    }

    /// `count` finite or NaN numbers of a field, if it is there.
    fn numbers(&self, names: &[&str], field: &str, count: usize) -> Result<Option<Vec<f64>>, ReadError> {
        let Some(text) = self.fields.get(names) else { return Ok(None) };
        let numbers: Vec<f64> = self.fields.numbers(field, text)?;
        match numbers.len() == count {
            true => Ok(Some(numbers)),
            false => Err(self.fields.error(field, text, "as many numbers as NDims asks for")),
        }
    }
}

/// Fields up to `ElementDataFile`, which is the last one, and the bytes after it.
fn split(bytes: &[u8]) -> Result<(Fields, &[u8]), ReadError> {
    let mut fields = Fields::new(VolumeFormat::MetaImage);
    let mut rest = bytes;
    while !rest.is_empty() {
        let end = rest.iter().take(LONGEST_LINE).position(|b| *b == b'\n');
        let line = &rest[..end.unwrap_or(rest.len().min(LONGEST_LINE))];
        let line = String::from_utf8_lossy(line);
        rest = end.map_or(&[][..], |end| &rest[end + 1..]);
        match line.split_once('=') {
            Some((name, value)) => {
                fields.add(name.trim(), value.trim());
                if name.trim() == "ElementDataFile" {
                    return Ok((fields, rest));
                }
            }
            None if line.trim().is_empty() => {}
            None => return Err(fields.error("line", line.trim(), "`name = value`")),
        }
    }
    Err(ReadError::MissingField { format: VolumeFormat::MetaImage, field: "ElementDataFile" })
}

fn extents(fields: &Fields) -> Result<(usize, [u64; 3]), ReadError> {
    const EXAMPLE: &str = "with SimpleITK: `image[:, :, :, 0]` or `sitk.VectorIndexSelectionCast(image, 0)`";
    let several = |count, kind| Err(ReadError::SeveralVolumes { count, kind, example: EXAMPLE });
    let [axes]: [usize; 1] = fields.exactly("NDims", fields.need(&["NDims"], "NDims")?, "a whole number")?;
    let text = fields.need(&["DimSize"], "DimSize")?;
    let sizes: Vec<u64> = fields.numbers("DimSize", text)?;
    if sizes.len() != axes {
        return Err(fields.error("DimSize", text, "as many numbers as NDims says"));
    }
    if !(3..=10).contains(&axes) {
        return Err(ReadError::Axes { found: axes as u64 });
    }
    if let Some(count) = sizes[3..].iter().find(|size| **size != 1) {
        return several(*count, "time points");
    }
    if let Some(text) = fields.get(&["ElementNumberOfChannels"]) {
        let [channels]: [u64; 1] = fields.exactly("ElementNumberOfChannels", text, "1")?;
        if channels != 1 {
            return several(channels, "components per voxel");
        }
    }
    Ok((axes, [sizes[0], sizes[1], sizes[2]]))
}

/// MetaIO's `long` has 4 bytes on every machine.
fn scalar(fields: &Fields) -> Result<ScalarType, ReadError> {
    let text = fields.need(&["ElementType"], "ElementType")?;
    match text {
        "MET_CHAR" => Ok(ScalarType::I8),
        "MET_UCHAR" => Ok(ScalarType::U8),
        "MET_SHORT" => Ok(ScalarType::I16),
        "MET_USHORT" => Ok(ScalarType::U16),
        "MET_INT" | "MET_LONG" => Ok(ScalarType::I32),
        "MET_UINT" | "MET_ULONG" => Ok(ScalarType::U32),
        "MET_LONG_LONG" => Ok(ScalarType::I64),
        "MET_ULONG_LONG" => Ok(ScalarType::U64),
        "MET_FLOAT" => Ok(ScalarType::F32),
        "MET_DOUBLE" => Ok(ScalarType::F64),
        _ => Err(ReadError::Unsupported {
            what: format!("the MetaImage type `{}`", excerpt(text)),
            remedy: "convert it to one integer or float per voxel, e.g. with SimpleITK's Cast",
        }),
    }
}

fn data_file(fields: &Fields) -> Result<DataFile, ReadError> {
    let text = fields.need(&["ElementDataFile"], "ElementDataFile")?;
    match text {
        "LOCAL" | "Local" | "local" => Ok(DataFile::Local),
        _ if text.starts_with("LIST") || text.contains('%') => Err(ReadError::Unsupported {
            what: format!("a MetaImage header with several data files (`{}`)", excerpt(text)),
            remedy: "write it as one .mha file, e.g. with SimpleITK's WriteImage",
        }),
        "" => Err(fields.error("ElementDataFile", text, "LOCAL or a file's name")),
        name => Ok(DataFile::Beside(name.into())),
    }
}

fn data_skip(fields: &Fields) -> Result<Option<usize>, ReadError> {
    match fields.get(&["HeaderSize"]) {
        None => Ok(Some(0)),
        Some("-1") => Ok(None),
        Some(text) => text.parse().map(Some).map_err(|_| fields.error("HeaderSize", text, "a number of bytes, or -1")),
    }
}

fn flag(fields: &Fields, names: &[&str], default: bool) -> Result<bool, ReadError> {
    match fields.get(names) {
        None => Ok(default),
        Some(text) if text.starts_with(['T', 't', '1', 'Y', 'y']) => Ok(true),
        Some(text) if text.starts_with(['F', 'f', '0', 'N', 'n']) => Ok(false),
        Some(text) => Err(fields.error(names[0], text, "True or False")),
    }
}
