//! Volumes written by other libraries are read as those libraries read them, and ours are read back.

use grosgrain::io::{WriteError, read_volume, write_volume};
use grosgrain::mesh::Volume;
use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/volumes")
}

/// One block of `expected.txt`.
struct Expected {
    file: String,
    cells: Vec<usize>,
    spacing: Option<Vec<f64>>,
    world: Option<Vec<f64>>,
    values: Vec<f64>,
}

fn expected() -> Vec<Expected> {
    let text = std::fs::read_to_string(fixtures().join("expected.txt")).unwrap();
    let numbers = |text: &str| -> Option<Vec<f64>> {
        (text != "none").then(|| text.split(' ').map(|n| n.parse().unwrap()).collect())
    };
    let block = |block: &str| {
        let fields: HashMap<&str, &str> = block.lines().map(|line| line.split_once(' ').unwrap()).collect();
        Expected {
            file: fields["file"].into(),
            cells: fields["cells"].split(' ').map(|n| n.parse().unwrap()).collect(),
            spacing: numbers(fields["spacing"]),
            world: numbers(fields["world"]),
            values: numbers(fields["values"]).unwrap(),
        }
    };
    text.trim_end().split("\n\n").map(block).collect()
}

/// Largest difference of two lists of numbers against the largest number.
fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let scale = b.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    a.iter().zip(b).fold(0.0, |m: f64, (x, y)| m.max((x - y).abs())) / scale
}

#[test]
fn every_fixture_has_the_values_spacing_and_axes_that_its_writer_reads() {
    let all = expected();
    assert!(all.len() > 100, "only {} fixtures", all.len());
    for e in all {
        let volume = read_volume(fixtures().join(&e.file)).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(volume.cells.as_slice(), e.cells, "{}", e.file);
        assert_eq!(volume.values, e.values, "{}", e.file);
        assert_eq!(volume.integral, e.values.iter().all(|v| v.fract() == 0.0), "{}", e.file);
        // Axis-parallel spacing is exact. A rotation's norm and products differ by the order of three
        // roundings of half an ulp each, squared and summed: below 8 ulp.
        let tolerance = if e.file.contains("oblique") { 8.0 * f64::EPSILON } else { 0.0 };
        match (&volume.spacing, &e.spacing) {
            (None, None) => {}
            (Some(found), Some(expected)) => {
                let difference = relative_difference(found, expected);
                assert!(difference <= tolerance, "{}: spacing {found:?}, not {expected:?}", e.file);
            }
            (found, expected) => panic!("{}: spacing {found:?}, not {expected:?}", e.file),
        }
        match (&volume.voxel_to_world, &e.world) {
            (None, None) => {}
            (Some(found), Some(expected)) => {
                let difference = relative_difference(found.as_flattened(), expected);
                assert!(difference <= tolerance, "{}: world {found:?}, not {expected:?}", e.file);
            }
            (found, expected) => panic!("{}: world {found:?}, not {expected:?}", e.file),
        }
    }
}

#[test]
fn every_fixture_file_is_expected_or_refused_by_name() {
    let known: Vec<String> = expected().into_iter().map(|e| e.file).collect();
    for entry in std::fs::read_dir(fixtures()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let companion = [".raw", ".raw.gz", ".zraw", ".txt"].iter().any(|ending| name.ends_with(ending));
        assert!(known.contains(&name) || companion || name == "dicom_jpeg2000", "{name} is read by no test");
    }
}

const EXTENSIONS: [&str; 6] = ["nii", "nii.gz", "nrrd", "mha", "mhd", "npy"];

/// A volume with these values, an oblique world and cells that are not cubes.
fn oblique(values: impl Fn(usize) -> f64) -> Volume {
    let cells = [4, 3, 2];
    let values: Vec<f64> = (0..24).map(values).collect();
    let (c, s) = (0.8, 0.6);
    let [x, y, z] = [0.5, 0.75, 2.5];
    Volume {
        cells,
        spacing: Some([x, y, z].map(|h| h * 1e-3)),
        voxel_to_world: Some([
            [c * x, -s * y, 0.0, 1.0],
            [s * x, c * y, 0.0, -2.0],
            [0.0, 0.0, z, 3.5],
            [0., 0., 0., 1.],
        ]),
        integral: values.iter().all(|v| v.fract() == 0.0),
        values,
    }
}

fn samples() -> Vec<(&'static str, Volume)> {
    vec![
        ("bytes", oblique(|n| n as f64)),
        ("shorts", oblique(|n| n as f64 * 100.0 - 1000.0)),
        ("ints", oblique(|n| n as f64 * 1e7)),
        ("floats", oblique(|n| n as f64 * 0.1 + 1e10)),
    ]
}

/// The folder named by `GROSGRAIN_WRITTEN`, whose files other libraries may check, or one that goes away.
fn output() -> (PathBuf, Option<tempfile::TempDir>) {
    match std::env::var_os("GROSGRAIN_WRITTEN") {
        Some(folder) => {
            std::fs::create_dir_all(&folder).unwrap();
            (folder.into(), None)
        }
        None => {
            let folder = tempfile::tempdir().unwrap();
            (folder.path().into(), Some(folder))
        }
    }
}

