//! Every scene in `scenes/` but those of published figures runs, and writes what it says.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use grosgrain::io::read_volume;
use serde_json::Value;

use super::program::{Run, grosgrain, json, names, root};

const GOLDEN: &str = include_str!("../data/scene_errors.toml");

/// A finished `simulate` with its folder.
pub struct Finished {
    pub run: Run,
    pub folder: PathBuf,
}

/// Runs `simulate` in the root of the repository, with a new folder for the results.
pub fn simulate(scene: &str) -> Finished {
    let name = Path::new(scene).file_stem().unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scenes").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    let run = grosgrain(&root(), &["simulate", scene, "-o", folder.to_str().unwrap()]).done();
    Finished { run, folder }
}

/// The longest run, which several tests look at.
pub fn torso() -> &'static Finished {
    static TORSO: OnceLock<Finished> = OnceLock::new();
    TORSO.get_or_init(|| simulate("scenes/torso.toml"))
}

#[test]
fn every_scene_runs_and_writes_what_it_says() {
    let golden: toml::Table = GOLDEN.parse().unwrap();
    let mut scenes: Vec<String> = names(&root().join("scenes"));
    // Those of published figures take minutes; `reproduce` runs them.
    scenes.retain(|name| name.ends_with(".toml") && !name.starts_with("fig"));
    // `mesh_scenes` runs those of meshes.
    scenes.retain(|name| !std::fs::read_to_string(root().join("scenes").join(name)).unwrap().contains("mesh = "));
    assert_eq!(scenes.len(), golden.len(), "every scene has its row in scene_errors.toml: {scenes:?}");
    for scene in scenes {
        let name = scene.trim_end_matches(".toml");
        let row = &golden[name];
        let number = |key: &str| row[key].as_float().unwrap();
        let own = (name != "torso").then(|| simulate(&format!("scenes/{scene}")));
        let finished = own.as_ref().unwrap_or_else(|| torso());
        let report = json(&finished.folder.join("report.json"));
        let steps = row.get("steps").map_or(0, |steps| steps.as_integer().unwrap() as usize);
        check_report(name, &report, steps);
        let error = report["error"]["rms_percent"].as_f64().unwrap();
        let (expected, margin) = (number("error_percent"), number("margin"));
        assert!((error - expected).abs() <= margin, "{name}: {error} % instead of {expected} ± {margin} %");
        let volume = row["volume"].as_bool().unwrap();
        check_files(name, finished, (volume, steps));
        check_told(name, finished, error);
    }
}

/// The keys that scripts may count on.
fn check_report(name: &str, report: &Value, steps: usize) {
    for key in ["title", "method"] {
        assert!(report[key].as_str().is_some_and(|text| !text.is_empty()), "{name}: {key} in {report}");
    }
    for model in ["fine", "coarse"] {
        for key in ["cells", "nodes", "unknowns"] {
            assert!(report[model][key].as_u64().is_some_and(|n| n > 0), "{name}: {model}.{key} in {report}");
        }
        assert_eq!(report[model]["unknowns"], 3 * report[model]["nodes"].as_u64().unwrap(), "{name}: {model}");
    }
    for stage in ["body", "training", "fitting", "assembly", "solve", "fine", "output", "total"] {
        assert!(report["seconds"][stage].as_f64().is_some_and(|s| s >= 0.0), "{name}: {stage} in {report}");
    }
    let rows = |key: &str| report[key].as_array().unwrap().clone();
    assert_eq!((rows("edits").len(), rows("frames").len()), (steps, steps + 1), "{name}");
    for (row, step) in rows("edits").iter().zip(1..) {
        let number = |key: &str| row[key].as_u64().unwrap();
        assert!(number("step") == step && number("changed_cells") > 0, "{name}: {row}");
        assert!(number("changed_fine_cells") >= number("changed_cells"), "{name}: {row}");
        assert!(number("dirty_cells") >= number("changed_cells"), "{name}: {row}");
        for stage in ["training", "fitting", "total"] {
            assert!(row["seconds"][stage].as_f64().is_some_and(|s| s >= 0.0), "{name}: {stage} in {row}");
        }
    }
    for (frame, step) in rows("frames").iter().zip(0..) {
        assert_eq!(frame["step"].as_u64(), Some(step), "{name}: {frame}");
        assert_eq!(frame["time"].as_f64().map(|t| t > 0.0), Some(step > 0), "{name}: {frame}");
        assert!(frame["energy"].as_f64().is_some_and(|e| e > 0.0), "{name}: {frame}");
    }
    assert_eq!(rows("frames")[steps]["error"], report["error"]["rms_percent"], "{name}");
    assert!(report["error"]["energy_ratio"].as_f64().is_some_and(|r| r > 0.0), "{name}: {report}");
}

fn check_files(name: &str, finished: &Finished, (volume, steps): (bool, usize)) {
    let frames = |series: &str| (0..=steps).map(|n| format!("{series}_{n:04}.vtu")).collect::<Vec<_>>();
    let mut expected = [frames("body"), frames("coarse")].concat();
    expected.extend(["body.pvd", "coarse.pvd", "picture.png", "report.json"].map(String::from));
    let volumes = ["deformed.nii.gz", "deformed.nrrd", "deformed-scan.nii.gz", "deformed-scan.nrrd"];
    expected.extend(volumes.iter().filter(|_| volume).map(|file| (*file).to_owned()));
    expected.extend((steps > 0).then(|| "picture_0000.png".into()));
    expected.sort();
    assert_eq!(names(&finished.folder), expected, "{name}: exactly these files, none half-written");
    for series in ["body", "coarse"] {
        let list = std::fs::read_to_string(finished.folder.join(format!("{series}.pvd"))).unwrap();
        let listed: Vec<&str> = list.split("file=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        assert_eq!(listed, frames(series), "{name}: {list}");
    }
    let decoder =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(finished.folder.join("picture.png")).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert!(info.width > 800, "{name}: {info:?}");
    let first = pixels[..3].to_vec();
    assert!(pixels.chunks(3).any(|p| p != first), "{name}: the picture is blank");
    if volume {
        let deformed = read_volume(finished.folder.join("deformed.nii.gz")).unwrap();
        let solid = deformed.values.iter().filter(|v| **v > 0.0).count();
        let fine = json(&finished.folder.join("report.json"))["fine"]["cells"].as_u64().unwrap() as f64;
        // Small displacements keep the volume up to the few voxels at the surface.
        assert!((solid as f64 / fine - 1.0).abs() < 0.1, "{name}: {solid} of {fine} voxels");
    }
}

fn check_told(name: &str, finished: &Finished, error: f64) {
    let told = &finished.run.stdout;
    let (figures, files) = told.split_at(told.find("wrote ").unwrap());
    let last = figures.lines().last().unwrap();
    assert!(last.trim().starts_with("error against the fine model"), "{name}: {told}");
    assert!(last.contains(&format!("{error:.1} % RMS, energy ratio ")), "{name}: {told}");
    assert!(files.lines().count() >= 4, "{name}: {told}");
    for line in files.lines() {
        let path = Path::new(line.strip_prefix("wrote ").unwrap());
        assert!(path.starts_with(&finished.folder) && path.is_file(), "{name}: {line}");
    }
}
