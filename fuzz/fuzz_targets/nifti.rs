#![no_main]

use grosgrain::io::volume::{read_nifti, read_nifti_pair};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = read_nifti(bytes);
    if let Some((header, image)) = bytes.split_at_checked(352) {
        let _ = read_nifti_pair(header, image);
    }
});
