//! The elements of a DICOM file: tags and values at the top level; sequences are passed over.

use super::super::ReadError;
use super::super::read_error::excerpt;
use super::super::samples::ByteOrder;
use super::error::DicomError;

/// Group and element number.
pub(super) type Tag = (u16, u16);

pub(super) const PIXEL_DATA: Tag = (0x7fe0, 0x0010);
const TRANSFER_SYNTAX: Tag = (0x0002, 0x0010);
const ITEM: Tag = (0xfffe, 0xe000);
const ITEM_END: Tag = (0xfffe, 0xe00d);
const SEQUENCE_END: Tag = (0xfffe, 0xe0dd);
const UNDEFINED: u32 = u32::MAX;
/// Deeper nesting than any standard sequence.
const DEEPEST: usize = 32;

/// Tags and values in the order of the file.
type Elements<'a> = Vec<(Tag, &'a [u8])>;

/// The pixels of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Pixels<'a> {
    Native(&'a [u8]),
    Fragments(Vec<&'a [u8]>),
}

/// The top-level elements of a DICOM file.
#[derive(Debug)]
pub(super) struct DataSet<'a> {
    /// Byte order of numbers.
    pub order: ByteOrder,
    /// Pixels are run-length encoded.
    pub run_length: bool,
    /// `None` in a file without an image.
    pub pixels: Option<Pixels<'a>>,
    elements: Elements<'a>,
}

impl<'a> DataSet<'a> {
    pub fn parse(bytes: &'a [u8]) -> Result<Self, ReadError> {
        if bytes.get(128..132) != Some(b"DICM") {
            return Err(DicomError::NoMark.into());
        }
        let mut cursor = Cursor { bytes, at: 132, order: ByteOrder::Little, explicit: true };
        let mut uid = "";
        while cursor.next_group() == Some(TRANSFER_SYNTAX.0) {
            let element = cursor.header()?;
            let value = cursor.take(element.length)?;
            if element.tag == TRANSFER_SYNTAX {
                uid = trimmed(value);
            }
        }
        let (explicit, order, run_length) = encoding(uid)?;
        cursor = Cursor { explicit, order, ..cursor };
        let (elements, pixels) = cursor.data_set()?;
        Ok(Self { order, run_length, pixels, elements })
    }

    /// The value's bytes; `None` if absent or empty.
    pub fn bytes(&self, tag: Tag) -> Option<&'a [u8]> {
        self.elements.iter().find(|(t, _)| *t == tag).map(|(_, value)| *value).filter(|value| !value.is_empty())
    }

    /// The value as text without padding; empty if absent.
    pub fn text(&self, tag: Tag) -> &'a str {
        self.bytes(tag).map_or("", trimmed)
    }

    /// A 16-bit number.
    pub fn number(&self, tag: Tag) -> Option<u16> {
        let word = self.bytes(tag)?.first_chunk::<2>()?;
        Some(u16::from_le_bytes(self.order.to_little(*word)))
    }

    /// N decimal numbers separated by backslashes.
    pub fn decimals<const N: usize>(&self, tag: Tag, element: &'static str) -> Result<Option<[f64; N]>, DicomError> {
        let text = self.text(tag);
        if text.is_empty() {
            return Ok(None);
        }
        let numbers: Result<Vec<f64>, _> = text.split('\\').map(|n| n.trim().parse()).collect();
        let numbers = numbers.ok().filter(|n| n.iter().all(|v| v.is_finite())).and_then(|n| n.try_into().ok());
        match numbers {
            Some(numbers) => Ok(Some(numbers)),
            None => Err(DicomError::Element {
                element,
                value: excerpt(text),
                expected: match N {
                    1 => "a finite decimal number",
                    _ => "finite decimal numbers separated by backslashes, as many as the element has",
                },
            }),
        }
    }
}

/// Explicit, byte order, run-length encoded.
fn encoding(uid: &str) -> Result<(bool, ByteOrder, bool), DicomError> {
    let name = match uid {
        "1.2.840.10008.1.2" => return Ok((false, ByteOrder::Little, false)),
        "1.2.840.10008.1.2.1" => return Ok((true, ByteOrder::Little, false)),
        "1.2.840.10008.1.2.2" => return Ok((true, ByteOrder::Big, false)),
        "1.2.840.10008.1.2.5" => return Ok((true, ByteOrder::Little, true)),
        "" => return Err(DicomError::Missing("TransferSyntaxUID (0002,0010)")),
        "1.2.840.10008.1.2.1.99" => "deflated",
        _ if uid.starts_with("1.2.840.10008.1.2.4.9") => "JPEG 2000",
        "1.2.840.10008.1.2.4.80" | "1.2.840.10008.1.2.4.81" => "JPEG-LS",
        _ if uid.starts_with("1.2.840.10008.1.2.4.5") || uid.starts_with("1.2.840.10008.1.2.4.7") => "JPEG",
        _ if uid.starts_with("1.2.840.10008.1.2.4.1") => "video or JPEG XL",
        _ if uid.starts_with("1.2.840.10008.1.2.4.20") => "HTJ2K",
        _ => "unknown",
    };
    Err(DicomError::TransferSyntax { uid: excerpt(uid), name })
}

