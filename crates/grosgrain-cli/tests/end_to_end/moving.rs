//! Dynamic and nonlinear runs: what they write is what mechanics says.

use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use super::program::{Run, changed, grosgrain, json, names};
use super::vtu::Vtu;

/// A layered bar of 4 × 2 × 2 coarse cells, held at one end, in steps of 10 ms.
pub const BAR: &str = r#"
title = "Bar"
[body]
grid = { cells = [8, 4, 4], size = [0.08, 0.04, 0.04] }
pattern = { kind = "layers", direction = [1, 0, 1], period = 4, labels = [0, 1] }
[materials.soft]
label = 0
model = "neo-hookean"
young = 1e5
poisson = 0.4
density = 1000.0
[materials.stiff]
label = 1
model = "neo-hookean"
young = 5e5
poisson = 0.3
density = 1500.0
[coarsening]
degree = 2
[time]
mode = "dynamic"
step = 0.01
steps = 8
[[fix]]
where = { plane = "x", at = "min" }
[output]
compare = "fine"
"#;

pub const GRAVITY: &str = "[[load]]\ngravity = [0, 0, -9.81]\n";
const FREE: [&str; 2] = ["[[fix]]\nwhere = { plane = \"x\", at = \"min\" }\n", ""];
pub const STATIC: [&str; 2] = ["mode = \"dynamic\"\nstep = 0.01\nsteps = 8", "tolerance = 1e-9"];
/// A part of the upper half of the bar, not where it is held.
const NOTCH: &str = "where = { box = [[0.04, 0, 0.03], [0.06, 0.04, 0.04]] }";

/// Whether a node of the full bar (in lattice order, x fastest: 9 × 5 × 5) is a coarse vertex: only those are held exactly in a coarse model.
const IS_VERTEX: fn(usize) -> bool = |node| node % 9 % 2 == 0 && node / 9 % 5 % 2 == 0 && node / 45 % 2 == 0;

/// What a run left.
pub struct Ended {
    folder: TempDir,
    pub run: Run,
}

impl Ended {
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join("out").join(name)
    }

    pub fn names(&self) -> Vec<String> {
        names(&self.folder.path().join("out"))
    }

    pub fn report(&self) -> Value {
        json(&self.path("report.json"))
    }

    fn body(&self, step: usize) -> Vtu {
        Vtu::read(&self.path(&format!("body_{step:04}.vtu")))
    }

    /// A number of every frame of the report.
    fn series(&self, key: &str) -> Vec<f64> {
        let number = |frame: &Value| frame[key].as_f64().unwrap_or_else(|| panic!("{key} in {frame}"));
        self.report()["frames"].as_array().unwrap().iter().map(number).collect()
    }

    fn vectors(&self, key: &str) -> Vec<[f64; 3]> {
        let vector = |frame: &Value| [0, 1, 2].map(|r| frame[key][r].as_f64().unwrap());
        self.report()["frames"].as_array().unwrap().iter().map(vector).collect()
    }

    fn error(&self) -> f64 {
        self.report()["error"]["rms_percent"].as_f64().unwrap()
    }
}

/// Runs `simulate` on the bar with these tables and changes.
pub fn simulate(tables: &str, changes: &[[&str; 2]], arguments: &[&str]) -> Ended {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("{}\n{tables}", changed(BAR, changes.iter().copied()));
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let run = grosgrain(folder.path(), &[&["simulate", "scene.toml", "-o", "out"], arguments].concat());
    Ended { folder, run }
}

fn done(tables: &str, changes: &[[&str; 2]]) -> Ended {
    let ended = simulate(tables, changes, &[]);
    assert_eq!(ended.run.code, Some(0), "{}", ended.run.stderr);
    ended
}

