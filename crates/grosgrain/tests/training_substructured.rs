//! Training in substructures: exact where nothing has changed, exact under full coupling, the same after an update as after a new build.

mod bodies;

use std::sync::Arc;

use bodies::*;
use grosgrain::fine::FineModel;
use grosgrain::material::MaterialTable;
use grosgrain::mesh::{Cell, Components, Label, Lattice, Neighbourhood, VoxelGrid};
use grosgrain::partition::{CellPart, CoarseCell, CoarseMesh, Partition};
use grosgrain::progress::silent;
use grosgrain::solver::SolverChoice;
use grosgrain::training::{
    HarmonicDisplacements, InterfaceForces, InterfaceSpace, LocalTrainer, RingKind, Substructures, Training,
};
use proptest::prelude::*;

/// Phases 1, 2, …; 0 is void.
fn body(cells: [usize; 3], phases: &[u8], youngs: &[f64]) -> FineModel {
    let mut grid = VoxelGrid::uniform(cells, [1.0, 0.5, 1.5], Label(0));
    for (c, phase) in phases.iter().enumerate() {
        grid.void[c] = *phase == 0;
        grid.labels[c] = Label(i32::from((*phase).max(1)) - 1);
    }
    FineModel::new(grid, &materials(youngs)).unwrap()
}

fn materials(youngs: &[f64]) -> MaterialTable {
    let materials: Vec<_> = youngs.iter().map(|young| isotropic(*young, 0.45)).collect();
    table(&materials)
}

fn phases(count: usize, seed: usize) -> Vec<u8> {
    (0..count).map(|n| 1 + (((n + 3) * (n + 11 * seed) * 2654435761) >> 7 & 1) as u8).collect()
}

fn forces(model: &FineModel, degree: usize) -> (Partition, HarmonicDisplacements, Arc<InterfaceForces>) {
    let partition = Partition::new(model.grid().lattice, degree).unwrap();
    let harmonic = HarmonicDisplacements::solve(model, SolverChoice::Direct, &silent).unwrap();
    let forces = Arc::new(InterfaceForces::new(model, &partition, &harmonic));
    (partition, harmonic, forces)
}

/// One element for each coarse cell that is not void, whatever hangs together inside.
fn whole(model: &FineModel, partition: &Partition) -> CoarseMesh {
    CoarseMesh::unsplit(&model.grid().void, partition)
}

/// A cell's data, `None` where the ring is not solved in substructures.
fn data(substructures: &Substructures, model: &FineModel, element: CellPart) -> Option<Box<[f64]>> {
    let mesh = whole(model, substructures.partition());
    substructures.train_cell(model, &mesh, &[element]).map(|mut matrices| matrices.remove(0))
}

/// Largest difference of a cell's data over their largest entry.
fn difference(found: &[f64], expected: &[f64]) -> f64 {
    let size = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    found.iter().zip(expected).fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / size
}

/// Compares the cells that are solved in substructures with the global data; returns how many they are.
fn compare_with_global(model: &FineModel, degree: usize, tolerance: f64) -> usize {
    let (partition, harmonic, forces) = forces(model, degree);
    let substructures = Substructures::new(model, forces, InterfaceSpace::default());
    let mesh = whole(model, &partition);
    let global = Training::from_harmonic(model, &mesh, mesh.elements(), &harmonic);
    let mut solved = 0;
    for (index, &cell) in mesh.elements().iter().enumerate() {
        if !ring_in_one_part(model, &partition, cell.cell) {
            continue;
        }
        let Some(found) = data(&substructures, model, cell) else { continue };
        solved += 1;
        let error = difference(&found, global.of(index));
        assert!(error < tolerance, "{cell:?}: {error:e}");
    }
    solved
}

#[test]
fn without_a_change_the_data_are_the_global_ones() {
    for (degree, coarse) in [(2, [4, 3, 3]), (3, [3, 2, 4]), (4, [3, 3, 1]), (1, [4, 3, 3])] {
        let cells = coarse.map(|n| n * degree);
        let count = cells.iter().product();
        let model = body(cells, &phases(count, degree), &[1e5, 5e6]);
        assert_eq!(compare_with_global(&model, degree, 1e-8), coarse.iter().product::<usize>());
    }
}

