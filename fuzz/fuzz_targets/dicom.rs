#![no_main]

use grosgrain::io::volume::read_dicom;
use libfuzzer_sys::fuzz_target;

/// A sound slice, so that the checks of a series are reached too.
static SOUND: &[u8] = include_bytes!("../../crates/grosgrain/tests/fixtures/volumes/dicom_explicit/a.dcm");

fuzz_target!(|bytes: &[u8]| {
    let _ = read_dicom([("fuzzed", bytes)]);
    let _ = read_dicom([("sound", SOUND), ("fuzzed", bytes)]);
});
