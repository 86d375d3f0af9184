//! Bytes of an array: plain or as base64, with VTK's headers, compressed or not.
//!
//! Where header and data are base64 texts of their own, the padding of the first ends its last group of letters, and reading on is right in both cases.

use crate::io::mesh::{MeshReadError, Place};
use flate2::bufread::ZlibDecoder;
use std::io::Read;

/// How the file stores arrays that are not text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoding {
    pub little_endian: bool,
    /// Bytes of each number in a header, 4 or 8.
    pub header_size: usize,
    pub compressed: bool,
}

/// What is left of an array's bytes.
pub(super) struct Stream<'a> {
    rest: &'a [u8],
    is_base64: bool,
    /// Bytes that the last group of letters held too many.
    spare: Vec<u8>,
    place: Place,
}

impl<'a> Stream<'a> {
    /// The array that begins with `rest`, which may go on after its end; `place` is for errors.
    pub fn new(rest: &'a [u8], is_base64: bool, place: Place) -> Self {
        Self { rest, is_base64, spare: Vec::new(), place }
    }

    /// The `needed` bytes of the array. Memory grows with what is there, not with `needed`.
    pub fn array(mut self, needed: usize, encoding: Encoding) -> Result<Vec<u8>, MeshReadError> {
        match encoding.compressed {
            true => self.compressed(needed, encoding),
            false => {
                let announced = self.header(encoding)?;
                match announced == needed as u64 {
                    true => self.take(needed),
                    false => Err(self.wrong_size(announced, needed)),
                }
            }
        }
    }

    fn compressed(&mut self, needed: usize, encoding: Encoding) -> Result<Vec<u8>, MeshReadError> {
        let blocks = self.header(encoding)?;
        let (full, last) = (self.header(encoding)?, self.header(encoding)?);
        if blocks > (self.rest.len() / encoding.header_size) as u64 {
            let (claimed, left) = (blocks, self.rest.len());
            return Err(MeshReadError::Claim { place: self.place, claimed, what: "compressed blocks", left });
        }
        let sizes = (0..blocks).map(|_| self.header(encoding)).collect::<Result<Vec<u64>, _>>()?;
        let mut out = Vec::new();
        for (block, size) in sizes.iter().enumerate() {
            let expanded = if block + 1 == sizes.len() && last > 0 { last } else { full };
            if expanded > (needed - out.len()) as u64 {
                return Err(self.wrong_size(out.len() as u64 + expanded, needed));
            }
            let size = usize::try_from(*size).unwrap_or(usize::MAX);
            self.inflate(size, expanded as usize, &mut out)?;
        }
        match out.len() == needed {
            true => Ok(out),
            false => Err(self.wrong_size(out.len() as u64, needed)),
        }
    }

    /// Appends a compressed block of `size` bytes that become `expanded`.
    fn inflate(&mut self, size: usize, expanded: usize, out: &mut Vec<u8>) -> Result<(), MeshReadError> {
        let block = self.take(size)?;
        let before = out.len();
        let read = ZlibDecoder::new(&block[..]).take((expanded as u64).saturating_add(1)).read_to_end(out);
        let damaged = |reason| MeshReadError::Damaged { place: self.place, part: "the compressed array", reason };
        read.map_err(|e| damaged(e.to_string()))?;
        match out.len() - before == expanded {
            true => Ok(()),
            false => Err(damaged(format!("a block has not the announced {expanded} bytes"))),
        }
    }

    fn header(&mut self, encoding: Encoding) -> Result<u64, MeshReadError> {
        let mut bytes = self.take(encoding.header_size)?;
        if !encoding.little_endian {
            bytes.reverse();
        }
        Ok(bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    fn take(&mut self, count: usize) -> Result<Vec<u8>, MeshReadError> {
        if !self.is_base64 {
            let Some((taken, rest)) = self.rest.split_at_checked(count) else { return Err(self.cut_off()) };
            self.rest = rest;
            return Ok(taken.to_vec());
        }
        let mut out = std::mem::take(&mut self.spare);
        while out.len() < count {
            let (bytes, held) = self.group()?;
            out.extend_from_slice(&bytes[..held]);
        }
        self.spare = out.split_off(count);
        Ok(out)
    }

    /// The one to three bytes of the next four letters.
    fn group(&mut self) -> Result<([u8; 3], usize), MeshReadError> {
        let (mut bits, mut letters, mut padding) = (0u32, 0, 0);
        while letters < 4 {
            let Some((&letter, rest)) = self.rest.split_first() else { return Err(self.cut_off()) };
            self.rest = rest;
            if letter.is_ascii_whitespace() {
                continue;
            }
            let value = match letter {
                b'=' if letters >= 2 => {
                    padding += 1;
                    0
                }
                _ if padding > 0 => return Err(self.no_base64(letter)),
                _ => sextet(letter).ok_or_else(|| self.no_base64(letter))?,
            };
            bits = bits << 6 | u32::from(value);
            letters += 1;
        }
        let [_, a, b, c] = bits.to_be_bytes();
        Ok(([a, b, c], 3 - padding))
    }

    fn cut_off(&self) -> MeshReadError {
        MeshReadError::CutOff { place: self.place, expected: "the rest of an array that begins here" }
    }

    fn no_base64(&self, letter: u8) -> MeshReadError {
        let reason = format!("`{}` is no letter of base64 there", char::from(letter).escape_default());
        MeshReadError::Damaged { place: self.place, part: "the base64 array", reason }
    }

    fn wrong_size(&self, found: u64, needed: usize) -> MeshReadError {
        let found = format!("an array of {found} bytes where {needed} are needed");
        MeshReadError::Unexpected {
            place: self.place,
            found,
            expected: "an array with an entry for each point or cell",
        }
    }
}

const fn sextet(letter: u8) -> Option<u8> {
    Some(match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    })
}