#[test]
fn without_a_change_the_data_are_the_global_ones_around_cuts_and_holes() {
    let cells = [9, 6, 6];
    let at = |c: usize| [c % 9, c / 9 % 6, c / 54];
    // A slot that parts coarse cells in two, a hole that reaches through several cells, and both with a missing coarse cell.
    let slot = |c: usize| at(c)[0] == 4 && at(c)[1] < 5;
    let hole = |c: usize| (1..8).contains(&at(c)[0]) && at(c)[1] == 2 && (2..4).contains(&at(c)[2]);
    let corner = |c: usize| at(c).iter().all(|x| *x < 3);
    let voids: [&dyn Fn(usize) -> bool; 3] = [&slot, &hole, &|c| slot(c) || corner(c)];
    // Halves of cells beside the slot have nearly dependent rows, and their rings are left to one-ring training.
    for (void, count) in voids.into_iter().zip([4, 12, 4]) {
        let mut labels = phases(324, 6);
        (0..324).filter(|c| void(*c)).for_each(|c| labels[c] = 0);
        let model = body(cells, &labels, &[1e5, 5e6]);
        assert_eq!(compare_with_global(&model, 3, 1e-8), count);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn without_a_change_the_data_are_the_global_ones_with_voids(
        labels in prop::collection::vec(0u8..9, 6 * 6 * 4), seed in 0usize..100
    ) {
        let mut labels = labels;
        labels.iter_mut().zip(phases(144, seed)).filter(|(l, _)| **l > 0).for_each(|(l, p)| *l = p);
        prop_assume!(one_part(&labels, [6, 6, 4]));
        compare_with_global(&body([6, 6, 4], &labels, &[1e5, 5e6]), 2, 1e-7);
    }

    #[test]
    fn full_coupling_is_the_one_ring_with_voids(labels in prop::collection::vec(0u8..9, 6 * 6 * 4)) {
        prop_assume!(labels.iter().any(|l| *l > 0));
        let labels: Vec<u8> = labels.iter().map(|l| (*l).min(2)).collect();
        compare_with_ring(&body([6, 6, 4], &labels, &[1e5, 5e6]), 2, 1e-7);
    }
}

/// Whether the solid cells are one face-connected part.
fn one_part(labels: &[u8], cells: [usize; 3]) -> bool {
    let void: Vec<bool> = labels.iter().map(|l| *l == 0).collect();
    Components::new(&void, &Lattice::new(cells), Neighbourhood::Faces).count() == 1
}

/// Else parts of the cell may move against each other in the ring but not in the body, or in any way at all.
fn ring_in_one_part(model: &FineModel, partition: &Partition, cell: CoarseCell) -> bool {
    let ring = partition.one_ring(cell);
    let window = cut_out(model.grid(), ring.start, ring.cells);
    Components::new(&window.void, &window.lattice, Neighbourhood::Faces).count() == 1
}

/// Compares the cells that are solved under full coupling with one-ring training where the ring is one part; returns how many they are.
fn compare_with_ring(model: &FineModel, degree: usize, tolerance: f64) -> usize {
    let (partition, _, forces) = forces(model, degree);
    let substructures = Substructures::new(model, forces, InterfaceSpace::Full);
    let trainer = LocalTrainer::new(&partition, RingKind::OneRing);
    let mut solved = 0;
    let mesh = whole(model, &partition);
    for &cell in mesh.elements() {
        if !ring_in_one_part(model, &partition, cell.cell) {
            continue;
        }
        let Some(found) = data(&substructures, model, cell) else { continue };
        solved += 1;
        let error = difference(&found, &trainer.train_cell(model, &mesh, &[cell]).unwrap()[0]);
        assert!(error < tolerance, "{cell:?}: {error:e}");
    }
    solved
}

#[test]
fn full_coupling_is_the_one_ring() {
    for (degree, coarse) in [(1, [4, 3, 3]), (2, [4, 3, 2]), (3, [3, 3, 1])] {
        let cells = coarse.map(|n| n * degree);
        let model = body(cells, &phases(cells.iter().product(), degree), &[1e5, 5e6]);
        assert_eq!(compare_with_ring(&model, degree, 1e-8), coarse.iter().product::<usize>());
    }
}

#[test]
fn the_error_falls_in_proportion_to_the_change() {
    let cells = [8, 6, 6];
    let labels = phases(288, 5);
    let (partition, _, forces) = forces(&body(cells, &labels, &[1e5, 5e6]), 2);
    // The stiff phase of the near half becomes a third one.
    let changed: Vec<u8> = (0..288).map(|c| if c < 144 && labels[c] == 2 { 3 } else { labels[c] }).collect();
    let error = |change: f64| {
        let model = body(cells, &changed, &[1e5, 5e6, 5e6 * (1.0 + change)]);
        let substructures = Substructures::new(&model, forces.clone(), InterfaceSpace::default());
        let harmonic = HarmonicDisplacements::solve(&model, SolverChoice::Direct, &silent).unwrap();
        let mesh = whole(&model, &partition);
        let all = mesh.elements();
        let global = Training::from_harmonic(&model, &mesh, all, &harmonic);
        let of = |i: usize| difference(&data(&substructures, &model, all[i]).unwrap(), global.of(i));
        (0..all.len()).map(of).fold(0.0, f64::max)
    };
    let errors = [1e-1, 1e-2, 1e-3, 1e-4].map(error);
    assert!(errors[0] > 1e-4, "the change matters: {errors:?}");
    for pair in errors[1..].windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((9.0..11.0).contains(&ratio), "{errors:?}");
    }
}

