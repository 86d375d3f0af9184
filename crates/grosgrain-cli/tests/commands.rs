//! What the commands promise to the shell.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;

fn grosgrain(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_grosgrain")).current_dir(folder).args(arguments).output().unwrap()
}

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data")
}

fn ct() -> String {
    data().join("ct_torso/example_ct.nii.gz").to_string_lossy().into_owned()
}

fn stdout(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_str(&stdout(output)).unwrap()
}

#[test]
fn every_help_ends_with_two_worked_examples() {
    let folder = tempfile::tempdir().unwrap();
    let overview = stdout(&grosgrain(folder.path(), &["--help"]));
    let listed = overview.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    let commands = listed.lines().filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help");
    let mut helps = vec![("grosgrain".to_string(), overview.clone())];
    for command in commands {
        helps.push((command.into(), stdout(&grosgrain(folder.path(), &[command, "--help"]))));
    }
    assert!(helps.len() >= 3);
    for (command, help) in helps {
        let examples: Vec<&str> = help.split("Examples:\n").nth(1).expect(&command).lines().collect();
        assert_eq!(examples.len(), 2, "{command}: {examples:?}");
        assert!(examples.iter().all(|line| line.trim().starts_with("grosgrain ")), "{command}: {examples:?}");
    }
}

#[test]
fn unusable_arguments_exit_with_2_and_broken_files_with_1() {
    let folder = tempfile::tempdir().unwrap();
    let code = |arguments: &[&str]| grosgrain(folder.path(), arguments).status.code();
    assert_eq!(code(&[]), Some(2));
    assert_eq!(code(&["inspect"]), Some(2));
    assert_eq!(code(&["inspect", "missing.nii"]), Some(2));
    assert_eq!(code(&["--threads", "0", "inspect", &ct()]), Some(2));
    assert_eq!(code(&["convert", &ct(), "out.nrrd", "--spacing", "1,2"]), Some(2));
    std::fs::write(folder.path().join("cut.nii"), b"\x5c\x01\x00\x00 far too short").unwrap();
    assert_eq!(code(&["inspect", "cut.nii"]), Some(1));
    std::fs::write(folder.path().join("cut.npz"), b"PK").unwrap();
    assert_eq!(code(&["inspect", "cut.npz"]), Some(1));
}

#[test]
fn inspect_tells_what_the_ct_volume_holds() {
    let folder = tempfile::tempdir().unwrap();
    let told = stdout(&grosgrain(folder.path(), &["inspect", &ct()]));
    for part in ["122 × 101 × 112 voxels", "3 × 3 × 3 mm", "0.366 × 0.303 × 0.336 m", "-1207 to 3382, whole numbers"]
    {
        assert!(told.contains(part), "{told}");
    }
    assert!(!told.contains("label "), "an image has no labels: {told}");
    let figures = json(&grosgrain(folder.path(), &["inspect", "--json", &ct()]));
    assert_eq!(figures[0]["kind"], "volume");
    assert_eq!(figures[0]["cells"], serde_json::json!([122, 101, 112]));
    assert_eq!(figures[0]["unknowns"], 3 * 123 * 102 * 113);
    assert_eq!(figures[0]["labels"], serde_json::Value::Null);
}

#[test]
fn inspect_goes_on_after_a_bad_file_and_tells_about_it_at_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let output = grosgrain(folder.path(), &["inspect", "missing.nii", &ct()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stdout).contains("122 × 101 × 112"));
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("missing.nii does not exist"));
}

const SCENE: &str = "
[body]
grid = { cells = [5, 4, 4], size = [0.05, 0.04, 0.04] }
pattern = { kind = \"layers\", direction = [1, 0, 0], period = 2, labels = [0, 1] }
[materials.soft]
label = 0
model = \"corotational\"
young = 1e5
poisson = 0.45
[materials.stiff]
label = 1
young = 5e6
poisson = 0.3
[coarsening]
degree = 2
";

#[test]
fn inspect_counts_cells_and_unknowns_of_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("beam.toml"), SCENE).unwrap();
    let output = grosgrain(folder.path(), &["inspect", "--json", "beam.toml"]);
    let figures = &json(&output)[0];
    assert_eq!(figures["solid_cells"], 80);
    assert_eq!(figures["fine_unknowns"], 3 * 6 * 5 * 5);
    assert_eq!(figures["coarse_cells"], 3 * 2 * 2, "the last layer of coarse cells is half void");
    assert_eq!(figures["coarse_unknowns"], 3 * 4 * 3 * 3);
    assert_eq!(figures["materials"][0]["cells"], 48);
    assert_eq!((figures["mode"].as_str(), figures["steps"].as_u64()), (Some("static"), Some(0)));
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
}

