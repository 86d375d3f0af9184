//! Voxel values as bytes: number types, byte order, and the check that the bytes are there.

use super::ReadError;
use super::read_error::excerpt;

/// The number type of a stored voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScalarType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F16,
    F32,
    F64,
}

impl ScalarType {
    /// Bytes per value.
    pub const fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The name of the type in an error.
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::I8 => "int8",
            Self::U16 => "uint16",
            Self::I16 => "int16",
            Self::U32 => "uint32",
            Self::I32 => "int32",
            Self::U64 => "uint64",
            Self::I64 => "int64",
            Self::F16 => "float16",
            Self::F32 => "float32",
            Self::F64 => "float64",
        }
    }

    pub const fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64)
    }

    const fn is_wide_integer(self) -> bool {
        matches!(self, Self::U64 | Self::I64)
    }

    /// The smallest of u8, i16, i32 that holds all values exactly, f64 where none does.
    pub fn smallest_for(values: &[f64]) -> Self {
        let holds = |low: f64, high: f64| values.iter().all(|v| v.fract() == 0.0 && (low..=high).contains(v));
        match () {
            () if holds(0.0, f64::from(u8::MAX)) => Self::U8,
            () if holds(f64::from(i16::MIN), f64::from(i16::MAX)) => Self::I16,
            () if holds(f64::from(i32::MIN), f64::from(i32::MAX)) => Self::I32,
            () => Self::F64,
        }
    }

    /// The values as little-endian bytes of this type; only for the types that `smallest_for` returns.
    pub fn encode(self, values: &[f64]) -> Vec<u8> {
        match self {
            Self::U8 => values.iter().map(|v| *v as u8).collect(),
            Self::I16 => values.iter().flat_map(|v| (*v as i16).to_le_bytes()).collect(),
            Self::I32 => values.iter().flat_map(|v| (*v as i32).to_le_bytes()).collect(),
            _ => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        }
    }
}

/// Which byte of a number comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    /// The number's bytes, turned so that the least significant comes first.
    pub fn to_little<const N: usize>(self, mut word: [u8; N]) -> [u8; N] {
        if self == Self::Big {
            word.reverse();
        }
        word
    }
}

/// How the voxels of a volume lie in a run of bytes, x fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SampleLayout {
    pub cells: [usize; 3],
    pub scalar: ScalarType,
    pub order: ByteOrder,
}

impl SampleLayout {
    /// Refuses empty volumes and those whose number of bytes, here or as f64, cannot be addressed.
    pub fn new(extents: [u64; 3], scalar: ScalarType, order: ByteOrder) -> Result<Self, ReadError> {
        if extents.contains(&0) {
            return Err(ReadError::ZeroExtent(extents));
        }
        let too_large = || ReadError::TooLarge(extents);
        let voxels = extents.iter().try_fold(1u64, |n, e| n.checked_mul(*e)).ok_or_else(too_large)?;
        let bytes = voxels.checked_mul(size_of::<f64>() as u64).ok_or_else(too_large)?;
        isize::try_from(bytes).map_err(|_| too_large())?;
        // Every extent is at most the number of voxels, which fits.
        Ok(Self { cells: extents.map(|e| e as usize), scalar, order })
    }

    pub const fn voxel_count(&self) -> usize {
        self.cells[0] * self.cells[1] * self.cells[2]
    }

    pub const fn byte_count(&self) -> usize {
        self.voxel_count() * self.scalar.size()
    }

    /// The first `byte_count` bytes as numbers; what follows them is not looked at.
    pub fn decode(&self, bytes: &[u8]) -> Result<Vec<f64>, ReadError> {
        let needed = self.byte_count();
        let bytes = bytes.get(..needed).ok_or(ReadError::Truncated {
            part: "voxel data",
            needed: needed as u64,
            found: bytes.len() as u64,
        })?;
        let values = decode(bytes, self.scalar, self.order);
        self.refuse_wide_integers(&values)?;
        Ok(values)
    }

    /// The voxels from text, numbers separated by blanks.
    pub fn decode_text(&self, bytes: &[u8]) -> Result<Vec<f64>, ReadError> {
        let text = String::from_utf8_lossy(bytes);
        let expected = self.scalar.name();
        let mut values = Vec::new();
        for (index, word) in text.split_ascii_whitespace().take(self.voxel_count()).enumerate() {
            let refuse = || ReadError::Text { index, text: excerpt(word), expected };
            let value: f64 = word.trim_end_matches(',').parse().map_err(|_| refuse())?;
            if !self.scalar.is_float() && value.fract() != 0.0 {
                return Err(refuse());
            }
            values.push(value);
        }
        if values.len() < self.voxel_count() {
            let (needed, found) = (self.voxel_count() as u64, values.len() as u64);
            return Err(ReadError::TextTruncated { needed, found });
        }
        self.refuse_wide_integers(&values)?;
        Ok(values)
    }