fn bits(substructures: &Substructures, model: &FineModel) -> Vec<u64> {
    let mesh = whole(model, substructures.partition());
    let training = substructures.train(model, &mesh, mesh.elements(), &silent).unwrap();
    training.iter().flatten().map(|x| x.to_bits()).collect()
}

#[test]
fn renewed_caches_are_those_of_a_new_build_to_the_last_bit() {
    let cells = [8, 6, 6];
    let labels = phases(288, 9);
    let initial = body(cells, &labels, &[1e5, 5e6, 3e7]);
    let (partition, _, forces) = forces(&initial, 2);
    let mut substructures = Substructures::new(&initial, forces.clone(), InterfaceSpace::default());
    let coarse_of = |c: usize| {
        let at = partition.fine().cell_position(Cell(c)).map(|x| x / 2);
        CoarseCell(partition.coarse().cell(at).0)
    };
    // New materials; a slot of two coarse cells; some of it filled again; a whole coarse cell gone; all as at first.
    let mut now = labels.clone();
    let edits: [&dyn Fn(usize, [usize; 3]) -> Option<u8>; 5] = [
        &|c, at| (at[0] < 3 && c % 3 == 0).then_some(3),
        &|_, at| (at[0] == 3 && at[1] < 4).then_some(0),
        &|_, at| (at[0] == 3 && at[1] < 2).then_some(2),
        &|_, at| at.iter().all(|x| *x < 2).then_some(0),
        &|c, _| Some(labels[c]),
    ];
    let mut states = Vec::new();
    for edit in edits {
        let before = now.clone();
        (0..288).for_each(|c| now[c] = edit(c, partition.fine().cell_position(Cell(c))).unwrap_or(now[c]));
        let mut changed: Vec<CoarseCell> = (0..288).filter(|c| now[*c] != before[*c]).map(coarse_of).collect();
        changed.dedup();
        let model = body(cells, &now, &[1e5, 5e6, 3e7]);
        substructures.renew(&model, &changed);
        let found = bits(&substructures, &model);
        let fresh = bits(&Substructures::new(&model, forces.clone(), InterfaceSpace::default()), &model);
        assert!(found == fresh, "after {} changed cells", changed.len());
        assert!(found.iter().all(|x| f64::from_bits(*x).is_finite()));
        states.push(found);
    }
    assert_ne!(states[0], states[1]);
    assert_eq!(states[4], bits(&Substructures::new(&initial, forces, InterfaceSpace::default()), &initial));
}

