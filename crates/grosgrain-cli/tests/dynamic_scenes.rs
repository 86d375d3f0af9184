//! Scenes of dynamic and of nonlinear runs say what their tables say: times, motions, springs, ground.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use grosgrain::coarse::Integration;
use grosgrain::dynamics::{Damping, Integrator};
use grosgrain::dynamics::{Holds, Motion, Ramp, Twist};
use grosgrain::fine::FineModel;
use grosgrain::mesh::Node;
use grosgrain::update::LooseParts;
use grosgrain_cli::body::{Body, build_body};
use grosgrain_cli::held_parts::{check_held_parts, held_parts};
use grosgrain_cli::meshes::MeshProblem;
use grosgrain_cli::placed_loads::PlacedLoads;
use grosgrain_cli::placed_springs::PlacedSprings;
use grosgrain_cli::progress::Progress;
use grosgrain_cli::scene::{Ground, Mode, Scene, SceneError, Start, Time, read_scene};
use grosgrain_cli::schedule::EditSchedule;

const BODY: &str = "[body]\ngrid = { cells = [4, 2, 2], size = [0.4, 0.2, 0.2] }\n\
    pattern = { kind = \"checkerboard\", labels = [0] }\n\
    [materials.soft]\nlabel = 0\nMODEL\nyoung = 1e5\npoisson = 0.3\ndensity = 1000\n";
const DYNAMIC: &str = "[time]\nmode = \"dynamic\"\nstep = 0.01\nsteps = 100\n";
const GRAVITY: &str = "[[load]]\ngravity = [0, 0, -10]\n";
const LEFT: &str = "[[fix]]\nwhere = { plane = \"x\", at = \"min\" }\n";

fn try_read(text: &str) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).unwrap();
    read_scene(&file)
}

