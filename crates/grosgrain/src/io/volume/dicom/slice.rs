//! One DICOM file: a grey image and its place in the patient.

use super::super::ReadError;
use super::super::read_error::excerpt;
use super::super::samples::{self, ByteOrder, ScalarType};
use super::data_set::{DataSet, Pixels, Tag};
use super::error::DicomError;
use super::rle;

const MODALITY: Tag = (0x0008, 0x0060);
const SERIES_DESCRIPTION: Tag = (0x0008, 0x103e);
const SLICE_THICKNESS: Tag = (0x0018, 0x0050);
const SLICE_DISTANCE: Tag = (0x0018, 0x0088);
const SERIES_UID: Tag = (0x0020, 0x000e);
const SERIES_NUMBER: Tag = (0x0020, 0x0011);
const POSITION: Tag = (0x0020, 0x0032);
const ORIENTATION: Tag = (0x0020, 0x0037);
const SAMPLES_PER_PIXEL: Tag = (0x0028, 0x0002);
const PHOTOMETRIC: Tag = (0x0028, 0x0004);
const FRAMES: Tag = (0x0028, 0x0008);
const ROWS: Tag = (0x0028, 0x0010);
const COLUMNS: Tag = (0x0028, 0x0011);
const PIXEL_SPACING: Tag = (0x0028, 0x0030);
const BITS_ALLOCATED: Tag = (0x0028, 0x0100);
const BITS_STORED: Tag = (0x0028, 0x0101);
const HIGH_BIT: Tag = (0x0028, 0x0102);
const SIGNED: Tag = (0x0028, 0x0103);
const INTERCEPT: Tag = (0x0028, 0x1052);
const SLOPE: Tag = (0x0028, 0x1053);

/// A slice as stored; numbers are made of the pixels only once the series is known to be whole.
#[derive(Clone, Debug)]
pub(super) struct Slice {
    pub file: String,
    pub series: String,
    pub description: String,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Centre of the first pixel [mm, LPS].
    pub position: [f64; 3],
    /// Directions of growing column index and of growing row index, unit vectors.
    pub orientation: [[f64; 3]; 2],
    /// Distance of columns and of rows \[mm\].
    pub spacing: [f64; 2],
    /// Distance of slices as the file has it \[mm\].
    pub distance: Option<f64>,
    pixels: Vec<u8>,
    word: Word,
    rescale: (f64, f64),
}

/// Which bits of a stored word are the number.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Word {
    scalar: ScalarType,
    order: ByteOrder,
    /// Bits above and below the number.
    unused: (u32, u32),
    signed: bool,
}

impl Slice {
    /// `None` for a DICOM file without an image.
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Option<Self>, ReadError> {
        let data = DataSet::parse(bytes)?;
        let Some(pixels) = &data.pixels else { return Ok(None) };
        refuse_colour_and_frames(&data)?;
        let size = [need(&data, COLUMNS, "Columns")?, need(&data, ROWS, "Rows")?].map(u32::from);
        if size.contains(&0) {
            return Err(ReadError::ZeroExtent([u64::from(size[0]), u64::from(size[1]), 1]));
        }
        let word = Word::of(&data)?;
        let [row_distance, column_distance] = need_decimals(&data, PIXEL_SPACING, "PixelSpacing (0028,0030)")?;
        let [slope] = data.decimals(SLOPE, "RescaleSlope (0028,1053)")?.unwrap_or([1.0]);
        let [intercept] = data.decimals(INTERCEPT, "RescaleIntercept (0028,1052)")?.unwrap_or([0.0]);
        Ok(Some(Self {
            file: file.into(),
            series: excerpt(data.text(SERIES_UID)),
            description: description(&data),
            size,
            position: need_decimals(&data, POSITION, "ImagePositionPatient (0020,0032)")?,
            orientation: orientation(&data)?,
            spacing: [column_distance, row_distance],
            distance: slice_distance(&data)?,
            pixels: stored_pixels(&data, pixels, size, word)?,
            word: if data.run_length { Word { order: ByteOrder::Little, ..word } } else { word },
            rescale: (slope, intercept),
        }))
    }

    /// The numbers with slope and intercept applied, columns fastest.
    pub fn into_values(self) -> Vec<f64> {
        let (slope, intercept) = self.rescale;
        let mut values = self.word.numbers(&self.pixels);
        values.iter_mut().for_each(|v| *v = *v * slope + intercept);
        values
    }
}

