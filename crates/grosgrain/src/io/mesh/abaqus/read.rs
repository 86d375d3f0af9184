//! Reading Abaqus input files.

use super::elements::ElementKind;
use super::lines::{Keyword, Line, Lines, fields, integer, real, unexpected};
use super::sets::{ElementSets, Origin};
use crate::io::excerpt::excerpt;
use crate::io::mesh::{Contents, MeshFile, MeshReadError, NodeNumbers, Place};
use std::collections::BTreeSet;

/// Reads the body in an Abaqus input file: `*NODE` and `*ELEMENT` with tetrahedra (C3D4 and its kin), triangles (CPE3, CPS3, S3, …) or trusses.
///
/// Tags are numbers of element sets: of those that a section names (`*SOLID SECTION`), else of `*ELSET`, else of `*ELEMENT`; the smallest one where an element is in several.
/// A set `TAG_n` gives the tag n; other sets that count get numbers from 1 in the order in which they stand, and their names are kept.
///
/// # Errors
/// Damaged lines, several parts, nodes or elements that keywords generate or other files hold, coordinates that are not Cartesian, bodies of other elements than simplices.
pub fn read_abaqus(bytes: &[u8]) -> Result<MeshFile, MeshReadError> {
    let mut deck = Deck::default();
    let mut block = Block::Skipped;
    for (place, line) in Lines::new(bytes) {
        match line {
            Line::Keyword(keyword) => block = deck.open(&keyword, place)?,
            Line::Data(line) => deck.data(&line, &mut block, place)?,
        }
    }
    if let Some(&(place, ..)) = deck.unfinished.first() {
        return Err(MeshReadError::CutOff { place, expected: "the rest of an element" });
    }
    deck.into_file()
}

/// What data lines mean after a keyword.
enum Block {
    Nodes,
    Elements(ElementKind, Option<usize>),
    Set { set: usize, generate: bool },
    Instance,
    Skipped,
}

/// A simplex: where it stands, its number, numbers of its nodes.
type Element = (Place, i64, Vec<i64>);

#[derive(Default)]
struct Deck {
    numbers: Vec<i64>,
    contents: Contents,
    elements: Vec<Element>,
    /// The element whose nodes go on in the next line, if any.
    unfinished: Vec<Element>,
    sets: ElementSets,
    parts: usize,
    /// Whether the line before ended within an element that is not kept.
    is_inside: bool,
    unknown: BTreeSet<String>,
}

impl Deck {
    fn open(&mut self, keyword: &Keyword, place: Place) -> Result<Block, MeshReadError> {
        if let Some((place, ..)) = self.unfinished.first() {
            return Err(MeshReadError::CutOff { place: *place, expected: "the rest of an element" });
        }
        let unsupported =
            |what: &str, remedy| Err(MeshReadError::Unsupported { what: format!("{place}: {what}"), remedy });
        let name = keyword.name.as_str();
        match name {
            "NODE" | "ELEMENT" | "INCLUDE" if name == "INCLUDE" || keyword.parameter("INPUT").is_some() => {
                unsupported("an input file that refers to another file", "paste that file into it")
            }
            "NODE" if !matches!(keyword.parameter("SYSTEM"), None | Some("R" | "r")) => {
                unsupported("coordinates in a system that is not Cartesian", "export Cartesian coordinates")
            }
            "SYSTEM" => unsupported("a coordinate system of its own (*SYSTEM)", "export global coordinates"),
            "NGEN" | "NFILL" | "NCOPY" | "NMAP" | "ELGEN" | "ELCOPY" => unsupported(
                "a mesh that keywords generate",
                "write the file from a pre-processor that lists nodes and elements",
            ),
            "PART" => {
                self.parts += 1;
                Ok(Block::Skipped)
            }
            "INSTANCE" => Ok(Block::Instance),
            "NODE" => Ok(Block::Nodes),
            "ELEMENT" => {
                let kind = ElementKind::of_type(keyword.parameter("TYPE").unwrap_or_default());
                let set = keyword.parameter("ELSET").map(|set| self.sets.open(set, Origin::Elements));
                self.is_inside = false;
                Ok(Block::Elements(kind, set))
            }
            "ELSET" if keyword.parameter("INTERNAL").is_none() => {
                let Some(name) = keyword.parameter("ELSET") else {
                    return Err(unexpected("*ELSET", "*ELSET with a parameter ELSET=", place));
                };
                let set = self.sets.open(name, Origin::Set);
                Ok(Block::Set { set, generate: keyword.parameter("GENERATE").is_some() })
            }
            "SOLID SECTION" | "SHELL SECTION" | "MEMBRANE SECTION" | "BEAM SECTION" => {
                if let Some(set) = keyword.parameter("ELSET") {
                    self.sets.open(set, Origin::Section);
                }
                Ok(Block::Skipped)
            }
            _ => Ok(Block::Skipped),
        }
    }

