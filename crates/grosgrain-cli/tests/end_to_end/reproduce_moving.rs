//! Figs. 1, 4 and 5 by `reproduce`, on small scenes of the same kind.

use std::fs;
use std::path::Path;

use grosgrain::io::read_volume;
use serde_json::Value;

use super::program::{Run, changed, grosgrain, json, names, root, write};

const BEAM: &str = r#"
title = "Small beam of layers"
[body]
grid = { cells = [12, 4, 4], size = [0.12, 0.04, 0.04] }
pattern = { kind = "layers", direction = [0, 0, 1], period = 2, labels = [0, 1] }
[materials.soft]
label = 0
model = "neo-hookean"
young = 2e4
poisson = 0.4
density = 1000.0
[materials.stiff]
label = 1
model = "neo-hookean"
young = 2e6
poisson = 0.4
density = 1000.0
[coarsening]
degree = 2
[time]
mode = "dynamic"
step = 0.02
steps = 12
[[fix]]
where = { plane = "x", at = "min" }
[[load]]
gravity = [0, 0, -9.81]
[[edit]]
at_step = 4
where = { and = [{ label = 1 }, { not = { plane = "x", at = "min" } }, { or = [{ plane = "x", at = 0.025 }, { plane = "x", at = 0.065 }] }] }
remove = true
"#;

/// A block of tissue around a rod of bone, cut twice.
const TRUNK: &str = r#"
title = "Small trunk"
[body]
volume = "scan.nii"
labels = [{ label = 0, below = -300, void = true }, { label = 1, below = 150 }, { label = 2 }]
[materials.soft-tissue]
label = 1
model = "neo-hookean"
young = 1e4
poisson = 0.4
density = 1000.0
[materials.bone]
label = 2
model = "neo-hookean"
young = 1e7
poisson = 0.4
density = 1500.0
[coarsening]
degree = 2
[time]
mode = "dynamic"
step = 0.02
steps = 6
[[fix]]
where = { plane = "z", at = "max" }
[[load]]
gravity = [0, 0, -9.81]
[[edit]]
at_step = 1
every_steps = 2
times = 2
advance = [0, -0.02, 0]
where = { blade = { edge = [[-0.01, 0.08, 0.03], [0.07, 0.08, 0.03]], sweep = [0, -0.02, 0] } }
remove = true
"#;

const PLATE: &str = r#"
title = "Small plate"
[body]
grid = { cells = [12, 8, 4], size = [0.12, 0.08, 0.04] }
pattern = { kind = "grid", period = [2, 2, 1], width = 1, box = [[2, 1, 0], [11, 8, 4]], labels = [0, 1] }
[materials.substrate]
label = 0
model = "neo-hookean"
young = 1e5
poisson = 0.45
density = 1000.0
[materials.active-stiff]
label = 1
model = "neo-hookean"
young = 1e7
poisson = 0.45
density = 1000.0
[materials.active-soft]
label = 2
model = "neo-hookean"
young = 1e5
poisson = 0.45
density = 1000.0
[coarsening]
degree = 4
[time]
mode = "dynamic"
step = 0.05
steps = 12
damping = 4.0
[[fix]]
where = { plane = "x", at = "min" }
[[fix]]
where = { plane = "x", at = "max" }
move = { twist = { axis = "x", angle = 40 }, to = 0.4 }
[[edit]]
at_step = 4
where = { label = 1 }
material = "active-soft"
"#;

/// Writes a scene where `--scenes scenes` finds it.
fn scene(folder: &Path, name: &str, text: &str) {
    fs::create_dir_all(folder.join("scenes")).unwrap();
    fs::write(folder.join("scenes").join(name), text).unwrap();
}

fn reproduce(folder: &Path, arguments: &[&str]) -> (Run, Vec<Value>) {
    let run = grosgrain(folder, &[&["reproduce", "--scenes", "scenes", "--json", "rows.json"], arguments].concat());
    let rows = json(&folder.join("rows.json")).as_array().unwrap().clone();
    (run, rows)
}

fn row<'r>(rows: &'r [Value], quantity: &str, method: &str) -> &'r Value {
    let found: Vec<&Value> = rows.iter().filter(|r| r["quantity"] == quantity && r["method"] == method).collect();
    assert_eq!(found.len(), 1, "{quantity}, {method}: {found:?}");
    found[0]
}

fn measured(rows: &[Value], quantity: &str, method: &str) -> f64 {
    row(rows, quantity, method)["measured"].as_f64().unwrap()
}

