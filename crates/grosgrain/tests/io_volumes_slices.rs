//! TIFF stacks and DICOM series that make no volume are refused with a sentence.

use grosgrain::io::read_volume;
use std::path::{Path, PathBuf};

fn fixture_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/volumes").join(name)
}

/// Bytes of a fixture file with the first occurrence of each text replaced by one of the same length.
fn fixture(name: &str, replacements: &[(&[u8], &[u8])]) -> Vec<u8> {
    let mut bytes = std::fs::read(fixture_path(name)).unwrap();
    for (old, new) in replacements {
        assert_eq!(old.len(), new.len());
        let at = bytes.windows(old.len()).position(|w| w == *old).unwrap_or_else(|| panic!("{}", old.escape_ascii()));
        bytes[at..at + new.len()].copy_from_slice(new);
    }
    bytes
}

#[track_caller]
fn refused(path: &Path, texts: &[&str]) {
    let message = read_volume(path).expect_err("must be refused").to_string();
    for text in texts {
        assert!(message.contains(text), "`{text}` is missing in: {message}");
    }
}

/// Writes these files into a folder, reads the folder and checks that it is refused with all these texts.
#[track_caller]
fn folder_refused(files: &[(&str, Vec<u8>)], texts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    refused(folder.path(), texts);
}

#[track_caller]
fn tiff_refused(bytes: &[u8], texts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    std::fs::write(&path, bytes).unwrap();
    refused(&path, texts);
}

/// The directory entry of one number: type 3 has 16 bits, type 4 has 32.
fn entry(tag: u16, kind: u16, value: u16) -> Vec<u8> {
    [tag.to_le_bytes(), kind.to_le_bytes(), [1, 0], [0, 0], value.to_le_bytes()].concat()
}

/// Replaces the value of a one-number tag of the first page of a little-endian TIFF.
fn with_tag(name: &str, (tag, kind): (u16, u16), old: u16, new: u16) -> Vec<u8> {
    fixture(name, &[(&entry(tag, kind, old), &entry(tag, kind, new))])
}

const WIDTH: (u16, u16) = (256, 4);
const COMPRESSION: (u16, u16) = (259, 3);
const PHOTOMETRIC: (u16, u16) = (262, 3);

#[test]
fn damaged_tiff() {
    let whole = fixture("tiff_u2.tif", &[]);
    tiff_refused(&whole[..whole.len() - 200], &["TIFF structure of page"]);
    tiff_refused(b"II*\0", &["TIFF structure of page 1 is damaged"]);
    tiff_refused(&with_tag("tiff_u2.tif", COMPRESSION, 1, 7), &["compression", "without compression"]);
    tiff_refused(&with_tag("tiff_u2.tif", PHOTOMETRIC, 1, 0), &["white as zero"]);
    tiff_refused(&with_tag("tiff_u2.tif", PHOTOMETRIC, 1, 2), &["cannot be read", "grey"]);
}

#[test]
fn lying_tiff_extents() {
    tiff_refused(&with_tag("tiff_u2.tif", WIDTH, 5, 65_535), &["pixels of a TIFF page are cut off", "524280 bytes"]);
    tiff_refused(&with_tag("tiff_u2.tif", WIDTH, 5, 6), &["48 bytes are needed, 40 are there"]);
}

#[test]
fn tiff_pages_and_files_of_different_size() {
    let files = [("1.tif", fixture("tiff_folder/slice_8.tif", &[])), ("2.tif", fixture("tiff_u2.tif", &[]))];
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in &files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    assert_eq!(read_volume(folder.path()).unwrap().cells, [5, 4, 4]);
    let narrow = with_tag("tiff_folder/slice_9.tif", WIDTH, 5, 4);
    folder_refused(
        &[("1.tif", files[0].1.clone()), ("2.tif", narrow)],
        &["2.tif", "page 2 of the TIFF stack has 4 × 4 pixels, the first has 5 × 4"],
    );
}

#[test]
fn several_volumes_in_one_tiff() {
    let frames = fixture("tiff_imagej.tif", &[(b"slices=3", b"frames=3")]);
    tiff_refused(&frames, &["3 time points; choose one", "tifffile"]);
    let shape = fixture("tiff_u2.tif", &[(b"[3, 4, 5]", b"[2,3,4,5]")]);
    tiff_refused(&shape, &["2 volumes; choose one"]);
}

/// The three slices of a DICOM fixture, in the order of their places along z.
fn slices(series: &str) -> Vec<(&'static str, Vec<u8>)> {
    ["c.dcm", "a.dcm", "b.dcm"].map(|name| (name, fixture(&format!("{series}/{name}"), &[]))).to_vec()
}

/// Replaces text of the same length in one slice.
fn changed(series: &str, slice: usize, old: &str, new: &str) -> Vec<(&'static str, Vec<u8>)> {
    let mut slices = slices(series);
    let name = format!("{series}/{}", slices[slice].0);
    slices[slice].1 = fixture(&name, &[(old.as_bytes(), new.as_bytes())]);
    slices
}

const CT: &str = "dicom_explicit";

#[test]
fn several_series_are_listed() {
    let files = changed(CT, 1, "1.2.826.0.1.3680043.10.2", "1.2.826.0.1.3680043.10.3");
    let texts = ["2 series", "7 CT synthetic", "2 slices", "1 slices", "1.2.826.0.1.3680043.10.3", "a.dcm"];
    folder_refused(&files, &texts);
}