/// The scene of [`BODY`] with these tables; `coarsening` follows `degree`.
fn read_with(model: &str, coarsening: &str, tables: &str) -> Scene {
    let text = format!("{}[coarsening]\ndegree = 2\n{coarsening}\n{tables}", BODY.replace("MODEL", model));
    try_read(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn read(tables: &str) -> Scene {
    read_with("", "", tables)
}

fn body(scene: &Scene) -> Body {
    build_body(scene).unwrap_or_else(|error| panic!("{error}"))
}

fn model(scene: &Scene) -> FineModel {
    let body = body(scene);
    FineModel::new(body.grid, &body.materials).unwrap()
}

fn holds(tables: &str) -> Holds {
    let scene = read(&format!("{DYNAMIC}{tables}"));
    let grid = body(&scene).grid;
    let holds = held_parts(&scene, &grid).unwrap();
    check_held_parts(&scene, &grid, &holds).unwrap_or_else(|error| panic!("{error}"));
    holds
}

#[test]
fn every_key_of_a_dynamic_run_is_read() {
    let tables = "[time]\nmode = \"dynamic\"\nstep = 0.02\nsteps = 50\nintegrator = \"midpoint\"\n\
        damping = { mass = 0.1, stiffness = 2e-3 }\ntolerance = 1e-7\nhalvings = 3\n\
        [start]\nvelocity = [1, 2, 3]\nspin = [0, 0, 6]\n\
        [contact]\nground = { z = -0.5, friction = 0.3, stiffness = 1e7 }\n\
        [output]\nanimation = true";
    let scene = read_with("model = \"corotational\"", "integration = \"stiffness\"\nupdate = false", tables);
    let expected = Time {
        mode: Mode::Dynamic,
        step: Some(0.02),
        steps: Some(50),
        integrator: Integrator::Midpoint,
        damping: Damping { mass: 0.1, stiffness: 2e-3 },
        tolerance: 1e-7,
        halvings: 3,
        increments: 1,
        given: vec!["mode", "step", "steps", "integrator", "damping", "tolerance", "halvings"],
    };
    assert_eq!(scene.time, expected);
    assert_eq!(scene.start, Start { velocity: [1.0, 2.0, 3.0], spin: [0.0, 0.0, 6.0] });
    assert_eq!(scene.contact, Some(Ground { z: -0.5, friction: 0.3, stiffness: Some(1e7) }));
    let coarsening = scene.coarsening;
    assert_eq!((coarsening.integration, coarsening.update), (Some(Integration::Stiffness), false));
    assert!(scene.output.animation && scene.is_dynamic() && scene.is_nonlinear());
    assert_eq!(scene.warnings, ["coarsening.update has no effect without edits"]);
    assert!(scene.require_conditions().is_ok(), "neither [[fix]] nor [[load]] is needed");
    assert_eq!(EditSchedule::new(&scene, &body(&scene).grid).steps(), 50);
}

#[test]
fn defaults_of_dynamic_runs_are_those_that_the_documentation_names() {
    let scene = read(&format!("{DYNAMIC}{GRAVITY}[contact]\nground = {{ z = 0 }}"));
    let given = vec!["mode", "step", "steps"];
    let expected = Time { mode: Mode::Dynamic, step: Some(0.01), steps: Some(100), given, ..Time::default() };
    assert_eq!(scene.time, expected);
    let Time { integrator, damping, tolerance, halvings, increments, .. } = scene.time;
    assert_eq!((integrator, damping), (Integrator::ImplicitEuler, Damping { mass: 0.0, stiffness: 0.0 }));
    assert_eq!((tolerance, halvings, increments), (1e-5, 8, 1));
    assert_eq!(scene.contact, Some(Ground { z: 0.0, friction: 0.0, stiffness: None }));
    assert_eq!((scene.start, scene.output.animation), (Start { velocity: [0.0; 3], spin: [0.0; 3] }, false));
    assert_eq!((scene.coarsening.integration_or_default(), scene.coarsening.update), (Integration::Gauss, true));
    assert_eq!((scene.body.loose, read(GRAVITY).body.loose), (LooseParts::Keep, LooseParts::Drop));
    assert_eq!(scene.warnings, Vec::<String>::new());
    let number = read(&format!("{}damping = 0.25\n{GRAVITY}", DYNAMIC));
    assert_eq!(number.time.damping, Damping { mass: 0.25, stiffness: 0.0 });
}

#[test]
fn an_edit_at_the_end_of_a_dynamic_run_is_told_to_come_to_nothing() {
    let warnings = |step: usize, time: &str| {
        read(&format!(
            "{time}{GRAVITY}{LEFT}[[edit]]\nat_step = {step}\nwhere = {{ plane = \"z\", at = 0.15 }}\nremove = true"
        ))
        .warnings
    };
    let told = "edit[0] is due at step 100, when the run ends: nothing moves after it, so it is not made";
    assert_eq!(warnings(100, DYNAMIC), [told]);
    assert_eq!((warnings(99, DYNAMIC), warnings(3, "")), (vec![], vec![]));
}

#[test]
fn a_twist_is_about_the_middle_of_the_part_unless_told_otherwise() {
    let right = "[[fix]]\nwhere = { plane = \"x\", at = \"max\" }\n";
    let motion = |keys: &str| holds(&format!("{right}move = {{ {keys}, to = 1 }}")).0[0].motion;
    let about = |axis, centre| Motion { twist: Twist::about(axis, centre, FRAC_PI_2), translation: [0.0; 3] };
    let found = motion("twist = { axis = \"x\", angle = 90 }");
    assert_eq!(found, about([1.0, 0.0, 0.0], [0.4, 0.1, 0.1]));
    // The corner at y = z = 0 goes where the one at y = 0.2, z = 0 was.
    let u = found.at(1.0).displacement([0.4, 0.0, 0.0]);
    assert!(u[0] == 0.0 && (u[1] - 0.2).abs() < 1e-15 && u[2].abs() < 1e-15, "{u:?}");
    let found = motion("twist = { axis = [0, 3, 4], angle = 90, centre = [1, 2, 3] }");
    assert_eq!(found, about([0.0, 3.0, 4.0], [1.0, 2.0, 3.0]));
    let both = motion("twist = { axis = \"z\", angle = 90 }, translate = [0, 0, 0.5]");
    assert_eq!(both, Motion { translation: [0.0, 0.0, 0.5], ..about([0.0, 0.0, 1.0], [0.4, 0.1, 0.1]) });
    assert_eq!(motion("translate = [0.1, 0, 0]"), Motion::translate([0.1, 0.0, 0.0]));
}

#[test]
fn held_parts_move_and_let_go_when_the_scene_says() {
    let moving = "[[fix]]\nwhere = { plane = \"x\", at = \"max\" }\n\
        move = { translate = [0.2, 0, 0], from = 0.125, to = 0.625 }\nuntil = 0.7\n";
    let holds = holds(&format!("{LEFT}{moving}"));
    assert_eq!((holds.0[1].ramp, holds.0[1].until), (Ramp { from: 0.125, to: 0.625 }, Some(0.7)));
    let end = |time| holds.displacement_at(4, [0.4, 0.0, 0.0], time).map(|u| u[0]);
    assert_eq!([0.0, 0.125, 0.375, 0.7, 0.71].map(end), [Some(0.0), Some(0.0), Some(0.1), Some(0.2), None]);
    assert_eq!(holds.displacement_at(0, [0.0; 3], 0.71), Some([0.0; 3]));
    let count = |time| holds.fixed_at(time, 45).into_iter().filter(|fixed| *fixed).count();
    assert_eq!([0.0, 0.7, 0.8].map(count), [18, 18, 9]);
}

#[test]
fn parts_may_overlap_where_they_agree_or_one_has_let_go() {
    let bottom = "[[fix]]\nwhere = { plane = \"z\", at = \"min\" }\n";
    let pull = "move = { translate = [0, 0, 0.1], to = 0.5 }\n";
    assert_eq!(holds(&format!("{LEFT}{pull}{bottom}{pull}")).0.len(), 2);
    let late = "move = { translate = [0, 0, 0.1], from = 0.4, to = 0.5 }\n";
    holds(&format!("{LEFT}until = 0.4\n{bottom}{late}"));
    let ground = "[contact]\nground = { z = 0 }\n";
    holds(&format!("{LEFT}{bottom}{ground}"));
    let turn = "move = { twist = { axis = \"y\", angle = -90, centre = [0, 0, 0] }, to = 0.5 }\n";
    holds(&format!("{bottom}{turn}{ground}"));
}

#[test]
fn springs_share_their_stiffness_and_loads_grow_and_end() {
    let springs = "[[load]]\nwhere = { plane = \"x\", at = \"max\" }\n\
        spring = { stiffness = 90, offset = [0, 0, 0.02] }\nfrom = 0.2\nto = 0.4\nuntil = 0.8\n";
    let force = "[[load]]\nwhere = { plane = \"x\", at = \"max\" }\nforce = [18, 0, 0]\nto = 0.5\n";
    let scene = read(&format!("{DYNAMIC}{springs}{force}{GRAVITY}until = 0.3"));
    let model = model(&scene);
    let placed = PlacedSprings::of(&scene, &model).unwrap();
    assert_eq!((placed.len(), placed[0].nodes.len(), placed[0].stiffness), (1, 9, 10.0));
    let stiffness = [0.1, 0.3, 0.4, 0.8, 0.9].map(|time| placed[0].stiffness_at(time));
    let expected = [0.0, 5.0, 10.0, 10.0, 0.0];
    assert!(stiffness.iter().zip(expected).all(|(found, k): (&f64, f64)| (found - k).abs() < 1e-12), "{stiffness:?}");
    assert_eq!(placed[0].anchor(Node(4), &model), [0.4, 0.0, 0.02]);
    let loads = PlacedLoads::new(&scene, &model).unwrap();
    let total = |time: f64, r: usize| loads.assemble(&model, time).iter().skip(r).step_by(3).sum::<f64>();
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} instead of {expected}");
    [(0.0, 0.0), (0.25, 9.0), (0.5, 18.0), (9.0, 18.0)].iter().for_each(|(time, pull)| near(total(*time, 0), *pull));
    let weight = -10.0 * 1000.0 * 0.4 * 0.2 * 0.2;
    [(0.0, weight), (0.3, weight), (0.31, 0.0)].iter().for_each(|(time, force)| near(total(*time, 2), *force));
    assert!(loads.differ(0.1, 0.2) && loads.differ(0.3, 0.31) && !loads.differ(0.6, 0.7));
    let in_full = loads.in_full(&model);
    near(in_full.iter().skip(2).step_by(3).sum(), weight);
    near(in_full.iter().step_by(3).sum(), 18.0);
}

#[test]
fn static_runs_hang_on_springs_and_are_driven_by_motions() {
    let refused = |tables: &str| read(tables).require_conditions().map_err(|error| error.to_string());
    let spring = "[[load]]\nwhere = { plane = \"x\", at = \"max\" }\nspring = { stiffness = 90OFFSET }\n";
    let (rest, pull) = (spring.replace("OFFSET", ""), spring.replace("OFFSET", ", offset = [0, 0, 0.1]"));
    assert!(refused(&format!("{rest}{GRAVITY}")).is_ok() && refused(&pull).is_ok());
    assert!(refused(&rest).unwrap_err().contains("nothing loads the body"));
    assert!(refused(&format!("{LEFT}move = {{ translate = [0.1, 0, 0] }}")).is_ok());
    assert!(refused(LEFT).unwrap_err().contains("nothing loads the body"));
    assert!(refused(GRAVITY).unwrap_err().contains("the body hangs on nothing"));
}

#[test]
fn a_nonlinear_static_run_has_no_warning_and_uses_the_keys_of_newtons_method() {
    let tables = format!("[time]\ntolerance = 1e-8\nincrements = 4\nhalvings = 2\n{LEFT}{GRAVITY}");
    for law in ["corotational", "neo-hookean"] {
        let scene = read_with(&format!("model = \"{law}\""), "integration = \"centre\"", &tables);
        assert_eq!((scene.warnings.as_slice(), scene.time.increments), (&[] as &[String], 4));
    }
    let told = |key: &str| format!("{key} has no effect in a static run of linear materials");
    let expected = ["time.tolerance", "time.halvings", "time.increments"].map(told);
    assert_eq!(read(&tables).warnings, expected);
    let idle = read_with("", "integration = \"centre\"", &format!("{LEFT}{GRAVITY}"));
    assert_eq!(idle.warnings, ["coarsening.integration has no effect on linear materials"]);
}

#[test]
fn what_has_no_effect_or_comes_too_late_is_told() {
    let fix = format!("{LEFT}move = {{ translate = [0, 0, 0.1], from = 0.2, to = 3 }}\n");
    let load = format!("{GRAVITY}from = 2\nto = 3\n");
    let dynamic = read(&format!("{DYNAMIC}increments = 2\n{fix}until = 4\n{load}"));
    let expected = [
        "time.increments has no effect in a dynamic run",
        "fix[0].move.to is 3 s, but the run ends at 1 s",
        "load[0].from is 2 s, but the run ends at 1 s",
    ];
    assert_eq!(dynamic.warnings, expected);
    let still = read(&format!("[start]\nspin = [0, 0, 1]\n[output]\nanimation = true\n{fix}{load}"));
    let expected = [
        "start has no effect in a static run",
        "output.animation has no effect on a single equilibrium",
        "fix[0].move.from has no effect in a static run without edits",
        "fix[0].move.to has no effect in a static run without edits",
        "load[0].from has no effect in a static run without edits",
        "load[0].to has no effect in a static run without edits",
    ];
    assert_eq!(still.warnings, expected);
    let idle = ["nothing sets the body in motion: there is no load, no moving [[fix]] and no velocity in [start]"];
    assert_eq!(read(DYNAMIC).warnings, idle);
    assert_eq!(read(&format!("{DYNAMIC}{LEFT}")).warnings, idle);
    for cause in
        [GRAVITY, "[start]\nvelocity = [1, 0, 0]\n", &format!("{LEFT}move = {{ translate = [0, 0, 1], to = 1 }}")]
    {
        assert_eq!(read(&format!("{DYNAMIC}{cause}")).warnings, Vec::<String>::new(), "{cause}");
    }
}

#[test]
fn the_scenes_in_the_documentation_can_be_read_and_hold_together() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = std::fs::read_to_string(root.join("docs/scenes.md")).unwrap();
    let blocks = text.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
    let (whole, parts): (Vec<&str>, Vec<&str>) = blocks.partition(|block| block.starts_with("title ="));
    assert_eq!(whole.len(), 3);
    let meshes = format!("mesh = \"{}/", root.join("data/meshes").canonicalize().unwrap().display());
    for text in whole {
        let text = text.replace("mesh = \"", &meshes);
        let scene = try_read(&text).unwrap_or_else(|error| panic!("{error}"));
        if scene.is_mesh() {
            let problem = MeshProblem::new(scene, &Progress::new(true)).unwrap_or_else(|error| panic!("{error}"));
            problem.require_support().unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(problem.scene.warnings, Vec::<String>::new(), "{}", problem.scene.title);
            continue;
        }
        let grid = body(&scene).grid;
        let holds = held_parts(&scene, &grid).unwrap();
        check_held_parts(&scene, &grid, &holds).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.warnings, Vec::<String>::new(), "{}", scene.title);
    }
    let tables: Vec<&str> = parts.into_iter().filter(|block| block.starts_with("[[")).collect();
    assert!(tables.len() >= 3);
    for table in tables {
        read(&format!("{DYNAMIC}{table}"));
    }
}
