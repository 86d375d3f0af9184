//! What `reproduce` lists and refuses.

use super::program::{grosgrain, names};

#[test]
fn reproduce_lists_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let told = grosgrain(folder.path(), &["reproduce", "--list"]).done().stdout;
    let indented = told.lines().filter(|line| line.starts_with(' '));
    let listed: Vec<&str> = indented.filter_map(|line| line.split_whitespace().next()).collect();
    let fast = ["table1", "table2", "table3", "fig1", "fig2", "fig3", "fig4", "fig5"];
    assert_eq!(
        listed,
        [&fast[..], &["springs", "homogeneous", "layers", "crack", "composite", "cheese", "liver"]].concat(),
        "{told}"
    );
}

#[test]
fn springs_and_homogeneous_bodies_are_exact() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["reproduce", "springs", "homogeneous", "--json", "rows.json"];
    let told = grosgrain(folder.path(), &arguments).done().stdout;
    assert!(told.contains("springs in series") && told.contains("tetrahedra"), "{told}");
    let rows: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("rows.json")).unwrap()).unwrap();
    for row in rows.as_array().unwrap() {
        let [published, measured] = ["published", "measured"].map(|key| row[key].as_f64().unwrap());
        let exact = match row["name"].as_str().unwrap() {
            "springs" => (measured / published - 1.0).abs() < 1e-12,
            _ => measured < 1e-10,
        };
        assert!(exact, "{row}");
    }
    assert_eq!(rows.as_array().unwrap().len(), 7);
}

#[test]
fn a_composite_on_coarse_triangles_is_shown_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let told = grosgrain(folder.path(), &["reproduce", "composite", "--json", "rows.json", "-o", "out"]).done().stdout;
    assert!(told.contains("without figures") && told.contains("harmonic, blended"), "{told}");
    assert_eq!(names(&folder.path().join("out")), ["composite.png"]);
    let rows: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("rows.json")).unwrap()).unwrap();
    let value = |quantity: &str, pattern: &str, method: &str| {
        let wanted = [quantity, pattern, method, "coarse equilibrium"];
        let keys = ["quantity", "pattern", "method", "setting"];
        let is_wanted = |row: &&serde_json::Value| keys.iter().zip(wanted).all(|(key, wanted)| row[key] == wanted);
        rows.as_array().unwrap().iter().find(is_wanted).unwrap()["measured"].as_f64().unwrap()
    };
    let energy = "elastic energy over that of the fine equilibrium";
    for mesh in ["1 triangle", "4 triangles", "16 triangles"] {
        let [barycentric, harmonic] = ["barycentric", "harmonic"].map(|map| value("error", mesh, map));
        assert!(harmonic < barycentric && barycentric < 50.0, "{mesh}: {harmonic} % and {barycentric} %");
    }
    // The barycentric map stretches stiff bands as much as soft ones.
    assert!(value(energy, "1 triangle", "barycentric") > 8.0);
    assert!((0.5..2.0).contains(&value(energy, "1 triangle", "harmonic")));
    assert!((0.5..2.0).contains(&value(energy, "4 triangles", "harmonic, blended")));
    assert_eq!(rows.as_array().unwrap().len(), 32);
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
    refused(
        &["tabel2"],
        &[
            "did you mean \"table2\"?",
            "expected table1, table2, table3, fig1, fig2, fig3, fig4, fig5, springs, homogeneous, layers, crack, composite, cheese and liver",
        ],
    );
    refused(
        &["fig9x"],
        &[
            "nothing is published as \"fig9x\"",
            "table1, table2, table3, fig1, fig2, fig3, fig4, fig5, springs, homogeneous, layers, crack, composite, cheese and liver",
        ],
    );
    refused(&["table1", "--degrees", "8"], &["table1 has degrees 2 to 7, not 8"]);
    refused(&["table1", "table3", "--degrees", "6"], &["table3 has degrees 2 to 5, not 6"]);
    refused(&["table1", "--degrees", "two"], &["two"]);
    refused(&["fig2", "--patterns", "obliqe"], &["did you mean \"oblique\"?"]);
    refused(&["fig1", "--degrees", "4"], &["fig1 is described by its scene; leave --degrees out"]);
    refused(&["fig5", "--patterns", "oblique"], &["fig5 is described by its scene; leave --patterns out"]);
    refused(&["table1", "--steps", "4"], &["table1 has no scene; leave --steps out, which is for fig1, fig4 and fig5"]);
    refused(&["fig1", "fig2", "--scenes", "."], &["fig2 has no scene; leave --scenes out"]);
    refused(&["cheese", "--meshes", "."], &["cheese reads no meshes; leave --meshes out, which is for liver"]);
    refused(&["springs", "--degrees", "4"], &["springs has nothing to choose; leave --degrees out"]);
    refused(&["table2", "--patterns", "oblique"], &["table2 is measured on one body"]);
    std::fs::write(folder.path().join("file"), "precious").unwrap();
    refused(&["fig2", "-o", "file"], &["is a file; results need a folder"]);
    assert_eq!(names(folder.path()), ["file"]);
}