/// Width, height, and number of frames of a PNG, all of which must decode.
fn picture(path: &Path) -> (u32, u32, u32) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let frames = reader.info().animation_control().map_or(1, |control| control.num_frames);
    let mut room = vec![0; reader.output_buffer_size().unwrap()];
    for _ in 0..frames {
        reader.next_frame(&mut room).unwrap();
    }
    (reader.info().width, reader.info().height, frames)
}

fn never_falls(values: &[f64], by: f64) -> bool {
    values.windows(2).all(|pair| pair[1] >= pair[0] - by)
}

#[test]
fn a_falling_block_falls_freely_lands_and_rests() {
    let changes = [
        FREE,
        ["step = 0.01\nsteps = 8", "step = 0.005\nsteps = 60"],
        ["[output]", "[output]\nframes = 10\npicture = true\nanimation = true"],
        ["cells = [8, 4, 4], size = [0.08,", "cells = [4, 4, 4], size = [0.04,"],
    ];
    let fall = done(&format!("{GRAVITY}[contact]\nground = {{ z = -0.02, friction = 0.3 }}"), &changes);
    assert!(!fall.run.stderr.contains("warning"), "{}", fall.run.stderr);
    // Half of 64 cells of 1 cm³ is soft.
    let (mass, g) = (32e-6 * (1000.0 + 1500.0), 9.81);
    let momentum = fall.vectors("momentum");
    for step in 0..=10 {
        let expected = -mass * g * 0.005 * step as f64;
        assert!((momentum[step][2] - expected).abs() < 1e-9, "step {step}: {momentum:?}");
    }
    let kinetic = fall.series("kinetic");
    let fastest = kinetic.iter().fold(0.0, |most: f64, k| most.max(*k));
    assert!(fastest > 0.9 * mass * g * 0.02 * 0.9 && kinetic[60] < 1e-9 * fastest, "{kinetic:?}");
    assert!(never_falls(&fall.series("dissipated"), 1e-9 * fastest), "{:?}", fall.series("dissipated"));
    let flight = fall.body(10).vectors("velocity");
    // Lumped masses let the coarse model strain a little as it falls.
    assert!(flight.iter().all(|v| (v[2] + g * 0.05).abs() < 1e-5 && v[0].abs() < 1e-5), "{flight:?}");
    let lowest = fall.body(60).vectors("displacement").iter().map(|u| u[2]).fold(f64::INFINITY, f64::min);
    assert!((-0.0205..-0.02).contains(&lowest), "{lowest} m, 2 cm above the ground at first");
    assert!(fall.body(60).numbers("von_mises").iter().any(|s| *s > 1.0));
    assert!(fall.error() < 1.0, "{} %", fall.error());
    let steps = &fall.report()["steps"];
    assert_eq!((steps[0]["steps"].as_u64(), steps[1]["steps"].as_u64(), kinetic.len()), (Some(60), Some(60), 61));
    for name in ["picture_0000.png", "picture.png", "picture_worst.png", "error.png", "energy.png", "film.png"] {
        assert!(picture(&fall.path(name)).0 >= 400, "{name}");
    }
    assert_eq!(picture(&fall.path("film-animated.png")).2, 7, "frames 0, 10, …, 60");
    let frames = |name: &str| std::fs::read_to_string(fall.path(name)).unwrap().matches("<DataSet").count();
    assert_eq!((frames("body.pvd"), frames("coarse.pvd")), (7, 7));
}

