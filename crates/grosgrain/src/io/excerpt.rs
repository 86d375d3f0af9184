//! Texts of files as they may be shown.

/// The start of a text from a file, fit to be shown on a terminal: no control characters, at most 80 others.
pub(super) fn excerpt(text: &str) -> String {
    let shown = |c: char| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c };
    text.chars().take(80).map(shown).collect()
}
