//! Edits change the cells they say, batches are what their edits are one after the other, and all can be undone.

mod bodies;

use bodies::{isotropic, random_tensor, table};
use grosgrain::fine::FineModel;
use grosgrain::material::Elasticity;
use grosgrain::mesh::{Axis, Cell, Cut, Label, PlaneAt, Selector, VoxelGrid};
use grosgrain::update::{Change, Edit, EditError, Editor, History, LooseParts, Region, resolve_all};
use proptest::prelude::*;

/// 6 × 4 × 3 cells of 1 m; labels 0 and 1 alternate along x, the last layer along z is void.
fn model() -> FineModel {
    let mut grid = VoxelGrid::uniform([6, 4, 3], [1.0; 3], Label(0));
    for c in 0..72 {
        grid.labels[c] = Label((c % 2) as i32);
        grid.void[c] = c >= 48;
    }
    let anisotropic = Elasticity::Anisotropic(random_tensor(3));
    FineModel::new(grid, &table(&[isotropic(1e5, 0.3), isotropic(2e6, 0.4), anisotropic])).unwrap()
}

fn everywhere(change: Change) -> Edit {
    Edit { region: Region::Selector(Selector::All), change }
}

fn at(cells: &[usize], change: Change) -> Edit {
    Edit { region: Region::Cells(cells.iter().map(|c| Cell(*c)).collect()), change }
}

fn refusal(edit: Edit) -> String {
    let model = model();
    let before = model.grid().clone();
    let error = edit.resolve(&model).unwrap_err();
    assert_eq!(model.grid(), &before);
    error.to_string()
}

#[test]
fn an_edit_resolves_to_the_cells_that_it_really_changes() {
    let model = model();
    let changed = |edit: Edit| {
        let resolved = edit.resolve(&model).unwrap();
        assert!(resolved.changes.is_sorted_by_key(|(cell, _)| *cell));
        (resolved.changes.len(), resolved.removed, resolved.added)
    };
    assert_eq!(
        changed(everywhere(Change::Material(Label(1)))),
        (24, 0, 0),
        "half of the solid cells are of it already"
    );
    assert_eq!(changed(everywhere(Change::Young(2e6))), (24, 0, 0), "the others have this modulus");
    assert_eq!(changed(everywhere(Change::Add(Label(0)))), (24, 0, 24), "the voids");
    assert_eq!(changed(at(&[60, 3, 2, 3], Change::Remove)), (2, 2, 0), "cells twice and voids");
    assert_eq!(changed(at(&[1, 3], Change::Material(Label(1)))), (0, 0, 0));
}

#[test]
fn edits_that_make_no_sense_are_refused_by_a_sentence() {
    let far = Selector::Box { low: [50.0; 3], high: [60.0; 3] };
    let upside_down = Selector::Box { low: [1.0; 3], high: [0.0; 3] };
    let upper = Selector::Box { low: [0.0, 0.0, 2.0], high: [6.0, 4.0, 3.0] };
    let lower = Selector::Box { low: [0.0, 0.0, 0.0], high: [6.0, 4.0, 2.0] };
    let region = |selector: Selector, change| Edit { region: Region::Selector(selector), change };
    let known = "0 (phase 0), 1 (phase 1), 2 (phase 2)";
    for (edit, says) in [
        (
            region(far, Change::Remove),
            "the edit's region holds no cell; the body extends over x 0.000000..6.000000, y 0.000000..4.000000, \
             z 0.000000..2.000000 m; move or enlarge the region",
        ),
        (
            region(upper, Change::Remove),
            "all 24 cells of the edit's region are void, so there is nothing to change; choose a region with solid cells",
        ),
        (
            region(lower, Change::Add(Label(1))),
            "all 48 cells of the edit's region are solid, so there is nothing to add; choose a region with voids",
        ),
        (everywhere(Change::Material(Label(7))), &format!("label 7 has no material; the model knows {known}")),
        (everywhere(Change::Add(Label(-1))), &format!("label -1 has no material; the model knows {known}")),
        (everywhere(Change::Young(0.0)), "a Young modulus of 0 Pa was asked for; it must be positive and finite"),
        (
            everywhere(Change::Young(f64::INFINITY)),
            "a Young modulus of inf Pa was asked for; it must be positive and finite",
        ),
        (everywhere(Change::Remove), "the edit would remove all 48 solid cells; keep a part of the body"),
        (at(&[72], Change::Remove), "cell 72 is outside of the grid of 6 x 4 x 3 cells; the last one is 71"),
        (
            at(&[], Change::Remove),
            "the edit's region holds no cell; the body extends over x 0.000000..6.000000, y 0.000000..4.000000, \
             z 0.000000..2.000000 m; move or enlarge the region",
        ),
        (
            region(upside_down, Change::Remove),
            "the box from [1.0, 1.0, 1.0] to [0.0, 0.0, 0.0] is empty; each first coordinate must be at most the second",
        ),
    ] {
        assert_eq!(refusal(edit), says);
    }
}

#[test]
fn a_modulus_is_refused_where_the_material_is_anisotropic() {
    let model = model();
    let error =
        resolve_all(&[at(&[4], Change::Material(Label(2))), at(&[3, 4], Change::Young(1e6))], &model).unwrap_err();
    assert_eq!(error.edit, 1);
    let expected = "edit 1 of the batch, counted from 0: material \"phase 2\" is given by a stiffness matrix";
    assert!(error.to_string().starts_with(expected), "{error}");
}

