//! Scenes whose body is a mesh: runs with known answers, what they write, and what they refuse.

use std::path::Path;

use grosgrain::io::mesh::write_mesh;
use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, SimplexLattice};
use serde_json::Value;

use super::program::{Run, changed, grosgrain, json, names, root};
use super::scenes::simulate;
use super::vtu::Vtu;

/// A bar of ν = 0 that is pulled at one end: its displacement is t x / E.
const PULLED: &str = r#"
[body]
mesh = "fine.mesh"
[materials.gel]
label = 1
young = 1e5
poisson = 0.0
density = 1000.0
[materials.stiffer]
label = 2
young = 1e5
poisson = 0.0
density = 1000.0
[coarsening]
mesh = "coarse.mesh"
[[fix]]
where = { plane = "x", at = "min" }
[[load]]
where = { plane = "x", at = "max" }
traction = [50.0, 0, 0]
[output]
compare = "fine"
"#;

/// The same bar, thrown.
const THROWN: [[&str; 2]; 2] = [
    ["[[fix]]\nwhere = { plane = \"x\", at = \"min\" }\n", "[start]\nvelocity = [1, 0, 2]\n"],
    [
        "[[load]]\nwhere = { plane = \"x\", at = \"max\" }\ntraction = [50.0, 0, 0]\n",
        "[time]\nmode = \"dynamic\"\nstep = 0.05\nsteps = 4\nintegrator = \"midpoint\"\n[[load]]\ngravity = [0, 0, -10]\n",
    ],
];

const SIZE: [f64; 3] = [0.8, 0.2, 0.1];

/// Writes the bar as a fine mesh, in layers along x of tags 1 and 2, and as a coarse one.
fn write_bar(folder: &Path, dimension: Dimension, fine: [usize; 3], coarse: [usize; 3]) {
    let around = BoundingBox { lower: [0.0; 3], upper: SIZE };
    let mesh = |boxes| SimplexLattice { dimension, boxes, around, cut: BoxCut::Alike }.mesh().unwrap();
    let layered = mesh(fine).tagged(|at| 1 + (at[0] / SIZE[0] * fine[0] as f64) as i32 % 2);
    write_mesh(folder.join("fine.mesh"), &layered, &[]).unwrap();
    write_mesh(folder.join("coarse.mesh"), &mesh(coarse), &[]).unwrap();
}

fn run(folder: &Path, scene: &str, arguments: &[&str]) -> Run {
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    grosgrain(folder, arguments)
}

fn compared(folder: &Path, scene: &str) -> Vec<Value> {
    run(folder, scene, &["compare", "scene.toml", "--json", "rows.json"]).done();
    json(&folder.join("rows.json")).as_array().unwrap().clone()
}

fn figure(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} in {row}"))
}

/// RMS error in percent that `simulate` measures, its margin (half a unit of the last digit; more where a body falls, since Newton's method stops at 1e-5), steps and the pictures.
const SCENES: [(&str, f64, f64, usize, &[&str]); 2] = [
    ("bar-bimetal", 2.76, 0.005, 0, &["picture.png"]),
    ("liver", 4.94, 0.1, 12, &["energy.png", "error.png", "film.png", "picture.png", "picture_0000.png"]),
];

#[test]
fn every_scene_of_meshes_runs_and_writes_what_it_says() {
    let is_mesh =
        |name: &String| std::fs::read_to_string(root().join("scenes").join(name)).unwrap().contains("mesh = ");
    let scenes: Vec<String> = names(&root().join("scenes")).into_iter().filter(is_mesh).collect();
    assert_eq!(scenes, SCENES.map(|(name, ..)| format!("{name}.toml")));
    for (name, expected, margin, steps, pictures) in SCENES {
        let finished = simulate(&format!("scenes/{name}.toml"));
        let report = json(&finished.folder.join("report.json"));
        let error = figure(&report["error"], "rms_percent");
        assert!((error - expected).abs() <= margin, "{name}: {error} % instead of {expected} ± {margin} %");
        assert_eq!(report["frames"].as_array().unwrap().len(), steps + 1, "{name}: {report}");
        assert!(report.get("stopped").is_none(), "{name}: {report}");
        let files = names(&finished.folder);
        let made: Vec<&String> = files.iter().filter(|file| file.ends_with(".png")).collect();
        assert!(pictures.iter().all(|file| files.iter().any(|made| made == file)), "{name}: {made:?}");
        assert!(files.iter().all(|file| !file.ends_with(".part")), "{name}: {files:?}");
        let told = &finished.run.stdout;
        assert!(told.contains(&format!("{error:.1} % RMS")), "{name}: {told}");
    }
}

