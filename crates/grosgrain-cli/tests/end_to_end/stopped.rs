//! Runs that cannot go on: a sentence says why and what to do, and what came before stays whole.

use super::moving::{Ended, GRAVITY, STATIC, simulate};
use super::vtu::Vtu;

const END: &str = "where = { plane = \"x\", at = \"max\" }";

/// Requires exit code 1, these parts of the last line on stderr, a report that says the same and frames of these steps that can be read.
fn stops(ended: &Ended, says: &[&str], frames: &[usize]) {
    let last = ended.run.stderr.lines().last().unwrap_or_default();
    assert_eq!(ended.run.code, Some(1), "{last}");
    assert!(says.iter().all(|part| last.contains(part)), "{last}\nexpected {says:?}");
    let report = ended.report();
    assert_eq!(report["stopped"].as_str(), Some(last));
    let names = ended.names();
    assert!(names.iter().all(|name| !name.ends_with(".part")), "{names:?}");
    let found: Vec<&String> = names.iter().filter(|name| name.starts_with("body_")).collect();
    let expected: Vec<String> = frames.iter().map(|step| format!("body_{step:04}.vtu")).collect();
    assert_eq!(found, expected.iter().collect::<Vec<_>>());
    for name in &expected {
        let frame = Vtu::read(&ended.path(name));
        assert_eq!(frame.vectors("velocity").len(), frame.vectors("displacement").len());
        assert!(!frame.numbers("von_mises").is_empty());
    }
    let steps = report["frames"].as_array().unwrap().len();
    assert_eq!(report["steps"][0]["steps"].as_u64(), report["steps"][1]["steps"].as_u64(), "no model is ahead");
    assert!(frames.last().is_none_or(|last| *last + 1 == steps), "the last step that was made has a frame: {steps}");
    let list = std::fs::read_to_string(ended.path("body.pvd")).map_or(0, |list| list.matches("<DataSet").count());
    assert_eq!(list, frames.len());
}

#[test]
fn a_motion_that_crushes_cells_ends_with_the_cell_and_the_last_good_step() {
    let crush = format!("[[fix]]\n{END}\nmove = {{ translate = [-0.2, 0, 0], to = 0.08 }}");
    let says =
        ["scene.toml: step 3: coarse, one-ring: no solution", "cell (", "is inverted: det J = -", "use a smaller step"];
    stops(&simulate(&crush, &[["[output]", "[output]\nframes = 5"]], &[]), &says, &[0, 2]);
}

#[test]
fn a_step_that_is_too_large_says_so() {
    let load = "[[load]]\ngravity = [-9000, 0, -9000]";
    let changes = [["step = 0.01\nsteps = 8", "step = 1\nsteps = 5\nhalvings = 0"]];
    let says =
        ["scene.toml: step 1: coarse, one-ring: no solution for the step to 1.000000 s", "det J", "use a smaller step"];
    stops(&simulate(load, &changes, &[]), &says, &[0]);
    // Each method tells of itself.
    let alone = simulate(load, &[changes[0], ["compare = \"fine\"", ""]], &["--method", "fine"]);
    let last = alone.run.stderr.lines().last().unwrap_or_default();
    assert!(last.starts_with("scene.toml: step 1: no solution") && alone.run.code == Some(1), "{last}");
}

#[test]
fn a_static_scene_without_equilibrium_says_how_far_it_came() {
    let says = ["scene.toml: step 0: coarse, one-ring: no equilibrium beyond", "% of the load", "lower the load"];
    let ended =
        simulate("[[load]]\ngravity = [0, 0, -981000]", &[STATIC, ["[output]", "[output]\npicture = true"]], &[]);
    stops(&ended, &says, &[]);
    assert!(!ended.run.stderr.contains("warning"), "{}", ended.run.stderr);
}

#[test]
fn removing_what_is_held_ends_a_static_run_and_frees_a_moving_body() {
    let edit = format!("{GRAVITY}[[edit]]\nat_step = 1\nwhere = {{ plane = \"x\", at = 0.005 }}\nremove = true");
    let says = ["scene.toml: step 1: edit: after the edit nothing of the body is held", "keep a held part"];
    stops(&simulate(&edit, &[STATIC], &[]), &says, &[0]);
    let keep = simulate(&edit, &[STATIC, ["[body]", "[body]\nloose = \"keep\""]], &[]);
    stops(&keep, &["scene.toml: step 1: parts hang on nothing", "expected loose = \"drop\""], &[0]);
    let free = simulate(&edit, &[], &[]);
    assert_eq!(free.run.code, Some(0), "{}", free.run.stderr);
    assert!(!free.run.stderr.contains("too soft"), "energies near zero tell nothing: {}", free.run.stderr);
    let velocity = Vtu::read(&free.path("body_0008.vtu")).vectors("velocity");
    let mean = velocity.iter().map(|v| v[2]).sum::<f64>() / velocity.len() as f64;
    assert!((mean + 9.81 * 0.07).abs() < 0.05, "{mean} m/s after 70 ms");
}

#[test]
fn an_edit_that_the_motion_cannot_take_says_so_with_the_cell() {
    let hole = "where = { box = [[0.02, 0, 0.02], [0.05, 0.04, 0.04]] }";
    let edits = format!(
        "[[fix]]\n{END}\nmove = {{ translate = [-0.058, 0, 0], to = 0.08 }}\n\
         [[edit]]\nat_step = 2\n{hole}\nremove = true\n[[edit]]\nat_step = 7\n{hole}\nadd = \"soft\""
    );
    let ended = simulate(&edits, &[], &[]);
    let says = [
        "scene.toml: step 7: coarse, one-ring: the edit leaves a motion that the body cannot have",
        "det J",
        "deformed less",
    ];
    stops(&ended, &says, &[0, 1, 2, 3, 4, 5, 6, 7]);
}

#[test]
fn inverted_cells_of_a_law_that_allows_them_are_told_and_frames_stay_readable() {
    let crush = format!("[[fix]]\n{END}\nmove = {{ translate = [-0.2, 0, 0], to = 0.08 }}");
    let law = ["model = \"neo-hookean\"", "model = \"corotational\""];
    let ended = simulate(&crush, &[law, law], &[]);
    let told = ended.run.stderr.lines().filter(|line| line.contains("inside out")).count();
    assert_eq!(told, 1, "{}", ended.run.stderr);
    stops(&ended, &["scene.toml: step 3: coarse, one-ring: ", "coarse cell (", "det J"], &[0, 1, 2]);
}