#[test]
fn a_twisted_end_is_where_it_must_be_and_springs_back_when_it_is_let_go() {
    let twist = "[[fix]]\nwhere = { plane = \"x\", at = \"max\" }\n\
                 move = { twist = { axis = \"x\", angle = 60 }, to = 0.05 }\nuntil = 0.06";
    let ended = done(twist, &[]);
    let (sine, cosine) = 60f64.to_radians().sin_cos();
    let fine = simulate(twist, &[], &["--method", "fine"]);
    for (ended, is_vertex) in [(&ended, IS_VERTEX), (&fine, |_| true)] {
        let displacement = ended.body(6).vectors("displacement");
        for (node, u) in displacement.iter().enumerate().filter(|(node, _)| node % 9 == 8 && is_vertex(*node)) {
            let (y, z) = (0.01 * (node / 9 % 5) as f64 - 0.02, 0.01 * (node / 45) as f64 - 0.02);
            let expected = [0.0, cosine * y - sine * z - y, sine * y + cosine * z - z];
            assert!((0..3).all(|r| (u[r] - expected[r]).abs() < 1e-12), "node {node}: {u:?} instead of {expected:?}");
        }
    }
    let (energy, work) = (ended.series("energy"), ended.series("work"));
    assert!(energy[8] < 0.1 * energy[6] && work[8] == work[6] && work[5] > work[4], "{energy:?} {work:?}");
    assert!(never_falls(&ended.series("dissipated"), 0.0), "backward Euler never puts energy in");
    let errors = ended.series("error");
    assert!(errors[6] < 10.0, "{errors:?}");
}

#[test]
fn the_midpoint_rule_keeps_energy_and_spin_of_a_free_body_and_damping_takes_energy() {
    let base =
        [FREE, ["step = 0.01\nsteps = 8", "step = 2e-4\nsteps = 40\nintegrator = \"midpoint\"\ntolerance = 1e-9"]];
    let start = "[start]\nspin = [0, 0, 60]\nvelocity = [0, 0.1, 0]";
    let free = done(start, &base);
    let (lost, energy) = (free.series("dissipated"), free.series("kinetic")[0]);
    assert!(free.series("energy")[40] > 1e-3 * energy, "it stretches as it spins: {:?}", free.series("energy"));
    assert!(lost.iter().all(|lost| lost.abs() < 1e-3 * energy), "{energy} J: {lost:?}");
    let spin = free.vectors("angular_momentum");
    assert!(spin.iter().all(|l| (l[2] / spin[0][2] - 1.0).abs() < 1e-6), "{spin:?}");
    let damping =
        "step = 2e-4\nsteps = 40\ndamping = { stiffness = 1e-3 }\nintegrator = \"midpoint\"\ntolerance = 1e-9";
    let damped = done(start, &[FREE, ["step = 0.01\nsteps = 8", damping]]);
    let lost = damped.series("dissipated");
    assert!(lost[40] > 0.02 * free.series("energy")[40] && never_falls(&lost, 1e-4 * energy), "{lost:?}");
}

#[test]
fn springs_that_grow_or_are_stretched_at_first_put_their_energy_into_the_books() {
    for growth in ["", "\nto = 0.05"] {
        let spring = format!(
            "[[load]]\nwhere = {{ plane = \"x\", at = \"max\" }}\nspring = {{ stiffness = 100, offset = [0, 0, 0.02] }}{growth}"
        );
        let ended = done(&spring, &[]);
        let (lost, work) = (ended.series("dissipated"), ended.series("work"));
        assert_eq!((lost[0], work[0]), (0.0, 0.0));
        assert!(never_falls(&lost, 1e-12) && lost[8] > 0.0, "{growth}: {lost:?}");
        // ½ k d² = 20 mJ are stored at first, or while it grows put in, less where the end has come nearer.
        let expected = if growth.is_empty() { 0.0..1e-12 } else { 5e-3..20e-3 };
        assert!(expected.contains(&work[8]), "{growth}: {work:?}");
    }
}

