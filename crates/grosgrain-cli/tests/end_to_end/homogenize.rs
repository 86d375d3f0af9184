//! `homogenize` from files to files.

use super::program::{Run, grosgrain, names, root};

/// Homogenizes the bimetal bar of `data/meshes` with these materials and further arguments.
fn homogenize(folder: &std::path::Path, materials: &str, more: &[&str]) -> Run {
    let mesh = |name: &str| root().join("data/meshes").join(name).display().to_string();
    std::fs::write(folder.join("materials.toml"), materials).unwrap();
    let (fine, coarse) = (mesh("bimetal.msh"), mesh("bar.msh"));
    let arguments = ["homogenize", &fine, "--onto", &coarse, "--materials", "materials.toml"];
    grosgrain(folder, &[&arguments[..], more].concat())
}

const BOTH: &str = "[materials.a]\nlabel = 1\nyoung = 2e11\npoisson = 0.3\ndensity = 7850.0\n\
                    [materials.b]\nlabel = 2\nyoung = 2e9\npoisson = 0.3\ndensity = 1100.0\n";

#[test]
fn a_bar_of_two_metals_becomes_files_for_three_programs() {
    let folder = tempfile::tempdir().unwrap();
    let run = homogenize(folder.path(), BOTH, &["-o", "bar.vtu", "--npz", "bar.npz", "--json", "bar.json"]).done();
    assert!(run.stdout.contains("16,275 cells") && run.stdout.contains("3,646 cells"), "{}", run.stdout);
    let json = std::fs::read_to_string(folder.path().join("bar.json")).unwrap();
    let figures: serde_json::Value = serde_json::from_str(&json).unwrap();
    // Half of a bar of 10 m³ each.
    let mass = figures["mass"].as_f64().unwrap();
    assert!((mass / (5.0 * (7850.0 + 1100.0)) - 1.0).abs() < 1e-6, "{mass}");
    assert!(figures["mass_difference"].as_f64().unwrap().abs() < 1e-12, "{json}");
    assert_eq!(figures["averaged_cells"].as_array().unwrap().len(), 0);
    homogenize(folder.path(), BOTH, &["-o", "bar.inp", "--coarse-normals"]).done();
    let deck = std::fs::read_to_string(folder.path().join("bar.inp")).unwrap();
    assert_eq!(deck.matches("TYPE=ANISOTROPIC").count(), 3646, "no two cells have the same tensor");
    assert!(!deck.contains("NaN") && !deck.contains("inf"));
    assert_eq!(names(folder.path()), ["bar.inp", "bar.json", "bar.npz", "bar.vtu", "materials.toml"]);
}

#[test]
fn a_mesh_is_made_where_none_is_given_and_fits_are_softer_than_values_at_nodes() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("materials.toml"), BOTH).unwrap();
    let fine = root().join("data/meshes/bimetal.msh").display().to_string();
    let figures = |more: &[&str]| -> serde_json::Value {
        let arguments = ["homogenize", &fine, "--cells", "40", "--materials", "materials.toml", "--json", "f.json"];
        let run = grosgrain(folder.path(), &[&arguments[..], more].concat()).done();
        assert!(run.stderr.contains("made a coarse mesh of"), "{}", run.stderr);
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("f.json")).unwrap()).unwrap()
    };
    let [nodes, fitted, held] = [
        figures(&[]),
        figures(&["--downsampling", "fitted"]),
        // With both ends held nothing stretches the bar, and that strain takes the average.
        figures(&["--held", "x=min", "--held", "x=10", "-o", "held.vtu"]),
    ];
    let cells = nodes["coarse"]["cells"].as_u64().unwrap();
    assert!((25..=60).contains(&cells), "{cells}");
    let of = |figures: &serde_json::Value| figures["worst_stiffening"].as_f64().unwrap();
    // Cells are as high as the bar and hold both metals; their corners move with one of them each.
    assert!(of(&nodes) > 2.0);
    assert!(of(&fitted) < of(&nodes), "{} {}", of(&fitted), of(&nodes));
    assert_eq!(held["averaged_cells"].as_array().unwrap().len() as u64, cells);
    assert_eq!(names(folder.path()), ["bimetal-tensors.vtu", "f.json", "held.vtu", "materials.toml"]);
    let refused = |more: &[&str], part: &str| {
        let arguments = ["homogenize", &fine, "--materials", "materials.toml"];
        let run = grosgrain(folder.path(), &[&arguments[..], more].concat());
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        assert!(run.stderr.contains(part), "{}", run.stderr);
    };
    refused(&[], "--onto");
    refused(&["--cells", "40", "--held", "w=min"], "expected x, y or z");
    refused(&["--cells", "40", "--held", "x=11"], "holds no node");
    refused(&["--cells", "4000000000"], "more than the 16,275 of the body");
}