    fn refuse_wide_integers(&self, values: &[f64]) -> Result<(), ReadError> {
        if !self.scalar.is_wide_integer() {
            return Ok(());
        }
        const EXACT: f64 = (1u64 << 53) as f64;
        match values.iter().position(|v| v.abs() >= EXACT) {
            None => Ok(()),
            Some(index) => Err(ReadError::WideInteger { value: values[index], at: position(index, self.cells) }),
        }
    }
}

/// Grid position (i, j, k) of the voxel with this index, x fastest.
pub(super) const fn position(index: usize, cells: [usize; 3]) -> [usize; 3] {
    [index % cells[0], index / cells[0] % cells[1], index / (cells[0] * cells[1])]
}

/// All whole numbers in the bytes, as f64.
pub(super) fn decode(bytes: &[u8], scalar: ScalarType, order: ByteOrder) -> Vec<f64> {
    match scalar {
        ScalarType::U8 => decode_as(bytes, order, |w| f64::from(u8::from_le_bytes(w))),
        ScalarType::I8 => decode_as(bytes, order, |w| f64::from(i8::from_le_bytes(w))),
        ScalarType::U16 => decode_as(bytes, order, |w| f64::from(u16::from_le_bytes(w))),
        ScalarType::I16 => decode_as(bytes, order, |w| f64::from(i16::from_le_bytes(w))),
        ScalarType::U32 => decode_as(bytes, order, |w| f64::from(u32::from_le_bytes(w))),
        ScalarType::I32 => decode_as(bytes, order, |w| f64::from(i32::from_le_bytes(w))),
        ScalarType::U64 => decode_as(bytes, order, |w| u64::from_le_bytes(w) as f64),
        ScalarType::I64 => decode_as(bytes, order, |w| i64::from_le_bytes(w) as f64),
        ScalarType::F16 => decode_as(bytes, order, |w| half_to_f64(u16::from_le_bytes(w))),
        ScalarType::F32 => decode_as(bytes, order, |w| f64::from(f32::from_le_bytes(w))),
        ScalarType::F64 => decode_as(bytes, order, f64::from_le_bytes),
    }
}

fn decode_as<const N: usize>(bytes: &[u8], order: ByteOrder, to_f64: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    let (words, _) = bytes.as_chunks::<N>();
    words.iter().map(|w| to_f64(order.to_little(*w))).collect()
}

/// IEEE binary16: 1 sign bit, 5 exponent bits (bias 15), 10 fraction bits.
fn half_to_f64(bits: u16) -> f64 {
    let fraction = f64::from(bits & 0x3ff);
    let magnitude = match bits >> 10 & 0x1f {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1024.0 + fraction) * 2f64.powi(i32::from(exponent) - 25),
    };
    if bits & 0x8000 == 0 { magnitude } else { -magnitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_precision_numbers_have_their_ieee_values() {
        for (bits, value) in
            [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (1, 2f64.powi(-24)), (0x3555, 0.333251953125)]
        {
            assert_eq!(half_to_f64(bits), value, "bits {bits:#06x}");
        }
        assert_eq!(half_to_f64(0x7c00), f64::INFINITY);
        assert!(half_to_f64(0x7e00).is_nan());
    }

    #[test]
    fn the_smallest_type_holds_every_value() {
        let cases = [
            (vec![0.0, 255.0], ScalarType::U8),
            (vec![-1.0, 255.0], ScalarType::I16),
            (vec![256.0], ScalarType::I16),
            (vec![32768.0], ScalarType::I32),
            (vec![2147483648.0], ScalarType::F64),
            (vec![0.5], ScalarType::F64),
            (vec![f64::INFINITY], ScalarType::F64),
        ];
        for (values, expected) in cases {
            let scalar = ScalarType::smallest_for(&values);
            assert_eq!(scalar, expected, "{values:?}");
            assert_eq!(decode(&scalar.encode(&values), scalar, ByteOrder::Little), values);
        }
    }

    #[test]
    fn extents_that_overflow_are_refused() {
        for extents in [[u64::MAX, 2, 1], [1 << 21, 1 << 21, 1 << 21], [u64::MAX / 8, 1, 1]] {
            let layout = SampleLayout::new(extents, ScalarType::U8, ByteOrder::Little);
            assert!(matches!(layout, Err(ReadError::TooLarge(e)) if e == extents), "{extents:?}: {layout:?}");
        }
    }
}
