//! A live model after any edits is the model that is built from scratch on the edited body.

mod bodies;

use bodies::*;
use grosgrain::coarse::CoarseModel;
use grosgrain::coarsening::BaseKind;
use grosgrain::fine::FineModel;
use grosgrain::mesh::{Brush, Cell, Cut, Label, Selector, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::training::{RunTimeTraining, TrainingKind};
use grosgrain::update::{Change, Edit, LiveError, LiveModel, LiveOptions, LooseParts, Region};
use proptest::prelude::*;

const SPACING: [f64; 3] = [1.0, 0.8, 1.2];

fn body(coarse: [usize; 3], degree: usize, void: f64, seed: u64) -> Option<FineModel> {
    let mut grid = VoxelGrid::uniform(coarse.map(|n| n * degree), SPACING, Label(0));
    let mut random = Uniform(seed);
    for c in 0..grid.lattice.cell_count() {
        grid.void[c] = random.next() < void;
        grid.labels[c] = Label(i32::from(random.next() < 0.5));
    }
    FineModel::new(grid, &table(&[isotropic(1.0, 0.3), isotropic(50.0, 0.45)])).ok()
}

fn options(kind: TrainingKind) -> LiveOptions {
    let training = RunTimeTraining::Fixed(kind);
    LiveOptions { training, loose: LooseParts::Keep, undo_depth: 8, ..LiveOptions::default() }
}

fn live(fine: FineModel, degree: usize, options: &LiveOptions) -> LiveModel {
    let nodes = fine.grid().lattice.node_count();
    LiveModel::new(fine, degree, options, vec![false; nodes], &silent).unwrap()
}

fn edit(kind: usize, at: [f64; 3], size: f64) -> Edit {
    let ball = Selector::Sphere { centre: at, radius: size };
    let (selector, change) = match kind {
        0 => (ball, Change::Material(Label(1))),
        1 => (ball, Change::Young(7.0)),
        2 => (ball, Change::Remove),
        3 => (ball, Change::Add(Label(0))),
        4 => {
            let normal = [1.0, 0.3 * size - 0.5, 0.2];
            (Selector::Cut(Cut { point: at, normal, radius: Some(2.0 * size) }), Change::Remove)
        }
        _ => {
            let path = vec![at, [at[0] + size, at[1], at[2] - size]];
            (Selector::Brush(Brush { path, radius: 0.7 }), Change::Material(Label(0)))
        }
    };
    Edit { region: Region::Selector(selector), change }
}

/// Largest difference of functions and stiffness, relative to the largest entries.
fn difference(a: &CoarseModel, b: &CoarseModel) -> f64 {
    assert_eq!(a.mesh(), b.mesh(), "another mesh");
    let mut worst = relative(a.mass(), b.mass());
    for index in 0..a.elements().len() {
        worst = worst.max(relative(a.functions().of(index), b.functions().of(index)));
        worst = worst.max(relative(a.stiffness(index), b.stiffness(index)));
    }
    worst
}

/// The same for models whose meshes may differ: infinite then.
fn difference_of_bodies(a: &CoarseModel, b: &CoarseModel) -> f64 {
    if a.mesh() == b.mesh() { difference(a, b) } else { f64::INFINITY }
}

fn check(
    kind: TrainingKind,
    coarse: [usize; 3],
    degree: usize,
    void: f64,
    edits: &[Edit],
    seed: u64,
) -> Result<(), TestCaseError> {
    let Some(fine) = body(coarse, degree, void, seed) else { return Ok(()) };
    let options = options(kind);
    let mut model = live(fine, degree, &options);
    let start = model.coarse().clone();
    let mut done = 0;
    for edit in edits {
        let before = model.coarse().clone();
        match model.apply(edit) {
            Ok(report) => {
                done += usize::from(report.changed > 0);
                let rebuilt = live(model.fine().clone(), degree, &options);
                let error = difference(model.coarse(), rebuilt.coarse());
                prop_assert!(error <= 1e-9, "{kind:?}: {error} after {edit:?}");
                if kind != TrainingKind::Global {
                    prop_assert_eq!(error, 0.0, "one code path, so the same bits");
                }
                prop_assert!(report.dirty >= report.changed.min(1) && report.seconds.total > 0.0);
            }
            Err(LiveError::Batch(_) | LiveError::Edit(_)) => {
                prop_assert_eq!(difference(model.coarse(), &before), 0.0, "a refused edit changes nothing");
            }
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
    prop_assert_eq!(model.undo_depth(), done.min(8));
    while let Some(report) = model.undo(&silent).unwrap() {
        prop_assert!(report.changed > 0);
    }
    prop_assert!(difference(model.coarse(), &start) <= 1e-9, "undone");
    Ok(())
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let one = (0usize..6, [0.0..9.0f64, 0.0..7.0, 0.0..7.0], 0.6..2.5f64);
    proptest::collection::vec(one.prop_map(|(kind, at, size)| edit(kind, at, size)), 1..6)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn updating_is_rebuilding_on_rings(edits in edits(), seed in 0u64..1000, void in 0.0..0.3f64) {
        check(TrainingKind::OneRing, [4, 3, 3], 2, void, &edits, seed)?;
    }

    #[test]
    fn updating_is_rebuilding_on_cells(edits in edits(), seed in 0u64..1000, void in 0.0..0.3f64) {
        check(TrainingKind::SingleCell, [3, 2, 2], 3, void, &edits, seed)?;
    }

    #[test]
    fn updating_is_rebuilding_on_the_whole(edits in edits(), seed in 0u64..1000) {
        check(TrainingKind::Global, [4, 3, 3], 2, 0.0, &edits, seed)?;
    }
}

#[test]
fn cells_beyond_the_reach_keep_their_functions() {
    let mut model = live(body([6, 3, 3], 2, 0.0, 1).unwrap(), 2, &options(TrainingKind::OneRing));
    let before = model.coarse().clone();
    let at_end = Selector::Box { low: [0.0; 3], high: [1.0, 0.8, 1.2] };
    let report = model.apply(&Edit { region: Region::Selector(at_end), change: Change::Young(3.0) }).unwrap();
    assert_eq!((report.changed_fine, report.changed, report.dirty), (1, 1, 8));
    for (index, element) in model.coarse().elements().iter().enumerate() {
        let at = model.coarse().partition().coarse().cell_position(Cell(element.cell.0));
        let same = model.coarse().functions().of(index) == before.functions().of(index);
        assert_eq!(same, at.iter().any(|x| *x > 1), "{at:?}");
    }
}

#[test]
fn substructures_return_to_the_global_data_when_every_edit_is_undone() {
    let mut model = live(body([3, 3, 2], 2, 0.0, 11).unwrap(), 2, &options(TrainingKind::Substructured));
    let start = model.coarse().clone();
    for (kind, at) in [(0, [2.0, 1.0, 1.0]), (2, [5.0, 4.0, 2.0]), (1, [1.0, 3.0, 3.0])] {
        model.apply(&edit(kind, at, 1.3)).unwrap();
        assert!(difference_of_bodies(model.coarse(), &start) > 1e-3, "the edit matters");
    }
    while model.undo(&silent).unwrap().is_some() {}
    assert_eq!(difference(model.coarse(), &start), 0.0);
    let global = live(body([3, 3, 2], 2, 0.0, 11).unwrap(), 2, &options(TrainingKind::Global));
    let error = difference(&start, global.coarse());
    assert!(error < 1e-7, "{error}");
}

#[test]
fn a_failed_update_does_not_cost_an_older_one_its_undoing() {
    for depth in [0, 1, 2] {
        let options = LiveOptions { undo_depth: depth, ..options(TrainingKind::SingleCell) };
        let mut model = live(body([3, 2, 2], 2, 0.0, 17).unwrap(), 2, &options);
        let young = |value: f64| Edit { region: Region::Selector(Selector::All), change: Change::Young(value) };
        for value in [2.0, 3.0, 4.0] {
            model.apply(&young(value)).unwrap();
        }
        assert_eq!(model.undo_depth(), depth);
        let stop = |name: &'static str, _: usize, _: usize| name != "fitting";
        assert!(model.apply_all(&[young(5.0)], &stop).is_err());
        assert_eq!((model.undo_depth(), model.fine().young(Cell(0))), (depth, 4.0));
        while model.undo(&silent).unwrap().is_some() {}
        assert_eq!(model.fine().young(Cell(0)), 4.0 - depth as f64);
    }
}

#[test]
fn rings_beyond_the_tolerance_are_trained_exactly() {
    let train = |kind: TrainingKind, data_tolerance: Option<f64>| {
        let options = LiveOptions { data_tolerance, ..options(kind) };
        let mut model = live(body([9, 3, 3], 2, 0.0, 13).unwrap(), 2, &options);
        let softest = (0..).map(Cell).find(|c| model.fine().young(*c) == 1.0 && c.0 % 18 == 2).unwrap();
        let slightly = Edit { region: Region::Cells(vec![softest]), change: Change::Young(1.01) };
        model.apply_all(&[slightly, edit(1, [15.0, 2.0, 3.0], 1.5)], &silent).unwrap();
        model
    };
    let [free, bounded] = [None, Some(0.1)].map(|tolerance| train(TrainingKind::Substructured, tolerance));
    let exact = train(TrainingKind::OneRing, None);
    let same = |a: &CoarseModel, b: &CoarseModel, i: usize| a.functions().of(i) == b.functions().of(i);
    for (i, element) in free.coarse().elements().iter().enumerate() {
        let x = free.coarse().partition().coarse().cell_position(Cell(element.cell.0))[0];
        assert_eq!(same(bounded.coarse(), exact.coarse(), i), x >= 5, "{element:?}: exact where the change is large");
        assert_eq!(same(bounded.coarse(), free.coarse(), i), x < 5, "{element:?}: in substructures elsewhere");
    }
}

#[test]
fn an_edit_that_changes_nothing_changes_not_a_bit() {
    let mut model = live(body([3, 2, 2], 2, 0.1, 3).unwrap(), 2, &options(TrainingKind::Global));
    let before = model.coarse().clone();
    let same = Edit { region: Region::Selector(Selector::Label(Label(1))), change: Change::Material(Label(1)) };
    let report = model.apply(&same).unwrap();
    assert_eq!((report.changed, report.dirty, model.undo_depth()), (0, 0, 0));
    assert_eq!(difference(model.coarse(), &before), 0.0);
}

#[test]
fn a_failed_step_leaves_everything_as_it_was() {
    let all_kinds = [TrainingKind::OneRing, TrainingKind::SingleCell, TrainingKind::Substructured];
    for (kind, stage) in all_kinds.into_iter().flat_map(|kind| [(kind, "training"), (kind, "fitting")]) {
        let mut model = live(body([3, 2, 2], 2, 0.1, 5).unwrap(), 2, &options(kind));
        model.state.displacement.iter_mut().enumerate().for_each(|(i, u)| *u = i as f64);
        let (grid, before, state) = (model.fine().grid().clone(), model.coarse().clone(), model.state.clone());
        let cut = Cut { point: [3.0, 1.0, 1.0], normal: [1.0, 0.0, 0.0], radius: None };
        let edit = Edit { region: Region::Selector(Selector::Cut(cut)), change: Change::Remove };
        let stop = |name: &'static str, _: usize, _: usize| name != stage;
        assert!(model.apply_all(std::slice::from_ref(&edit), &stop).is_err());
        assert_eq!(model.fine().grid(), &grid);
        assert_eq!((difference(model.coarse(), &before), &model.state, model.undo_depth()), (0.0, &state, 0));
        model.apply(&edit).unwrap();
        let mut undisturbed = live(body([3, 2, 2], 2, 0.1, 5).unwrap(), 2, &options(kind));
        undisturbed.apply(&edit).unwrap();
        assert_eq!(difference(model.coarse(), undisturbed.coarse()), 0.0, "{kind:?}: the failure left a trace");
        let after = (model.fine().grid().clone(), model.coarse().clone(), model.state.clone());
        assert!(model.undo(&stop).is_err());
        assert_eq!(model.fine().grid(), &after.0);
        assert_eq!((difference(model.coarse(), &after.1), &model.state, model.undo_depth()), (0.0, &after.2, 1));
    }
}

#[test]
fn motion_is_carried_across_a_cut_to_both_sides() {
    let mut options = options(TrainingKind::OneRing);
    options.base = BaseKind::Trilinear;
    let mut model = live(body([3, 2, 2], 3, 0.0, 7).unwrap(), 3, &options);
    let position = |model: &LiveModel| -> Vec<f64> {
        let mesh = model.coarse().mesh();
        let node =
            |v: &grosgrain::partition::Vertex| model.fine().node_position(mesh.partition().coincident_node(v.node));
        mesh.vertices().iter().flat_map(node).collect()
    };
    model.state.displacement = position(&model);
    model.state.velocity = position(&model).iter().map(|x| 2.0 * x).collect();
    let count = model.coarse().mesh().vertices().len();
    let cut = Cut { point: [4.5, 1.0, 1.0], normal: [1.0, 0.0, 0.0], radius: None };
    model.apply(&Edit { region: Region::Selector(Selector::Cut(cut)), change: Change::Remove }).unwrap();
    // The middle cells are in two parts, and all of their nodes are doubled.
    assert_eq!(model.coarse().mesh().vertices().len(), count + 18);
    assert_eq!(model.state.displacement, position(&model));
    assert_eq!(model.state.velocity, position(&model).iter().map(|x| 2.0 * x).collect::<Vec<_>>());
}
