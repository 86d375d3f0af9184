//! The architecture is what ARCHITECTURE.md and `lib.rs` say: modules in order, short files, known sources.

use std::fs;
use std::path::{Path, PathBuf};

/// Longest file of source or tests.
const LONGEST_FILE: usize = 500;
const VAGUE_NAMES: [&str; 8] = ["util", "utils", "common", "helper", "helpers", "core", "manager", "misc"];

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All files below a folder with this extension, and all folders.
fn walk(folder: &Path, extension: &str) -> (Vec<PathBuf>, Vec<PathBuf>) {
    let (mut files, mut folders) = (Vec::new(), Vec::new());
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            let (inner_files, inner_folders) = walk(&path, extension);
            files.extend(inner_files);
            folders.extend(inner_folders);
            folders.push(path);
        } else if path.extension().is_some_and(|e| e == extension) {
            files.push(path);
        }
    }
    files.sort();
    (files, folders)
}

/// Source and test folders of every crate of the workspace.
fn code_folders() -> Vec<PathBuf> {
    let crates = fs::read_dir(workspace().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    crates.flat_map(|c| ["src", "tests", "benches", "examples"].map(|f| c.join(f))).filter(|f| f.is_dir()).collect()
}

/// The modules of the library in the order in which `lib.rs` declares them.
fn modules() -> Vec<String> {
    let text = fs::read_to_string(workspace().join("crates/grosgrain/src/lib.rs")).unwrap();
    let names = text.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    names.map(str::to_owned).collect()
}

/// The module that a source file belongs to.
fn module_of(file: &Path) -> String {
    let inside = file.strip_prefix(workspace().join("crates/grosgrain/src")).unwrap();
    let first = inside.components().next().unwrap().as_os_str().to_str().unwrap();
    first.trim_end_matches(".rs").to_owned()
}

/// Number of segments of a file's module path: 1 for `mesh/mod.rs`, 2 for `mesh/lattice.rs`.
fn depth_of(file: &Path) -> usize {
    let inside = file.strip_prefix(workspace().join("crates/grosgrain/src")).unwrap();
    inside.components().count() - usize::from(file.file_name().is_some_and(|name| name == "mod.rs"))
}

/// First path segments after every `crate::` in a line, also those of `crate::{a::…, b}`.
fn named_modules(line: &str) -> Vec<String> {
    let identifier = |text: &str| -> String { text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect() };
    let mut found = Vec::new();
    for (start, pattern) in line.match_indices("crate::") {
        let rest = &line[start + pattern.len()..];
        match rest.strip_prefix('{') {
            None => found.push(identifier(rest)),
            Some(list) => found.extend(list.split(',').map(|item| identifier(item.trim()))),
        }
    }
    found.retain(|name| !name.is_empty());
    found
}

#[test]
fn the_reader_of_module_names_finds_them() {
    assert_eq!(named_modules("use crate::mesh::{Cell, Node}; // crate::fine"), ["mesh", "fine"]);
    assert_eq!(named_modules("use crate::{linalg::X, mesh};"), ["linalg", "mesh"]);
    assert!(named_modules("use super::mesh;").is_empty());
}

#[test]
fn a_module_names_only_modules_above_it() {
    let modules = modules();
    assert!(modules.len() >= 13, "lib.rs declares {modules:?}");
    let place = |name: &str| modules.iter().position(|m| m == name);
    let mut seen = 0;
    for file in walk(&workspace().join("crates/grosgrain/src"), "rs").0 {
        let own = module_of(&file);
        if own == "lib" {
            continue;
        }
        let own_place = place(&own).unwrap_or_else(|| panic!("{} is no module of lib.rs", file.display()));
        let text = fs::read_to_string(&file).unwrap();
        let mut depth = depth_of(&file);
        for (line, number) in text.lines().zip(1..) {
            depth += usize::from(line == "mod tests {");
            let climbs = (1..9).rev().find(|n| line.contains(&"super::".repeat(*n))).unwrap_or(0);
            assert!(climbs < depth, "{}:{number} climbs out of `{own}`", file.display());
            for named in named_modules(line) {
                let allowed = place(&named).is_some_and(|p| p <= own_place);
                assert!(allowed, "{}:{number} names `{named}`, which is not above `{own}`", file.display());
                seen += 1;
            }
        }
    }
    assert!(seen > 50, "only {seen} names of modules found");
}

#[test]
fn architecture_md_lists_the_modules_in_their_order() {
    let text = fs::read_to_string(workspace().join("ARCHITECTURE.md")).unwrap();
    let listed: Vec<String> = text
        .split("```")
        .skip(1)
        .step_by(2)
        .flat_map(str::lines)
        .filter_map(|line| Some(line.trim().strip_prefix("src/")?.split_once('/')?.0.to_owned()))
        .collect();
    assert_eq!(listed, modules(), "ARCHITECTURE.md against lib.rs");
}

#[test]
fn no_folder_or_file_has_a_vague_name() {
    for folder in code_folders() {
        let (files, folders) = walk(&folder, "rs");
        for path in files.iter().chain(&folders) {
            let name = path.file_stem().unwrap().to_str().unwrap();
            assert!(!VAGUE_NAMES.contains(&name), "{}: a concept is missing", path.display());
        }
    }
}

#[test]
fn files_are_short() {
    for file in code_folders().iter().flat_map(|folder| walk(folder, "rs").0) {
        let lines = fs::read_to_string(&file).unwrap().lines().count();
        assert!(lines <= LONGEST_FILE, "{} has {lines} lines, more than {LONGEST_FILE}", file.display());
    }
}

/// Words in backticks made of a name, a year and a word, all in small letters.
fn source_keys(text: &str) -> Vec<String> {
    let is_key = |word: &&str| {
        let name = word.chars().take_while(char::is_ascii_lowercase).count();
        let year = word[name..].chars().take_while(char::is_ascii_digit).count();
        let title = &word[name + year..];
        name >= 2 && year == 4 && title.len() >= 2 && title.chars().all(|c| c.is_ascii_lowercase())
    };
    text.lines().flat_map(|line| line.split('`').skip(1).step_by(2)).filter(is_key).map(str::to_owned).collect()
}

#[test]
fn every_work_stands_in_the_bibliography_once_and_is_closed() {
    let bibliography = fs::read_to_string(workspace().join("docs/references.bib")).unwrap();
    let mut keys: Vec<&str> = Vec::new();
    let mut depth = 0i64;
    for line in bibliography.lines() {
        if let Some(entry) = line.strip_prefix('@') {
            assert_eq!(depth, 0, "the entry before {entry:?} has no end");
            let key = entry.split(['{', ',']).nth(1).unwrap_or_default();
            assert!(!keys.contains(&key), "{key} stands there twice");
            keys.push(key);
        }
        depth += line.matches('{').count() as i64 - line.matches('}').count() as i64;
    }
    assert!(depth == 0 && keys.len() > 20, "{depth} {}", keys.len());
}

#[test]
fn every_cited_source_is_in_the_bibliography() {
    assert_eq!(source_keys("see (`he2022fast`, `x`) and `pub fn`"), ["he2022fast"]);
    let bibliography = fs::read_to_string(workspace().join("docs/references.bib")).unwrap();
    let mut keys: Vec<String> = code_folders()
        .iter()
        .flat_map(|folder| walk(folder, "rs").0)
        .flat_map(|file| source_keys(&fs::read_to_string(file).unwrap()))
        .collect();
    keys.sort();
    keys.dedup();
    assert!(keys.iter().any(|key| key == "kharevych2009numerical"), "found {keys:?}");
    for key in keys {
        assert!(bibliography.contains(&format!("{{{key},")), "`{key}` is not in docs/references.bib");
    }
}
