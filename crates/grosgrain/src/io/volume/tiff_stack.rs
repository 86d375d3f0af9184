//! TIFF stacks: the pages of one file, or the files of a folder, are the layers along z.

use super::ReadError;
use super::geometry::Geometry;
use crate::mesh::Volume;
use std::io::Cursor;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{CompressionMethod, PhotometricInterpretation, Tag};
use tiff::{ColorType, TiffError};

/// Reads a TIFF file (classic or BigTIFF) from its bytes; its pages are the layers along z.
///
/// Grey pages of 8 to 64 bits, integer or float, plain, PackBits, deflate or LZW. No spacing is taken from TIFF.
///
/// # Errors
/// A damaged structure, colour, an unsupported compression, pages of different size, a stack with several
/// time points or channels, NaN.
pub fn read_tiff(bytes: &[u8]) -> Result<Volume, ReadError> {
    let mut stack = Stack::default();
    stack.push_file(bytes)?;
    stack.into_volume()
}

/// Layers gathered from one or several files.
#[derive(Default)]
pub(super) struct Stack {
    /// Width and height of every page.
    size: Option<[u32; 2]>,
    pages: usize,
    values: Vec<f64>,
}

impl Stack {
    /// Appends all pages of a file.
    pub fn push_file(&mut self, bytes: &[u8]) -> Result<(), ReadError> {
        let limits = page_limits(bytes.len());
        let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(|e| self.error(e))?.with_limits(limits);
        refuse_several_volumes(&mut decoder)?;
        // Pages may share their data; together they must not exceed what the file can hold.
        let mut budget = usize::MAX;
        loop {
            let page_budget = self.check_page(&mut decoder, bytes.len())?;
            budget = budget.min(page_budget);
            let values = to_f64(decoder.read_image().map_err(|e| self.error(e))?);
            let size = self.size.unwrap_or_default();
            let pixels = size[0] as usize * size[1] as usize;
            let values = values.get(..pixels).ok_or(ReadError::Truncated {
                part: "pixels of a TIFF page",
                needed: pixels as u64,
                found: values.len() as u64,
            })?;
            budget = budget.checked_sub(values.len()).ok_or_else(|| self.error(TiffError::LimitsExceeded))?;
            self.values.extend_from_slice(values);
            self.pages += 1;
            if !decoder.more_images() {
                return Ok(());
            }
            decoder.next_image().map_err(|e| self.error(e))?;
        }
    }

    /// The layers as a volume without spacing.
    pub fn into_volume(self) -> Result<Volume, ReadError> {
        let size = self.size.unwrap_or_default();
        let cells = [size[0] as usize, size[1] as usize, self.pages];
        if cells.contains(&0) {
            return Err(ReadError::ZeroExtent(cells.map(|n| n as u64)));
        }
        Geometry { cells, spacing: None, voxel_to_world: None }.with_values(self.values)
    }

    /// Refuses pages that are not grey, not as large as the first or larger than their data can be; returns the
    /// most pixels that all pages together can have.
    fn check_page(&mut self, decoder: &mut Decoder<Cursor<&[u8]>>, length: usize) -> Result<usize, ReadError> {
        let (width, height) = decoder.dimensions().map_err(|e| self.error(e))?;
        let found = [width, height];
        let expected = *self.size.get_or_insert(found);
        if found != expected {
            return Err(ReadError::PageSize { page: self.pages + 1, found, expected });
        }
        let bits = match decoder.colortype().map_err(|e| self.error(e))? {
            ColorType::Gray(bits @ (8 | 16 | 32 | 64)) => bits,
            other => return Err(unsupported(format!("a TIFF page of type {other:?}"))),
        };
        let photometric = self.tag(decoder, Tag::PhotometricInterpretation)?;
        if photometric == Some(PhotometricInterpretation::WhiteIsZero.to_u16()) {
            return Err(unsupported("a TIFF page that stores white as zero".into()));
        }
        let ratio = expansion(self.tag(decoder, Tag::Compression)?)?;
        let stored = self.stored_bytes(decoder)?.min(length as u64);
        let most = stored.saturating_mul(ratio as u64);
        let needed = u64::from(width).saturating_mul(u64::from(height)).saturating_mul(u64::from(bits / 8));
        match needed <= most {
            true => Ok(length.saturating_mul(ratio)),
            false => Err(ReadError::Truncated { part: "pixels of a TIFF page", needed, found: most }),
        }
    }

