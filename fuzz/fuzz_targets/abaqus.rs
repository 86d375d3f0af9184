#![no_main]

use grosgrain::io::mesh::read_abaqus;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = read_abaqus(bytes) {
        let _ = file.into_mesh();
    }
});
