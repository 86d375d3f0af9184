//! What a command is asked for goes to stdout or to files.

use std::io::{ErrorKind, Write};
use std::path::Path;

use crate::failure::Failure;

/// Writes `text` and a line end to stdout.
///
/// # Errors
/// [`Failure::ReaderGone`] if the reader of a pipe has left; anything else that keeps the text from being written.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush());
    written.map_err(|error| match error.kind() {
        ErrorKind::BrokenPipe => Failure::ReaderGone,
        _ => Failure::Failed(format!("the results cannot be written to stdout: {error}")),
    })
}

/// Writes a value as JSON to stdout.
///
/// # Errors
/// As [`print()`].
pub fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value);
    print(&text.map_err(|error| Failure::Failed(format!("the results cannot be written as JSON: {error}")))?)
}

/// Writes a value as JSON to a file, whole or not at all.
///
/// # Errors
/// A file that cannot be written.
pub fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), Failure> {
    let failed =
        |error: &dyn std::fmt::Display| Failure::Failed(format!("{} cannot be written: {error}", path.display()));
    let text = serde_json::to_string_pretty(value).map_err(|error| failed(&error))?;
    let write = |writer: &mut std::io::BufWriter<std::fs::File>| writeln!(writer, "{text}");
    grosgrain::io::write_atomically(path, write).map_err(|error| failed(&error))
}

/// Rows of any number of columns: the first to the left, the others to the right.
pub fn columns<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |c: usize| rows.iter().map(|row| row[c].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let line = |row: &[String; N]| {
        let cells = (0..N).map(|c| match c {
            0 => format!("{:<w$}", row[0], w = widths[0]),
            _ => format!("{:>w$}", row[c], w = widths[c]),
        });
        format!("  {}", cells.collect::<Vec<_>>().join("  "))
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Rows of two columns, the first as wide as its widest entry.
pub fn table(rows: &[(String, String)]) -> String {
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let lines: Vec<String> = rows.iter().map(|(name, value)| format!("  {name:width$}  {value}")).collect();
    lines.join("\n")
}
