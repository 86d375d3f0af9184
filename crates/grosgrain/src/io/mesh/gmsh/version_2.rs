//! Nodes and elements of versions 2.0 to 2.2.

use super::MeshReadError;
use super::encoding::{Encoding, Numbers};
use super::kind::Kind;
use super::read::Sections;

/// `$Nodes`: a count in text, then number and coordinates of each node.
pub(super) fn read_nodes(sections: &mut Sections, numbers: &mut Numbers<'_>) -> Result<(), MeshReadError> {
    let count: u64 = numbers.scanner.parse("the number of nodes")?;
    numbers.scanner.end_line();
    let mut of_file = Vec::new();
    for _ in 0..count {
        of_file.push(i64::from(numbers.int("the number of a node")?));
        sections.contents.nodes.push(numbers.point()?);
    }
    sections.set_numbers(&of_file)?;
    numbers.scanner.expect("$EndNodes")
}

/// `$Elements`: a count in text, then number, kind, tags and nodes of each element; binary ones in blocks of one kind.
pub(super) fn read_elements(sections: &mut Sections, numbers: &mut Numbers<'_>) -> Result<(), MeshReadError> {
    let count: u64 = numbers.scanner.parse("the number of elements")?;
    numbers.scanner.end_line();
    let mut read = 0;
    while read < count {
        if numbers.encoding == Encoding::Text {
            numbers.int("the number of an element")?;
            let (kind, tags) = (kind(numbers)?, tag_count(numbers)?);
            read_element(sections, numbers, kind, tags)?;
            read += 1;
            continue;
        }
        let (kind, elements, tags) = (kind(numbers)?, block_length(numbers)?, tag_count(numbers)?);
        for _ in 0..elements {
            numbers.int("the number of an element")?;
            read_element(sections, numbers, kind, tags)?;
        }
        read += u64::from(elements);
    }
    numbers.scanner.expect("$EndElements")
}

/// Tags and nodes of one element: the first tag is its physical group, the second its geometric entity.
fn read_element(
    sections: &mut Sections,
    numbers: &mut Numbers<'_>,
    kind: Kind,
    tags: u32,
) -> Result<(), MeshReadError> {
    let mut found = [0; 2];
    for n in 0..tags {
        let tag = numbers.int("a tag of an element")?;
        if let Some(place) = found.get_mut(n as usize) {
            *place = tag;
        }
    }
    let mut nodes = [0; Kind::MOST_NODES];
    for node in &mut nodes[..kind.nodes] {
        *node = i64::from(numbers.int("the number of a node of an element")?);
    }
    sections.add(kind, &nodes[..kind.nodes], found, || numbers.place())
}

fn kind(numbers: &mut Numbers<'_>) -> Result<Kind, MeshReadError> {
    let number = numbers.int("the kind of an element")?;
    Kind::of_number(number).ok_or_else(|| numbers.unexpected(number.into(), "a kind of element of Gmsh up to order 4"))
}

fn block_length(numbers: &mut Numbers<'_>) -> Result<u32, MeshReadError> {
    const EXPECTED: &str = "the number of elements of a block";
    let count = numbers.int(EXPECTED)?;
    u32::try_from(count).ok().filter(|c| *c > 0).ok_or_else(|| numbers.unexpected(count.into(), EXPECTED))
}

fn tag_count(numbers: &mut Numbers<'_>) -> Result<u32, MeshReadError> {
    const EXPECTED: &str = "the number of tags of an element";
    let count = numbers.int(EXPECTED)?;
    u32::try_from(count).map_err(|_| numbers.unexpected(count.into(), EXPECTED))
}
