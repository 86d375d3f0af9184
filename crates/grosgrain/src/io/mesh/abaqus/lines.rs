//! Keyword and data lines of an input file.

use crate::io::excerpt::excerpt;
use crate::io::mesh::{MeshReadError, Place};
use std::borrow::Cow;

/// A keyword with its parameters, all in upper case but the values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keyword {
    /// Words with single blanks, e.g. `SOLID SECTION`.
    pub name: String,
    parameters: Vec<(String, String)>,
}

impl Keyword {
    /// From the text after the asterisk.
    fn new(text: &str) -> Self {
        let mut parts = text.split(',');
        let name = parts.next().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ").to_uppercase();
        let parameter = |part: &str| {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            (key.trim().to_uppercase(), value.trim().trim_matches('"').to_owned())
        };
        Self { name, parameters: parts.map(parameter).filter(|(key, _)| !key.is_empty()).collect() }
    }

    /// The value of a parameter, empty if it has none.
    pub fn parameter(&self, key: &str) -> Option<&str> {
        self.parameters.iter().find(|(k, _)| k == key).map(|(_, value)| value.as_str())
    }
}

/// A line that counts.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Line<'a> {
    Keyword(Keyword),
    Data(Cow<'a, str>),
}

type Split<'a> = std::iter::Enumerate<std::slice::Split<'a, u8, fn(&u8) -> bool>>;

/// The lines of a file with their numbers, comments and empty lines left out, keyword lines that go on joined.
pub(super) struct Lines<'a> {
    rest: Split<'a>,
}

fn is_line_end(byte: &u8) -> bool {
    *byte == b'\n'
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes.split(is_line_end as fn(&u8) -> bool).enumerate() }
    }

    /// The next line with something on it, without blanks at its ends.
    fn text(&mut self) -> Option<(Place, Cow<'a, str>)> {
        loop {
            let (at, line) = self.rest.next()?;
            let line = line.trim_ascii();
            if !line.is_empty() && !line.starts_with(b"**") {
                return Some((Place::Line(at + 1), String::from_utf8_lossy(line)));
            }
        }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (Place, Line<'a>);

    fn next(&mut self) -> Option<Self::Item> {
        let (place, text) = self.text()?;
        let Some(first) = text.strip_prefix('*') else { return Some((place, Line::Data(text))) };
        let mut keyword = first.to_owned();
        while keyword.ends_with(',') {
            let Some((_, more)) = self.text() else { break };
            keyword.push_str(&more);
        }
        Some((place, Line::Keyword(Keyword::new(&keyword))))
    }
}

/// The fields of a data line; one that ends with a comma has an empty last field, which is left out.
pub(super) fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.strip_suffix(',').unwrap_or(line).split(',').map(str::trim)
}

/// A number of a node or element.
pub(super) fn integer(field: &str, place: Place) -> Result<i64, MeshReadError> {
    field.parse().map_err(|_| unexpected(field, "a whole number", place))
}

/// A coordinate; an empty field is zero, and Fortran's exponents count.
pub(super) fn real(field: &str, place: Place) -> Result<f64, MeshReadError> {
    if field.is_empty() {
        return Ok(0.0);
    }
    let number = field.parse().or_else(|_| field.replace(['d', 'D'], "e").parse());
    number.map_err(|_| unexpected(field, "a number", place))
}

pub(super) fn unexpected(found: &str, expected: &'static str, place: Place) -> MeshReadError {
    MeshReadError::Unexpected { place, found: excerpt(found), expected }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keywords_comments_and_continued_lines_are_told_apart() {
        let text = b"** comment\n*Solid  Section, elset=\"Set A\",\n material=M1\n\n 1, 2.,\n*node\n";
        let lines: Vec<_> = Lines::new(text).collect();
        assert_eq!(lines.len(), 3);
        let (Place::Line(2), Line::Keyword(section)) = &lines[0] else { panic!("{lines:?}") };
        assert_eq!((section.name.as_str(), section.parameter("ELSET")), ("SOLID SECTION", Some("Set A")));
        assert_eq!((section.parameter("MATERIAL"), section.parameter("TYPE")), (Some("M1"), None));
        let (place, Line::Data(data)) = &lines[1] else { panic!("{lines:?}") };
        assert_eq!((*place, fields(data).collect::<Vec<_>>()), (Place::Line(5), vec!["1", "2."]));
        assert_eq!((real("-1.5D+2", *place).unwrap(), real("", *place).unwrap()), (-150.0, 0.0));
        assert!(integer("1.5", *place).unwrap_err().to_string().starts_with("line 5: `1.5` stands where a whole"));
    }
}
