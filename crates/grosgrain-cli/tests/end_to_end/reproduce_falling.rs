//! Cheese and liver of `reproduce`: bodies that fall in fine and coarse meshes.

use std::path::Path;

use grosgrain::io::mesh::write_mesh;
use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, SimplexLattice, SimplexMesh};
use serde_json::Value;

use super::program::{Run, grosgrain, json, names};

fn reproduce(folder: &Path, arguments: &[&str]) -> (Run, Vec<Value>) {
    let run = grosgrain(folder, &[&["reproduce"], arguments, &["--json", "rows.json"]].concat()).done();
    (run, json(&folder.join("rows.json")).as_array().unwrap().clone())
}

/// The figure of a quantity for a method, and for a half where there are two.
fn measured(rows: &[Value], quantity: &str, method: &str, half: Option<&str>) -> f64 {
    let is_it = |row: &&Value| {
        row["quantity"] == quantity && row["method"] == method && half.is_none_or(|half| row["pattern"] == half)
    };
    let found: Vec<&Value> = rows.iter().filter(is_it).collect();
    assert_eq!(found.len(), 1, "{quantity}, {method}: {found:?}");
    found[0]["measured"].as_f64().unwrap()
}

const COARSE: [&str; 3] = ["tensor", "average", "trilinear"];

fn check_common(rows: &[Value], published: f64) {
    let ratio = rows.iter().find(|row| row["quantity"] == "cost ratio" && row["method"] == "tensor").unwrap();
    assert_eq!(ratio["published"], published);
    assert!(rows.iter().filter(|row| row["quantity"] == "cost ratio").count() == 3);
    let mass = rows.iter().find(|row| row["quantity"] == "mass difference").unwrap();
    assert!(mass["measured"].as_f64().unwrap() < 1e-12, "{mass}");
    for method in COARSE {
        let [mean, worst] = ["mean error", "worst error"].map(|quantity| measured(rows, quantity, method, None));
        assert!(0.0 < mean && mean <= worst && worst < 20.0, "{method}: {mean}, {worst} %");
    }
}

#[test]
fn the_half_of_the_cheese_with_holes_is_softer_and_steps_of_the_coarse_wheel_are_much_cheaper() {
    let folder = tempfile::tempdir().unwrap();
    let (run, rows) = reproduce(folder.path(), &["cheese", "--steps", "6", "-o", "out"]);
    check_common(&rows, 150.0);
    let ratio = measured(&rows, "cost ratio", "tensor", None);
    // Far below what is reached, since other tests run beside this one.
    assert!(ratio > 20.0, "{ratio}");
    let of = |quantity, method, half| measured(&rows, quantity, method, Some(half));
    for method in COARSE {
        let [holed, solid] =
            ["holed half", "solid half"].map(|half| of("compliance over that of cheese", method, half));
        assert!(holed > 1.15 * solid && (0.98..1.05).contains(&solid), "{method}: {holed}, {solid}");
    }
    assert!(of("largest compression", "fine", "holed half") > 0.1, "it has met the ground");
    assert!(run.stdout.contains("6 steps of 0.0025 s") && run.stdout.contains("holes of radius"), "{}", run.stdout);
    let pictures =
        ["cheese-animated.png", "cheese-error.png", "cheese-harmonic.png", "cheese-meshes.png", "cheese.png"];
    assert_eq!(names(&folder.path().join("out")), pictures);
    assert!(pictures.iter().all(|picture| run.stdout.contains(picture)), "{}", run.stdout);
}

/// A box in millimetres, with a vein of each kind through it.
fn body(boxes: [usize; 3]) -> SimplexMesh {
    let around = BoundingBox { lower: [0.0; 3], upper: [80.0, 60.0, 50.0] };
    let mesh = SimplexLattice { dimension: Dimension::Three, boxes, around, cut: BoxCut::Alternating }.mesh().unwrap();
    mesh.tagged(|at| match at {
        [_, y, z] if (y - 15.0).hypot(z - 25.0) < 8.0 => 2,
        [x, _, z] if (x - 60.0).hypot(z - 25.0) < 8.0 => 3,
        _ => 1,
    })
}

#[test]
fn a_liver_of_other_meshes_falls_and_its_veins_make_it_stiffer() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, mesh: &SimplexMesh| write_mesh(folder.path().join(name), mesh, &[]).unwrap();
    write("liver_veins_mid.mesh", &body([8, 6, 5]));
    let missing = grosgrain(folder.path(), &["reproduce", "liver", "--meshes", "."]);
    assert_eq!(missing.code, Some(2), "{}", missing.stderr);
    assert!(missing.stderr.contains("liver_coarse.mesh is missing; expected the figure's mesh"), "{}", missing.stderr);
    write("liver_coarse.mesh", &body([4, 3, 2]).tagged(|_| 1));
    let (run, rows) = reproduce(folder.path(), &["liver", "--steps", "3", "--meshes", "."]);
    check_common(&rows, 100.0);
    assert!(COARSE.iter().all(|method| measured(&rows, "modulus over that of liver", method, None) > 1.0));
    // Eight cells for each of 5 · 240.
    assert!(
        run.stdout.contains("fine 9,600 tetrahedra") && run.stdout.contains("coarse 120 tetrahedra"),
        "{}",
        run.stdout
    );
    assert_eq!(names(folder.path()), ["liver_coarse.mesh", "liver_veins_mid.mesh", "rows.json"]);
}
