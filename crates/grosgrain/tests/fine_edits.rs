//! Changing cells of a fine model gives the model of the changed body, and changing back gives the old one.

mod bodies;

use bodies::{isotropic, random_tensor, table};
use grosgrain::assembly::CellStiffness;
use grosgrain::fine::{CellState, ChangeError, FineModel};
use grosgrain::material::{Elasticity, MaterialTable};
use grosgrain::mesh::{Cell, Label, VoxelGrid};
use proptest::prelude::*;

const CELLS: [usize; 3] = [4, 3, 3];
const COUNT: usize = 36;

/// Two isotropic materials and an anisotropic one, with labels 0, 1, 2.
fn materials() -> MaterialTable {
    table(&[isotropic(3e4, 0.3), isotropic(7e5, 0.45), Elasticity::Anisotropic(random_tensor(5))])
}

fn body(labels: &[i32], void: &[bool], young: Option<Vec<f64>>, density: Option<Vec<f64>>) -> VoxelGrid {
    let mut grid = VoxelGrid::uniform(CELLS, [0.1, 0.2, 0.3], Label(0));
    grid.labels = labels.iter().map(|l| Label(*l)).collect();
    grid.void = void.to_vec();
    grid.void[0] = false;
    (grid.young, grid.density) = (young, density);
    grid
}

prop_compose! {
    /// Bodies with and without fields per voxel; with moduli only isotropic materials, as files give them.
    fn any_body()(
        labels in prop::collection::vec(0..3i32, COUNT),
        void in prop::collection::vec(any::<bool>(), COUNT),
        young in prop::option::of(prop::collection::vec(1e3..1e6f64, COUNT)),
        density in prop::option::of(prop::collection::vec(500.0..2e3f64, COUNT)),
    ) -> VoxelGrid {
        let labels: Vec<i32> = labels.into_iter().map(|l| if young.is_some() { l % 2 } else { l }).collect();
        body(&labels, &void, young, density)
    }
}

prop_compose! {
    fn any_change(with_density: bool)(
        cell in 1..COUNT, label in 0..3i32, void in any::<bool>(),
        young in prop::option::of(1e3..1e6f64), density in prop::option::of(500.0..2e3f64),
    ) -> (Cell, CellState) {
        let young = young.filter(|_| label < 2);
        (Cell(cell), CellState { label: Label(label), void, young, density: density.filter(|_| with_density) })
    }
}

/// Everything that a computation sees of a model, with all bits.
fn seen(model: &FineModel) -> (Vec<u64>, Vec<bool>, usize) {
    let of_cell = |c: usize| {
        let stiffness = model.stiffness(c).into_iter().flat_map(|(f, m)| [f].into_iter().chain(m.iter().copied()));
        stiffness.chain([model.cell_mass(Cell(c)), model.young(Cell(c))]).map(f64::to_bits).collect::<Vec<_>>()
    };
    ((0..COUNT).flat_map(of_cell).collect(), model.active().to_vec(), model.solid_count())
}

proptest! {
    #[test]
    fn a_changed_model_is_the_model_of_the_changed_body_and_back(
        grid in any_body(), batches in prop::collection::vec(prop::collection::vec(any_change(true), 0..12), 1..5),
    ) {
        let has_young = grid.young.is_some();
        let with_density = grid.density.is_some();
        let mut model = FineModel::new(grid.clone(), &materials()).unwrap();
        let mut undo = Vec::new();
        for batch in batches {
            let before = (seen(&model), undo.len());
            let batch: Vec<(Cell, CellState)> =
                batch.into_iter().map(|(c, s)| (c, CellState { density: s.density.filter(|_| with_density), ..s })).collect();
            model.change(&batch, &mut undo).unwrap();
            prop_assert_eq!(undo.len(), before.1 + batch.len());
            let fresh = FineModel::new(model.grid().clone(), &materials()).unwrap();
            prop_assert_eq!(seen(&model), seen(&fresh));
            for (n, (cell, state)) in batch.iter().enumerate() {
                let last = batch[n + 1..].iter().all(|(c, _)| c != cell);
                prop_assert!(!last || model.is_void(*cell) == state.void);
                let young = model.young_of(state);
                prop_assert!(!last || (model.young(*cell) - young).abs() <= 1e-15 * young, "a division and a product");
                prop_assert!(!last || model.density(*cell) == model.density_of(state));
            }
            let mut back = model.clone();
            back.restore(&undo[before.1..]).unwrap();
            prop_assert_eq!(seen(&back), before.0);
        }
        model.restore(&undo).unwrap();
        prop_assert_eq!(seen(&model), seen(&FineModel::new(grid.clone(), &materials()).unwrap()));
        prop_assert_eq!((&model.grid().labels, &model.grid().void, &model.grid().density), (&grid.labels, &grid.void, &grid.density));
        prop_assert!(!has_young || model.grid().young == grid.young);
    }
}

