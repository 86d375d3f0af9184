#![no_main]

use grosgrain::io::volume::read_metaimage;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = read_metaimage(bytes);
});
