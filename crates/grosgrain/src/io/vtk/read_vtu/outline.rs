//! What stands where in a `.vtu` file.

use super::super::numbers::NumberType;
use super::stream::Encoding;
use crate::io::excerpt::excerpt;
use crate::io::mesh::{MeshReadError, Place};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

/// The part of a piece that an array belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Section {
    Points,
    Cells,
    CellData,
}

/// Where the bytes of an array are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Store {
    /// Numbers as text, from this byte of the file.
    Text(usize),
    /// Base64, from this byte of the file.
    Base64(usize),
    /// So many bytes (raw) or letters (base64) after the start of the appended data.
    Appended(usize),
}

#[derive(Clone, Debug)]
pub(super) struct ArrayOutline {
    pub section: Section,
    pub name: String,
    pub kind: Option<NumberType>,
    pub components: usize,
    pub store: Store,
    pub place: Place,
}

/// A piece and its arrays.
#[derive(Clone, Debug)]
pub(super) struct PieceOutline {
    pub points: usize,
    pub cells: usize,
    pub arrays: Vec<ArrayOutline>,
}

/// Appended data: where they start, and whether they are base64.
#[derive(Clone, Copy, Debug)]
pub(super) struct Appended {
    pub start: usize,
    pub is_base64: bool,
}

#[derive(Debug)]
pub(super) struct Outline {
    pub encoding: Encoding,
    pub pieces: Vec<PieceOutline>,
    pub appended: Option<Appended>,
}

const APPENDED: &[u8] = b"<AppendedData";

impl Outline {
    /// Reads the mark-up; raw appended data, which are no XML, are not looked at.
    pub fn read(bytes: &[u8]) -> Result<Self, MeshReadError> {
        let end = bytes.windows(APPENDED.len()).position(|w| w == APPENDED).unwrap_or(bytes.len());
        let damaged =
            |at: usize, reason: String| MeshReadError::Damaged { place: Place::Byte(at), part: "the XML", reason };
        let text = |from: usize, to: usize| {
            std::str::from_utf8(&bytes[from..to]).map_err(|e| damaged(from + e.valid_up_to(), "no UTF-8".into()))
        };
        let appended = if end < bytes.len() { Some(read_appended(bytes, end, &text)?) } else { None };
        let mut reader = Reader::from_str(text(0, end)?);
        let mut walk = Walk::default();
        loop {
            let event = reader.read_event().map_err(|e| damaged(reader.error_position() as usize, e.to_string()))?;
            let at = reader.buffer_position() as usize;
            match event {
                Event::Start(tag) => walk.open(&tag, at)?,
                Event::Empty(tag) => {
                    walk.open(&tag, at)?;
                    walk.close(tag.name().0);
                }
                Event::End(tag) => walk.close(tag.name().0),
                Event::Eof => break,
                _ => {}
            }
        }
        if walk.encoding.is_some() && !walk.is_closed && appended.is_none() {
            return Err(MeshReadError::CutOff {
                place: Place::Byte(bytes.len()),
                expected: "the end of the element VTKFile",
            });
        }
        let encoding = walk.encoding.ok_or(MeshReadError::Missing {
            section: "element VTKFile",
            remedy: "give a .vtu file as ParaView, pyvista or meshio write it",
        })?;
        Ok(Self { encoding, pieces: walk.pieces, appended })
    }
}

/// The mark-up so far.
#[derive(Default)]
struct Walk {
    encoding: Option<Encoding>,
    pieces: Vec<PieceOutline>,
    section: Option<Section>,
    /// Whether the end of the file's element has come.
    is_closed: bool,
}