#[test]
fn edits_of_a_moving_body_are_followed_with_and_without_training() {
    let edits = format!(
        "{GRAVITY}[[edit]]\nat_step = 2\n{NOTCH}\nremove = true\n[[edit]]\nat_step = 4\nwhere = {{ label = 1 }}\nmaterial = \"soft\""
    );
    let updated = done(&edits, &[]);
    let still = done(&edits, &[["degree = 2", "degree = 2\nupdate = false"]]);
    let rows = updated.report()["edits"].clone();
    assert_eq!((rows[0]["step"].as_u64(), rows[0]["changed_fine_cells"].as_u64()), (Some(2), Some(8)));
    assert!(rows[0]["dirty_cells"].as_u64() < rows[1]["dirty_cells"].as_u64(), "{rows}");
    let edited = updated.series("edited");
    assert!(edited[..=2].iter().all(|e| *e == 0.0) && edited[3] < 0.0 && edited[5] < edited[4], "{edited:?}");
    assert!(never_falls(&updated.series("dissipated"), 0.0), "{:?}", updated.series("dissipated"));
    assert_eq!(updated.series("energy")[..=2], still.series("energy")[..=2]);
    assert!(updated.error() < 0.7 * still.error(), "{} % with update, {} % without", updated.error(), still.error());
    assert!(updated.body(2).numbers("von_mises").len() == 128 && updated.body(3).numbers("von_mises").len() == 120);
}

#[test]
fn an_edit_to_what_is_there_changes_no_bit() {
    let nothing = "[[edit]]\nat_step = 3\nwhere = { label = 0 }\nmaterial = \"soft\"";
    let plain = done(GRAVITY, &[]);
    let edited = done(&format!("{GRAVITY}{nothing}"), &[]);
    assert_eq!(edited.report()["frames"], plain.report()["frames"]);
    assert_eq!(edited.report()["edits"][0]["changed_fine_cells"].as_u64(), Some(0));
}

#[test]
fn a_part_that_is_cut_off_falls() {
    let cut = "[[edit]]\nat_step = 1\nwhere = { cut = { point = [0.045, 0, 0], normal = [1, 0, 0] } }\nremove = true\n\
               [[edit]]\nat_step = 4\nwhere = { box = [[0.02, 0, 0.03], [0.03, 0.01, 0.04]] }\nremove = true";
    let ended = done(&format!("{GRAVITY}{cut}"), &[]);
    let told: Vec<&str> = ended.run.stderr.lines().filter(|line| line.contains("hangs on nothing")).collect();
    assert_eq!(told, ["warning: step 1: 1 part with 48 cells hangs on nothing; free to move"], "told once");
    assert_eq!(ended.report()["edits"][1]["loose_parts"].as_u64(), Some(1));
    let velocity = ended.body(8).vectors("velocity").last().copied().unwrap_or_default();
    // Freely for 70 ms, after 10 ms on the bar.
    assert!((-0.8..-0.65).contains(&velocity[2]), "{velocity:?}");
    assert!(ended.error() < 5.0, "{} %", ended.error());
}

#[test]
fn cells_that_are_added_to_a_moving_body_move_along() {
    let corner = "where = { box = [[0.06, 0, 0.02], [0.08, 0.04, 0.04]] }";
    let edits = format!(
        "{GRAVITY}[[edit]]\nat_step = 2\n{corner}\nremove = true\n[[edit]]\nat_step = 5\n{corner}\nadd = \"soft\""
    );
    for method in ["one-ring", "fine"] {
        let ended = simulate(&edits, &[], &["--method", method]);
        assert_eq!(ended.run.code, Some(0), "{}", ended.run.stderr);
        let cells = |step: usize| ended.body(step).numbers("von_mises").len();
        assert_eq!((cells(2), cells(3), cells(5), cells(6)), (128, 112, 112, 128), "{method}");
        let u = ended.body(6).vectors("displacement");
        let below = 8 + 9 * 2 + 45 * 2;
        // The corner at the top is new, the node two cells below it is not.
        let (new, old) = (u[below + 90], u[below]);
        let distance = (0..3).map(|r| (new[r] - old[r]).powi(2)).sum::<f64>().sqrt();
        let size = old.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(distance < 0.5 * size, "{method}: {new:?} at the top, {old:?} below");
    }
}

