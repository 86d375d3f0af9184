//! Words, numbers and raw bytes of a file, with the place of each.

use super::{MeshReadError, Place};
use crate::io::excerpt::excerpt;
use std::str::FromStr;

/// Longest word that is looked at, in bytes; longer ones are no numbers and no keywords.
const LONGEST_WORD: usize = 256;

/// A position in a file that moves forward.
#[derive(Clone, Debug)]
pub(in crate::io) struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Where the word that was read last begins.
    word_at: usize,
    /// Whether `#` begins a comment to the end of its line.
    comments: bool,
}

impl<'a> Scanner<'a> {
    /// A text in which nothing is a comment, or bytes.
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, word_at: 0, comments: false }
    }

    /// A text in which `#` begins comments.
    pub const fn with_comments(bytes: &'a [u8]) -> Self {
        Self { comments: true, ..Self::new(bytes) }
    }

    /// The line of the word that was read last.
    pub fn line(&self) -> Place {
        Place::Line(1 + self.bytes[..self.word_at].iter().filter(|b| **b == b'\n').count())
    }

    /// Offset of the next byte.
    pub const fn offset(&self) -> usize {
        self.at
    }

    /// The next word, `None` at the end.
    pub fn next_word(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        self.word_at = self.at;
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|b| b.is_ascii_whitespace()).unwrap_or(rest.len());
        self.at += length;
        (length > 0).then_some(&rest[..length])
    }

    fn skip_blanks(&mut self) {
        while let Some(byte) = self.bytes.get(self.at) {
            match byte {
                b'#' if self.comments => self.end_line(),
                b if b.is_ascii_whitespace() => self.at += 1,
                _ => return,
            }
        }
    }

    /// The next word as a number or whatever else.
    pub fn parse<T: FromStr>(&mut self, expected: &'static str) -> Result<T, MeshReadError> {
        let word = self.next_word().ok_or_else(|| self.cut_off(expected))?;
        let text = (word.len() <= LONGEST_WORD).then(|| std::str::from_utf8(word).ok()).flatten();
        text.and_then(|t| t.parse().ok()).ok_or_else(|| self.unexpected(word, expected))
    }

    /// The next word, which must be this one.
    pub fn expect(&mut self, word: &'static str) -> Result<(), MeshReadError> {
        match self.next_word() {
            Some(found) if found == word.as_bytes() => Ok(()),
            Some(found) => Err(self.unexpected(found, word)),
            None => Err(self.cut_off(word)),
        }
    }

    /// Goes to the start of the next line.
    pub fn end_line(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|b| *b == b'\n').map_or(rest.len(), |n| n + 1);
    }

    /// The rest of the line, without blanks at its ends; goes to the next line.
    pub fn rest_of_line(&mut self) -> String {
        let start = self.at;
        self.end_line();
        self.word_at = start;
        String::from_utf8_lossy(&self.bytes[start..self.at]).trim().to_owned()
    }

    /// The words of the next line that has any; goes to the line after it.
    pub fn words_of_line(&mut self, expected: &'static str) -> Result<Vec<&'a str>, MeshReadError> {
        self.skip_blanks();
        let start = self.at;
        self.word_at = start;
        self.end_line();
        let line = &self.bytes[start..self.at];
        let end = line.iter().position(|b| self.comments && *b == b'#').unwrap_or(line.len());
        if end == 0 {
            return Err(self.cut_off(expected));
        }
        let text = std::str::from_utf8(&line[..end]).map_err(|_| self.unexpected(&line[..end], expected))?;
        Ok(text.split_ascii_whitespace().collect())
    }

    /// The next N raw bytes.
    pub fn raw<const N: usize>(&mut self, expected: &'static str) -> Result<[u8; N], MeshReadError> {
        match self.bytes[self.at..].first_chunk::<N>() {
            Some(chunk) => {
                self.at += N;
                Ok(*chunk)
            }
            None => Err(MeshReadError::CutOff { place: Place::Byte(self.bytes.len()), expected }),
        }
    }

    /// Goes behind the next occurrence of a mark; whether there is one.
    pub fn skip_behind(&mut self, mark: &[u8]) -> bool {
        let found = self.bytes[self.at..].windows(mark.len().max(1)).position(|window| window == mark);
        self.at = found.map_or(self.bytes.len(), |n| self.at + n + mark.len());
        found.is_some()
    }

    /// What stands at the word that was read last is not what is expected.
    pub fn unexpected(&self, found: &[u8], expected: &'static str) -> MeshReadError {
        let found = String::from_utf8_lossy(&found[..found.len().min(LONGEST_WORD)]);
        MeshReadError::Unexpected { place: self.line(), found: excerpt(found.trim()), expected }
    }

    fn cut_off(&self, expected: &'static str) -> MeshReadError {
        MeshReadError::CutOff { place: self.line(), expected }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_numbers_come_with_their_lines() {
        let mut text = Scanner::with_comments(b"# a # comment\n12 3.5e-1# more\n\n end");
        assert_eq!(text.parse::<i32>("a count").unwrap(), 12);
        let error = text.parse::<f64>("a coordinate").unwrap_err();
        assert!(error.to_string().starts_with("line 2: `3.5e-1#` stands where a coordinate is expected"), "{error}");
        text.expect("more").unwrap();
        text.expect("end").unwrap();
        let end = text.parse::<i32>("a count").unwrap_err();
        assert!(end.to_string().starts_with("line 4: the file ends where a count is expected"), "{end}");
    }

    #[test]
    fn lines_are_read_without_comments_and_empty_ones_skipped() {
        let mut text = Scanner::with_comments(b"\n# first\n1 2 3 # x\n4\n");
        assert_eq!(text.words_of_line("numbers").unwrap(), ["1", "2", "3"]);
        assert_eq!((text.words_of_line("numbers").unwrap(), text.line()), (vec!["4"], Place::Line(4)));
        assert!(text.words_of_line("numbers").is_err());
    }

    #[test]
    fn bytes_are_not_read_past_the_end_and_marks_are_found() {
        let mut data = Scanner::new(b"ab$Endcd");
        assert!(data.skip_behind(b"$End") && !data.clone().skip_behind(b"$End"));
        assert_eq!(data.raw::<2>("two bytes").unwrap(), *b"cd");
        assert!(matches!(data.raw::<1>("a byte").unwrap_err(), MeshReadError::CutOff { place: Place::Byte(8), .. }));
    }
}