#[test]
fn what_cannot_be_homogenized_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |materials: &str, more: &[&str], code: i32, parts: &[&str]| {
        let run = homogenize(folder.path(), materials, more);
        assert_eq!(run.code, Some(code), "{}", run.stderr);
        assert!(parts.iter().all(|part| run.stderr.contains(part)), "{}", run.stderr);
        assert_eq!(names(folder.path()), ["materials.toml"]);
    };
    let one = BOTH.split("[materials.b]").next().unwrap();
    refused(one, &["-o", "bar.vtu"], 2, &["materials.toml", "2"]);
    refused("[materials.a]\nlabel = 1\nyoung = -1.0\npoisson = 0.3\n", &[], 2, &["materials.a.young"]);
    refused("title = \"no materials\"\n", &[], 2, &["materials"]);
    refused(BOTH, &["-o", "bar.stl"], 2, &["bar.stl", ".vtu or .inp"]);
    refused(BOTH, &["--scale=-1"], 2, &["positive number"]);
}

#[test]
fn what_is_odd_about_a_mesh_is_told_and_what_is_impossible_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = |name: &str, cells: &[[usize; 4]]| {
        // Two unit tetrahedra whose nodes lie at the same places, and one more apex.
        let corners = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
        let places = corners.iter().chain(&corners).chain(&["1 1 1"]);
        let nodes: String = places.map(|at| format!("{at} 0\n")).collect();
        let cells: Vec<String> = cells.iter().map(|c| format!("{} {} {} {} 1\n", c[0], c[1], c[2], c[3])).collect();
        let text = format!(
            "MeshVersionFormatted 2\nDimension 3\nVertices 9\n{nodes}Tetrahedra {}\n{}End\n",
            cells.len(),
            cells.concat()
        );
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    std::fs::write(folder.path().join("m.toml"), "[materials.a]\nlabel = 1\nyoung = 1e6\npoisson = 0.3\n").unwrap();
    mesh("twins.mesh", &[[1, 2, 3, 4], [5, 6, 7, 8]]);
    mesh("one.mesh", &[[1, 2, 3, 4]]);
    let run = |fine: &str| {
        grosgrain(folder.path(), &["homogenize", fine, "--onto", "one.mesh", "--materials", "m.toml", "-o", "out.vtu"])
    };
    let told = run("twins.mesh").done().stderr;
    assert!(told.contains("2 parts that are not connected") && told.contains("both lie at"), "{told}");
    assert!(told.contains("materials.a has no density"), "{told}");
    std::fs::remove_file(folder.path().join("out.vtu")).unwrap();
    // Three cells at one face.
    mesh("crowded.mesh", &[[1, 2, 3, 4], [2, 3, 4, 9], [2, 3, 4, 5]]);
    let refused = run("crowded.mesh");
    assert_eq!(refused.code, Some(1), "{}", refused.stderr);
    assert!(refused.stderr.contains("crowded.mesh"), "{}", refused.stderr);
    assert_eq!(names(folder.path()), ["crowded.mesh", "m.toml", "one.mesh", "twins.mesh"]);
}
