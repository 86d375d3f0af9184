//! Compressed voxel data, expanded no further than the header asks for.

use super::ReadError;
use flate2::bufread::{GzDecoder, ZlibDecoder};
use std::io::Read;

/// Whether a gzip stream starts here.
pub(super) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// The first `needed` bytes of a gzip stream (of one or several members) or a zlib stream.
///
/// Memory grows with what the stream really holds, never with `needed`. The checksum of the stream is
/// verified if it ends with these bytes; rubbish after it is not looked at.
///
/// # Errors
/// A damaged stream, or one that holds less.
pub(super) fn inflate(stream: &[u8], needed: usize, part: &'static str) -> Result<Vec<u8>, ReadError> {
    let mut out = Vec::new();
    let mut rest = stream;
    loop {
        rest = match is_gzip(rest) {
            true => inflate_member(GzDecoder::new(rest), needed, &mut out)?.into_inner(),
            false => inflate_member(ZlibDecoder::new(rest), needed, &mut out)?.into_inner(),
        };
        match out.len() == needed {
            true => return Ok(out),
            false if is_gzip(rest) => {}
            false => {
                let found = out.len() as u64;
                return Err(ReadError::Truncated { part, needed: needed as u64, found });
            }
        }
    }
}

/// Up to `count` bytes from the start of a gzip stream.
pub(super) fn inflate_at_most(stream: &[u8], count: usize) -> Result<Vec<u8>, ReadError> {
    let mut out = Vec::new();
    GzDecoder::new(stream).take(count as u64).read_to_end(&mut out).map_err(ReadError::Compression)?;
    Ok(out)
}

/// Appends to `out` until it holds `needed` bytes or the member ends.
fn inflate_member<R: Read>(mut member: R, needed: usize, out: &mut Vec<u8>) -> Result<R, ReadError> {
    let missing = (needed - out.len()) as u64;
    (&mut member).take(missing).read_to_end(out).map_err(ReadError::Compression)?;
    if out.len() == needed {
        // One byte further: at the end of the member its checksum is verified.
        member.read(&mut [0]).map_err(ReadError::Compression)?;
    }
    Ok(member)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::{GzEncoder, ZlibEncoder};
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn members_are_joined_and_trailing_rubbish_is_ignored() {
        let stream = [gzip(b"abc"), gzip(b"defg"), b"rubbish".to_vec()].concat();
        assert_eq!(inflate(&stream, 7, "voxel data").unwrap(), b"abcdefg");
        assert_eq!(inflate(&stream, 5, "voxel data").unwrap(), b"abcde");
        let error = inflate(&stream, 8, "voxel data").unwrap_err();
        assert!(matches!(error, ReadError::Truncated { needed: 8, found: 7, .. }), "{error}");
    }

    #[test]
    fn a_wrong_checksum_is_refused() {
        let mut stream = gzip(b"abcdefg");
        let checksum = stream.len() - 8;
        stream[checksum] ^= 1;
        assert!(matches!(inflate(&stream, 7, "voxel data"), Err(ReadError::Compression(_))));
    }

    #[test]
    fn zlib_streams_are_read_too() {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(b"abcdefg").unwrap();
        assert_eq!(inflate(&encoder.finish().unwrap(), 7, "voxel data").unwrap(), b"abcdefg");
    }

    #[test]
    fn a_lying_size_costs_no_memory() {
        let error = inflate(&gzip(b"abc"), usize::MAX / 2, "voxel data").unwrap_err();
        assert!(matches!(error, ReadError::Truncated { found: 3, .. }), "{error}");
    }
}
