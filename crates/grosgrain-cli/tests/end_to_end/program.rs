//! Runs the built program in a folder.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use grosgrain::io::write_volume;
use grosgrain::mesh::Volume;

/// A cantilever of 8 × 2 × 2 coarse cells of two materials.
pub const SMALL: &str = r#"
title = "Small beam"
[body]
grid = { cells = [16, 4, 4], size = [0.16, 0.04, 0.04] }
pattern = { kind = "layers", direction = [1, 0, 1], period = 4, labels = [0, 1] }
[materials.soft]
label = 0
young = 1e5
poisson = 0.45
density = 1000.0
[materials.stiff]
label = 1
young = 5e6
poisson = 0.45
density = 1500.0
[coarsening]
degree = 2
[[fix]]
where = { plane = "x", at = "min" }
[[load]]
gravity = [0, 0, -9.81]
[output]
compare = "fine"
"#;

/// How a run ended and what it said.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

/// Runs the program in `folder`.
pub fn grosgrain(folder: &Path, arguments: &[&str]) -> Run {
    let output = Command::new(env!("CARGO_BIN_EXE_grosgrain")).current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Run { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

impl Run {
    /// Requires success.
    pub fn done(self) -> Self {
        assert_eq!(self.code, Some(0), "{}\n{}", self.stdout, self.stderr);
        self
    }
}

/// The folder of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// `text` with every change made once; a change that finds nothing to replace fails.
pub fn changed<'c>(text: &str, changes: impl IntoIterator<Item = [&'c str; 2]>) -> String {
    changes.into_iter().fold(text.to_owned(), |text, [old, new]| {
        assert!(text.contains(old), "there is no {old:?} in {text}");
        text.replacen(old, new, 1)
    })
}

/// Reads JSON from a file.
pub fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The names in a folder, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Writes a volume of `value` per voxel with edges of 1 cm.
pub fn write(path: &Path, cells: [usize; 3], value: impl Fn([usize; 3]) -> f64) {
    let [nx, ny, nz] = cells;
    let at = |v: usize| [v % nx, v / nx % ny, v / (nx * ny)];
    let values: Vec<f64> = (0..nx * ny * nz).map(|v| value(at(v))).collect();
    let integral = values.iter().all(|v| v.fract() == 0.0);
    write_volume(path, &Volume { cells, spacing: Some([0.01; 3]), voxel_to_world: None, values, integral }).unwrap();
}

/// Writes the volumes that the scenes in `tests/data` name.
pub fn write_volumes(folder: &Path) {
    let file = |name: &str| folder.join(name);
    let block = |inside: fn([usize; 3]) -> bool| move |at| f64::from(u8::from(inside(at)));
    write(&file("full.nii"), [8, 4, 4], |_| 1.0);
    write(&file("two.nii"), [8, 4, 4], block(|[i, _, _]| !(3..5).contains(&i)));
    write(&file("edge.nii"), [8, 4, 4], block(|[i, _, k]| (i < 4) == (k < 2)));
    write(&file("node.nii"), [8, 4, 4], block(|[i, j, k]| (i < 4) == (k < 2) && (j < 2) == (k < 2)));
    write(&file("young.nii"), [8, 4, 4], |[i, j, k]| if i > 5 && j < 2 { 0.0 } else { 1e5 * (1 + i + k) as f64 });
    write(&file("nan.nii"), [8, 4, 4], |[i, j, k]| if [i, j, k] == [1, 2, 3] { f64::NAN } else { 1.0 });
    write(&file("whole.nii.gz"), [8, 4, 4], |[i, j, k]| (i * j * k) as f64);
    let bytes = |name: &str| std::fs::read(file(name)).unwrap();
    let compressed = bytes("whole.nii.gz");
    std::fs::write(file("cut.nii.gz"), &compressed[..compressed.len() / 2]).unwrap();
    // NIfTI-1: dim at byte 40 (16 bits each), pixdim at 76 and the sform's rows at 280 (32 bits each).
    let mut four = bytes("full.nii");
    (four[40], four[48]) = (4, 2);
    std::fs::write(file("four.nii"), four).unwrap();
    let mut flat = bytes("full.nii");
    flat[80..84].fill(0);
    flat[280..284].fill(0);
    std::fs::write(file("flat.nii"), flat).unwrap();
}