#[test]
fn cells_that_a_change_does_not_reach_keep_their_data() {
    // A coarse cell goes; rings that do not hold it are still those of the global displacements, though their outer interfaces are gone.
    let cells = [10, 6, 4];
    let labels = phases(240, 4);
    let initial = body(cells, &labels, &[1e5, 5e6]);
    let (partition, harmonic, forces) = forces(&initial, 2);
    let at = |c: usize| partition.fine().cell_position(Cell(c)).map(|x| x / 2);
    let now: Vec<u8> = (0..240).map(|c| if at(c) == [1, 1, 0] { 0 } else { labels[c] }).collect();
    let model = body(cells, &now, &[1e5, 5e6]);
    let substructures = Substructures::new(&model, forces, InterfaceSpace::default());
    let mut far = 0;
    for &cell in whole(&model, &partition).elements() {
        let found = data(&substructures, &model, cell).unwrap();
        let global = Training::from_harmonic(&initial, &whole(&initial, &partition), &[cell], &harmonic);
        let error = difference(&found, global.of(0));
        if partition.coarse().cell_position(Cell(cell.cell.0))[0] > 2 {
            far += 1;
            assert!(error < 1e-8, "{cell:?}: {error:e}");
        } else {
            assert!(error > 1e-4 && error.is_finite(), "{cell:?}: {error:e}");
        }
    }
    assert_eq!(far, 12);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let mut labels = phases(6 * 6 * 6, 2);
    (0..216).step_by(7).for_each(|c| labels[c] = 0);
    let model = body([6, 6, 6], &labels, &[1e5, 5e6]);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (_, _, forces) = forces(&model, 2);
            bits(&Substructures::new(&model, forces, InterfaceSpace::default()), &model)
        })
    };
    let one = with(1);
    assert!(one.iter().all(|x| f64::from_bits(*x).is_finite()));
    [2, 5].iter().for_each(|n| assert!(with(*n) == one, "{n} threads"));
}

#[test]
fn the_bound_vanishes_without_a_change_only() {
    let cells = [8, 6, 6];
    let labels = phases(288, 1);
    let (_, _, forces) = forces(&body(cells, &labels, &[1e5, 5e6]), 2);
    let changed: Vec<u8> = (0..288).map(|c| if c % 5 == 0 { 3 } else { labels[c] }).collect();
    let bound = |young: f64| {
        let model = body(cells, if young == 0.0 { &labels } else { &changed }, &[1e5, 5e6, young.max(1e5)]);
        let substructures = Substructures::new(&model, forces.clone(), InterfaceSpace::default());
        substructures.error_bound(&model, CoarseCell(4 + 12 + 1)).unwrap()
    };
    let (none, large) = (bound(0.0), bound(5e7));
    for k in 0..6 {
        assert!(none[k] < 1e-6 && large[k] > 1e-2, "field {k}: {:e} {:e}", none[k], large[k]);
    }
}

#[path = "../examples/interface_study.rs"]
#[allow(dead_code, reason = "the example's own main is not called here")]
mod interface_study;

#[test]
fn on_layered_cantilevers_the_error_is_the_global_one_at_the_start_and_grows_with_the_change() {
    use interface_study::{Case, PATTERNS, Start};
    let mut table = Vec::new();
    for (_, direction) in PATTERNS {
        let case = Case::new(2, direction).unwrap();
        let [global, _] = case.references().unwrap();
        let error =
            |start| case.substructured(&case.forces(direction, start).unwrap(), InterfaceSpace::default()).unwrap();
        table.push([global, error(Start::Itself), error(Start::Swapped), error(Start::Homogeneous)]);
    }
    // Global, initialised on itself, from swapped phases, from a homogeneous body; oblique, horizontal, vertical. An independent prototype has
    // 22.2, 61.8 and 23.2 in the first two columns.
    let expected = [[22.2, 22.2, 77.6, 242.8], [61.8, 61.8, 93.2, 104.8], [23.2, 23.2, 24.3, 26.1]];
    for (row, expected) in table.iter().zip(expected) {
        assert!((row[0] - row[1]).abs() < 1e-4, "{table:?}");
        assert!(row.iter().zip(expected).all(|(e, x)| (e - x).abs() < 0.06), "{table:?}");
    }
}