#[test]
fn missing_doubled_and_shifted_slices() {
    let distance = changed(CT, 2, "1\\2\\8", "1\\2\\9");
    folder_refused(&distance, &["c.dcm", "a.dcm", "2.5 mm apart where the mean distance is 3 mm", "missing"]);
    let mut doubled = slices(CT);
    doubled.push(("d.dcm", doubled[0].1.clone()));
    folder_refused(&doubled, &["c.dcm", "d.dcm", "both lie at 3 mm", "several volumes"]);
    let shifted = changed(CT, 2, "1\\2\\8", "2\\2\\8");
    folder_refused(&shifted, &["b.dcm", "shifted by 1 mm", "gantry"]);
}

#[test]
fn slices_that_differ() {
    let columns = |n: u8| [0x28, 0, 0x11, 0, b'U', b'S', 2, 0, n, 0];
    let mut files = slices(CT);
    files[2].1 = fixture(&format!("{CT}/b.dcm"), &[(&columns(5), &columns(4))]);
    folder_refused(&files, &["b.dcm has 4 × 4 pixels, the first has 5 × 4"]);
    folder_refused(&changed(CT, 2, "0.75\\0.5", "0.75\\0.6"), &["b.dcm has another pixel spacing"]);
    let turned = changed(CT, 1, "1.0000000000\\0.0000000000\\0.0", "0.9950041653\\0.0998334166\\0.0");
    folder_refused(&turned, &["two perpendicular unit vectors"]);
}

#[test]
fn dicom_elements_without_use() {
    let flat = fixture("dicom_explicit/a.dcm", &[(b"0.75\\0.5", b"0.75\\0.0")]);
    folder_refused(&[("a.dcm", flat)], &["spacing along x is 0 (from PixelSpacing"]);
    folder_refused(&changed(CT, 0, "0.75\\0.5", "0.75\\abc"), &["PixelSpacing (0028,0030) is `0.75\\abc`"]);
    let bits = |n: u8| [0x28, 0, 0, 1, b'U', b'S', 2, 0, n, 0];
    let mut files = slices(CT);
    files[0].1 = fixture(&format!("{CT}/c.dcm"), &[(&bits(16), &bits(12))]);
    folder_refused(&files, &["c.dcm", "BitsAllocated (0028,0100) is `12`"]);
    let samples = |n: u8| [0x28, 0, 2, 0, b'U', b'S', 2, 0, n, 0];
    files[0].1 = fixture(&format!("{CT}/c.dcm"), &[(&samples(1), &samples(3))]);
    folder_refused(&files, &["colour image (3 samples per pixel"]);
    files[0].1 = fixture(&format!("{CT}/c.dcm"), &[(b"MONOCHROME2 ", b"PALETTECOLOR")]);
    folder_refused(&files, &["colour image (1 samples per pixel, PALETTECOLOR)"]);
    // ImagePositionPatient (0020,0032) becomes an element that nobody asks for.
    files[0].1 = fixture(&format!("{CT}/c.dcm"), &[(&[0x20, 0, 0x32, 0], &[0x20, 0, 0x33, 0])]);
    folder_refused(&files, &["ImagePositionPatient (0020,0032) is missing"]);
    // SliceThickness becomes NumberOfFrames.
    let multi = [(
        &[0x18, 0, 0x50, 0, b'D', b'S', 4, 0, b'2', b'.', b'5', b' '][..],
        &[0x28, 0, 8, 0, b'I', b'S', 4, 0, b'1', b'2', b'0', b' '][..],
    )];
    files[0].1 = fixture(&format!("{CT}/c.dcm"), &multi);
    folder_refused(&files, &["holds 120 frames; multi-frame DICOM is not read", "dcm2niix"]);
}

#[test]
fn compressed_and_unknown_transfer_syntaxes() {
    let path = fixture_path("dicom_jpeg2000");
    refused(&path, &["1.2.840.10008.1.2.4.90 (JPEG 2000) is not read", "gdcmconv", "dcm2niix"]);
    let files = changed(CT, 0, "1.2.840.10008.1.2.1\0", "1.2.840.10008.9.2.1\0");
    folder_refused(&files, &["1.2.840.10008.9.2.1 (unknown)"]);
}

#[test]
fn truncated_dicom() {
    let mut files = slices(CT);
    let length = files[2].1.len();
    files[2].1.truncate(length - 1);
    folder_refused(&files, &["b.dcm", "DICOM elements are cut off"]);
    files[2].1.truncate(400);
    folder_refused(&files, &["b.dcm", "cut off"]);
    let mut files = slices("dicom_rle");
    let length = files[0].1.len();
    files[0].1.truncate(length - 20);
    folder_refused(&files, &["c.dcm", "cut off"]);
    folder_refused(&[("a.dcm", b"something else".to_vec())], &["a.dcm", "is not a DICOM file"]);
}

#[test]
fn one_slice_takes_its_thickness() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a"), fixture("dicom_explicit/a.dcm", &[])).unwrap();
    let volume = read_volume(folder.path()).unwrap();
    assert_eq!((volume.cells, volume.spacing), ([5, 4, 1], Some([0.5, 0.75, 2.5].map(|h| h * 1e-3))));
    let unknown = fixture("dicom_explicit/a.dcm", &[(&[0x18, 0, 0x50, 0], &[0x18, 0, 0x51, 0])]);
    folder_refused(&[("a.dcm", unknown)], &["one slice only and no SliceThickness"]);
    refused(&fixture_path("dicom_explicit/a.dcm"), &["a single DICOM file", "give the folder"]);
}
