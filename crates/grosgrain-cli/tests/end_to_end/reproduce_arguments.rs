//! What `reproduce` lists and refuses.

use super::program::{grosgrain, names};

#[test]
fn reproduce_lists_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let told = grosgrain(folder.path(), &["reproduce", "--list"]).done().stdout;
    let listed: Vec<&str> = told.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(listed, ["table1", "table2", "table3", "fig1", "fig2", "fig3", "fig4", "fig5"], "{told}");
}

#[test]
fn unusable_arguments_of_reproduce_exit_with_2_and_say_what_is_expected() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str], parts: &[&str]| {
        let run = grosgrain(folder.path(), &[&["reproduce"], arguments].concat());
        assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{arguments:?}: {}", run.stderr);
        assert!(parts.iter().all(|part| run.stderr.contains(part)), "{arguments:?}: {}", run.stderr);
    };
    refused(&[], &["NAME"]);
    refused(&["tabel2"], &["did you mean \"table2\"?", "expected table1, table2, table3 or fig1 to fig5"]);
    refused(&["fig9x"], &["nothing is published as \"fig9x\"", "table1, table2, table3 or fig1 to fig5"]);
    refused(&["table1", "--degrees", "8"], &["table1 has degrees 2 to 7, not 8"]);
    refused(&["table1", "table3", "--degrees", "6"], &["table3 has degrees 2 to 5, not 6"]);
    refused(&["table1", "--degrees", "two"], &["two"]);
    refused(&["fig2", "--patterns", "obliqe"], &["did you mean \"oblique\"?"]);
    refused(&["fig1", "--degrees", "4"], &["fig1 is described by its scene; leave --degrees out"]);
    refused(&["fig5", "--patterns", "oblique"], &["fig5 is described by its scene; leave --patterns out"]);
    refused(&["table1", "--steps", "4"], &["table1 has no scene; leave --steps out, which is for fig1, fig4 and fig5"]);
    refused(&["fig1", "fig2", "--scenes", "."], &["fig2 has no scene; leave --scenes out"]);
    refused(&["table2", "--patterns", "oblique"], &["table2 is measured on one body"]);
    std::fs::write(folder.path().join("file"), "precious").unwrap();
    refused(&["fig2", "-o", "file"], &["is a file; results need a folder"]);
    assert_eq!(names(folder.path()), ["file"]);
}
