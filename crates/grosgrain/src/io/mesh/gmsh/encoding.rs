//! Numbers of a Gmsh file as text or binary.

use super::super::scanner::Scanner;
use super::{MeshReadError, Place};

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    /// Bytes; sizes (counts and numbers of nodes in version 4) take eight of them or four.
    Binary {
        big_endian: bool,
        wide: bool,
    },
}

/// The numbers that follow one another.
pub(super) struct Numbers<'a> {
    pub scanner: Scanner<'a>,
    pub encoding: Encoding,
}

impl Numbers<'_> {
    /// A signed integer of 32 bits.
    pub fn int(&mut self, expected: &'static str) -> Result<i32, MeshReadError> {
        match self.encoding {
            Encoding::Text => self.scanner.parse(expected),
            Encoding::Binary { big_endian, .. } => {
                let bytes = self.scanner.raw::<4>(expected)?;
                Ok(if big_endian { i32::from_be_bytes(bytes) } else { i32::from_le_bytes(bytes) })
            }
        }
    }

    /// A count or the number of a node.
    pub fn size(&mut self, expected: &'static str) -> Result<i64, MeshReadError> {
        match self.encoding {
            Encoding::Text => self.scanner.parse(expected),
            Encoding::Binary { wide: false, .. } => self.int(expected).map(i64::from),
            Encoding::Binary { big_endian, .. } => {
                let bytes = self.scanner.raw::<8>(expected)?;
                Ok(if big_endian { i64::from_be_bytes(bytes) } else { i64::from_le_bytes(bytes) })
            }
        }
    }

    /// A real number.
    pub fn real(&mut self, expected: &'static str) -> Result<f64, MeshReadError> {
        match self.encoding {
            Encoding::Text => self.scanner.parse(expected),
            Encoding::Binary { big_endian, .. } => {
                let bytes = self.scanner.raw::<8>(expected)?;
                Ok(if big_endian { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) })
            }
        }
    }

    /// Three coordinates.
    pub fn point(&mut self) -> Result<[f64; 3], MeshReadError> {
        const COORDINATE: &str = "a coordinate of a node";
        Ok([self.real(COORDINATE)?, self.real(COORDINATE)?, self.real(COORDINATE)?])
    }

    /// Line of the last word, or offset of the next byte.
    pub fn place(&self) -> Place {
        match self.encoding {
            Encoding::Text => self.scanner.line(),
            Encoding::Binary { .. } => Place::Byte(self.scanner.offset()),
        }
    }

    /// A number is not what must stand here.
    pub fn unexpected(&self, found: i64, expected: &'static str) -> MeshReadError {
        MeshReadError::Unexpected { place: self.place(), found: found.to_string(), expected }
    }
}
