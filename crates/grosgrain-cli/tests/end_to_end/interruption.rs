//! Ctrl-C ends a run soon and leaves nothing behind.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::moving::{BAR, GRAVITY};
use super::program::{SMALL, changed, names};
use super::vtu::Vtu;

/// Far longer than a run takes to notice, far shorter than the run itself would take.
const PATIENCE: Duration = Duration::from_secs(15);

/// Starts the program, sends Ctrl-C half a second after the line that starts with `line`, and requires that it ends soon and says why.
fn interrupt(folder: &Path, arguments: &[&str], line: &str) {
    let mut run = Command::new(env!("CARGO_BIN_EXE_grosgrain"))
        .current_dir(folder)
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stderr = BufReader::new(run.stderr.take().unwrap());
    let mut read = String::new();
    while !read.starts_with(line) {
        read.clear();
        assert!(stderr.read_line(&mut read).unwrap() > 0, "the run ended by itself");
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
}

#[test]
fn an_interrupted_run_says_so_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let larger = ["cells = [16, 4, 4]", "cells = [192, 48, 48]"];
    std::fs::write(folder.path().join("scene.toml"), changed(SMALL, [larger, ["degree = 2", "degree = 4"]])).unwrap();
    interrupt(folder.path(), &["simulate", "scene.toml", "-o", "out/results"], "building the coarse model");
    assert_eq!(names(folder.path()), ["scene.toml"]);
}

#[test]
fn an_interrupted_reproduction_says_so_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["reproduce", "table1", "--degrees", "6", "-o", "out", "--json", "rows/table1.json"];
    interrupt(folder.path(), &arguments, "oblique, d = 6: fine model");
    assert!(names(folder.path()).is_empty());
}

#[test]
fn an_interrupted_motion_leaves_whole_frames() {
    let folder = tempfile::tempdir().unwrap();
    let longer = ["steps = 8", "steps = 100000"];
    let scene = format!("{}\n{GRAVITY}", changed(BAR, [longer]));
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    interrupt(folder.path(), &["simulate", "scene.toml", "-o", "out"], "building the coarse model");
    let found = names(&folder.path().join("out"));
    let frames: Vec<&String> = found.iter().filter(|name| name.starts_with("body_")).collect();
    assert!(frames.len() > 3, "{found:?}");
    assert!(found.iter().all(|name| name.ends_with(".vtu") || name.ends_with(".pvd")), "{found:?}");
    for name in frames {
        assert!(!Vtu::read(&folder.path().join("out").join(name)).numbers("von_mises").is_empty(), "{name}");
    }
}

#[test]
fn an_interrupted_figure_of_motion_says_so_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let motion = "degree = 2\n[time]\nmode = \"dynamic\"\nstep = 0.01\nsteps = 1000000";
    std::fs::write(folder.path().join("fig1-beam.toml"), changed(SMALL, [["degree = 2", motion]])).unwrap();
    interrupt(
        folder.path(),
        &["reproduce", "fig1", "--scenes", ".", "-o", "out", "--json", "rows/fig1.json"],
        "steps:",
    );
    assert_eq!(names(folder.path()), ["fig1-beam.toml"]);
}