impl Walk {
    /// Takes in the start of an element that ends before byte `at`.
    fn open(&mut self, tag: &BytesStart, at: usize) -> Result<(), MeshReadError> {
        let place = Place::Byte(at);
        match tag.name().0 {
            "VTKFile" => self.encoding = Some(encoding_of(tag, place)?),
            "Piece" => self.pieces.push(PieceOutline {
                points: count(tag, "NumberOfPoints", place)?,
                cells: count(tag, "NumberOfCells", place)?,
                arrays: Vec::new(),
            }),
            "Points" => self.section = Some(Section::Points),
            "Cells" => self.section = Some(Section::Cells),
            "CellData" => self.section = Some(Section::CellData),
            "DataArray" => {
                if let (Some(section), Some(piece)) = (self.section, self.pieces.last_mut()) {
                    piece.arrays.push(array_of(tag, section, at)?);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn close(&mut self, name: &str) {
        if matches!(name, "Points" | "Cells" | "CellData" | "Piece") {
            self.section = None;
        }
        self.is_closed |= name == "VTKFile";
    }
}

fn attribute(tag: &BytesStart, name: &str, place: Place) -> Result<Option<String>, MeshReadError> {
    let damaged = |reason: String| MeshReadError::Damaged { place, part: "the XML", reason };
    let Some(found) = tag.try_get_attribute(name).map_err(|e| damaged(e.to_string()))? else { return Ok(None) };
    let value = found.normalized_value(XmlVersion::Implicit1_0).map_err(|e| damaged(e.to_string()))?;
    Ok(Some(value.into_owned()))
}

fn count(tag: &BytesStart, name: &'static str, place: Place) -> Result<usize, MeshReadError> {
    let value = attribute(tag, name, place)?.unwrap_or_default();
    value.trim().parse().map_err(|_| MeshReadError::Unexpected { place, found: excerpt(&value), expected: name })
}

fn encoding_of(tag: &BytesStart, place: Place) -> Result<Encoding, MeshReadError> {
    let value = |name: &str| attribute(tag, name, place).map(Option::unwrap_or_default);
    let kind = value("type")?;
    if kind != "UnstructuredGrid" {
        let (what, remedy) = (
            format!("a VTK file of type `{}`", excerpt(&kind)),
            "save an unstructured grid in one file (in ParaView: Append Datasets or Merge Blocks, then .vtu)",
        );
        return Err(MeshReadError::Unsupported { what, remedy });
    }
    let compressor = value("compressor")?;
    if !matches!(compressor.as_str(), "" | "vtkZLibDataCompressor") {
        let what = format!("a VTK file compressed by `{}`", excerpt(&compressor));
        return Err(MeshReadError::Unsupported { what, remedy: "save it with the compressor ZLib, or with none" });
    }
    let header_size = match value("header_type")?.as_str() {
        "" | "UInt32" => 4,
        "UInt64" => 8,
        other => {
            let found = excerpt(other);
            return Err(MeshReadError::Unexpected { place, found, expected: "UInt32 or UInt64 as header_type" });
        }
    };
    Ok(Encoding { little_endian: value("byte_order")? != "BigEndian", header_size, compressed: !compressor.is_empty() })
}

fn array_of(tag: &BytesStart, section: Section, at: usize) -> Result<ArrayOutline, MeshReadError> {
    let place = Place::Byte(at);
    let value = |name: &str| attribute(tag, name, place).map(Option::unwrap_or_default);
    let unexpected = |found: &str, expected| MeshReadError::Unexpected { place, found: excerpt(found), expected };
    let components = match value("NumberOfComponents")?.as_str() {
        "" => 1,
        text => text.trim().parse().map_err(|_| unexpected(text, "a number of components"))?,
    };
    let store = match value("format")?.as_str() {
        "ascii" | "" => Store::Text(at),
        "binary" => Store::Base64(at),
        "appended" => {
            let offset = value("offset")?;
            Store::Appended(offset.trim().parse().map_err(|_| unexpected(&offset, "the offset of an array"))?)
        }
        other => return Err(unexpected(other, "ascii, binary or appended as format of an array")),
    };
    let kind = NumberType::of_name(&value("type")?);
    Ok(ArrayOutline { section, name: value("Name")?, kind, components, store, place })
}

/// Where the appended data start, whose element starts at byte `at`.
fn read_appended<'a>(
    bytes: &[u8],
    at: usize,
    text: &impl Fn(usize, usize) -> Result<&'a str, MeshReadError>,
) -> Result<Appended, MeshReadError> {
    let cut_off = |expected| MeshReadError::CutOff { place: Place::Byte(bytes.len()), expected };
    let find = |from: usize, letter: u8| bytes[from..].iter().position(|b| *b == letter).map(|n| from + n);
    let close = find(at, b'>').ok_or_else(|| cut_off("the end of the tag AppendedData"))?;
    let start = find(close, b'_').ok_or_else(|| cut_off("the underscore before appended data"))? + 1;
    let tag = text(at + 1, close)?;
    let is_base64 = tag.contains("base64");
    if !is_base64 && !tag.contains("raw") {
        let (place, found) = (Place::Byte(at), excerpt(tag));
        return Err(MeshReadError::Unexpected { place, found, expected: "raw or base64 as encoding of appended data" });
    }
    Ok(Appended { start, is_base64 })
}