fn trimmed(value: &[u8]) -> &str {
    // Names in other alphabets are of no use here; what matters is ASCII.
    let text = value.utf8_chunks().next().map_or("", |chunk| chunk.valid());
    text.trim_matches(|c: char| c == '\0' || c.is_ascii_whitespace())
}

struct Element {
    tag: Tag,
    length: u32,
    /// Value representation UN, whose sequences are implicit little-endian.
    unknown: bool,
}

#[derive(Clone)]
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    order: ByteOrder,
    explicit: bool,
}

impl<'a> Cursor<'a> {
    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    fn next_group(&self) -> Option<u16> {
        self.rest().first_chunk::<2>().map(|word| u16::from_le_bytes(self.order.to_little(*word)))
    }

    fn take(&mut self, length: u32) -> Result<&'a [u8], ReadError> {
        let rest = self.rest();
        let value = rest.get(..length as usize).ok_or(ReadError::Truncated {
            part: "DICOM elements",
            needed: self.at as u64 + u64::from(length),
            found: self.bytes.len() as u64,
        })?;
        self.at += value.len();
        Ok(value)
    }

    fn word<const N: usize>(&mut self) -> Result<[u8; N], ReadError> {
        let word = self.take(N as u32)?.first_chunk::<N>().copied().unwrap_or([0; N]);
        Ok(self.order.to_little(word))
    }

    fn short(&mut self) -> Result<u16, ReadError> {
        Ok(u16::from_le_bytes(self.word()?))
    }

    fn long(&mut self) -> Result<u32, ReadError> {
        Ok(u32::from_le_bytes(self.word()?))
    }

    fn damaged<T>(&self, reason: &'static str) -> Result<T, ReadError> {
        Err(DicomError::Damaged { at: self.at, reason }.into())
    }

    fn header(&mut self) -> Result<Element, ReadError> {
        let tag = (self.short()?, self.short()?);
        if !self.explicit || tag.0 == ITEM.0 {
            return Ok(Element { tag, length: self.long()?, unknown: false });
        }
        let representation = [self.take(1)?, self.take(1)?].concat();
        let length = match representation.as_slice() {
            b"OB" | b"OD" | b"OF" | b"OL" | b"OV" | b"OW" | b"SQ" | b"SV" | b"UC" | b"UN" | b"UR" | b"UT" | b"UV" => {
                self.short()?;
                self.long()?
            }
            [b'A'..=b'Z', b'A'..=b'Z'] => u32::from(self.short()?),
            _ => return self.damaged("no value representation where one must stand"),
        };
        Ok(Element { tag, length, unknown: representation == b"UN" })
    }

    /// Elements up to the pixels or the end of the file.
    fn data_set(mut self) -> Result<(Elements<'a>, Option<Pixels<'a>>), ReadError> {
        let mut elements = Vec::new();
        while !self.rest().is_empty() {
            let element = self.header()?;
            match (element.tag, element.length) {
                (PIXEL_DATA, UNDEFINED) => return Ok((elements, Some(Pixels::Fragments(self.fragments()?)))),
                (PIXEL_DATA, length) => return Ok((elements, Some(Pixels::Native(self.take(length)?)))),
                (_, UNDEFINED) => self.skip_sequence(element.unknown, 0)?,
                (tag, length) => elements.push((tag, self.take(length)?)),
            }
        }
        Ok((elements, None))
    }

    /// The items of encapsulated pixels; the first, a table of offsets, is left out.
    fn fragments(&mut self) -> Result<Vec<&'a [u8]>, ReadError> {
        let mut fragments = Vec::new();
        loop {
            let element = self.header()?;
            match (element.tag, element.length) {
                (SEQUENCE_END, _) => break,
                (ITEM, length) if length != UNDEFINED => fragments.push(self.take(length)?),
                _ => return self.damaged("compressed pixels are not a sequence of items"),
            }
        }
        match fragments.is_empty() {
            true => self.damaged("compressed pixels have no table of offsets"),
            false => Ok(fragments.split_off(1)),
        }
    }

    fn skip_sequence(&mut self, unknown: bool, depth: usize) -> Result<(), ReadError> {
        if depth > DEEPEST {
            return self.damaged("sequences are nested deeper than 32");
        }
        let (explicit, order) = (self.explicit, self.order);
        if unknown {
            (self.explicit, self.order) = (false, ByteOrder::Little);
        }
        loop {
            let element = self.header()?;
            match (element.tag, element.length) {
                (SEQUENCE_END, _) => break,
                (ITEM, UNDEFINED) => self.skip_item(depth)?,
                (ITEM, length) => drop(self.take(length)?),
                _ => return self.damaged("a sequence holds something that is no item"),
            }
        }
        (self.explicit, self.order) = (explicit, order);
        Ok(())
    }

    fn skip_item(&mut self, depth: usize) -> Result<(), ReadError> {
        loop {
            let element = self.header()?;
            match (element.tag, element.length) {
                (ITEM_END, _) => return Ok(()),
                (_, UNDEFINED) => self.skip_sequence(element.unknown, depth + 1)?,
                (_, length) => drop(self.take(length)?),
            }
        }
    }
}
