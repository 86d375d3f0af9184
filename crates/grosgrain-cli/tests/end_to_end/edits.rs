//! Runs with edits: each step has the equilibrium of the body as it then is.

use serde_json::Value;

use super::program::{SMALL, changed, grosgrain, json, names};

/// `SMALL` with these tables at its end, run; the report, what was said, and the files.
fn run(tables: &str, changes: &[[&str; 2]], arguments: &[&str]) -> (Value, String, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("{}\n{tables}", changed(SMALL, changes.iter().copied()));
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let arguments = [&["simulate", "scene.toml", "-o", "out"], arguments].concat();
    let run = grosgrain(folder.path(), &arguments).done();
    (json(&folder.path().join("out/report.json")), run.stderr, names(&folder.path().join("out")))
}

fn energies(report: &Value) -> Vec<f64> {
    report["frames"].as_array().unwrap().iter().map(|frame| frame["energy"].as_f64().unwrap()).collect()
}

#[test]
fn an_edit_gives_the_equilibrium_of_a_body_that_was_made_so() {
    let stiffen = "[[edit]]\nat_step = 2\nwhere = \"all\"\nmaterial = \"stiff\"";
    let made = [["labels = [0, 1]", "labels = [1, 1]"]];
    for method in ["fine", "one-ring", "average"] {
        let (report, _, files) = run(stiffen, &[], &["--method", method]);
        let (expected, _, _) = run("", &made, &["--method", method]);
        let (found, expected) = (energies(&report), energies(&expected)[0]);
        assert_eq!(found[0], found[1], "{method}: nothing happens at step 1");
        assert!((found[2] / expected - 1.0).abs() < 1e-9, "{method}: {found:?} instead of {expected}");
        let edit = &report["edits"][0];
        let number = |key: &str| edit[key].as_u64().unwrap();
        assert_eq!((number("step"), number("changed_fine_cells")), (2, 128), "half of 16 x 4 x 4 cells are soft");
        assert_eq!(number("dirty_cells"), if method == "fine" { 0 } else { 32 }, "{method}");
        assert!(files.contains(&"body_0002.vtu".to_owned()));
    }
}

#[test]
fn a_severed_end_is_dropped_or_kept_still_and_never_makes_the_solution_singular() {
    let cut = "[[edit]]\nat_step = 1\nremove = true\nwhere = { cut = { point = [0.105, 0, 0], normal = [1, 0, 0] } }";
    let shorter = [["cells = [16, 4, 4], size = [0.16, 0.04, 0.04]", "cells = [10, 4, 4], size = [0.1, 0.04, 0.04]"]];
    let (expected, _, _) = run("", &shorter, &["--method", "fine"]);
    for (loose, says) in [("drop", "left out from now on"), ("keep", "kept where they are")] {
        let key = format!("[body]\nloose = \"{loose}\"");
        for method in ["fine", "one-ring"] {
            let (report, stderr, _) = run(cut, &[["[body]", key.as_str()]], &["--method", method]);
            let edit = &report["edits"][0];
            assert_eq!((edit["loose_parts"].as_u64(), edit["loose_cells"].as_u64()), (Some(1), Some(80)), "{edit}");
            let told = format!("step 1: 1 part with 80 cells hangs on nothing; {says}");
            assert!(stderr.contains(&told) && edit["warnings"][0].as_str().unwrap().contains(&told), "{stderr}");
            if method == "fine" {
                let (found, expected) = (energies(&report)[1], energies(&expected)[0]);
                assert!((found / expected - 1.0).abs() < 1e-9, "{loose}: {found} instead of {expected}");
            }
        }
    }
}

#[test]
fn an_edit_that_finds_nothing_is_told_and_one_that_leaves_nothing_ends_the_run() {
    let twice =
        "[[edit]]\nat_step = 1\nevery_steps = 1\ntimes = 2\nremove = true\nwhere = { plane = \"x\", at = 0.155 }";
    let (report, stderr, _) = run(twice, &[], &["--method", "fine"]);
    let told = "step 2: edit[0]: all 16 cells of the edit's region are void, so there is nothing to change";
    assert!(stderr.contains(told), "{stderr}");
    assert_eq!(report["edits"][1]["changed_fine_cells"].as_u64(), Some(0));
    let folder = tempfile::tempdir().unwrap();
    let all = format!("{SMALL}\n[[edit]]\nat_step = 1\nremove = true\nwhere = \"all\"");
    std::fs::write(folder.path().join("scene.toml"), all).unwrap();
    let run = grosgrain(folder.path(), &["simulate", "scene.toml", "-o", "out", "--method", "fine"]);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    let says = "scene.toml: step 1: edit: the edit would remove all 256 solid cells; keep a part of the body";
    assert!(run.stderr.contains(says), "{}", run.stderr);
}
