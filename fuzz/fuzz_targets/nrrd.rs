#![no_main]

use grosgrain::io::volume::read_nrrd;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = read_nrrd(bytes);
});
