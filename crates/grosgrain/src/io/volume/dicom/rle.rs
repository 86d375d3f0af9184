//! Run-length encoded pixels: one segment per byte of a pixel, most significant first, each in PackBits.

use super::super::ReadError;
use super::error::DicomError;

/// The pixels of a grey frame as little-endian words of `width` bytes.
///
/// # Errors
/// A wrong number of segments, segments outside the frame or too short.
pub(super) fn decode(frame: &[u8], pixels: usize, width: usize) -> Result<Vec<u8>, ReadError> {
    let (header, _) = frame.as_chunks::<4>();
    let entry = |index: usize| header.get(index).map(|word| u32::from_le_bytes(*word) as usize);
    if entry(0) != Some(width) || width > 8 {
        return Err(damaged(0, "the number of run-length segments is not the number of bytes per pixel"));
    }
    let mut planes = Vec::new();
    for segment in 0..width {
        let start = entry(segment + 1).unwrap_or(0);
        let end = if segment + 1 < width { entry(segment + 2).unwrap_or(0) } else { frame.len() };
        let packed =
            frame.get(start..end).ok_or_else(|| damaged(start, "a run-length segment lies outside its frame"))?;
        planes.push(unpack(packed, pixels)?);
    }
    let byte = |pixel: usize, significance: usize| planes[width - 1 - significance][pixel];
    Ok((0..pixels).flat_map(|pixel| (0..width).map(move |s| (pixel, s))).map(|(pixel, s)| byte(pixel, s)).collect())
}

/// PackBits: n < 128 copies n + 1 bytes, n > 128 repeats the next byte 257 − n times.
fn unpack(mut packed: &[u8], pixels: usize) -> Result<Vec<u8>, ReadError> {
    let mut plane = Vec::new();
    while plane.len() < pixels {
        packed = match packed {
            [n @ 0..128, rest @ ..] if rest.len() > usize::from(*n) => {
                let (copied, rest) = rest.split_at(usize::from(*n) + 1);
                plane.extend_from_slice(copied);
                rest
            }
            [128, rest @ ..] => rest,
            [n @ 129..=255, byte, rest @ ..] => {
                plane.resize(plane.len() + 257 - usize::from(*n), *byte);
                rest
            }
            _ => {
                let (needed, found) = (pixels as u64, plane.len() as u64);
                return Err(ReadError::Truncated { part: "run-length encoded pixels", needed, found });
            }
        };
    }
    plane.truncate(pixels);
    Ok(plane)
}

fn damaged(at: usize, reason: &'static str) -> ReadError {
    DicomError::Damaged { at, reason }.into()
}