fn joined(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

#[test]
fn written_volumes_are_read_back() {
    let (folder, _keep) = output();
    let mut record = Vec::new();
    for (name, volume) in samples() {
        for extension in EXTENSIONS {
            let file = format!("{name}.{extension}");
            write_volume(folder.join(&file), &volume).unwrap();
            compare(&file, &read_volume(folder.join(&file)).unwrap(), &volume);
            let mut block = format!("file {file}\ncells 4 3 2\n");
            writeln!(block, "spacing {}", joined(&volume.spacing.unwrap())).unwrap();
            writeln!(block, "world {}", joined(volume.voxel_to_world.unwrap().as_flattened())).unwrap();
            write!(block, "values {}", joined(&volume.values)).unwrap();
            record.push(block);
        }
    }
    std::fs::write(folder.join("expected.txt"), record.join("\n\n")).unwrap();
}

fn compare(file: &str, found: &Volume, expected: &Volume) {
    assert_eq!(found.cells, expected.cells, "{file}");
    assert_eq!(found.values, expected.values, "{file}");
    assert_eq!(found.integral, expected.integral, "{file}");
    if file.ends_with("npy") {
        assert_eq!((found.spacing, found.voxel_to_world), (None, None), "{file}");
        return;
    }
    // NIfTI-1 rounds each number to single precision; the text formats to a few ulp by scaling and norms.
    let tolerance = if file.contains(".nii") { f64::from(f32::EPSILON) } else { 8.0 * f64::EPSILON };
    let spacing = relative_difference(&found.spacing.unwrap(), &expected.spacing.unwrap());
    assert!(spacing <= tolerance, "{file}: spacing differs by {spacing:e}");
    let (found, expected) = (found.voxel_to_world.unwrap(), expected.voxel_to_world.unwrap());
    let world = relative_difference(found.as_flattened(), expected.as_flattened());
    assert!(world <= tolerance, "{file}: world differs by {world:e}");
}

#[test]
fn whole_numbers_take_the_fewest_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for ((name, volume), bytes) in samples().into_iter().zip([1, 2, 4, 8]) {
        let path = folder.path().join(format!("{name}.nii"));
        write_volume(&path, &volume).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().len(), 352 + 24 * bytes, "{name}");
    }
}

#[test]
fn a_volume_without_spacing_keeps_none_where_the_format_allows() {
    let folder = tempfile::tempdir().unwrap();
    let volume = Volume { spacing: None, voxel_to_world: None, ..oblique(|n| n as f64) };
    for extension in ["nrrd", "mha", "mhd", "npy"] {
        let path = folder.path().join(format!("bare.{extension}"));
        write_volume(&path, &volume).unwrap();
        assert_eq!(read_volume(&path).unwrap(), volume, "{extension}");
    }
    let error = write_volume(folder.path().join("bare.nii"), &volume).unwrap_err();
    assert!(error.to_string().contains("NIfTI needs a voxel spacing"), "{error}");
    assert!(!folder.path().join("bare.nii").exists());
}

#[test]
fn a_volume_without_world_keeps_its_spacing() {
    let folder = tempfile::tempdir().unwrap();
    let volume = Volume { voxel_to_world: None, ..oblique(|n| n as f64) };
    for extension in ["nrrd", "mha", "mhd"] {
        let path = folder.path().join(format!("plain.{extension}"));
        write_volume(&path, &volume).unwrap();
        assert_eq!(read_volume(&path).unwrap(), volume, "{extension}");
    }
}

#[test]
fn an_overridden_spacing_is_what_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let volume = Volume { spacing: Some([1e-3, 2e-3, 4e-3]), ..oblique(|n| n as f64) };
    let path = folder.path().join("overridden.nrrd");
    write_volume(&path, &volume).unwrap();
    let found = read_volume(&path).unwrap().spacing.unwrap();
    let difference = relative_difference(&found, &[1e-3, 2e-3, 4e-3]);
    assert!(difference <= 8.0 * f64::EPSILON, "{found:?}");
}

#[test]
fn what_cannot_be_written_is_refused_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let volume = oblique(|n| n as f64);
    let refused = |name: &str, volume: &Volume, text: &str| {
        let error = write_volume(folder.path().join(name), volume).unwrap_err();
        assert!(matches!(error, WriteError::InFile { .. }), "{error:?}");
        assert!(error.to_string().contains(text) && error.to_string().contains(name), "{error}");
    };
    for name in ["a.tif", "a.raw", "a", "a.img", "a.nhdr"] {
        refused(name, &volume, "no volume format is written under this name");
    }
    refused("a.npy", &Volume { values: vec![0.0], ..volume.clone() }, "1 values for 24 voxels");
    let flat = Volume { spacing: Some([1.0, 0.0, 1.0]), ..volume.clone() };
    refused("a.nrrd", &flat, "must be positive and finite");
    let long = Volume { cells: [40_000, 1, 1], values: vec![0.0; 40_000], ..volume.clone() };
    refused("a.nii", &long, "exceed the 32767 voxels");
    refused("missing/a.npy", &volume, "cannot be written");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
