//! Headers that are lines of text: a field's name and its value.

use super::read_error::excerpt;
use super::{ReadError, VolumeFormat};
use std::str::FromStr;

/// The fields in the order in which they stand.
#[derive(Clone, Debug)]
pub(super) struct Fields {
    format: VolumeFormat,
    entries: Vec<(String, String)>,
}

impl Fields {
    pub const fn new(format: VolumeFormat) -> Self {
        Self { format, entries: Vec::new() }
    }

    pub fn add(&mut self, name: &str, value: &str) {
        self.entries.push((name.into(), value.into()));
    }

    /// The value of the first field that has one of these names.
    pub fn get(&self, names: &[&str]) -> Option<&str> {
        self.entries.iter().find(|(name, _)| names.contains(&name.as_str())).map(|(_, value)| value.as_str())
    }

    /// As `get`, refused where absent.
    pub fn need(&self, names: &[&str], field: &'static str) -> Result<&str, ReadError> {
        self.get(names).ok_or(ReadError::MissingField { format: self.format, field })
    }

    /// Numbers separated by blanks.
    pub fn numbers<T: FromStr>(&self, field: &str, text: &str) -> Result<Vec<T>, ReadError> {
        let numbers = text.split_ascii_whitespace().map(str::parse).collect::<Result<_, _>>();
        numbers.map_err(|_| self.error(field, text, "numbers separated by blanks"))
    }

    /// Exactly N numbers separated by blanks.
    pub fn exactly<T: FromStr, const N: usize>(
        &self,
        field: &str,
        text: &str,
        expected: &'static str,
    ) -> Result<[T; N], ReadError> {
        let numbers: Vec<T> = self.numbers(field, text)?;
        numbers.try_into().map_err(|_| self.error(field, text, expected))
    }

    /// A field with an unusable value; long values are cut.
    pub fn error(&self, field: &str, value: &str, expected: &'static str) -> ReadError {
        ReadError::Field { format: self.format, field: field.into(), value: format!("`{}`", excerpt(value)), expected }
    }
}
