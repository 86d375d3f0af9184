//! Inline binary data of VTK's XML formats.

use base64::{Engine, engine::general_purpose::STANDARD, write::EncoderWriter};
use flate2::{Compression, write::ZlibEncoder};
use std::io::{self, Write};

/// Bytes per compressed block, before compression.
const BLOCK: usize = 1 << 20;

/// Writes `bytes` as VTK's compressed inline data.
///
/// A header of UInt64 (number of blocks, size of a block, size of the last block if it is smaller and 0 if not,
/// compressed size of each block) in base64, then all compressed blocks as one base64 text.
pub(super) fn write_compressed<W: Write>(writer: &mut W, bytes: &[u8]) -> io::Result<()> {
    let blocks = bytes.chunks(BLOCK).map(compress).collect::<io::Result<Vec<_>>>()?;
    let sizes = [blocks.len(), BLOCK, bytes.len() % BLOCK].into_iter().chain(blocks.iter().map(Vec::len));
    let header: Vec<u8> = sizes.flat_map(|n| (n as u64).to_le_bytes()).collect();
    writer.write_all(STANDARD.encode(header).as_bytes())?;
    let mut encoder = EncoderWriter::new(writer, &STANDARD);
    blocks.iter().try_for_each(|block| encoder.write_all(block))?;
    encoder.finish().map(|_| ())
}

fn compress(block: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(block)?;
    encoder.finish()
}

/// Text as the value of an XML attribute. Control characters, which XML 1.0 cannot carry, become spaces.
pub(super) fn escape(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut out, c| {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
        out
    })
}
