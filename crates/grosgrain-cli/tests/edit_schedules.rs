//! The edits of a scene are due when its tables say.

use grosgrain::mesh::{Label, Selector, VoxelGrid};
use grosgrain::update::{Change, LooseParts, Region};
use grosgrain_cli::body::build_body;
use grosgrain_cli::scene::{Scene, Training, read_scene};
use grosgrain_cli::schedule::EditSchedule;

fn scene(tables: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    let text = format!(
        "[body]\ngrid = {{ cells = [4, 2, 2], size = [4, 2, 2] }}\npattern = {{ kind = \"checkerboard\", labels = [3, 4] }}\n\
         loose = \"keep\"\n[materials.soft]\nlabel = 3\nyoung = 1e5\npoisson = 0.3\n[materials.stiff]\nlabel = 4\n\
         young = 1e6\npoisson = 0.3\n[coarsening]\ndegree = 2\ntraining = \"auto\"\n{tables}"
    );
    std::fs::write(&file, text).unwrap();
    let scene = read_scene(&file).unwrap_or_else(|error| panic!("{error}"));
    build_body(&scene).unwrap_or_else(|error| panic!("{error}"));
    scene
}

fn grid() -> VoxelGrid {
    VoxelGrid::uniform([4, 2, 2], [1.0; 3], Label(3))
}

/// The schedule, and the steps up to three beyond its end at which each edit is due, with its repetition.
fn steps(tables: &str) -> (EditSchedule, Vec<(usize, String, usize)>) {
    let schedule = EditSchedule::new(&scene(tables), &grid());
    let due = |step| schedule.due(step).into_iter().map(move |due| (step, due.key, due.repetition));
    let found = (1..=schedule.steps() + 3).flat_map(due).collect();
    (schedule, found)
}

/// Steps and repetitions of one edit; what stands before | belongs to `[time]`.
fn times(tables: &str) -> Vec<(usize, usize)> {
    let edit = "[[edit]]\nwhere = \"all\"\nyoung = 2e5\n";
    let (time, keys) = tables.split_once('|').unwrap_or(("", tables));
    steps(&format!("[time]\n{time}\n{edit}{keys}")).1.into_iter().map(|(step, _, n)| (step, n)).collect()
}

#[test]
fn an_edit_is_due_at_the_first_step_that_is_not_before_its_time() {
    assert_eq!(times("at_step = 3"), [(3, 0)]);
    assert_eq!(times("step = 0.1|at = 0.3"), [(3, 0)], "0.3 / 0.1 is not 3 in binary");
    assert_eq!(times("step = 0.1|at = 0.31"), [(4, 0)]);
    assert_eq!(times("step = 0.1|at = 0.01"), [(1, 0)]);
}

#[test]
fn repetitions_follow_at_their_interval_until_their_end() {
    assert_eq!(times("at_step = 2\nevery_steps = 3\ntimes = 3"), [(2, 0), (5, 1), (8, 2)]);
    assert_eq!(times("step = 0.1|at = 0.1\nevery = 0.1\ntimes = 4"), [(1, 0), (2, 1), (3, 2), (4, 3)]);
    assert_eq!(times("step = 0.1|at = 0.15\nevery = 0.25\nuntil = 0.9"), [(2, 0), (4, 1), (7, 2), (9, 3)]);
    assert_eq!(times("step = 0.1|at_step = 2\nevery = 0.15\nuntil = 0.5"), [(2, 0), (4, 1), (5, 2)]);
    assert_eq!(times("step = 0.5|at = 1\nevery_steps = 2\ntimes = 2"), [(2, 0), (4, 1)]);
    let endless = times("steps = 7|at_step = 1\nevery_steps = 2");
    assert_eq!(endless[..4], [(1, 0), (3, 1), (5, 2), (7, 3)]);
}

#[test]
fn the_run_ends_with_the_scene_or_with_the_last_edit() {
    let edit = |keys: &str| format!("[[edit]]\nwhere = \"all\"\nyoung = 2e5\n{keys}\n");
    let length = |tables: &str| steps(tables).0.steps();
    assert_eq!(length(""), 0);
    assert_eq!(length("[time]\nsteps = 9"), 0, "without edits there is one equilibrium");
    assert_eq!(length(&format!("[time]\nsteps = 9\n{}", edit("at_step = 2"))), 9);
    let two = edit("at_step = 2") + &edit("at_step = 1\nevery_steps = 4\ntimes = 3");
    assert_eq!(length(&two), 9);
    assert_eq!(steps(&two).1.first().unwrap().1, "edit[1]");
    let schedule = steps(&format!("[time]\nstep = 0.25\n{}", edit("at_step = 2"))).0;
    assert_eq!(schedule.time(2), 0.5);
}

#[test]
fn the_region_advances_and_added_cells_stay_in_the_box() {
    let ball = "where = { sphere = { centre = [1, 1, 1], radius = 1 } }";
    let repeated = "[[edit]]\nat_step = 1\nevery_steps = 1\ntimes = 3\nadvance = [0.5, 0, 1]\nremove = true";
    let due = EditSchedule::new(&scene(&format!("{repeated}\n{ball}")), &grid()).due(3).remove(0);
    let expected = Selector::Sphere { centre: [2.0, 1.0, 3.0], radius: 1.0 };
    assert_eq!((due.edit.region, due.edit.change), (Region::Selector(expected), Change::Remove));
    let changes =
        [("material = \"stiff\"", Change::Material(Label(4)), 24), ("add = \"soft\"", Change::Add(Label(3)), 16)];
    for (change, expected, cells) in changes {
        let tables = format!("[[edit]]\nat_step = 1\nwhere = \"all\"\n{change}");
        let due = EditSchedule::new(&scene(&tables), &grid()).due(1);
        assert_eq!(due[0].edit.change, expected);
        let Region::Selector(selector) = &due[0].edit.region else { panic!("a selector") };
        let padded = VoxelGrid::uniform([6, 2, 2], [1.0; 3], Label(3));
        assert_eq!(selector.cells(&padded).iter().filter(|inside| **inside).count(), cells);
    }
}

#[test]
fn what_is_accepted_with_edits_is_told_where_it_has_no_effect() {
    let edit = "[[edit]]\nat_step = 1\nevery_steps = 1\ntimes = 5\nwhere = \"all\"\nyoung = 2e5";
    let read = scene(&format!("[time]\nstep = 0.1\nsteps = 3\ndamping = 0.1\n{edit}"));
    assert_eq!((read.body.loose, read.coarsening.training), (LooseParts::Keep, Training::Auto));
    let expected =
        ["time.damping has no effect in a static run", "edit[0] repeats up to step 5, but the run ends at step 3"];
    assert_eq!(read.warnings, expected);
}
