//! Coarse cells that fall into several parts: each part has coarse nodes, functions and stiffness of its own.

mod bodies;

use bodies::*;
use faer::{Mat, Side};
use grosgrain::coarse::{BuildOptions, Built, CoarseModel, Embedding, Method, build};
use grosgrain::coarsening::{BaseKind, COLUMNS, Objective, ShapeFunctions};
use grosgrain::dynamics::{CoarseSolution, relative_error, solve_coarse, solve_fine};
use grosgrain::fine::{FineModel, gravity, traction};
use grosgrain::mesh::{Cell, Components, Label, Neighbourhood, Node, VoxelGrid};
use grosgrain::partition::{CellPart, CoarseCell, CoarseMesh, Partition};
use grosgrain::progress::silent;
use grosgrain::solver::{SolverChoice, SolverError};
use grosgrain::training::{HarmonicDisplacements, Training, TrainingKind, train};
use proptest::prelude::*;

const KINDS: [TrainingKind; 3] = [TrainingKind::Global, TrainingKind::OneRing, TrainingKind::SingleCell];
const BASES: [BaseKind; 3] = [BaseKind::Harmonic, BaseKind::Trilinear, BaseKind::Material];

fn methods() -> Vec<(Method, BaseKind)> {
    let trained = KINDS.into_iter().flat_map(|kind| BASES.map(|base| (Method::Trained(kind), base)));
    let plain = [(Method::Trilinear, BaseKind::Harmonic), (Method::Average, BaseKind::Harmonic)];
    plain.into_iter().chain(trained).collect()
}

fn built(model: &FineModel, degree: usize, (method, base): (Method, BaseKind), split: bool) -> Built {
    let options = BuildOptions { method, base, split, ..BuildOptions::default() };
    build(model, degree, &options, &silent).unwrap()
}

/// The body without the cells that `gone` names.
fn without(model: &FineModel, gone: impl Fn([usize; 3]) -> bool) -> FineModel {
    let mut grid = model.grid().clone();
    for cell in 0..grid.void.len() {
        grid.void[cell] |= gone(grid.lattice.cell_position(Cell(cell)));
    }
    let poisson = if grid.young.is_some() { 0.3 } else { 0.0 };
    FineModel::new(grid, &table(&[isotropic(1.0, poisson)])).unwrap()
}

fn bits(values: impl IntoIterator<Item = f64>) -> Vec<u64> {
    values.into_iter().map(f64::to_bits).collect()
}

fn model_bits(model: &CoarseModel) -> Vec<u64> {
    let stiffness = (0..model.elements().len()).flat_map(|index| model.stiffness(index).to_vec());
    bits(model.functions().iter().flatten().copied().chain(stiffness).chain(model.mass().iter().copied()))
}

/// Which node-connected part of the body every vertex belongs to.
fn part_of_vertices(model: &FineModel, mesh: &CoarseMesh) -> Vec<usize> {
    let parts = Components::new(&model.grid().void, &model.grid().lattice, Neighbourhood::Nodes);
    let mut part_of = vec![usize::MAX; mesh.vertices().len()];
    for (element, corners) in mesh.elements().iter().zip(mesh.corners()) {
        let (_, fine) = mesh.fine_cells(*element).next().unwrap();
        corners.iter().for_each(|v| part_of[*v as usize] = parts.of(fine).unwrap());
    }
    part_of
}

#[test]
fn bodies_without_voids_have_the_same_model_split_or_not() {
    let model = random_model([6, 3, 6], [1.0, 0.5, 2.0], 1e3, 0.3, 12);
    let (fixed, loads) = (plane(model.grid().lattice, 0, 0), gravity(&model, [0.0, 0.0, -9.81]));
    for method in methods() {
        let [split, whole] = [true, false].map(|split| built(&model, 3, method, split));
        assert_eq!(model_bits(&split.model), model_bits(&whole.model), "{method:?}");
        let data = |built: &Built| bits(built.training.iter().flat_map(|t| t.iter().flatten().copied()));
        assert_eq!(data(&split), data(&whole), "{method:?}");
        let solve = |built: &Built| solve_coarse(&built.model, &fixed, &loads, &silent).unwrap().displacement;
        assert_eq!(bits(solve(&split)), bits(solve(&whole)), "{method:?}");
    }
}

