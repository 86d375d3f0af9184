#![no_main]

use grosgrain::io::vtk::read_vtk_legacy;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = read_vtk_legacy(bytes) {
        let _ = file.into_mesh();
    }
});
