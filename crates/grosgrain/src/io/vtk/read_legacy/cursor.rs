//! Lines, words and binary numbers of a legacy file.

use super::super::numbers::NumberType;
use crate::io::excerpt::excerpt;
use crate::io::mesh::{MeshReadError, Place};

/// What is left of a file.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Whether numbers of arrays are binary, most significant byte first.
    pub is_binary: bool,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, is_binary: false }
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The line, or the byte where numbers are binary.
    pub fn place(&self) -> Place {
        match self.is_binary {
            true => Place::Byte(self.at),
            false => Place::Line(1 + self.bytes[..self.at].iter().filter(|b| **b == b'\n').count()),
        }
    }

    pub fn unexpected(&self, found: &str, expected: &'static str) -> MeshReadError {
        MeshReadError::Unexpected { place: self.place(), found: excerpt(found), expected }
    }

    /// The rest of the line, without blanks at its ends.
    pub fn line(&mut self) -> Option<String> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        // A line of binary numbers read by mistake is long; no keyword line is.
        Some(String::from_utf8_lossy(&rest[..length.min(1 << 12)]).trim().to_owned())
    }

    /// The next line with something on it.
    pub fn full_line(&mut self) -> Option<String> {
        loop {
            let line = self.line()?;
            if !line.is_empty() {
                return Some(line);
            }
        }
    }

    /// The next full line, which stays unread.
    pub fn peek(&mut self) -> Option<String> {
        let at = self.at;
        let line = self.full_line();
        self.at = at;
        line
    }

    /// So many numbers. Memory grows with what is there.
    pub fn numbers(&mut self, count: usize, kind: NumberType) -> Result<Vec<f64>, MeshReadError> {
        let left = self.rest().len();
        let least = if self.is_binary { kind.size() } else { 1 };
        let Some(needed) = count.checked_mul(least).filter(|needed| *needed <= left) else {
            return Err(MeshReadError::Claim { place: self.place(), claimed: count as u64, what: "numbers", left });
        };
        if self.is_binary {
            let numbers = kind.numbers(&self.rest()[..needed], false);
            self.at += needed;
            return Ok(numbers);
        }
        (0..count).map(|_| self.number()).collect()
    }

    fn number(&mut self) -> Result<f64, MeshReadError> {
        let rest = self.rest();
        self.at += rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
        let rest = self.rest();
        let word = &rest[..rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len())];
        if word.is_empty() {
            return Err(MeshReadError::CutOff { place: self.place(), expected: "a number" });
        }
        let text = String::from_utf8_lossy(word);
        let number = text.parse().map_err(|_| self.unexpected(&text, "a number"))?;
        self.at += word.len();
        Ok(number)
    }
}