#[test]
fn impossible_changes_are_refused_and_leave_the_model_as_it_was() {
    let mut grid = body(&[0; COUNT], &[true; COUNT], None, None);
    grid.labels[1] = Label(9);
    let mut model = FineModel::new(grid.clone(), &materials()).unwrap();
    let solid = CellState { label: Label(1), void: false, young: None, density: None };
    let good = (Cell(5), solid);
    let mut undo = Vec::new();
    let known = "0 (phase 0), 1 (phase 1), 2 (phase 2)";
    for (bad, says) in [
        ((Cell(36), solid), "cell 36 is outside of the grid of 4 x 3 x 3 cells; the last one is 35".to_owned()),
        ((Cell(1), CellState { label: Label(9), ..solid }), format!("label 9 has no material; the model knows {known}")),
        (
            (Cell(1), CellState { young: Some(f64::NAN), ..solid }),
            "a Young modulus of NaN Pa was asked for; it must be positive and finite".into(),
        ),
        (
            (Cell(1), CellState { young: Some(-2.0), ..solid }),
            "a Young modulus of -2 Pa was asked for; it must be positive and finite".into(),
        ),
        (
            (Cell(1), CellState { label: Label(2), young: Some(5.0), ..solid }),
            "material \"phase 2\" is given by a stiffness matrix, which a Young modulus cannot replace; set a material with young \
             and poisson first"
                .into(),
        ),
        (
            (Cell(1), CellState { density: Some(5.0), ..solid }),
            "a density was given for a single cell, but the body's densities come from its materials; leave it out".into(),
        ),
    ] {
        let error = model.change(&[good, bad], &mut undo).unwrap_err();
        assert_eq!(error.to_string(), says);
        assert_eq!((model.grid(), undo.len()), (&grid, 0));
    }
    let gone = CellState { void: true, ..model.state(Cell(0)) };
    let made = (Cell(3), CellState { young: Some(1e5), ..solid });
    let unmade = (Cell(3), CellState { void: true, ..solid });
    assert_eq!(model.change(&[made, (Cell(0), gone), unmade], &mut undo), Err(ChangeError::AllVoid));
    assert_eq!((model.grid(), undo.len()), (&grid, 0));
    assert_eq!(seen(&model), seen(&FineModel::new(grid, &materials()).unwrap()));
}

#[test]
fn densities_per_voxel_need_a_positive_one_for_every_material_that_is_set() {
    let mut materials = materials();
    let mut weightless = materials.get(Label(1)).unwrap().clone();
    weightless.density = 0.0;
    materials.insert(Label(1), weightless);
    let grid = body(&[0; COUNT], &[false; COUNT], None, Some(vec![800.0; COUNT]));
    let mut model = FineModel::new(grid, &materials).unwrap();
    let state = CellState { label: Label(1), void: false, young: None, density: None };
    let error = model.change(&[(Cell(2), state)], &mut Vec::new()).unwrap_err();
    let says = "a density of 0 kg/m³ was asked for material \"phase 1\"; it must be positive and finite";
    assert_eq!(error.to_string(), says);
    model.change(&[(Cell(2), CellState { density: Some(900.0), ..state })], &mut Vec::new()).unwrap();
    assert_eq!(model.density(Cell(2)), 900.0);
}