#[test]
fn cells_that_are_added_to_a_body_that_has_turned_do_not_kick_it() {
    let corner = "where = { box = [[0.06, 0, 0], [0.08, 0.04, 0.02]] }";
    let edits = format!(
        "[start]\nspin = [0, 0, 20]\n[[edit]]\nat_step = 1\n{corner}\nremove = true\n\
         [[edit]]\nat_step = 12\n{corner}\nadd = \"soft\""
    );
    let slower = ["step = 0.01\nsteps = 8", "step = 0.005\nsteps = 14"];
    for method in ["one-ring", "fine"] {
        let ended = simulate(&edits, &[FREE, slower], &["--method", method]);
        assert_eq!(ended.run.code, Some(0), "{}", ended.run.stderr);
        let (edited, kinetic, elastic) = (ended.series("edited"), ended.series("kinetic"), ended.series("energy"));
        // It has turned by 69°; what is added brings the kinetic energy that was taken, and hardly a strain.
        let brought = edited[13] - edited[12];
        assert!((0.5..1.5).contains(&(brought / -edited[2])), "{method}: {edited:?}");
        assert!(elastic[13] < 0.01 * kinetic[13], "{method}: {elastic:?}, {kinetic:?}");
    }
}

fn last<T: Copy>(values: &[T]) -> T {
    values[values.len() - 1]
}

#[test]
fn nonlinear_equilibria_depend_neither_on_increments_nor_on_how_the_body_came_to_be() {
    let at_once = done(GRAVITY, &[STATIC]);
    let in_parts = done(GRAVITY, &[STATIC, ["tolerance = 1e-9", "tolerance = 1e-9\nincrements = 3"]]);
    let made = done(GRAVITY, &[STATIC, ["labels = [0, 1]", "labels = [0, 0]"]]);
    let edit = format!(
        "{GRAVITY}[[edit]]\nat_step = 1\n{NOTCH}\nremove = true\n[[edit]]\nat_step = 2\n{NOTCH}\nadd = \"soft\"\n\
         [[edit]]\nat_step = 3\nwhere = \"all\"\nmaterial = \"soft\""
    );
    // A density of its own would make the weight differ from that of the body that was made so.
    let edited = done(&edit, &[STATIC]);
    let energy = |ended: &Ended| last(&ended.series("energy"));
    assert!((energy(&in_parts) / energy(&at_once) - 1.0).abs() < 1e-7, "{} {}", energy(&in_parts), energy(&at_once));
    assert!((energy(&edited) / energy(&made) - 1.0).abs() < 1e-7, "{} {}", energy(&edited), energy(&made));
    assert!(at_once.error() < 10.0 && edited.error() < 10.0);
    assert_eq!(edited.series("energy").len(), 4);
}

#[test]
fn an_end_that_is_moved_in_a_static_run_is_where_the_scene_says() {
    let moved = "[[fix]]\nwhere = { plane = \"x\", at = \"max\" }\nmove = { translate = [0.01, 0, 0.02] }";
    for law in ["neo-hookean", "linear"] {
        let laws = [["model = \"neo-hookean\"", law], ["model = \"neo-hookean\"", law]]
            .map(|[old, law]| [old.to_owned(), format!("model = \"{law}\"")]);
        let changes: Vec<[&str; 2]> = laws.iter().map(|[old, new]| [old.as_str(), new.as_str()]).collect();
        let ended = done(
            moved,
            &[&[["mode = \"dynamic\"\nstep = 0.01\nsteps = 8", "mode = \"static\""]], &changes[..]].concat(),
        );
        let u = ended.body(0).vectors("displacement");
        for (node, u) in u.iter().enumerate().filter(|(node, _)| [0, 8].contains(&(node % 9)) && IS_VERTEX(*node)) {
            let expected = if node % 9 == 8 { [0.01, 0.0, 0.02] } else { [0.0; 3] };
            assert!((0..3).all(|r| (u[r] - expected[r]).abs() < 1e-12), "{law}, node {node}: {u:?}");
        }
        assert!(ended.error() < 15.0, "{law}: {} %", ended.error());
    }
}