/// Number of frames of a PNG.
fn frames(path: &Path) -> u32 {
    let reader = png::Decoder::new(std::io::Cursor::new(fs::read(path).unwrap())).read_info().unwrap();
    reader.info().animation_control().map_or(1, |control| control.num_frames)
}

#[test]
fn errors_of_figure_1_are_those_of_compare_with_and_without_update() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), "fig1-beam.toml", BEAM);
    let (run, rows) = reproduce(folder.path(), &["fig1", "-o", "out"]);
    let run = run.done();
    let methods = [("with update", true, 24.0, 204.0), ("without update", false, 55.0, 257.0)];
    for (n, (method, update, published, cost)) in methods.into_iter().enumerate() {
        // The run that `compare` makes of the same scene, with the scene's own switch.
        let text = changed(BEAM, [["degree = 2", &format!("degree = 2\nupdate = {update}")]]);
        fs::write(folder.path().join("scene.toml"), text).unwrap();
        let compare = ["compare", "scene.toml", "--methods", "one-ring", "--json", "compare.json"];
        grosgrain(folder.path(), &compare).done();
        let compared = json(&folder.path().join("compare.json"))[0].clone();
        let close = |quantity: &str, expected: f64| {
            let found = measured(&rows, quantity, method);
            assert!((found / expected - 1.0).abs() < 1e-9, "{method}, {quantity}: {found} against {expected}");
        };
        close("error", compared["error_percent"].as_f64().unwrap());
        close("worst error", compared["worst_error_percent"].as_f64().unwrap());
        close("elastic energy over fine", compared["energy_ratio"].as_f64().unwrap());
        let errors = compared["errors_percent"].as_array().unwrap()[1..].iter().map(|error| error.as_f64().unwrap());
        close("mean error", errors.sum::<f64>() / 12.0);
        assert_eq!(row(&rows, "error", method)["published"].as_f64(), Some(published));
        // The second and the fourth of six layers of 2 × 2 coarse cells are cut, and those beside them see it: the first five.
        let update = ["update, training data", "update, shape functions"][n];
        let update = row(&rows, update, "with update");
        assert_eq!(update["published"].as_f64(), Some(cost));
        assert!(update["measured"].as_f64().unwrap() > 0.0 && update["updated_cells"] == 20, "{update}");
    }
    for model in ["with update", "without update", "fine"] {
        assert!(measured(&rows, "time of a step", model) > 0.0, "{model}");
    }
    let [coarse, fine] = ["with update", "fine"].map(|model| measured(&rows, "time of a step", model));
    assert!((measured(&rows, "speed-up over fine", "with update") * coarse / fine - 1.0).abs() < 1e-9);
    assert!(rows.iter().all(|row| row["name"] == "fig1" && row["degree"] == 2), "{rows:?}");
    assert!(run.stdout.contains("1 edit, in 8.00 coarse cells"), "{}", run.stdout);
    let pictures = ["fig1-animated.png", "fig1-error.png", "fig1.png"];
    assert_eq!(names(&folder.path().join("out")), pictures);
    assert_eq!(pictures.map(|name| frames(&folder.path().join("out").join(name))), [13, 1, 1]);
    assert!(pictures.iter().all(|name| run.stdout.contains(name)), "{}", run.stdout);
}

#[test]
fn figure_4_leaves_the_cut_scan_of_both_models() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), "fig4-abdomen.toml", TRUNK);
    let scan = |[i, j, _]: [usize; 3]| if (2..4).contains(&i) && j < 4 { 900.0 } else { 40.0 };
    write(&folder.path().join("scenes/scan.nii"), [6, 8, 6], scan);
    let (run, rows) = reproduce(folder.path(), &["fig4", "-o", "out"]);
    let run = run.done();
    assert!(run.stdout.contains("2 edits"), "{}", run.stdout);
    let published = ["with update", "without update"].map(|method| row(&rows, "error", method)["published"].as_f64());
    assert_eq!(published, [Some(28.0), None]);
    let out = folder.path().join("out");
    let expected = [
        "fig4-animated.png",
        "fig4-error.png",
        "fig4-scan-animated.png",
        "fig4-scan-coarse.nii.gz",
        "fig4-scan-coarse.nrrd",
        "fig4-scan-fine.nii.gz",
        "fig4-scan-fine.nrrd",
        "fig4-scan.png",
        "fig4.png",
    ];
    assert_eq!(names(&out), expected);
    assert_eq!(["fig4-animated.png", "fig4-scan-animated.png"].map(|name| frames(&out.join(name))), [7, 7]);
    for model in ["fine", "coarse"] {
        let [nifti, nrrd] =
            ["nii.gz", "nrrd"].map(|ending| read_volume(out.join(format!("fig4-scan-{model}.{ending}"))).unwrap());
        assert_eq!((&nifti.cells, &nifti.values), (&nrrd.cells, &nrrd.values), "{model}");
        // The scan has no air, so its lowest value is shown where there is no body; bone hangs on.
        let bone = nifti.values.iter().filter(|value| **value > 500.0).count();
        assert!((40..60).contains(&bone), "{model}: {bone} voxels of bone; 48 before");
        assert!(nifti.cells[2] >= 6, "{model}: {:?}", nifti.cells);
    }
}

