//! Random bodies with random voids under random gravity and random edits: steps are made or end with a sentence, and nothing else happens.

use std::fmt::Write;

use assert_cmd::Command;
use grosgrain::io::write_volume;
use grosgrain::mesh::Volume;
use proptest::prelude::*;
use serde_json::Value;

const CELLS: [usize; 3] = [6, 4, 4];
const LAWS: [&str; 3] = ["linear", "corotational", "neo-hookean"];

/// An edit of a box of cells.
#[derive(Clone, Debug)]
struct Edited {
    step: usize,
    low: [usize; 3],
    size: [usize; 3],
    change: &'static str,
}

#[derive(Clone, Debug)]
struct Case {
    /// 0 is void; labels 1 and 2.
    labels: Vec<u8>,
    laws: [usize; 2],
    moduli: [f64; 2],
    poisson: f64,
    gravity: [f64; 3],
    held: bool,
    ground: bool,
    integrator: &'static str,
    integration: &'static str,
    update: bool,
    method: &'static str,
    edits: Vec<Edited>,
}

fn edit() -> impl Strategy<Value = Edited> {
    let change = prop::sample::select(vec!["remove = true", "material = \"a\"", "material = \"b\"", "add = \"a\""]);
    (1..5usize, [0..5usize, 0..3usize, 0..3usize], [1..4usize, 1..4usize, 1..4usize], change)
        .prop_map(|(step, low, size, change)| Edited { step, low, size, change })
}

fn case() -> impl Strategy<Value = Case> {
    let label = prop_oneof![1 => Just(0u8), 3 => Just(1u8), 2 => Just(2u8)];
    let body = (
        prop::collection::vec(label, CELLS.iter().product::<usize>()),
        [0..3usize, 0..3usize],
        [1e4..1e6f64, 1e4..1e6f64],
        0.0..0.45f64,
        [-60.0..60.0f64, -60.0..60.0f64, -60.0..60.0f64],
    );
    let run = (
        any::<[bool; 3]>(),
        prop::sample::select(vec!["implicit-euler", "midpoint"]),
        prop::sample::select(vec!["gauss", "centre", "stiffness"]),
        prop::sample::select(vec!["one-ring", "trilinear", "single-cell", "average", "substructured"]),
        prop::collection::vec(edit(), 0..4),
    );
    (body, run).prop_map(
        |((labels, laws, moduli, poisson, gravity), (flags, integrator, integration, method, edits))| {
            let [held, ground, update] = flags;
            Case {
                labels,
                laws,
                moduli,
                poisson,
                gravity,
                held,
                ground,
                integrator,
                integration,
                update,
                method,
                edits,
            }
        },
    )
}

fn scene(case: &Case) -> String {
    let mut text = format!(
        "[body]\nvolume = \"body.nii\"\nvoid = [0]\n\
         [materials.a]\nlabel = 1\nmodel = \"{}\"\nyoung = {}\npoisson = {p}\ndensity = 1000\n\
         [materials.b]\nlabel = 2\nmodel = \"{}\"\nyoung = {}\npoisson = {p}\ndensity = 1500\n\
         [coarsening]\ndegree = 2\nintegration = \"{}\"\nupdate = {}\n\
         [time]\nmode = \"dynamic\"\nstep = 0.01\nsteps = 5\nintegrator = \"{}\"\nhalvings = 3\n\
         [[load]]\ngravity = {:?}\n[output]\ncompare = \"fine\"\npicture = {}\n",
        LAWS[case.laws[0]],
        case.moduli[0],
        LAWS[case.laws[1]],
        case.moduli[1],
        case.integration,
        case.update,
        case.integrator,
        case.gravity,
        case.held && case.ground,
        p = case.poisson,
    );
    if case.held {
        text.push_str("[[fix]]\nwhere = { plane = \"x\", at = \"min\" }\n");
    }
    if case.ground {
        text.push_str("[contact]\nground = { z = -0.001, friction = 0.4 }\n");
    }
    for Edited { step, low, size, change } in &case.edits {
        let high = [0, 1, 2].map(|a| 0.01 * (low[a] + size[a]) as f64 + 1e-3);
        let low = low.map(|i| 0.01 * i as f64 - 1e-3);
        let _ = write!(text, "[[edit]]\nat_step = {step}\nwhere = {{ box = [{low:?}, {high:?}] }}\n{change}\n");
    }
    text
}

fn every_number(value: &Value, visit: &mut impl FnMut(&Value)) {
    match value {
        Value::Array(values) => values.iter().for_each(|value| every_number(value, visit)),
        Value::Object(map) => map.values().for_each(|value| every_number(value, visit)),
        other => visit(other),
    }
}

/// What is wrong with how the run of a case ended.
fn wrong(case: &Case) -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    let values = case.labels.iter().map(|label| f64::from(*label)).collect();
    let volume = Volume { cells: CELLS, spacing: Some([0.01; 3]), voxel_to_world: None, values, integral: true };
    write_volume(folder.path().join("body.nii"), &volume).unwrap();
    std::fs::write(folder.path().join("scene.toml"), scene(case)).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_grosgrain"));
    let arguments = ["--quiet", "simulate", "scene.toml", "-o", "out", "--method", case.method];
    let output = command.current_dir(folder.path()).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if said.contains("panicked") || said.contains("NaN") || said.contains("not finite") {
        return Some(said);
    }
    let stopped = match output.status.code() {
        Some(0) => false,
        // A volume without solid voxels, or with none where it is held.
        Some(2) if said.starts_with("scene.toml:") => return None,
        Some(1) if said.lines().last().is_some_and(|line| line.starts_with("scene.toml: step ")) => true,
        _ => return Some(format!("{:?}: {said}", output.status)),
    };
    let text = std::fs::read_to_string(folder.path().join("out/report.json")).unwrap_or_default();
    let report: Value = serde_json::from_str(&text).unwrap_or_default();
    let mut nulls = 0;
    every_number(&report, &mut |value| nulls += usize::from(value.is_null()));
    let frames = report["frames"].as_array().map_or(0, Vec::len);
    let complete = if stopped { (1..6).contains(&frames) } else { frames == 6 };
    let names = std::fs::read_dir(folder.path().join("out")).unwrap();
    let bodies =
        names.filter(|name| name.as_ref().is_ok_and(|n| n.file_name().to_string_lossy().starts_with("body_0")));
    // JSON has no infinities: they are written as null.
    let sound = nulls == 0 && complete && bodies.count() == frames && stopped == report.get("stopped").is_some();
    (!sound).then(|| format!("{nulls} numbers are not finite, {frames} frames, stopped: {stopped}\n{said}"))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20, failure_persistence: None, max_shrink_iters: 40, ..ProptestConfig::default() })]

    #[test]
    fn every_random_run_ends_well(case in case()) {
        let wrong = wrong(&case);
        prop_assert!(wrong.is_none(), "{}\n{}", wrong.unwrap_or_default(), scene(&case));
    }
}