#[test]
fn a_slot_through_coarse_cells_leaves_linear_fields_of_either_side_exact() {
    let solid =
        FineModel::new(VoxelGrid::uniform([8, 4, 8], [1.0, 0.5, 1.5], Label(0)), &table(&[isotropic(5.0, 0.3)]));
    let model = without(&solid.unwrap(), |[_, _, k]| k == 2);
    let gradients =
        [[[0.3, -0.2, 0.7], [0.1, 0.9, -0.4], [0.8, 0.2, -0.5]], [[-0.6, 0.4, 0.1], [0.5, -0.3, 0.2], [0.7, 0.6, 0.9]]];
    for method in methods().into_iter().filter(|(_, base)| *base == BaseKind::Trilinear) {
        let coarse = built(&model, 4, method, true).model;
        let mesh = coarse.mesh();
        let part_of = part_of_vertices(&model, mesh);
        let at_vertices = mesh.vertices().iter().zip(&part_of).flat_map(|(vertex, part)| {
            apply(gradients[*part], model.node_position(mesh.partition().coincident_node(vertex.node)))
        });
        let found = Embedding::new(&coarse).prolong(&at_vertices.collect::<Vec<f64>>());
        let lattice = model.grid().lattice;
        for node in (0..lattice.node_count()).filter(|&n| model.active()[n]) {
            let part = usize::from(lattice.node_position(Node(node))[2] > 2);
            let exact = apply(gradients[part], model.node_position(Node(node)));
            for r in 0..3 {
                let error = (found[3 * node + r] - exact[r]).abs();
                assert!(error < 1e-11, "{method:?}, node {node}: off by {error:.1e} of 10 m");
            }
        }
    }
}

#[test]
fn both_sides_of_a_slotted_bar_stretch_as_they_are_pulled() {
    let grid = VoxelGrid::uniform([8, 4, 8], [1.0, 0.5, 1.5], Label(0));
    let model = without(&FineModel::new(grid, &table(&[isotropic(1.0, 0.0)])).unwrap(), |[_, _, k]| k == 2);
    let lattice = model.grid().lattice;
    let side = |n: usize| usize::from(lattice.node_position(Node(n))[2] > 2);
    let pulls = [0.02, -0.05];
    let mut loads = vec![0.0; 3 * lattice.node_count()];
    for (part, pull) in pulls.into_iter().enumerate() {
        let end: Vec<bool> = plane(lattice, 0, 8).iter().enumerate().map(|(n, m)| *m && side(n) == part).collect();
        loads.iter_mut().zip(traction(&model, &end, [pull, 0.0, 0.0]).0).for_each(|(sum, f)| *sum += f);
    }
    let mut exact = vec![0.0; loads.len()];
    for n in (0..lattice.node_count()).filter(|&n| model.active()[n]) {
        exact[3 * n] = pulls[side(n)] * model.node_position(Node(n))[0];
    }
    for method in methods().into_iter().filter(|(_, base)| *base == BaseKind::Trilinear) {
        let solve =
            |split| solve_coarse(&built(&model, 4, method, split).model, &plane(lattice, 0, 0), &loads, &silent);
        let error = relative(&solve(true).unwrap().displacement, &exact);
        assert!(error < 1e-9, "{method:?}: {error:.1e}");
        let tied = relative(&solve(false).unwrap().displacement, &exact);
        assert!(tied > 0.5, "{method:?}: tied over the slot the bars cannot part, {tied:.2}");
    }
}

/// Solutions of a body, of its cells below the layer `gap`, and of those above.
fn pair_and_singles(model: &FineModel, gap: usize, method: (Method, BaseKind), split: bool) -> [CoarseSolution; 3] {
    let fixed = plane(model.grid().lattice, 0, 0);
    let pair = without(model, |[_, _, k]| k == gap);
    let lower = without(model, |[_, _, k]| k >= gap);
    let upper = without(model, |[_, _, k]| k <= gap);
    [pair, lower, upper].map(|body| {
        let loads = gravity(&body, [0.0, 3.0, -9.81]);
        solve_coarse(&built(&body, 3, method, split).model, &fixed, &loads, &silent).unwrap()
    })
}

