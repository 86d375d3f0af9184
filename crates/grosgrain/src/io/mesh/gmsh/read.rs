//! Reading the sections of a Gmsh file.

use super::super::scanner::Scanner;
use super::super::{Contents, MeshFile, NodeNumbers};
use super::encoding::{Encoding, Numbers};
use super::kind::Kind;
use super::{MeshReadError, Place, version_2, version_4};
use std::collections::BTreeMap;

/// What has been read so far.
#[derive(Default)]
pub(super) struct Sections {
    pub contents: Contents,
    pub numbers: Option<NodeNumbers>,
    /// First physical group of an entity of a dimension; version 4.
    pub physical: BTreeMap<(i32, i32), i32>,
}

impl Sections {
    /// Adds an element whose nodes have these numbers in the file.
    pub fn add(
        &mut self,
        kind: Kind,
        nodes: &[i64],
        [physical, entity]: [i32; 2],
        place: impl Fn() -> Place,
    ) -> Result<(), MeshReadError> {
        if !kind.is_simplex() {
            self.contents.add_other(kind.dimension, kind.plural, 1);
            return Ok(());
        }
        let numbers = self.numbers.as_ref().ok_or(MeshReadError::Missing {
            section: "$Nodes before $Elements",
            remedy: "save the whole mesh in one file with Gmsh",
        })?;
        let mut corners = [0; 4];
        for (corner, node) in corners.iter_mut().zip(nodes) {
            *corner = numbers.position(*node, &place)?;
        }
        self.contents.add_or(&corners[..kind.dimension + 1], physical, entity);
        Ok(())
    }

    /// Takes the numbers of the nodes that have been read.
    pub fn set_numbers(&mut self, numbers: &[i64]) -> Result<(), MeshReadError> {
        if self.numbers.is_some() {
            return Err(MeshReadError::Unsupported {
                what: "a Gmsh file with several $Nodes sections".into(),
                remedy: "open it in Gmsh and save it as one mesh",
            });
        }
        self.numbers = Some(NodeNumbers::new(numbers)?);
        Ok(())
    }
}

/// The version of a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

/// Reads a Gmsh mesh (`.msh`): versions 2.0 to 2.2 and 4.1, text or binary of either byte order.
///
/// A cell's tag is its first physical group; where no cell of the body is in any, the number of its geometric entity.
///
/// # Errors
/// What is damaged, with its line or byte; other versions, partitioned meshes; elements of the highest dimension that are no simplices of first order.
pub fn read_gmsh(bytes: &[u8]) -> Result<MeshFile, MeshReadError> {
    let mut scanner = Scanner::new(bytes);
    skip_to_format(&mut scanner)?;
    let (version, encoding) = read_format(&mut scanner)?;
    let mut numbers = Numbers { scanner, encoding };
    let mut sections = Sections::default();
    while let Some(word) = numbers.scanner.next_word() {
        let Some(name) = word.strip_prefix(b"$") else {
            return Err(numbers.scanner.unexpected(word, "a section, e.g. $Nodes"));
        };
        let name = name.to_owned();
        numbers.scanner.end_line();
        read_section(&mut sections, &mut numbers, version, &name)?;
    }
    if sections.numbers.is_none() {
        return Err(MeshReadError::Missing {
            section: "$Nodes",
            remedy: "save the mesh itself, not only its geometry",
        });
    }
    sections.contents.into_file()
}

fn skip_to_format(scanner: &mut Scanner<'_>) -> Result<(), MeshReadError> {
    match scanner.next_word() {
        Some(b"$MeshFormat") => Ok(()),
        Some(b"$NOD") => Err(unsupported_version("1")),
        Some(b"$Comments") if scanner.skip_behind(b"$EndComments") => scanner.expect("$MeshFormat"),
        Some(word) => Err(scanner.unexpected(word, "$MeshFormat")),
        None => Err(MeshReadError::CutOff { place: Place::Line(1), expected: "$MeshFormat" }),
    }
}

