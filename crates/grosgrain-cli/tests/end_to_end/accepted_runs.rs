//! Unusual runs that must work, with the error that they reach.

use super::program::{SMALL, changed, grosgrain, json, names, root, write_volumes};

const CASES: &str = include_str!("../data/accepted_runs.toml");

fn texts(value: &toml::Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect()
}

#[test]
fn every_unusual_run_reaches_its_error() {
    let table: toml::Table = CASES.parse().unwrap();
    let folder = tempfile::tempdir().unwrap();
    write_volumes(folder.path());
    let mut wrong = Vec::new();
    for case in table["case"].as_array().unwrap() {
        let name = case["name"].as_str().unwrap();
        let base = case.get("base").map_or(SMALL, |base| table[base.as_str().unwrap()].as_str().unwrap());
        let changes = case.get("changes").map_or(Vec::new(), |changes| changes.as_array().unwrap().clone());
        let scene = changed(base, changes.iter().map(|change| texts(change).try_into().unwrap()));
        let scene = scene.replace("DATA", &root().join("data").to_string_lossy());
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let run = grosgrain(folder.path(), &["simulate", "scene.toml", "-o", "out"]);
        if run.code != Some(0) {
            wrong.push(format!("{name}: exit code {:?}\n{}", run.code, run.stderr));
            continue;
        }
        let error = json(&folder.path().join("out/report.json"))["error"]["rms_percent"].as_f64().unwrap();
        let below = case["error_below"].as_float().unwrap();
        if error > below || error.is_nan() {
            wrong.push(format!("{name}: {error} %, not below {below} %"));
        }
        for part in case.get("says").map_or(Vec::new(), |parts| texts(parts)) {
            if !run.stderr.contains(part) {
                wrong.push(format!("{name}: {part:?} is not in\n{}", run.stderr));
            }
        }
        assert!(names(&folder.path().join("out")).iter().all(|file| !file.ends_with(".part")), "{name}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn the_coupled_fit_gives_the_error_of_the_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let tiny = [["cells = [16, 4, 4], size = [0.16, 0.04, 0.04]", "cells = [4, 2, 2], size = [0.04, 0.02, 0.02]"]];
    let error = |objective: &str| {
        let degree = format!("degree = 2\nobjective = \"{objective}\"");
        let scene = changed(&changed(SMALL, tiny), [["degree = 2", degree.as_str()]]);
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        grosgrain(folder.path(), &["simulate", "scene.toml", "-o", "out"]).done();
        json(&folder.path().join("out/report.json"))["error"]["rms_percent"].as_f64().unwrap()
    };
    let (coupled, closed) = (error("coupled"), error("closed-form"));
    assert!(closed > 1e-3, "{closed} %: without an error there is nothing to compare");
    assert!((coupled - closed).abs() < 1e-6, "{coupled} % coupled, {closed} % in closed form");
}