#[test]
fn two_beams_beside_each_other_in_coarse_cells_move_as_each_does_alone() {
    let model = random_model([9, 3, 6], [1.0, 0.5, 0.8], 1e2, 0.3, 4);
    for method in methods() {
        let difference = |split| {
            let [pair, lower, upper] = pair_and_singles(&model, 1, method, split);
            let both: Vec<f64> = lower.displacement.iter().zip(&upper.displacement).map(|(a, b)| a + b).collect();
            relative(&pair.displacement, &both)
        };
        let (split, whole) = (difference(true), difference(false));
        println!("{method:?}: {split:.1e} split, {whole:.1e} whole");
        assert!(split < 1e-10, "{method:?}: {split:.1e}");
        assert!(whole > 1e-2, "{method:?}: in one piece the beams hold each other, {whole:.1e}");
    }
}

#[test]
fn a_slit_opens_as_that_of_the_fine_body_does() {
    let model = without(&random_model([32, 4, 8], [1.0; 3], 1.0, 0.3, 1), |[i, _, k]| i >= 16 && k == 5);
    let lattice = model.grid().lattice;
    let fixed = plane(lattice, 0, 0);
    let side = |n: usize, upper: bool| (lattice.node_position(Node(n))[2] > 5) == upper;
    let mut loads = vec![0.0; 3 * lattice.node_count()];
    for (upper, force) in [(true, 1.0), (false, -1.0)] {
        let end: Vec<bool> = plane(lattice, 0, 32).iter().enumerate().map(|(n, m)| *m && side(n, upper)).collect();
        loads.iter_mut().zip(traction(&model, &end, [0.0, 0.0, force]).0).for_each(|(sum, f)| *sum += f);
    }
    let fine = solve_fine(&model, &fixed, &loads, SolverChoice::Direct, &silent).unwrap();
    for method in methods() {
        let [split, whole] = [true, false].map(|split| {
            let coarse = built(&model, 4, method, split).model;
            let solution = solve_coarse(&coarse, &fixed, &loads, &silent).unwrap();
            100.0 * relative_error(&solution.displacement, &fine.displacement)
        });
        println!("{method:?}: {split:.1} % split, {whole:.1} % whole");
        // The arms bend, in which trilinear functions lock: without training or over a conforming base much is left. Measured: 0.18 of the
        // error in one piece over the harmonic base, 0.56 and 0.60 over the others, 0.80 with averaged material.
        let share = if matches!(method, (Method::Trained(_), BaseKind::Harmonic)) { 0.25 } else { 0.85 };
        assert!(split < share * whole, "{method:?}: {split:.1} % split, {whole:.1} % whole");
    }
}

#[test]
fn data_of_a_part_are_the_harmonic_displacements_of_its_fine_cells() {
    let model = without(&random_model([9, 3, 3], [1.0, 0.5, 0.8], 1e2, 0.3, 4), |[i, _, k]| k == 1 && i < 5);
    let partition = Partition::new(model.grid().lattice, 3).unwrap();
    let mesh = CoarseMesh::new(&model.grid().void, &partition);
    assert_eq!(mesh.elements().len(), 4);
    let harmonic = HarmonicDisplacements::solve(&model, SolverChoice::Direct, &silent).unwrap();
    let training = Training::from_harmonic(&model, &mesh, mesh.elements(), &harmonic);
    let (lattice, local, spacing) = (model.grid().lattice, partition.cell_lattice(), model.grid().spacing);
    for (field, u) in harmonic.displacements.chunks_exact(3 * lattice.node_count()).enumerate() {
        for (index, element) in mesh.elements().iter().enumerate() {
            let own: Vec<f64> = training.of(index).chunks_exact(6).map(|row| row[field]).collect();
            for (cell, fine) in mesh.fine_cells(*element) {
                let found = strain(local, spacing, &own, Cell(cell), [0.3; 3]);
                let exact = strain(lattice, spacing, u, fine, [0.3; 3]);
                (0..6).for_each(|i| assert!((found[i] - exact[i]).abs() < 1e-11 * largest(&exact), "{element:?}"));
            }
        }
    }
}

