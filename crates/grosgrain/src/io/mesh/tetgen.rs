//! Meshes of TetGen and Triangle: a file of nodes and a file of elements.

use super::scanner::Scanner;
use super::{Contents, MeshFile, MeshReadError, NodeNumbers};

/// Reads the `.node` and the `.ele` file of a mesh of TetGen, or of Triangle in two dimensions; numbers may begin at 0 or 1.
///
/// A cell's tag is its first attribute (its region), which must be a whole number; 0 where there is none.
///
/// # Errors
/// What is damaged, with its line; elements of second order.
pub fn read_tetgen(nodes: &[u8], elements: &[u8]) -> Result<MeshFile, MeshReadError> {
    read_elements(read_nodes(nodes)?, elements)?.into_file()
}

/// What a file of nodes holds.
pub(super) struct Nodes {
    contents: Contents,
    /// Number of coordinates.
    axes: usize,
    numbers: NodeNumbers,
}

/// A word of a line as a number.
fn number<T: std::str::FromStr>(
    text: &Scanner<'_>,
    words: &[&str],
    at: usize,
    expected: &'static str,
) -> Result<T, MeshReadError> {
    let word = words.get(at).copied().unwrap_or("(end of line)");
    word.parse().map_err(|_| text.unexpected(word.as_bytes(), expected))
}

/// Reads a `.node` file.
pub(super) fn read_nodes(bytes: &[u8]) -> Result<Nodes, MeshReadError> {
    let mut contents = Contents::default();
    let mut text = Scanner::with_comments(bytes);
    let header = text.words_of_line("the first line of a .node file: the number of nodes, 2 or 3")?;
    let count: u64 = number(&text, &header, 0, "the number of nodes")?;
    let axes: usize = number(&text, &header, 1, "the number of coordinates, 2 or 3")?;
    if !matches!(axes, 2 | 3) {
        return Err(text.unexpected(header[1].as_bytes(), "the number of coordinates, 2 or 3"));
    }
    let mut of_file = Vec::new();
    for _ in 0..count {
        let words = text.words_of_line("a node: its number and coordinates")?;
        of_file.push(number(&text, &words, 0, "the number of a node")?);
        let mut at = [0.0; 3];
        for (a, x) in at[..axes].iter_mut().enumerate() {
            *x = number(&text, &words, 1 + a, "a coordinate of a node")?;
        }
        contents.nodes.push(at);
    }
    Ok(Nodes { contents, axes, numbers: NodeNumbers::new(&of_file)? })
}

/// Reads the `.ele` file that belongs to nodes.
pub(super) fn read_elements(nodes: Nodes, bytes: &[u8]) -> Result<Contents, MeshReadError> {
    let Nodes { mut contents, axes, numbers } = nodes;
    let mut text = Scanner::with_comments(bytes);
    let header = text.words_of_line("the first line of an .ele file: the number of elements and of their nodes")?;
    let count: u64 = number(&text, &header, 0, "the number of elements")?;
    let corners: usize = number(&text, &header, 1, "the number of nodes of an element")?;
    let attributes: usize = if header.len() > 2 { number(&text, &header, 2, "the number of attributes")? } else { 0 };
    if corners != axes + 1 {
        return Err(MeshReadError::Unsupported {
            what: format!("elements of {corners} nodes in {axes} dimensions"),
            remedy: "mesh without the switch -o2, so that elements have their corners only",
        });
    }
    for _ in 0..count {
        let words = text.words_of_line("an element: its number and nodes")?;
        let mut cell = [0; 4];
        for (n, corner) in cell[..corners].iter_mut().enumerate() {
            let node = number(&text, &words, 1 + n, "the number of a node of an element")?;
            *corner = numbers.position(node, || text.line())?;
        }
        let tag = if attributes > 0 { region(&text, &words, 1 + corners)? } else { 0 };
        contents.add(&cell[..corners], tag);
    }
    Ok(contents)
}

/// A region's attribute: a real number in the format, but a whole one.
fn region(text: &Scanner<'_>, words: &[&str], at: usize) -> Result<i32, MeshReadError> {
    const EXPECTED: &str = "a whole number of 32 bits as attribute (region) of an element";
    let value: f64 = number(text, words, at, EXPECTED)?;
    match value == value.trunc() && (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&value) {
        true => Ok(value as i32),
        false => Err(text.unexpected(words[at].as_bytes(), EXPECTED)),
    }
}