fn unsupported_version(version: &str) -> MeshReadError {
    MeshReadError::Unsupported {
        what: format!("version {version} of Gmsh's mesh format"),
        remedy: "save it as version 4.1: `gmsh IN.msh -save -format msh41 -o OUT.msh`",
    }
}

fn read_format(scanner: &mut Scanner<'_>) -> Result<(Version, Encoding), MeshReadError> {
    let number: String = scanner.parse("a version")?;
    let version = match number.as_str() {
        "2" | "2.0" | "2.1" | "2.2" => Version::Two,
        "4.1" => Version::Four,
        _ => return Err(unsupported_version(&crate::io::excerpt::excerpt(&number))),
    };
    let is_binary = match scanner.parse::<u8>("0 (text) or 1 (binary)")? {
        0 => false,
        1 => true,
        other => return Err(scanner.unexpected(other.to_string().as_bytes(), "0 (text) or 1 (binary)")),
    };
    let size: u8 = scanner.parse("the size of numbers, 4 or 8")?;
    let encoding = match (is_binary, size) {
        (false, _) => Encoding::Text,
        (true, 4 | 8) => {
            scanner.end_line();
            let wide = version == Version::Four && size == 8;
            Encoding::Binary { big_endian: is_big_endian(scanner)?, wide }
        }
        _ => return Err(scanner.unexpected(size.to_string().as_bytes(), "the size of numbers, 4 or 8")),
    };
    scanner.expect("$EndMeshFormat")?;
    Ok((version, encoding))
}

fn is_big_endian(scanner: &mut Scanner<'_>) -> Result<bool, MeshReadError> {
    const ONE: &str = "a binary 1 of four bytes that shows the byte order";
    match scanner.raw::<4>(ONE)? {
        [1, 0, 0, 0] => Ok(false),
        [0, 0, 0, 1] => Ok(true),
        other => Err(MeshReadError::Unexpected {
            place: Place::Byte(scanner.offset() - 4),
            found: format!("{other:02x?}"),
            expected: ONE,
        }),
    }
}

fn read_section(
    sections: &mut Sections,
    numbers: &mut Numbers<'_>,
    version: Version,
    name: &[u8],
) -> Result<(), MeshReadError> {
    match (name, version) {
        (b"PhysicalNames", _) => read_names(&mut sections.contents, &mut numbers.scanner),
        (b"Entities", Version::Four) => version_4::read_entities(sections, numbers),
        (b"Nodes", Version::Two) => version_2::read_nodes(sections, numbers),
        (b"Nodes", Version::Four) => version_4::read_nodes(sections, numbers),
        (b"Elements", Version::Two) => version_2::read_elements(sections, numbers),
        (b"Elements", Version::Four) => version_4::read_elements(sections, numbers),
        (b"PartitionedEntities", _) => Err(MeshReadError::Unsupported {
            what: "a partitioned Gmsh mesh".into(),
            remedy: "open it in Gmsh, choose Mesh > Unpartition (`gmsh.model.mesh.unpartition()`) and save it again",
        }),
        _ => {
            let end = [b"$End", name].concat();
            match numbers.scanner.skip_behind(&end) {
                true => Ok(()),
                false => Err(MeshReadError::CutOff { place: numbers.place(), expected: "the end of a section" }),
            }
        }
    }
}

/// Lines of dimension, number and a name in quotes; text in every file.
fn read_names(contents: &mut Contents, scanner: &mut Scanner<'_>) -> Result<(), MeshReadError> {
    let count: u64 = scanner.parse("the number of physical names")?;
    for _ in 0..count {
        let dimension: usize = scanner.parse("the dimension of a physical group")?;
        let tag: i32 = scanner.parse("the number of a physical group")?;
        let line = scanner.rest_of_line();
        let name = line.strip_prefix('"').and_then(|l| l.strip_suffix('"'));
        let name = name.ok_or_else(|| scanner.unexpected(line.as_bytes(), "a name in quotes"))?;
        contents.names.push((dimension, tag, name.replace(char::is_control, "\u{fffd}")));
    }
    scanner.expect("$EndPhysicalNames")
}