/// Three coarse cells in a row, three in the next: an edit of one leaves those two cells away alone.
#[test]
fn replacing_what_an_edit_reaches_gives_the_model_of_the_edited_body() {
    let before = without(&random_model([15, 6, 3], [1.0, 0.5, 0.8], 1e2, 0.3, 4), |[i, _, k]| i > 6 && k == 1);
    let after = without(&before, |at| at[2] == 1 && at[0] < 2 || at == [1, 1, 2]);
    let partition = Partition::new(after.grid().lattice, 3).unwrap();
    for kind in [TrainingKind::OneRing, TrainingKind::SingleCell] {
        for base in BASES {
            let built_before = built(&before, 3, (Method::Trained(kind), base), true);
            let built_after = built(&after, 3, (Method::Trained(kind), base), true);
            let mut mesh = built_before.model.mesh().clone();
            let changed = [0, 5].map(CoarseCell);
            mesh.update(&after.grid().void, &changed);
            let reach = |cell: CoarseCell| match kind {
                TrainingKind::OneRing => partition.coarse().cell_position(Cell(cell.0))[0] <= 1,
                _ => changed.contains(&cell),
            };
            let dirty: Vec<CellPart> = mesh.elements().iter().copied().filter(|e| reach(e.cell)).collect();
            let (data, _) = train(&after, &mesh, &dirty, kind, &silent).unwrap();
            let options = (base, Objective::ClosedForm);
            let renewed = ShapeFunctions::fit(&after, &mesh, &data, options, &silent).unwrap();
            let mut training = built_before.training.unwrap();
            training.replace(mesh.elements(), data);
            assert_eq!(Some(training), built_after.training, "{kind:?}");
            let mut model = built_before.model;
            model.replace(&after, mesh, renewed);
            assert_eq!(model.mesh(), built_after.model.mesh());
            assert_eq!(model_bits(&model), model_bits(&built_after.model), "{kind:?}, {base:?}");
        }
    }
}

#[test]
fn a_part_that_nothing_holds_is_named() {
    let grid = VoxelGrid::uniform([10, 5, 5], [1.0; 3], Label(0));
    let hollow = |[i, j, k]: [usize; 3]| {
        let island = [i, j, k] == [7, 2, 2];
        !island && [i % 5, j, k].iter().all(|x| (1..4).contains(x)) && i >= 5
    };
    let model = without(&FineModel::new(grid, &table(&[isotropic(1.0, 0.0)])).unwrap(), hollow);
    let (fixed, loads) = (plane(model.grid().lattice, 0, 0), gravity(&model, [0.0, 0.0, -9.81]));
    for method in methods() {
        let error = solve_coarse(&built(&model, 5, method, true).model, &fixed, &loads, &silent).unwrap_err();
        assert_eq!(error, SolverError::Unheld { elements: 1, at: [1, 0, 0] }, "{method:?}");
        assert!(error.to_string().contains("held by nothing"), "{error}");
    }
}