#[test]
fn a_plate_of_figure_5_is_too_stiff_where_its_functions_are_not_updated() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), "fig5-plate.toml", PLATE);
    let (run, rows) = reproduce(folder.path(), &["fig5"]);
    let run = run.done();
    let [with, without] =
        ["with update", "without update"].map(|model| measured(&rows, "elastic energy over fine", model));
    assert!(without > 1.05 && without - 1.0 > 5.0 * (with - 1.0).abs(), "{with} with update, {without} without");
    let [with, without] = ["with update", "without update"].map(|model| measured(&rows, "error", model));
    assert!(without > with, "{with} % with update, {without} % without");
    let error = row(&rows, "error", "without update");
    assert!(error["published"].is_null() && error["note"].as_str().unwrap().contains("artificial stiffening"));
    assert!(run.stdout.contains("“close match”") && run.stdout.contains("-o DIR draws it"), "{}", run.stdout);
    assert_eq!(names(folder.path()), ["rows.json", "scenes"], "no pictures without a folder for them");
}

#[test]
fn a_run_can_be_shortened_and_one_that_fails_keeps_what_came_before() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), "fig1-beam.toml", BEAM);
    let (run, _) = reproduce(folder.path(), &["fig1", "--steps", "3"]);
    let told = run.done().stdout;
    assert!(told.contains("; 3 steps of 0.02 s") && told.contains("no edits in these steps"), "{told}");
    // Half a turn within one undivided step turns cells inside out.
    let twisted = PLATE.replace("angle = 40 }, to = 0.4", "angle = 180 }, from = 0.2, to = 0.25");
    scene(folder.path(), "fig5-plate.toml", &changed(&twisted, [["damping = 4.0", "halvings = 0"]]));
    let (run, rows) = reproduce(folder.path(), &["fig5", "-o", "out"]);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(
        run.stderr.contains("step 5") && run.stdout.contains("the run ended early"),
        "{}{}",
        run.stdout,
        run.stderr
    );
    assert!(row(&rows, "time of a step", "fine")["note"].as_str().unwrap().contains("step 5"));
    assert_eq!(frames(&folder.path().join("out/fig5-animated.png")), 5, "the steps before the one that failed");
}

#[test]
fn scenes_of_the_figures_are_found_from_anywhere_and_are_whole() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["fig1-beam.toml", "fig4-abdomen.toml", "fig5-plate.toml"] {
        let scene = root().join("scenes").join(name);
        let inspected = grosgrain(folder.path(), &["inspect", scene.to_str().unwrap()]).done();
        assert!(inspected.stdout.contains("dynamic") && !inspected.stderr.contains("warning"), "{}", inspected.stderr);
    }
    let refused = |arguments: &[&str], part: &str| {
        let run = grosgrain(folder.path(), &[&["reproduce"], arguments].concat());
        assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{arguments:?}: {}", run.stderr);
        assert!(run.stderr.contains(part), "{arguments:?}: {}", run.stderr);
    };
    refused(&["fig1", "--scenes", "."], "fig1-beam.toml is missing; expected the figure's scene");
    fs::write(folder.path().join("fig1-beam.toml"), BEAM.replace("mode = \"dynamic\"", "mode = \"static\"")).unwrap();
    refused(&["fig1", "--scenes", "."], "expected mode = \"dynamic\"");
    refused(&["fig4", "--steps", "0"], "0 is not in 1..");
    // The program lies in the repository, whose folder of scenes is found from there.
    let found = grosgrain(folder.path(), &["reproduce", "fig1", "--steps", "1"]).done();
    assert!(found.stderr.contains("fig1-beam.toml") && found.stdout.contains("; 1 step of"), "{}", found.stderr);
}