#[test]
fn every_method_is_exact_for_a_homogeneous_bar_under_tension() {
    for (dimension, nodes) in [(Dimension::One, [9, 3]), (Dimension::Two, [27, 6]), (Dimension::Three, [81, 12])] {
        let folder = tempfile::tempdir().unwrap();
        write_bar(folder.path(), dimension, [8, 2, 2], [2, 1, 1]);
        let rows = compared(folder.path(), PULLED);
        let methods: Vec<&str> = rows.iter().map(|row| row["method"].as_str().unwrap()).collect();
        assert_eq!(methods, ["fine", "tensor", "average", "trilinear", "sampled"]);
        for (n, row) in rows.iter().enumerate() {
            // Newton's tolerance is 1e-10 of the forces.
            assert!(figure(row, "error_percent") < 1e-6, "{dimension}: {row}");
            assert!((figure(row, "energy_ratio") - 1.0).abs() < 1e-8, "{dimension}: {row}");
            let unknowns = dimension.axes() * nodes[usize::from(n > 0)];
            assert_eq!(row["unknowns"], unknowns, "{dimension}: {row}");
        }
    }
}

#[test]
fn frames_and_report_hold_the_known_displacement_energy_and_stress() {
    let folder = tempfile::tempdir().unwrap();
    write_bar(folder.path(), Dimension::Three, [8, 2, 2], [2, 1, 1]);
    run(folder.path(), PULLED, &["simulate", "scene.toml", "-o", "out"]).done();
    let out = folder.path().join("out");
    let expected = ["body.pvd", "body_0000.vtu", "coarse.pvd", "coarse_0000.vtu", "report.json"];
    assert_eq!(names(&out), expected, "exactly these files, none half-written");
    let report = json(&out.join("report.json"));
    assert_eq!((&report["method"], report["fine"]["cells"].as_u64()), (&"tensor".into(), Some(192)));
    assert_eq!((report["coarse"]["cells"].as_u64(), report["coarse"]["unknowns"].as_u64()), (Some(12), Some(36)));
    for stage in ["body", "harmonic", "intersections", "tensors", "solve", "fine", "output", "total"] {
        assert!(report["seconds"][stage].as_f64().is_some_and(|s| s >= 0.0), "{stage} in {report}");
    }
    // ½ t² V / E.
    let energy = 0.5 * 50.0 * 50.0 * 0.8 * 0.2 * 0.1 / 1e5;
    assert!((figure(&report["frames"][0], "energy") / energy - 1.0).abs() < 1e-8, "{report}");
    assert!(figure(&report["error"], "rms_percent") < 1e-6, "{report}");
    for series in ["body_0000.vtu", "coarse_0000.vtu"] {
        let frame = Vtu::read(&out.join(series));
        for (u, at) in frame.vectors("displacement").iter().zip(frame.vectors("Points")) {
            let exact = [50.0 * at[0] / 1e5, 0.0, 0.0];
            assert!((0..3).all(|r| (u[r] - exact[r]).abs() < 1e-11), "{series}: {u:?} at {at:?}");
        }
    }
    let body = Vtu::read(&out.join("body_0000.vtu"));
    assert!(body.numbers("von_mises").iter().all(|stress| (stress - 50.0).abs() < 1e-6));
    assert!(body.numbers("young").iter().all(|young| *young == 1e5));
    assert_eq!(Vtu::read(&out.join("coarse_0000.vtu")).numbers("stiffness").len(), 12 * 36);
}

#[test]
fn layers_in_series_keep_their_stiffness_with_tensors_only() {
    let folder = tempfile::tempdir().unwrap();
    write_bar(folder.path(), Dimension::One, [8, 1, 1], [2, 1, 1]);
    // Per two metres 1 / 1 + 1 / 9 of compliance; the mean modulus is 5.
    let rows = compared(folder.path(), &changed(PULLED, [["label = 2\nyoung = 1e5", "label = 2\nyoung = 9e5"]]));
    let ratio = |n: usize| figure(&rows[n], "energy_ratio");
    assert!((ratio(1) - 1.0).abs() < 1e-8, "{rows:?}");
    let mean = (1.0 / 5.0) / (0.5 * (1.0 + 1.0 / 9.0));
    for n in [2, 3] {
        assert!((ratio(n) / mean - 1.0).abs() < 1e-8, "{}: {} instead of {mean}", rows[n]["method"], ratio(n));
    }
}

