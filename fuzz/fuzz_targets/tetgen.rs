#![no_main]

use grosgrain::io::mesh::read_tetgen;
use libfuzzer_sys::fuzz_target;

// A zero byte separates the file of nodes from that of elements.
fuzz_target!(|bytes: &[u8]| {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    if let Ok(file) = read_tetgen(&bytes[..end], bytes.get(end + 1..).unwrap_or_default()) {
        let _ = file.into_mesh();
    }
});