#[test]
fn every_method_goes_through_a_dynamic_scene_and_compare_has_a_row_for_each() {
    let folder = tempfile::tempdir().unwrap();
    let edit = format!("{GRAVITY}[[edit]]\nat_step = 3\n{NOTCH}\nremove = true");
    std::fs::write(folder.path().join("scene.toml"), format!("{BAR}\n{edit}")).unwrap();
    let methods = ["fine", "trilinear", "average", "global", "one-ring", "single-cell", "substructured", "auto"];
    let asked = methods.join(",");
    let run = grosgrain(folder.path(), &["compare", "scene.toml", "--methods", &asked, "--json", "rows.json"]).done();
    let rows = json(&folder.path().join("rows.json"));
    let rows = rows.as_array().unwrap();
    assert_eq!(rows.len(), methods.len());
    for (row, method) in rows.iter().zip(methods) {
        assert!(run.stdout.contains(method), "{}", run.stdout);
        let errors: Vec<f64> = row["errors_percent"].as_array().unwrap().iter().map(|e| e.as_f64().unwrap()).collect();
        let number = |key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key} in {row}"));
        assert_eq!(errors.len(), 9, "{method}: the start and 8 steps");
        assert_eq!((errors[0], last(&errors)), (0.0, number("error_percent")), "{method}");
        let worst = errors.iter().fold(0.0f64, |worst, e| worst.max(*e));
        assert_eq!(worst, number("worst_error_percent"), "{method}");
        assert!(number("seconds_per_step") > 0.0 && number("speed_up") > 0.0, "{row}");
        match method {
            "fine" => assert!(worst == 0.0 && number("speed_up") == 1.0 && number("energy_ratio") == 1.0),
            _ => assert!((0.1..60.0).contains(&worst), "{method}: {worst} %"),
        }
    }
    let of = |n: usize| rows[n]["worst_error_percent"].as_f64().unwrap();
    assert!(of(4) < of(1) && of(4) < of(2), "fitted functions are nearer than trilinear ones: {rows:?}");
}

#[test]
fn the_fine_method_runs_alone() {
    let ended = simulate(GRAVITY, &[], &["--method", "fine"]);
    assert_eq!(ended.run.code, Some(0), "{}", ended.run.stderr);
    let report = ended.report();
    assert!(report.get("coarse").is_none() && report.get("error").is_none(), "{report}");
    assert_eq!(report["steps"].as_array().map(Vec::len), Some(1));
    assert!(ended.names().iter().all(|name| !name.starts_with("coarse")), "{:?}", ended.names());
}

/// The report without what times and threads decide.
fn timeless(value: &Value) -> Value {
    let timed = ["seconds", "seconds_per_step", "speed_up", "threads"];
    match value {
        Value::Object(map) => map
            .iter()
            .filter(|(key, _)| !timed.contains(&key.as_str()))
            .map(|(k, v)| (k.clone(), timeless(v)))
            .collect(),
        Value::Array(values) => values.iter().map(timeless).collect(),
        other => other.clone(),
    }
}

#[test]
fn a_dynamic_run_is_the_same_with_one_thread_and_with_two() {
    let edit = format!(
        "{GRAVITY}[contact]\nground = {{ z = -0.002, friction = 0.2 }}\n[[edit]]\nat_step = 3\n{NOTCH}\nremove = true"
    );
    let runs = ["1", "2"].map(|threads| simulate(&edit, &[], &["--threads", threads]));
    assert!(runs.iter().all(|run| run.run.code == Some(0)), "{}", runs[0].run.stderr);
    assert_eq!(timeless(&runs[0].report()), timeless(&runs[1].report()));
    for name in runs[0].names().iter().filter(|name| name.ends_with(".vtu")) {
        let [one, two] = [0, 1].map(|n: usize| std::fs::read(runs[n].path(name)).unwrap());
        assert!(one == two, "{name}");
    }
}