#[test]
fn the_harmonic_map_puts_the_soft_layers_back_where_they_stretch() {
    let folder = tempfile::tempdir().unwrap();
    write_bar(folder.path(), Dimension::One, [8, 1, 1], [2, 1, 1]);
    let layers = ["label = 2\nyoung = 1e5", "label = 2\nyoung = 9e5"];
    let errors = |map: &str| {
        let coarsening = ["mesh = \"coarse.mesh\"\n", &format!("mesh = \"coarse.mesh\"\nmap = \"{map}\"\n")];
        let rows = compared(folder.path(), &changed(PULLED, [layers, coarsening]));
        rows.iter().map(|row| figure(row, "error_percent")).collect::<Vec<f64>>()
    };
    let [plain, harmonic, blended] = ["barycentric", "harmonic", "harmonic-blended"].map(errors);
    // The stress is that of a harmonic displacement, so that the fine displacement is one.
    assert!(plain[1] > 1.0 && harmonic[1] < 1e-6 && blended[1] < 1e-6, "{plain:?} {harmonic:?} {blended:?}");
    assert_eq!(plain[2..], harmonic[2..], "averages have no harmonic displacements");
    let scene = PULLED.replace("mesh = \"coarse.mesh\"\n", "mesh = \"coarse.mesh\"\nmap = \"magic\"\n");
    let refused = run(folder.path(), &scene, &["compare", "scene.toml"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("harmonic-blended"), "{}", refused.stderr);
}

#[test]
fn a_bar_in_flight_has_the_same_velocity_by_either_map() {
    let folder = tempfile::tempdir().unwrap();
    write_bar(folder.path(), Dimension::Three, [8, 2, 2], [2, 1, 1]);
    let velocities = |map: &str| {
        let coarsening = ["mesh = \"coarse.mesh\"\n", &format!("mesh = \"coarse.mesh\"\nmap = \"{map}\"\n")];
        let layers = ["label = 2\nyoung = 1e5", "label = 2\nyoung = 9e5"];
        let scene = changed(&changed(PULLED, THROWN), [coarsening, layers]);
        run(folder.path(), &scene, &["simulate", "scene.toml", "-o", map]).done();
        Vtu::read(&folder.path().join(map).join("body_0004.vtu")).vectors("velocity").to_vec()
    };
    let [plain, blended] = ["barycentric", "harmonic-blended"].map(velocities);
    for (a, b) in plain.iter().zip(&blended) {
        assert!((0..3).all(|r| (a[r] - b[r]).abs() < 1e-6), "{a:?} {b:?}");
    }
}

#[test]
fn a_bar_on_springs_shifts_by_force_over_stiffness() {
    let folder = tempfile::tempdir().unwrap();
    write_bar(folder.path(), Dimension::Three, [8, 2, 2], [2, 1, 1]);
    let springs = "[[load]]\nwhere = { plane = \"x\", at = \"min\" }\nspring = { stiffness = 200.0 }\n";
    let held = "[[fix]]\nwhere = { plane = \"x\", at = \"min\" }\n";
    let force = [
        [held, springs],
        // The same as the traction of 50 Pa: 1 N on 0.02 m².
        ["traction = [50.0, 0, 0]", "force = [1.0, 0, 0]"],
    ];
    for method in ["tensor", "fine"] {
        let arguments = ["simulate", "scene.toml", "-o", "out", "--method", method];
        run(folder.path(), &changed(PULLED, force), &arguments).done();
        let body = Vtu::read(&folder.path().join("out/body_0000.vtu"));
        for (u, at) in body.vectors("displacement").iter().zip(body.vectors("Points")) {
            let exact = 1.0 / 200.0 + 50.0 * at[0] / 1e5;
            assert!((u[0] - exact).abs() < 1e-9 && u[1].abs() + u[2].abs() < 1e-9, "{method}: {u:?} at {at:?}");
        }
    }
}

#[test]
fn a_thrown_bar_flies_as_a_point_does_on_both_meshes() {
    let folder = tempfile::tempdir().unwrap();
    write_bar(folder.path(), Dimension::Three, [4, 2, 2], [2, 1, 1]);
    let turning =
        [["[coarsening]\nmesh = \"coarse.mesh\"\n", ""], ["young = 1e5", "young = 1e5\nmodel = \"corotational\""]];
    for scene in [changed(PULLED, THROWN), changed(&changed(PULLED, THROWN), turning)] {
        let told = run(folder.path(), &scene, &["simulate", "scene.toml", "-o", "out"]).done().stderr;
        assert_eq!(told.contains("no coarse mesh is given"), !scene.contains("[coarsening]"), "{told}");
        let out = folder.path().join("out");
        let report = json(&out.join("report.json"));
        let frames = report["frames"].as_array().unwrap();
        let mass = 0.8 * 0.2 * 0.1 * 1000.0;
        for frame in frames {
            let time = figure(frame, "time");
            let momentum: Vec<f64> =
                frame["momentum"].as_array().unwrap().iter().map(|p| p.as_f64().unwrap()).collect();
            let exact = [mass, 0.0, mass * (2.0 - 10.0 * time)];
            assert!((0..3).all(|r| (momentum[r] - exact[r]).abs() < 1e-6 * mass), "{frame}");
            assert!(frame.get("error").is_none_or(|error| error.as_f64().unwrap() < 1e-4), "{frame}");
        }
        assert_eq!(frames.len(), 5);
        let last = Vtu::read(&out.join("body_0004.vtu"));
        for (u, v) in last.vectors("displacement").iter().zip(last.vectors("velocity")) {
            // The midpoint rule is exact under constant acceleration: at 0.2 s.
            assert!((u[0] - 0.2).abs() + u[1].abs() + (u[2] - 0.2).abs() < 1e-6, "{u:?}");
            assert!((v[0] - 1.0).abs() + v[1].abs() + v[2].abs() < 1e-5, "{v:?}");
        }
        let steps = report["steps"].as_array().unwrap();
        assert_eq!((&steps[0]["method"], &steps[1]["method"]), (&"tensor".into(), &"fine".into()));
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn coarsen_writes_the_tensors_of_homogenize_and_inspect_sums_the_scene_up() {
    let folder = tempfile::tempdir().unwrap();
    write_bar(folder.path(), Dimension::Three, [4, 2, 2], [2, 1, 1]);
    let told = run(folder.path(), PULLED, &["coarsen", "scene.toml", "-o", "scene.npz", "--json", "scene.json"]).done();
    assert!(told.stdout.contains("12 cells, 36 unknowns"), "{}", told.stdout);
    assert_eq!(json(&folder.path().join("scene.json"))["cells"], 12);
    let arguments = ["homogenize", "fine.mesh", "--onto", "coarse.mesh", "--materials", "scene.toml"];
    grosgrain(folder.path(), &[&arguments[..], &["--npz", "other.npz", "-o", "other.vtu"]].concat()).done();
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("scene.npz"), bytes("other.npz"), "the same archive");
    let inspected = run(folder.path(), PULLED, &["inspect", "--json", "scene.toml"]).done().stdout;
    let summary: Value = serde_json::from_str::<Value>(&inspected).unwrap()[0].take();
    assert_eq!((&summary["kind"], &summary["cells_are"]), (&"scene".into(), &"tetrahedra".into()));
    assert_eq!((summary["fine"]["cells"].as_u64(), summary["coarse"]["cells"].as_u64()), (Some(96), Some(12)));
}

#[test]
fn what_cannot_be_run_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    write_bar(folder.path(), Dimension::Three, [4, 2, 2], [2, 1, 1]);
    std::fs::write(folder.path().join("scene.toml"), "").unwrap();
    let before = names(folder.path());
    let plain = ["simulate", "scene.toml", "-o", "out/here"];
    let refused = |changes: &[[&str; 2]], arguments: &[&str], parts: &[&str]| {
        let Run { code, stdout, stderr } = run(folder.path(), &changed(PULLED, changes.iter().copied()), arguments);
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{stderr}");
        assert!(parts.iter().all(|part| stderr.contains(part)), "{stderr} lacks one of {parts:?}");
        assert_eq!(names(folder.path()), before);
    };
    let method = |name| [&plain[..], &["--method", name]].concat();
    refused(&[], &method("global"), &["global is a method for voxels, but the body is a mesh; expected fine, tensor"]);
    refused(&[], &["compare", "scene.toml", "--methods", "fine,one-ring"], &["one-ring is a method for voxels"]);
    refused(&[], &["coarsen", "scene.toml", "--method", "average"], &["average leaves nothing to write"]);
    let held = "where = { plane = \"x\", at = \"min\" }";
    refused(&[["[[fix]]\nwhere = { plane = \"x\", at = \"min\" }\n", ""]], &plain, &["hangs on nothing"]);
    let corner = "where = { sphere = { centre = [0, 0, 0], radius = 0.01 } }";
    refused(&[[held, corner]], &plain, &["scene.toml", "fix: the body is held at 1 point, about which it turns"]);
    let edge = "where = { box = [[0, 0, 0], [0, 0.2, 0]] }";
    refused(&[[held, edge]], &plain, &["held at 3 points in line", "three places that are not in line"]);
    refused(&[["traction = [50.0, 0, 0]", "traction = [0, 0, 0]"]], &plain, &["load: the loads are zero"]);
    let inside = "where = { box = [[0.3, 0.05, 0.02], [0.5, 0.15, 0.08]] }";
    refused(&[["where = { plane = \"x\", at = \"max\" }", inside]], &plain, &["load[0]", "no whole face"]);
}
