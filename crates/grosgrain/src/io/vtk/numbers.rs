//! Types of numbers in VTK's files.

use std::borrow::Cow;

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl NumberType {
    /// By the name in the XML format (`Int32`) or in the legacy format (`int`, `vtktypeint64`).
    pub fn of_name(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "int8" | "char" | "vtktypeint8" | "signed_char" => Self::I8,
            "uint8" | "unsigned_char" | "vtktypeuint8" => Self::U8,
            "int16" | "short" | "vtktypeint16" => Self::I16,
            "uint16" | "unsigned_short" | "vtktypeuint16" => Self::U16,
            "int32" | "int" | "vtktypeint32" => Self::I32,
            "uint32" | "unsigned_int" | "vtktypeuint32" => Self::U32,
            // Legacy files hold `long` with 8 bytes, as Linux and macOS have it, and `vtkIdType` as `int`.
            "int64" | "long" | "vtktypeint64" => Self::I64,
            "uint64" | "unsigned_long" | "vtktypeuint64" => Self::U64,
            "vtkidtype" => Self::I32,
            "float32" | "float" => Self::F32,
            "float64" | "double" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The numbers that `bytes` hold; integers beyond 2^53 are rounded.
    pub fn numbers(self, bytes: &[u8], little_endian: bool) -> Vec<f64> {
        let ordered = if little_endian { Cow::Borrowed(bytes) } else { Cow::Owned(swapped(bytes, self.size())) };
        match self {
            Self::I8 => each(&ordered, |b: [u8; 1]| f64::from(b[0] as i8)),
            Self::U8 => each(&ordered, |b: [u8; 1]| f64::from(b[0])),
            Self::I16 => each(&ordered, |b| f64::from(i16::from_le_bytes(b))),
            Self::U16 => each(&ordered, |b| f64::from(u16::from_le_bytes(b))),
            Self::I32 => each(&ordered, |b| f64::from(i32::from_le_bytes(b))),
            Self::U32 => each(&ordered, |b| f64::from(u32::from_le_bytes(b))),
            Self::I64 => each(&ordered, |b| i64::from_le_bytes(b) as f64),
            Self::U64 => each(&ordered, |b| u64::from_le_bytes(b) as f64),
            Self::F32 => each(&ordered, |b| f64::from(f32::from_le_bytes(b))),
            Self::F64 => each(&ordered, f64::from_le_bytes),
        }
    }
}

/// Bytes with every group of `size` turned round.
fn swapped(bytes: &[u8], size: usize) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes.chunks_mut(size).for_each(<[u8]>::reverse);
    bytes
}

fn each<const N: usize>(bytes: &[u8], number: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    bytes.as_chunks::<N>().0.iter().map(|chunk| number(*chunk)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_all_types_are_read_in_both_byte_orders() {
        let cases: [(&str, Vec<u8>, f64); 10] = [
            ("char", (-3i8).to_be_bytes().into(), -3.0),
            ("UInt8", vec![200], 200.0),
            ("Int16", (-300i16).to_be_bytes().into(), -300.0),
            ("unsigned_short", 60_000u16.to_be_bytes().into(), 60_000.0),
            ("vtkIdType", (-70_000i32).to_be_bytes().into(), -70_000.0),
            ("UInt32", 4_000_000_000u32.to_be_bytes().into(), 4e9),
            ("vtktypeint64", (-5_000_000_000i64).to_be_bytes().into(), -5e9),
            ("UInt64", 5_000_000_000u64.to_be_bytes().into(), 5e9),
            ("float", 0.5f32.to_be_bytes().into(), 0.5),
            ("Float64", (1.0f64 / 3.0).to_be_bytes().into(), 1.0 / 3.0),
        ];
        for (name, mut bytes, value) in cases {
            let kind = NumberType::of_name(name).unwrap();
            assert_eq!((kind.size(), kind.numbers(&bytes, false)), (bytes.len(), vec![value]), "{name}");
            bytes.reverse();
            assert_eq!(kind.numbers(&bytes, true), [value], "{name}");
        }
        assert_eq!(NumberType::of_name("string"), None);
    }
}