    fn data(&mut self, line: &str, block: &mut Block, place: Place) -> Result<(), MeshReadError> {
        match *block {
            Block::Nodes => self.node(line, place),
            Block::Elements(ElementKind::Simplex(corners), set) => self.simplex(line, corners, set, place),
            Block::Elements(ElementKind::Other(axes, plural), _) => {
                if !self.is_inside {
                    self.contents.add_other(axes, plural, 1);
                }
                self.is_inside = line.ends_with(',');
                Ok(())
            }
            Block::Set { set, generate } => self.set_line(line, set, generate, place),
            Block::Instance => {
                self.contents
                    .notes
                    .push("the placement of an instance, which leaves the shape of the body as it is".into());
                *block = Block::Skipped;
                Ok(())
            }
            Block::Skipped => Ok(()),
        }
    }

    fn node(&mut self, line: &str, place: Place) -> Result<(), MeshReadError> {
        let mut fields = fields(line);
        self.numbers.push(integer(fields.next().unwrap_or_default(), place)?);
        let mut at = [0.0; 3];
        for (x, field) in at.iter_mut().zip(fields) {
            *x = real(field, place)?;
        }
        self.contents.nodes.push(at);
        Ok(())
    }

    fn simplex(&mut self, line: &str, corners: usize, set: Option<usize>, place: Place) -> Result<(), MeshReadError> {
        let mut numbers = fields(line).map(|field| integer(field, place));
        let mut element = match self.unfinished.pop() {
            Some(element) => element,
            None => (place, numbers.next().unwrap_or(Ok(0))?, Vec::with_capacity(corners)),
        };
        for node in numbers {
            element.2.push(node?);
        }
        match element.2.len() {
            found if found < corners && line.ends_with(',') => self.unfinished.push(element),
            found if found == corners => {
                if let Some(set) = set {
                    self.sets.add_range(set, element.1, element.1, 1);
                }
                self.elements.push(element);
            }
            found => return Err(unexpected(&format!("{found} nodes"), "as many nodes as the element type has", place)),
        }
        Ok(())
    }

    fn set_line(&mut self, line: &str, set: usize, generate: bool, place: Place) -> Result<(), MeshReadError> {
        if generate {
            let numbers =
                fields(line).filter(|f| !f.is_empty()).map(|f| integer(f, place)).collect::<Result<Vec<_>, _>>()?;
            let (&[first, last] | &[first, last, _]) = &numbers[..] else {
                return Err(unexpected(line, "first and last element and a step", place));
            };
            self.sets.add_range(set, first, last, numbers.get(2).copied().unwrap_or(1));
            return Ok(());
        }
        for field in fields(line).filter(|field| !field.is_empty()) {
            match field.parse() {
                Ok(number) => self.sets.add_range(set, number, number, 1),
                Err(_) if self.sets.add_set(set, field.trim_matches('"')) => {}
                Err(_) => {
                    self.unknown.insert(excerpt(field));
                }
            }
        }
        Ok(())
    }

    fn into_file(mut self) -> Result<MeshFile, MeshReadError> {
        if self.parts > 1 {
            let remedy = "export a single part, or a flat input file without parts and assemblies";
            return Err(MeshReadError::Unsupported {
                what: format!("an input file with {} parts", self.parts),
                remedy,
            });
        }
        let nodes = NodeNumbers::new(&self.numbers)?;
        let body = self.elements.iter().map(|(.., nodes)| nodes.len()).max().unwrap_or(0);
        let is_body = |element: &&Element| element.2.len() == body;
        let numbers: Vec<i64> = self.elements.iter().filter(is_body).map(|(_, number, _)| *number).collect();
        let found = self.sets.tags(&numbers);
        let mut tags = found.tags.iter();
        for (place, _, element) in &self.elements {
            let corner = |node: &i64| nodes.position(*node, || *place);
            let corners = element.iter().map(corner).collect::<Result<Vec<u32>, _>>()?;
            let tag = if corners.len() == body { tags.next().copied().unwrap_or(0) } else { 0 };
            self.contents.add(&corners, tag);
        }
        let axes = body.saturating_sub(1);
        self.contents.names = found.names.into_iter().map(|(tag, name)| (axes, tag, name)).collect();
        if found.in_several > 0 {
            let note = format!("{} elements are in several sets; the smallest one counts", found.in_several);
            self.contents.notes.push(note);
        }
        for name in self.unknown {
            self.contents.notes.push(format!("`{name}` in an element set, which is defined nowhere before"));
        }
        self.contents.into_file()
    }
}
