//! Runs that cannot be made end with one sentence and leave nothing behind.

use super::program::{Run, SMALL, changed, grosgrain, names, write_volumes};

const CASES: &str = include_str!("../data/refused_runs.toml");

fn texts(value: &toml::Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect()
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_is_told_before_anything_is_computed() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (scene, locked) = (folder.path().join("scene.toml"), folder.path().join("locked"));
    std::fs::write(&scene, SMALL).unwrap();
    std::fs::create_dir(&locked).unwrap();
    std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o555)).unwrap();
    if std::fs::write(locked.join("probe"), "").is_ok() {
        return; // The superuser may write everywhere.
    }
    for output in ["locked", "locked/inner"] {
        let Run { code, stderr, .. } = grosgrain(folder.path(), &["simulate", "scene.toml", "-o", output]);
        assert_eq!(code, Some(1), "{stderr}");
        let expected = format!("no file can be written to {output}: ");
        assert!(stderr.starts_with(&expected) && stderr.lines().count() == 1, "{stderr}");
    }
}

/// Whether `text` is `pattern`, in which … stands for any text.
fn fits(text: &str, pattern: &str) -> bool {
    let Some((head, rest)) = pattern.split_once('…') else { return text == pattern };
    let mut parts: Vec<&str> = rest.split('…').collect();
    let tail = parts.pop().unwrap_or_default();
    let Some(middle) = text.strip_prefix(head).and_then(|text| text.strip_suffix(tail)) else { return false };
    parts.into_iter().try_fold(middle, |text, part| text.split_once(part).map(|(_, rest)| rest)).is_some()
}

#[test]
fn the_pattern_of_the_cases_is_strict_outside_its_gaps() {
    assert!(fits("a 1.5 b 2 c", "a … b … c") && fits("ab", "ab"));
    assert!(!fits("a 1.5 c", "a … b … c") && !fits("abc", "ab") && !fits("xab", "a…b"));
}

#[test]
fn every_impossible_run_ends_with_one_sentence_and_leaves_nothing_behind() {
    let table: toml::Table = CASES.parse().unwrap();
    let folder = tempfile::tempdir().unwrap();
    write_volumes(folder.path());
    std::fs::write(folder.path().join("file"), "in the way").unwrap();
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    std::fs::write(folder.path().join("scene.toml"), "").unwrap();
    let before = names(folder.path());
    let mut wrong = Vec::new();
    for case in table["case"].as_array().unwrap() {
        let name = case["name"].as_str().unwrap();
        let base = case.get("base").map_or(SMALL, |base| table[base.as_str().unwrap()].as_str().unwrap());
        let changes = case.get("changes").map_or(Vec::new(), |changes| changes.as_array().unwrap().clone());
        let scene = changed(base, changes.iter().map(|change| texts(change).try_into().unwrap()));
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let arguments =
            case.get("arguments").map_or(vec!["simulate", "scene.toml", "-o", "results/here"], |given| texts(given));
        let Run { code, stdout, stderr } = grosgrain(folder.path(), &arguments);
        let expected = case["code"].as_integer().map(|code| code as i32);
        let says = case["says"].as_str().unwrap();
        if code != expected || !fits(stderr.trim_end(), says.trim_end()) {
            wrong.push(format!("{name}: exit code {code:?}, {expected:?} expected\n{stderr}expected\n{says}"));
        }
        assert_eq!(stdout, "", "{name}");
        assert_eq!(names(folder.path()), before, "{name}: nothing is left behind");
        assert_eq!(names(&folder.path().join("folder")), Vec::<String>::new(), "{name}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}