/// K̄ over the vertices, dense.
fn dense_stiffness(coarse: &CoarseModel) -> Mat<f64> {
    let mut k = Mat::zeros(3 * coarse.mesh().vertices().len(), 3 * coarse.mesh().vertices().len());
    for (index, corners) in coarse.mesh().corners().iter().enumerate() {
        let unknown = |i: usize| 3 * corners[i / 3] as usize + i % 3;
        for (n, value) in coarse.stiffness(index).iter().enumerate() {
            k[(unknown(n / COLUMNS), unknown(n % COLUMNS))] += value;
        }
    }
    k
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bodies_are_solved_or_refused_with_the_part_that_nothing_holds(
        coarse_cells in prop::array::uniform3(1..4usize),
        degree in 2..5usize,
        void in 0.1..0.8f64,
        method in 0..11usize,
        seed in any::<u64>(),
    ) {
        let mut random = Uniform(seed);
        let solid = random_model(coarse_cells.map(|n| n * degree), [1.0, 0.6, 1.7], 10.0, 0.3, seed);
        let gone: Vec<bool> = (0..solid.grid().void.len()).map(|_| random.next() < void).collect();
        prop_assume!(gone.contains(&false));
        let lattice = solid.grid().lattice;
        let model = without(&solid, |at| gone[lattice.cell(at).0]);
        let fixed = plane(lattice, 0, 0);
        let coarse = built(&model, degree, methods()[method], true).model;
        let parts = Components::new(&model.grid().void, &lattice, Neighbourhood::Nodes);
        let touches_held = |c: Cell| lattice.cell_position(c)[0] == 0;
        let held: std::collections::BTreeSet<usize> =
            (0..lattice.cell_count()).map(Cell).filter(|c| touches_held(*c)).filter_map(|c| parts.of(c)).collect();
        let all_held = held.len() == parts.count();
        match solve_coarse(&coarse, &fixed, &gravity(&model, [1.0, 2.0, -9.81]), &silent) {
            Ok(solution) => {
                prop_assert!(all_held, "a part floats");
                prop_assert!(solution.displacement.iter().chain([&solution.energy]).all(|v| v.is_finite()));
            }
            // What hangs by a node or an edge can still turn: no direct solver can know.
            Err(SolverError::Unheld { .. }) => prop_assert!(!all_held),
            Err(error) => prop_assert!(!error.to_string().is_empty() && !error.to_string().contains("NaN"), "{error}"),
        }
    }

    #[test]
    fn every_connected_part_has_its_own_rigid_motions_and_its_own_mass(
        coarse_cells in prop::array::uniform3(1..3usize),
        degree in 2..5usize,
        void in 0.3..0.9f64,
        method in 0..11usize,
        seed in any::<u64>(),
    ) {
        let mut random = Uniform(seed);
        let solid = random_model(coarse_cells.map(|n| n * degree), [1.0, 0.6, 1.7], 10.0, 0.3, seed);
        let gone: Vec<bool> = (0..solid.grid().void.len()).map(|_| random.next() < void).collect();
        prop_assume!(gone.contains(&false));
        let lattice = solid.grid().lattice;
        let model = without(&solid, |at| gone[lattice.cell(at).0]);
        let built = built(&model, degree, methods()[method], true);
        let (coarse, mesh) = (&built.model, built.model.mesh());
        let part_of = part_of_vertices(&model, mesh);
        // Elements that share a vertex are in one part of the body, so a vertex is in one part whichever element says so.
        for (element, corners) in mesh.elements().iter().zip(mesh.corners()) {
            let fine = mesh.fine_cells(*element).next().unwrap().1;
            let parts = Components::new(&model.grid().void, &lattice, Neighbourhood::Nodes);
            prop_assert!(corners.iter().all(|v| Some(part_of[*v as usize]) == parts.of(fine)));
        }
        let parts = Components::new(&model.grid().void, &lattice, Neighbourhood::Nodes);
        let k = dense_stiffness(coarse);
        let values = k.self_adjoint_eigenvalues(Side::Lower).unwrap();
        let top = values[values.len() - 1];
        prop_assert!(values[0] > -1e-12 * top, "{} of {top}", values[0]);
        for part in 0..parts.count() {
            for motion in 0..6 {
                let axis = motion % 3;
                let field = |v: usize| -> [f64; 3] {
                    let x = model.node_position(mesh.partition().coincident_node(mesh.vertices()[v].node));
                    let mut u = [0.0; 3];
                    match motion < 3 {
                        true => u[axis] = 1.0,
                        false => (u[(axis + 1) % 3], u[(axis + 2) % 3]) = (-x[(axis + 2) % 3], x[(axis + 1) % 3]),
                    }
                    if part_of[v] == part { u } else { [0.0; 3] }
                };
                let rigid: Vec<f64> = (0..mesh.vertices().len()).flat_map(field).collect();
                let force = &k * Mat::from_fn(rigid.len(), 1, |i, _| rigid[i]);
                let size = (0..rigid.len()).fold(0.0f64, |m, i| m.max(force[(i, 0)].abs()));
                prop_assert!(size < 1e-9 * top, "part {part}, motion {motion}: {size:.1e} of {top:.1e}");
            }
            let of_fine = (0..lattice.cell_count()).map(Cell).filter(|c| parts.of(*c) == Some(part));
            let exact: f64 = of_fine.map(|c| model.cell_mass(c)).sum();
            let mass: f64 = coarse.mass().iter().zip(&part_of).filter(|(_, p)| **p == part).map(|(m, _)| m).sum();
            prop_assert!((mass / exact - 1.0).abs() < 1e-12, "part {part}: {mass} kg, {exact} kg");
        }
    }
}