    /// The bytes of all strips or tiles of a page, as its directory has them.
    fn stored_bytes(&self, decoder: &mut Decoder<Cursor<&[u8]>>) -> Result<u64, ReadError> {
        let mut bytes = 0u64;
        for tag in [Tag::StripByteCounts, Tag::TileByteCounts] {
            let counts = decoder.find_tag_unsigned_vec::<u64>(tag).map_err(|e| self.error(e))?;
            bytes = counts.into_iter().flatten().fold(bytes, u64::saturating_add);
        }
        Ok(bytes)
    }

    fn tag(&self, decoder: &mut Decoder<Cursor<&[u8]>>, tag: Tag) -> Result<Option<u16>, ReadError> {
        decoder.find_tag_unsigned(tag).map_err(|e| self.error(e))
    }

    fn error(&self, reason: TiffError) -> ReadError {
        match reason {
            TiffError::UnsupportedError(reason) => unsupported(format!("a TIFF page ({reason})")),
            reason => ReadError::Tiff { page: self.pages + 1, reason },
        }
    }
}

/// Bounds that follow from the file's length instead of fixed ones.
fn page_limits(length: usize) -> Limits {
    let mut limits = Limits::default();
    limits.ifd_value_size = length;
    limits.intermediate_buffer_size = length.max(limits.intermediate_buffer_size);
    limits.decoding_buffer_size = length.saturating_mul(LZW_EXPANSION);
    limits
}

/// A 12-bit LZW code stands for at most 3,839 bytes.
const LZW_EXPANSION: usize = 2560;

/// How many bytes at most come out of one byte of the file.
fn expansion(compression: Option<u16>) -> Result<usize, ReadError> {
    match CompressionMethod::from_u16_exhaustive(compression.unwrap_or(1)) {
        CompressionMethod::None => Ok(1),
        CompressionMethod::PackBits => Ok(64),
        CompressionMethod::Deflate | CompressionMethod::OldDeflate => Ok(1032),
        CompressionMethod::LZW => Ok(LZW_EXPANSION),
        other => Err(unsupported(format!("the TIFF compression {other:?}"))),
    }
}

fn unsupported(what: String) -> ReadError {
    ReadError::Unsupported {
        what,
        remedy: "save a grey stack, black as zero, 8- to 64-bit, without compression or with deflate or LZW",
    }
}

/// The description of ImageJ, OME and tifffile says if pages are more than layers.
fn refuse_several_volumes(decoder: &mut Decoder<Cursor<&[u8]>>) -> Result<(), ReadError> {
    const EXAMPLE: &str = "with tifffile: `imwrite(name, imread(old)[0])`";
    let Ok(text) = decoder.get_tag_ascii_string(Tag::ImageDescription) else { return Ok(()) };
    let frames = ["frames=", "SizeT=\""].iter().find_map(|key| number_after(&text, key));
    let channels = ["channels=", "SizeC=\""].iter().find_map(|key| number_after(&text, key));
    let described = text.starts_with("ImageJ=") || text.contains("<OME");
    match (frames, channels) {
        (Some(count), _) if described && count > 1 => {
            Err(ReadError::SeveralVolumes { count, kind: "time points", example: EXAMPLE })
        }
        (_, Some(count)) if described && count > 1 => {
            Err(ReadError::SeveralVolumes { count, kind: "channels", example: EXAMPLE })
        }
        _ => match tifffile_shape(&text).as_slice() {
            [count, _, _, _, ..] => Err(ReadError::SeveralVolumes { count: *count, kind: "volumes", example: EXAMPLE }),
            _ => Ok(()),
        },
    }
}

/// The axes longer than 1 of `{"shape": [2, 3, 4, 5]}`.
fn tifffile_shape(text: &str) -> Vec<u64> {
    let Some(shape) = text.strip_prefix("{\"shape\": [").and_then(|t| t.split(']').next()) else { return Vec::new() };
    shape.split(',').filter_map(|n| n.trim().parse().ok()).filter(|n| *n != 1).collect()
}

fn number_after(text: &str, key: &str) -> Option<u64> {
    let digits = text.split_once(key)?.1;
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    digits[..end].parse().ok()
}

fn to_f64(page: DecodingResult) -> Vec<f64> {
    match page {
        DecodingResult::U8(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::U16(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::U32(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::U64(v) => v.into_iter().map(|v| v as f64).collect(),
        DecodingResult::I8(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::I16(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::I32(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::I64(v) => v.into_iter().map(|v| v as f64).collect(),
        DecodingResult::F16(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::F32(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::F64(v) => v,
    }
}