#[test]
fn inspect_estimates_the_memory_of_steps_where_steps_are_made() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |scene: &str| {
        std::fs::write(folder.path().join("moving.toml"), scene).unwrap();
        json(&grosgrain(folder.path(), &["inspect", "--json", "moving.toml"]))[0]["steps_bytes"].take()
    };
    assert!(bytes(&SCENE.replace("corotational", "linear")).is_null(), "a linear equilibrium has none");
    assert!(bytes(SCENE).is_array(), "a nonlinear one is found by steps");
    let dense = SCENE.replace("poisson", "density = 1000\npoisson");
    let moving = format!("{dense}\n[time]\nmode = \"dynamic\"\nstep = 0.01\nsteps = 5\n");
    let (plain, damped) = (bytes(&moving), bytes(&format!("{moving}damping = {{ stiffness = 1e-3 }}\n")));
    let more = |n: usize| damped[n].as_f64().unwrap() - plain[n].as_f64().unwrap();
    // Another 24 x 24 matrix for each of 80 cells, or of 12 elements.
    assert!((more(0) - 80.0 * 4608.0).abs() < 1.0 && (more(1) - 12.0 * 4608.0).abs() < 1.0, "{plain} {damped}");
    let told = stdout(&grosgrain(folder.path(), &["inspect", "moving.toml"]));
    assert!(told.contains("for the fine model, ") && told.contains("for the coarse one"), "{told}");
}

#[test]
fn converting_there_and_back_keeps_every_figure() {
    let folder = tempfile::tempdir().unwrap();
    let figures = |file: &str| {
        let mut figures = json(&grosgrain(folder.path(), &["inspect", "--json", file]))[0].take();
        figures.as_object_mut().unwrap().remove("file");
        figures
    };
    let mut last = ct();
    for next in ["a.nrrd", "b.mha", "c.mhd", "d.nii.gz", "e.nii"] {
        stdout(&grosgrain(folder.path(), &["--quiet", "convert", &last, next]));
        last = next.into();
    }
    assert_eq!(figures("e.nii"), figures(&ct()));
    stdout(&grosgrain(folder.path(), &["convert", "e.nii", "f.npy"]));
    assert_eq!(figures("f.npy")["spacing_metres"], serde_json::Value::Null);
    stdout(&grosgrain(folder.path(), &["convert", "f.npy", "g.nrrd", "--spacing", "0.003,0.003,0.003"]));
    assert_eq!(figures("g.nrrd"), figures(&ct()));
}

#[test]
fn convert_overwrites_only_when_told_and_never_its_input() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("old.nrrd"), "precious").unwrap();
    let refused = |arguments: &[&str], part: &str| {
        let output = grosgrain(folder.path(), arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(part), "{said}");
    };
    refused(&["convert", &ct(), "old.nrrd"], "old.nrrd exists; --overwrite replaces it");
    assert_eq!(std::fs::read(folder.path().join("old.nrrd")).unwrap(), b"precious");
    stdout(&grosgrain(folder.path(), &["convert", "--overwrite", &ct(), "old.nrrd"]));
    refused(&["convert", "--overwrite", "old.nrrd", "./old.nrrd"], "belongs to the input and is never overwritten");
    refused(&["convert", "old.nrrd", "new.png"], "expected .nii, .nii.gz, .nrrd, .mha, .mhd or .npy");
    refused(&["convert", "old.nrrd", "new"], "expected .nii");
    std::fs::write(folder.path().join("new.raw"), "precious").unwrap();
    refused(&["convert", "old.nrrd", "new.mhd"], "new.raw exists");
    let mut names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["new.raw", "old.nrrd"]);
}

#[test]
fn quiet_leaves_stderr_empty() {
    let folder = tempfile::tempdir().unwrap();
    let input = ct();
    let said = |quiet: &[&str]| {
        let arguments = [quiet, &["convert", "--overwrite", &input, "out.nrrd"]].concat();
        grosgrain(folder.path(), &arguments).stderr
    };
    assert_eq!(said(&["--quiet"]), b"");
    assert!(!said(&[]).is_empty());
}
