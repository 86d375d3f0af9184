//! README, tutorial and help texts name commands that exist and files that are there.

use std::collections::BTreeSet;
use std::path::Path;

use clap::Parser;
use grosgrain_cli::arguments::Arguments;

use super::program::{grosgrain, root};
use super::scenes::torso;

const START: [&str; 2] =
    ["cargo run --release -- simulate scenes/torso.toml -o out/torso", "cargo test --release --workspace"];
/// What a file's name ends with in a command.
const FILES: [&str; 8] = [".toml", ".nii.gz", ".nii", ".npz", ".json", ".nrrd", ".mha", ".tif"];

fn text(file: &str) -> String {
    std::fs::read_to_string(root().join(file)).unwrap()
}

/// The lines of the code blocks of `language`.
fn blocks<'t>(text: &'t str, language: &str) -> Vec<&'t str> {
    let fence = format!("```{language}\n");
    text.split(fence.as_str()).skip(1).filter_map(|rest| rest.split("```").next()).collect()
}

/// The words of a command line of this program, its name first.
fn words(line: &str) -> Option<Vec<&str>> {
    let rest = line.trim().strip_prefix("cargo run --release --").or(line.trim().strip_prefix("grosgrain "))?;
    Some(std::iter::once("grosgrain").chain(rest.split_whitespace()).collect())
}

/// The files that a command reads, and those that it writes.
fn files<'w>(words: &[&'w str]) -> (Vec<&'w str>, Vec<&'w str>) {
    let is_file = |n: &usize| FILES.iter().any(|ending| words[*n].ends_with(ending));
    let is_output =
        |n: &usize| ["-o", "--output", "--json"].contains(&words[n - 1]) || (words[1] == "convert" && *n == 3);
    let (written, read): (Vec<usize>, Vec<usize>) = (1..words.len()).filter(is_file).partition(is_output);
    let names = |places: Vec<usize>| places.into_iter().map(|n| words[n]).collect();
    (names(read), names(written))
}

/// Parses every command and requires that its files exist or were made by the commands before.
fn check_commands(place: &str, lines: &[&str], mut made: BTreeSet<String>) {
    let commands: Vec<Vec<&str>> = lines.iter().filter_map(|line| words(line)).collect();
    assert!(!commands.is_empty(), "{place} has no command");
    for words in commands {
        let line = words.join(" ");
        if let Err(error) = Arguments::try_parse_from(&words) {
            panic!("{place}: {line}: {error}");
        }
        let (read, written) = files(&words);
        for file in read {
            assert!(made.contains(file) || root().join(file).exists(), "{place}: {line}: there is no {file}");
        }
        made.extend(written.into_iter().map(String::from));
    }
}

#[test]
fn the_readme_starts_with_the_two_commands_and_the_first_one_works() {
    let readme = text("README.md");
    let start = blocks(&readme, "sh")[0];
    assert_eq!(start.lines().collect::<Vec<_>>(), START);
    let command = words(START[0]).unwrap();
    assert_eq!(command, ["grosgrain", "simulate", "scenes/torso.toml", "-o", "out/torso"]);
    let told = &torso().run.stdout;
    assert!(told.contains("error against the fine model") && told.contains("wrote "), "{told}");
}

#[test]
fn every_command_of_readme_tutorial_and_reproduction_can_be_run_in_its_order() {
    for file in ["README.md", "docs/tutorial.md", "docs/reproduction.md"] {
        let text = text(file);
        let lines: Vec<&str> = blocks(&text, "sh").into_iter().flat_map(str::lines).collect();
        let saved = text.split("Save this as `").skip(1).filter_map(|rest| rest.split('`').next()).map(String::from);
        check_commands(file, &lines, saved.collect());
    }
}

#[test]
fn the_scene_of_the_tutorial_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let text = text("docs/tutorial.md");
    let scene = blocks(&text, "toml")[0].replace("../data", &root().join("data").to_string_lossy());
    std::fs::write(folder.path().join("my-torso.toml"), scene).unwrap();
    let run = grosgrain(folder.path(), &["inspect", "my-torso.toml"]).done();
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);
}

#[test]
fn every_example_of_the_help_texts_names_files_that_exist() {
    for command in ["", "inspect", "coarsen", "simulate", "compare", "reproduce", "convert"] {
        let arguments: Vec<&str> = command.split_whitespace().chain(["--help"]).collect();
        let help = grosgrain(Path::new("."), &arguments).done().stdout;
        let examples: Vec<&str> = help.split("Examples:\n").nth(1).unwrap().lines().collect();
        assert_eq!(examples.len(), 2, "{help}");
        check_commands(&format!("the help of {command:?}"), &examples, BTreeSet::new());
    }
}
