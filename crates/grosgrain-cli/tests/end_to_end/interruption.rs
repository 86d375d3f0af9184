//! Ctrl-C ends a run soon and leaves nothing behind.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::program::{SMALL, changed, names};

/// Far longer than a run takes to notice, far shorter than the run itself would take.
const PATIENCE: Duration = Duration::from_secs(15);

#[test]
fn an_interrupted_run_says_so_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let larger = ["cells = [16, 4, 4]", "cells = [192, 48, 48]"];
    std::fs::write(folder.path().join("scene.toml"), changed(SMALL, [larger, ["degree = 2", "degree = 4"]])).unwrap();
    let mut run = Command::new(env!("CARGO_BIN_EXE_grosgrain"))
        .current_dir(folder.path())
        .args(["simulate", "scene.toml", "-o", "out/results"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stderr = BufReader::new(run.stderr.take().unwrap());
    let mut line = String::new();
    while !line.starts_with("building the coarse model") {
        line.clear();
        assert!(stderr.read_line(&mut line).unwrap() > 0, "the run ended by itself");
    }
    std::thread::sleep(Duration::from_millis(500));
    let start = Instant::now();
    let kill = format!("kill -INT {}", run.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    let mut said = String::new();
    stderr.read_to_string(&mut said).unwrap();
    assert_eq!(run.wait().unwrap().code(), Some(1), "{said}");
    assert!(start.elapsed() < PATIENCE, "it took {:?} to stop", start.elapsed());
    assert_eq!(said.lines().last(), Some("interrupted; no half-written file is left"), "{said}");
    assert_eq!(names(folder.path()), ["scene.toml"]);
}
