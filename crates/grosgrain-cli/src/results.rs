//! What a command is asked for goes to stdout.

use std::io::{ErrorKind, Write};

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
/// As [`print`].
pub fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value);
    print(&text.map_err(|error| Failure::Failed(format!("the results cannot be written as JSON: {error}")))?)
}

/// Rows of two columns, the first as wide as its widest entry.
pub fn table(rows: &[(String, String)]) -> String {
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let lines: Vec<String> = rows.iter().map(|(name, value)| format!("  {name:width$}  {value}")).collect();
    lines.join("\n")
}
