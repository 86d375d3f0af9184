//! Parts that an edit cuts loose are found, dropped or kept, and come back when the edit is undone.

mod bodies;

use bodies::{isotropic, table};
use grosgrain::fine::FineModel;
use grosgrain::mesh::{Cell, Components, Cut, Label, Neighbourhood, Node, Selector, VoxelGrid, loose_parts};
use grosgrain::update::{Change, Edit, EditError, Editor, LooseParts, LooseReport, LooseSearch, Region};
use proptest::prelude::*;

fn model_of(grid: VoxelGrid) -> FineModel {
    FineModel::new(grid, &table(&[isotropic(1e5, 0.3)])).unwrap()
}

fn beam() -> FineModel {
    model_of(VoxelGrid::uniform([8, 3, 2], [0.1; 3], Label(0)))
}

fn held_at(model: &FineModel, x: usize) -> Vec<bool> {
    let lattice = model.grid().lattice;
    (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == x).collect()
}

fn cut_at(x: f64) -> Edit {
    let cut = Cut { point: [x, 0.0, 0.0], normal: [1.0, 0.0, 0.0], radius: None };
    Edit { region: Region::Selector(Selector::Cut(cut)), change: Change::Remove }
}

#[test]
fn the_end_that_a_cut_severs_is_dropped_in_the_same_update_and_undone_with_it() {
    let mut model = beam();
    let (before, held) = (model.grid().clone(), held_at(&model, 0));
    let mut editor = Editor::new(4, LooseParts::Drop);
    let resolved = cut_at(0.45).resolve(&model).unwrap();
    let applied = editor.apply(&mut model, &resolved, &held).unwrap();
    assert_eq!(applied.loose, LooseReport { parts: 1, cells: 18, dropped: true });
    let beyond = |c: &Cell| before.lattice.cell_position(*c)[0] >= 4;
    assert_eq!(applied.changed, (0..48).map(Cell).filter(beyond).collect::<Vec<_>>());
    assert_eq!(model.solid_count(), 24);
    let active = model.active().iter().filter(|a| **a).count();
    assert_eq!(active, 5 * 4 * 3);
    assert_eq!(editor.undo(&mut model).unwrap().map(<[Cell]>::len), Some(24));
    assert_eq!(model.grid(), &before);
}

#[test]
fn a_kept_part_stays_and_is_told() {
    let mut model = beam();
    let held = held_at(&model, 0);
    let mut editor = Editor::new(1, LooseParts::Keep);
    let resolved = cut_at(0.45).resolve(&model).unwrap();
    let applied = editor.apply(&mut model, &resolved, &held).unwrap();
    assert_eq!(applied.loose, LooseReport { parts: 1, cells: 18, dropped: false });
    assert_eq!((applied.changed.len(), model.solid_count()), (6, 42));
    let (report, cells) = editor.loose(&model, &held);
    assert_eq!((report.cells, cells.len()), (18, 18));
}

#[test]
fn where_nothing_is_held_the_largest_part_stays() {
    let mut model = beam();
    let mut editor = Editor::new(1, LooseParts::Drop);
    let resolved = cut_at(0.25).resolve(&model).unwrap();
    let applied = editor.apply(&mut model, &resolved, &[false; 108]).unwrap();
    assert_eq!(applied.loose, LooseReport { parts: 1, cells: 12, dropped: true });
    assert_eq!(model.solid_count(), 30);
    assert!(!model.is_void(Cell(7)));
}

#[test]
fn an_edit_after_which_nothing_is_held_is_refused_and_taken_back() {
    let mut model = beam();
    let (before, held) = (model.grid().clone(), held_at(&model, 0));
    let mut editor = Editor::new(4, LooseParts::Drop);
    let resolved = cut_at(0.05).resolve(&model).unwrap();
    let error = editor.apply(&mut model, &resolved, &held).unwrap_err();
    assert_eq!(error, EditError::NothingHeld { cells: 42 });
    assert_eq!(
        error.to_string(),
        "after the edit nothing of the body is held, so all 42 remaining cells would be dropped; keep a held part or keep loose parts"
    );
    assert_eq!(model.grid(), &before);
    assert_eq!(editor.undo(&mut model).unwrap(), None);
}

#[test]
fn a_part_that_hangs_by_an_edge_is_loose() {
    // Removing one of two diagonal neighbours' common neighbours leaves a hinge.
    let mut grid = VoxelGrid::uniform([2, 2, 2], [1.0; 3], Label(0));
    for at in [[1, 0, 0], [1, 0, 1]] {
        let cell = grid.lattice.cell(at);
        grid.void[cell.0] = true;
    }
    let mut model = model_of(grid);
    let lattice = model.grid().lattice;
    let held: Vec<bool> = (0..27).map(|n| lattice.node_position(Node(n))[1] == 0).collect();
    let upper =
        Edit { region: Region::Cells(vec![lattice.cell([0, 1, 0]), lattice.cell([0, 1, 1])]), change: Change::Remove };
    let resolved = upper.resolve(&model).unwrap();
    let applied = Editor::new(1, LooseParts::Drop).apply(&mut model, &resolved, &held).map(|a| a.loose).unwrap();
    assert_eq!(applied, LooseReport { parts: 1, cells: 2, dropped: true });
}

proptest! {
    /// Against the exact search for parts that can move, cell by cell.
    #[test]
    fn loose_cells_are_those_of_the_parts_that_can_move(
        void in prop::collection::vec(prop::bool::weighted(0.4), 48),
        held in prop::collection::vec(prop::bool::weighted(0.15), 105),
    ) {
        let mut grid = VoxelGrid::uniform([4, 4, 3], [0.1, 0.1, 0.2], Label(0));
        let held = &held[..100];
        grid.void = void;
        grid.void[0] = false;
        let model = model_of(grid.clone());
        prop_assume!(held.contains(&true));
        let mut search = LooseSearch::new();
        let fixed: Vec<[bool; 3]> = held.iter().map(|h| [*h; 3]).collect();
        let parts = Components::new(&grid.void, &grid.lattice, Neighbourhood::Faces);
        let exact = loose_parts(&grid, &fixed);
        let numbers: Vec<usize> = exact.iter().filter_map(|p| parts.of(grid.lattice.cell(p.first_cell))).collect();
        let is_loose = |c: &Cell| parts.of(*c).is_some_and(|n| numbers.contains(&n));
        let expected: Vec<Cell> = (0..48).map(Cell).filter(is_loose).collect();
        for _ in 0..2 {
            let report = search.find(&model, held);
            prop_assert_eq!(search.cells(), &expected[..]);
            prop_assert_eq!((report.parts, report.cells), (exact.len(), expected.len()));
        }
        expected.iter().for_each(|c| grid.void[c.0] = true);
        prop_assert!(expected.len() == parts.sizes().iter().sum::<usize>() || loose_parts(&grid, &fixed).is_empty());
    }
}
