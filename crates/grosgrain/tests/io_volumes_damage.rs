//! Damaged files give an error or a volume, never a panic.

use grosgrain::io::volume::{read_dicom, read_metaimage, read_nifti, read_nifti_pair, read_npy, read_nrrd, read_tiff};
use grosgrain::io::{ReadError, VolumeFormat, read_volume};
use grosgrain::mesh::Volume;
use proptest::prelude::*;
use std::path::{Path, PathBuf};

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name)
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => files.extend(files_below(&path)),
            false => files.push(path),
        }
    }
    files.sort();
    files
}

fn read_bytes(format: VolumeFormat, bytes: &[u8]) -> Result<Volume, ReadError> {
    match format {
        VolumeFormat::Nifti => read_nifti(bytes),
        VolumeFormat::Nrrd => read_nrrd(bytes),
        VolumeFormat::MetaImage => read_metaimage(bytes),
        VolumeFormat::Tiff => read_tiff(bytes),
        VolumeFormat::Npy => read_npy(bytes),
        _ => read_dicom([("slice", bytes)]),
    }
}

/// Whatever is read has as many values as voxels.
fn check(result: Result<Volume, ReadError>) {
    match result {
        Ok(volume) => assert_eq!(volume.values.len(), volume.cells.iter().product::<usize>()),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn damaged(bytes: &[u8], keep: prop::sample::Index, cut: bool, flips: &[(prop::sample::Index, u8)]) -> Vec<u8> {
    let length = if cut { keep.index(bytes.len() + 1) } else { bytes.len() };
    let mut bytes = bytes[..length].to_vec();
    for (at, mask) in flips.iter().filter(|_| length > 0) {
        bytes[at.index(length)] ^= mask;
    }
    bytes
}

/// Where in the headers flips do most harm: the first bytes; the rest are spread over the file.
fn flips() -> impl Strategy<Value = Vec<(prop::sample::Index, u8)>> {
    prop::collection::vec((any::<prop::sample::Index>(), 1u8..), 0..6)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn damage_never_panics(keep in any::<prop::sample::Index>(), cut: bool, flips in flips()) {
        for path in files_below(&folder("volumes")) {
            let Some(format) = VolumeFormat::of_name(&path) else { continue };
            let bytes = damaged(&std::fs::read(&path).unwrap(), keep, cut, &flips);
            check(read_bytes(format, &bytes));
        }
    }

    #[test]
    fn damaged_pairs_never_panic(keep in any::<prop::sample::Index>(), cut: bool, flips in flips()) {
        let header = std::fs::read(folder("volumes/nifti1_pair.hdr")).unwrap();
        let image = std::fs::read(folder("volumes/nifti1_pair.img")).unwrap();
        check(read_nifti_pair(&damaged(&header, keep, cut, &flips), &image));
        check(read_nifti_pair(&header, &damaged(&image, keep, cut, &flips)));
    }

    #[test]
    fn one_damaged_slice_never_panics(keep in any::<prop::sample::Index>(), cut: bool, flips in flips()) {
        for series in ["dicom_explicit", "dicom_implicit", "dicom_big_endian", "dicom_rle", "dicom_rle_bytes"] {
            let paths = files_below(&folder("volumes").join(series));
            let mut slices: Vec<Vec<u8>> = paths.iter().take(3).map(|path| std::fs::read(path).unwrap()).collect();
            slices[1] = damaged(&slices[1], keep, cut, &flips);
            check(read_dicom(slices.iter().map(|bytes| ("slice", bytes.as_slice()))));
        }
    }

    #[test]
    fn damaged_headers_of_detached_data_never_panic(keep in any::<prop::sample::Index>(), cut: bool, flips in flips()) {
        let beside = tempfile::tempdir().unwrap();
        for name in ["nrrd_detached_raw", "nrrd_detached_gzip", "meta_detached", "meta_detached_compressed"] {
            for path in files_below(&folder("volumes")).iter().filter(|p| p.to_string_lossy().contains(name)) {
                std::fs::copy(path, beside.path().join(path.file_name().unwrap())).unwrap();
            }
            let extension = if name.starts_with("nrrd") { "nhdr" } else { "mhd" };
            let path = beside.path().join(name).with_extension(extension);
            std::fs::write(&path, damaged(&std::fs::read(&path).unwrap(), keep, cut, &flips)).unwrap();
            check(read_volume(&path));
        }
    }
}

#[test]
fn inputs_that_fuzzing_found_are_refused_in_printable_sentences() {
    let formats = [
        ("nifti", VolumeFormat::Nifti),
        ("nrrd", VolumeFormat::Nrrd),
        ("metaimage", VolumeFormat::MetaImage),
        ("tiff", VolumeFormat::Tiff),
        ("npy", VolumeFormat::Npy),
        ("dicom", VolumeFormat::Dicom),
    ];
    for (name, format) in formats {
        let files = files_below(&folder("fuzz").join(name));
        assert!(!files.is_empty(), "no inputs for {name}");
        for path in files {
            let error = read_bytes(format, &std::fs::read(&path).unwrap()).expect_err(&path.display().to_string());
            let message = error.to_string();
            assert!(!message.is_empty() && !message.contains(char::is_control), "{}: {message:?}", path.display());
        }
    }
}
