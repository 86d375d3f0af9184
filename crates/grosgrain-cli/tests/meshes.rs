//! `inspect` and `convert` with meshes.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;

fn grosgrain(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_grosgrain")).current_dir(folder).args(arguments).output().unwrap()
}

fn mesh(name: &str) -> String {
    let data: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/meshes");
    data.join(name).to_string_lossy().into_owned()
}

fn stdout(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn figures(folder: &Path, file: &str) -> serde_json::Value {
    let text = stdout(&grosgrain(folder, &["inspect", "--json", file]));
    serde_json::from_str::<serde_json::Value>(&text).unwrap()[0].take()
}

#[test]
fn inspect_tells_what_a_mesh_holds() {
    let folder = tempfile::tempdir().unwrap();
    let found = figures(folder.path(), &mesh("bimetal.msh"));
    assert_eq!((&found["kind"], &found["cells_are"]), (&"mesh".into(), &"tetrahedra".into()));
    assert_eq!((&found["nodes"], &found["cells"], &found["parts"]), (&3881.into(), &16275.into(), &1.into()));
    assert_eq!(found["unknowns"], 3 * 3881);
    assert_eq!((&found["low"], &found["high"]), (&vec![0.0; 3].into(), &vec![10.0, 1.0, 1.0].into()));
    let tags = found["tags"].as_array().unwrap();
    assert_eq!(
        (&tags[1]["tag"], &tags[1]["name"], &tags[1]["cells"]),
        (&2.into(), &"top_material".into(), &8204.into())
    );
    assert!((tags[1]["measure"].as_f64().unwrap() - 5.0).abs() < 1e-12);
    let worst = found["worst_quality"].as_f64().unwrap();
    assert!(0.0 < worst && worst < found["mean_quality"].as_f64().unwrap(), "{worst}");
    let told = stdout(&grosgrain(folder.path(), &["inspect", &mesh("bimetal.msh")]));
    for part in
        ["16,275 tetrahedra, 3,881 nodes", "10 × 1 × 1", "tag 1 (bottom_material)  8,071 cells, 50.00 %", "one part"]
    {
        assert!(told.contains(part), "{part} in {told}");
    }
}

#[test]
fn converting_there_and_back_keeps_every_figure() {
    let folder = tempfile::tempdir().unwrap();
    let told = |file: &str| {
        let mut figures = figures(folder.path(), file);
        let figures = figures.as_object_mut().unwrap();
        figures.remove("file");
        figures.remove("skipped");
        figures.clone()
    };
    let first = told(&mesh("liver_veins_mid.mesh"));
    stdout(&grosgrain(folder.path(), &["convert", &mesh("liver_veins_mid.mesh"), "a.msh"]));
    stdout(&grosgrain(folder.path(), &["convert", "a.msh", "b.mesh"]));
    let last = told("b.mesh");
    for (key, figure) in &first {
        // Cells of a Gmsh file stand in the order of tags, so sums may differ in the last bits.
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-13 * b.abs();
        let same = match (figure.as_f64(), last[key].as_f64()) {
            (Some(a), Some(b)) => near(b, a),
            _ if key == "tags" => figure.as_array().unwrap().len() == last[key].as_array().unwrap().len(),
            _ => *figure == last[key],
        };
        assert!(same, "{key}: {figure} and then {}", last[key]);
    }
    stdout(&grosgrain(folder.path(), &["convert", "--scale", "0.001", "a.msh", "metres.msh"]));
    let [small, large] = ["metres.msh", "a.msh"].map(|file| told(file)["measure"].as_f64().unwrap());
    assert!((small / large - 1e-9).abs() < 1e-20, "{small} of {large}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str], code: i32, sentence: &str| {
        let output = grosgrain(folder.path(), arguments);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{told}");
        assert!(told.contains(sentence), "{arguments:?}: {told}");
    };
    let bar = mesh("bar.msh");
    refused(&["convert", &bar, "bar.nrrd"], 2, "expected .msh, .mesh, .vtu or .inp");
    refused(&["convert", &bar, "bar.mesh", "--spacing", "1,1,1"], 2, "--spacing is for volumes; a mesh takes --scale");
    refused(&["convert", &bar, "bar.mesh", "--scale", "0"], 2, "expected a positive number");
    std::fs::write(folder.path().join("old.mesh"), "MFEM mesh v1.0\n").unwrap();
    refused(&["convert", &bar, "old.mesh"], 2, "old.mesh exists; --overwrite replaces it");
    refused(&["inspect", "old.mesh"], 1, "old.mesh: an MFEM mesh cannot be read; save it from MFEM");
    refused(&["convert", "old.mesh", "--overwrite", "./old.mesh"], 2, "belongs to the input and is never overwritten");
    refused(&["convert", "absent.msh", "new.msh"], 2, "absent.msh does not exist; expected a volume or a mesh");
}
