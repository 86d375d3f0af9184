//! Memory stays bounded over many edits. A test binary of its own: what other tests allocate would count too.
#![cfg(target_os = "linux")]

mod bodies;

use bodies::*;
use grosgrain::fine::FineModel;
use grosgrain::mesh::{Cell, Label, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::training::{RunTimeTraining, TrainingKind};
use grosgrain::update::{Change, Edit, LiveModel, LiveOptions, LooseParts, Region};

#[test]
fn ten_thousand_edits_do_not_grow_memory() {
    let resident = || -> usize {
        let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
        pages.split_whitespace().nth(1).unwrap().parse::<usize>().unwrap() * 4096
    };
    let grid = VoxelGrid::uniform([6; 3], [1.0; 3], Label(0));
    let fine = FineModel::new(grid, &table(&[isotropic(1.0, 0.3), isotropic(50.0, 0.45)])).unwrap();
    let training = RunTimeTraining::Fixed(TrainingKind::SingleCell);
    let options = LiveOptions { training, loose: LooseParts::Keep, undo_depth: 8, ..LiveOptions::default() };
    let mut model = LiveModel::new(fine, 2, &options, vec![false; 343], &silent).unwrap();
    let mut after_warm_up = 0;
    for step in 0..10_000usize {
        let cell = Cell(step * 7919 % 216);
        let change = match (step % 4, model.fine().is_void(cell)) {
            (_, true) => Change::Add(Label(1)),
            (0, false) => Change::Remove,
            (1, false) => Change::Young(1.0 + step as f64),
            _ => Change::Material(Label((step % 2) as i32)),
        };
        model.apply(&Edit { region: Region::Cells(vec![cell]), change }).unwrap();
        if step == 2_000 {
            after_warm_up = resident();
        }
    }
    let grown = resident().saturating_sub(after_warm_up);
    assert!(grown < 4 << 20, "memory has grown by {grown} bytes");
}
