#![no_main]

use grosgrain::io::mesh::read_gmsh;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = read_gmsh(bytes) {
        let _ = file.into_mesh();
    }
});