impl Word {
    fn of(data: &DataSet) -> Result<Self, DicomError> {
        let allocated = need(data, BITS_ALLOCATED, "BitsAllocated")?;
        let scalar = match allocated {
            8 => ScalarType::U8,
            16 => ScalarType::U16,
            32 => ScalarType::U32,
            _ => return Err(wrong("BitsAllocated (0028,0100)", allocated, "8, 16 or 32")),
        };
        let stored = data.number(BITS_STORED).unwrap_or(allocated);
        let high = data.number(HIGH_BIT).unwrap_or(stored.saturating_sub(1));
        if stored == 0 || high >= allocated || stored > high + 1 {
            let expected = "at most HighBit + 1, and HighBit below BitsAllocated";
            return Err(wrong("BitsStored (0028,0101)", stored, expected));
        }
        let unused = (u32::from(allocated - 1 - high), u32::from(high + 1 - stored));
        Ok(Self { scalar, order: data.order, unused, signed: data.number(SIGNED) == Some(1) })
    }

    fn numbers(self, bytes: &[u8]) -> Vec<f64> {
        let mut values = samples::decode(bytes, self.scalar, self.order);
        let bits = 8 * self.scalar.size() as u32;
        let (above, below) = self.unused;
        for value in &mut values {
            // The number's bits at the top of the word, then down with its sign.
            let word = (*value as u32) << (32 - bits) << above;
            let down = 32 - bits + above + below;
            *value = match self.signed {
                true => f64::from((word as i32) >> down),
                false => f64::from(word >> down),
            };
        }
        values
    }
}

fn refuse_colour_and_frames(data: &DataSet) -> Result<(), ReadError> {
    let frames = data.text(FRAMES);
    match frames.parse::<u64>() {
        Ok(0 | 1) => {}
        Ok(frames) => return Err(DicomError::MultiFrame { frames }.into()),
        Err(_) if frames.is_empty() => {}
        Err(_) => return Err(wrong("NumberOfFrames (0028,0008)", frames, "a whole number").into()),
    }
    let photometric = data.text(PHOTOMETRIC);
    let samples = data.number(SAMPLES_PER_PIXEL).unwrap_or(1);
    match (samples, photometric) {
        (1, "" | "MONOCHROME1" | "MONOCHROME2") => Ok(()),
        _ => Err(ReadError::Unsupported {
            what: format!("a colour image ({samples} samples per pixel, {})", excerpt(photometric)),
            remedy: "give the series of grey slices",
        }),
    }
}

fn orientation(data: &DataSet) -> Result<[[f64; 3]; 2], ReadError> {
    const NAME: &str = "ImageOrientationPatient (0020,0037)";
    let o: [f64; 6] = need_decimals(data, ORIENTATION, NAME)?;
    let (row, column) = ([o[0], o[1], o[2]], [o[3], o[4], o[5]]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let unit = |v| (dot(v, v) - 1.0).abs() < 1e-3;
    match unit(row) && unit(column) && dot(row, column).abs() < 1e-3 {
        true => Ok([row, column]),
        false => Err(wrong(NAME, data.text(ORIENTATION), "two perpendicular unit vectors").into()),
    }
}

/// `SpacingBetweenSlices`, else `SliceThickness`; used for a single slice only.
fn slice_distance(data: &DataSet) -> Result<Option<f64>, DicomError> {
    let between = data.decimals(SLICE_DISTANCE, "SpacingBetweenSlices (0018,0088)")?;
    let thickness = data.decimals(SLICE_THICKNESS, "SliceThickness (0018,0050)")?;
    Ok(between.or(thickness).map(|[distance]| distance))
}

fn stored_pixels(data: &DataSet, pixels: &Pixels, size: [u32; 2], word: Word) -> Result<Vec<u8>, ReadError> {
    let count = size[0] as usize * size[1] as usize;
    let needed = count * word.scalar.size();
    match pixels {
        Pixels::Native(bytes) if !data.run_length => match bytes.get(..needed) {
            Some(bytes) => Ok(bytes.to_vec()),
            None => {
                let (needed, found) = (needed as u64, bytes.len() as u64);
                Err(ReadError::Truncated { part: "pixel data", needed, found })
            }
        },
        Pixels::Fragments(fragments) if data.run_length => rle::decode(&fragments.concat(), count, word.scalar.size()),
        _ => Err(DicomError::Damaged { at: 0, reason: "the pixels are not stored as the transfer syntax says" }.into()),
    }
}

fn description(data: &DataSet) -> String {
    let parts = [data.text(SERIES_NUMBER), data.text(MODALITY), data.text(SERIES_DESCRIPTION)];
    excerpt(&parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" "))
}

fn need(data: &DataSet, tag: Tag, name: &'static str) -> Result<u16, DicomError> {
    data.number(tag).ok_or(DicomError::Missing(name))
}

fn need_decimals<const N: usize>(data: &DataSet, tag: Tag, name: &'static str) -> Result<[f64; N], DicomError> {
    data.decimals(tag, name)?.ok_or(DicomError::Missing(name))
}

fn wrong(element: &'static str, value: impl ToString, expected: &'static str) -> DicomError {
    DicomError::Element { element, value: excerpt(&value.to_string()), expected }
}
