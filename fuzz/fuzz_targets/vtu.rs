#![no_main]

use grosgrain::io::vtk::read_vtu;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = read_vtu(bytes) {
        let _ = file.into_mesh();
    }
});