#[test]
fn what_is_changed_and_changed_back_is_no_change() {
    let model = model();
    let there_and_back = [
        at(&[1, 3], Change::Remove),
        at(&[1, 3], Change::Add(Label(1))),
        at(&[0], Change::Young(7.0)),
        at(&[0], Change::Material(Label(0))),
        at(&[60], Change::Add(Label(0))),
        at(&[60], Change::Remove),
    ];
    assert_eq!(resolve_all(&there_and_back, &model).unwrap().changes, []);
    let all_but_one = [everywhere(Change::Remove), at(&[71], Change::Add(Label(0)))];
    let resolved = resolve_all(&all_but_one, &model).unwrap();
    assert_eq!((resolved.removed, resolved.added), (48, 1), "only the whole batch has to leave something");
}

fn any_edit() -> impl Strategy<Value = Edit> {
    let corner = || [0.0..6.0f64, 0.0..4.0, 0.0..3.0];
    let selector = prop_oneof![
        (corner(), 0.5..3.0f64).prop_map(|(centre, radius)| Selector::Sphere { centre, radius }),
        (0..3i32).prop_map(|label| Selector::Label(Label(label))),
        Just(Selector::Plane { axis: Axis::Z, at: PlaneAt::Max }),
        Just(Selector::Plane { axis: Axis::X, at: PlaneAt::Min }),
        (corner(), [-1.0..1.0f64, -1.0..1.0, 0.1..1.0]).prop_map(|(point, normal)| Selector::Cut(Cut {
            point,
            normal,
            radius: None
        })),
    ];
    let change = prop_oneof![
        (0..3i32).prop_map(|label| Change::Material(Label(label))),
        (1e3..1e6f64).prop_map(Change::Young),
        Just(Change::Remove),
        (0..3i32).prop_map(|label| Change::Add(Label(label))),
    ];
    (selector, change).prop_map(|(selector, change)| Edit { region: Region::Selector(selector), change })
}

/// What a model is, apart from where its moduli are kept.
fn content(model: &FineModel) -> Vec<(bool, Label, u64, u64)> {
    let of = |cell: Cell| {
        let label = if model.is_void(cell) { Label(0) } else { model.grid().labels[cell.0] };
        (model.is_void(cell), label, model.young(cell).to_bits(), model.density(cell).to_bits())
    };
    (0..72).map(|c| of(Cell(c))).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn a_batch_is_its_edits_one_after_the_other_and_undoes_at_once(edits in prop::collection::vec(any_edit(), 1..6)) {
        let start = model();
        let mut one_by_one = model();
        let mut history = History::new(edits.len());
        let mut accepted = Vec::new();
        for edit in &edits {
            let Ok(resolved) = edit.resolve(&one_by_one) else { continue };
            history.change(&mut one_by_one, &resolved.changes).unwrap();
            accepted.push(edit.clone());
        }
        let resolved = resolve_all(&accepted, &start).unwrap();
        let mut together = model();
        let mut editor = Editor::new(1, LooseParts::Keep);
        editor.apply(&mut together, &resolved, &[]).unwrap();
        prop_assert_eq!(content(&together), content(&one_by_one));
        let differing = content(&start).iter().zip(content(&together)).filter(|(a, b)| **a != *b).count();
        prop_assert_eq!(resolved.changes.len(), differing, "net changes only");
        let undone = editor.undo(&mut together).unwrap().map(<[Cell]>::to_vec);
        let cells: Vec<Cell> = resolved.changes.iter().map(|(cell, _)| *cell).collect();
        prop_assert_eq!(undone, (!cells.is_empty()).then_some(cells));
        prop_assert_eq!(content(&together), content(&start));
        let mut undone = Vec::new();
        while history.undo(&mut one_by_one, &mut undone).unwrap() {}
        prop_assert_eq!(content(&one_by_one), content(&start));
    }
}

#[test]
fn the_history_holds_as_many_updates_as_it_is_deep() {
    let mut model = model();
    let mut editor = Editor::new(3, LooseParts::Keep);
    let mut contents = vec![content(&model)];
    for cell in 0..5 {
        let resolved = at(&[cell], Change::Young(10.0 + cell as f64)).resolve(&model).unwrap();
        assert_eq!(editor.apply(&mut model, &resolved, &[]).unwrap().changed, [Cell(cell)]);
        editor.settle();
        contents.push(content(&model));
    }
    for back in (2..5).rev() {
        assert_eq!(editor.undo(&mut model).unwrap(), Some(&[Cell(back)][..]));
        assert_eq!(content(&model), contents[back]);
    }
    assert_eq!(editor.undo(&mut model).unwrap(), None);
    assert_eq!(content(&model), contents[2]);
    let nothing = at(&[0], Change::Young(10.0)).resolve(&model).unwrap();
    assert_eq!(editor.apply(&mut model, &nothing, &[]).unwrap().changed, []);
    assert!(editor.history().is_empty(), "nothing to change is no update");
}

#[test]
fn errors_tell_whether_an_edit_only_found_nothing() {
    let model = model();
    let error = |edit: Edit| edit.resolve(&model).unwrap_err();
    assert!(error(at(&[71], Change::Remove)).finds_nothing());
    assert!(error(at(&[], Change::Remove)).finds_nothing());
    assert!(error(at(&[1], Change::Add(Label(0)))).finds_nothing());
    assert!(!error(everywhere(Change::Remove)).finds_nothing());
    assert!(matches!(error(everywhere(Change::Remove)), EditError::Everything { cells: 48 }));
}
