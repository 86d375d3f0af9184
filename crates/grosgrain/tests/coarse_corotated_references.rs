//! The coarse model under large rotations against the fine model, the linear coarse model and itself built anew.

mod bodies;
mod corotated;

use bodies::*;
use corotated::*;
use grosgrain::coarse::{
    BuildOptions, CoarseModel, Corotated, CorotatedError, EmbeddedPoint, Embedding, Integration, Method, NO_POTENTIALS,
    Potential, SupportedCoarse, build,
};
use grosgrain::dynamics::solve_coarse;
use grosgrain::fine::{FineForces, FineModel};
use grosgrain::linalg::matrix3::{apply, cross};
use grosgrain::material::{Law, Material, MaterialTable, Projection};
use grosgrain::mesh::{Cell, Label, Node, VoxelGrid};
use grosgrain::partition::CellPart;
use grosgrain::progress::silent;
use grosgrain::training::TrainingKind;

/// The coarse cell at `at` of a body, as a body of its own.
fn alone(model: &FineModel, degree: usize, at: [usize; 3]) -> FineModel {
    FineModel::new(cut_out(model.grid(), at.map(|x| x * degree), [degree; 3]), &materials()).unwrap()
}

#[test]
fn energy_and_forces_at_the_gauss_points_are_those_of_the_fine_model_on_the_embedded_displacement() {
    // Coarse cells with voids, and with cells of small displacement among others.
    for (degree, at) in [(2, [1, 0, 0]), (3, [1, 0, 0]), (3, [0, 1, 0])] {
        let model = alone(&body(degree, true, 5), degree, at);
        let coarse = coarsened(&model, degree, Method::Trained(TrainingKind::SingleCell));
        assert_eq!(coarse.elements().len(), 1);
        let embedding = Embedding::new(&coarse);
        let corotated = Corotated::new(&model, &coarse, Integration::Gauss);
        let fine = FineForces::new(&model);
        let u = far(&model, &coarse, 12);
        let moved = corotated.prolong(&coarse, &embedding, &u).unwrap();
        let mut fine_forces = vec![0.0; moved.len()];
        let exact = fine.gradient(&model, &moved, &mut fine_forces).unwrap();
        let mut forces = vec![0.0; u.len()];
        let found = corotated.gradient(&coarse, &u, NO_POTENTIALS, &mut forces).unwrap().elastic;
        assert!((found / exact - 1.0).abs() < 1e-12, "degree {degree}: {found} against {exact}");
        let step = 1e-5;
        for seed in 0..4 {
            let p = random_direction(u.len(), seed);
            let [ahead, behind] =
                [step, -step].map(|s| corotated.prolong(&coarse, &embedding, &stepped(&u, s, &p)).unwrap());
            let virtual_work: f64 =
                fine_forces.iter().zip(ahead.iter().zip(&behind)).map(|(f, (a, b))| f * (a - b) / (2.0 * step)).sum();
            assert!((virtual_work - dot(&forces, &p)).abs() < 1e-8 * norm(&forces), "degree {degree}");
        }
    }
}

#[test]
fn trilinear_functions_do_not_see_the_rotation_at_the_gauss_points() {
    let model = body(2, true, 5);
    let coarse = coarsened(&model, 2, Method::Trilinear);
    let (embedding, u) = (Embedding::new(&coarse), far(&model, &coarse, 3));
    let corotated = Corotated::new(&model, &coarse, Integration::Gauss);
    let found = corotated.energy(&coarse, &u, NO_POTENTIALS).unwrap().elastic;
    let exact = FineForces::new(&model).energy(&model, &embedding.prolong(&u)).unwrap();
    assert!((found / exact - 1.0).abs() < 1e-12, "{found} against {exact}");
    let forces = gradient(&corotated, &coarse, &u, NO_POTENTIALS);
    let mut fine_forces = vec![0.0; 3 * model.active().len()];
    FineForces::new(&model).gradient(&model, &embedding.prolong(&u), &mut fine_forces).unwrap();
    let error = relative(&forces, &embedding.restrict(&fine_forces));
    assert!(error < 1e-12, "off by {error:.1e}");
}

#[test]
fn one_point_per_cell_is_exact_where_the_deformation_is_uniform() {
    let model = body(3, false, 5);
    let coarse = coarsened(&model, 3, Method::Trilinear);
    let turn = rotation([0.4, 0.3, -1.0], 100.0);
    let stretch = [[1.1, 0.05, 0.0], [0.0, 0.9, -0.1], [0.02, 0.0, 1.2]];
    let displaced = |x: &[f64; 3]| {
        let to = apply(&turn, &apply(&stretch, x));
        [0, 1, 2].map(|r| to[r] - x[r])
    };
    let u: Vec<f64> = vertex_positions(&model, &coarse).iter().flat_map(displaced).collect();
    let [eight, one] = [Integration::Gauss, Integration::Centre].map(|integration| {
        let corotated = Corotated::new(&model, &coarse, integration);
        let energy = corotated.energy(&coarse, &u, NO_POTENTIALS).unwrap().elastic;
        (energy, gradient(&corotated, &coarse, &u, NO_POTENTIALS))
    });
    assert!((eight.0 / one.0 - 1.0).abs() < 1e-13, "{} against {}", eight.0, one.0);
    assert!(relative(&one.1, &eight.1) < 1e-12);
}

#[test]
fn a_rigid_motion_of_the_vertices_moves_every_fine_node_so() {
    for degree in [2, 3] {
        let model = body(degree, false, 7);
        let coarse = trained(&model, degree);
        let turn = rotation([0.7, 0.1, -0.4], 100.0);
        let u = moved(&model, &coarse, &turn, 0.0, 0);
        let corotated = Corotated::new(&model, &coarse, Integration::Stiffness);
        let found = corotated.prolong(&coarse, &Embedding::new(&coarse), &u).unwrap();
        for node in (0..model.active().len()).map(Node) {
            let x = model.node_position(node);
            let exact = apply(&turn, &x);
            for r in 0..3 {
                let exact = if model.active()[node.0] { exact[r] - x[r] + [0.4, -0.1, 0.2][r] } else { 0.0 };
                assert!((found[3 * node.0 + r] - exact).abs() < 1e-14 * 10.0, "node {node:?}");
            }
        }
    }
}

#[test]
fn embedded_nodes_are_where_the_prolongation_puts_them() {
    let model = body(3, true, 7);
    let coarse = trained(&model, 3);
    let u = far(&model, &coarse, 1);
    let mut corotated = Corotated::new(&model, &coarse, Integration::Centre);
    let fine = corotated.prolong(&coarse, &Embedding::new(&coarse), &u).unwrap();
    let mut positions = Vec::new();
    for node in (0..model.active().len()).map(Node) {
        let copies = EmbeddedPoint::of_node(&coarse, node);
        assert_eq!(copies.is_empty(), !model.active()[node.0]);
        corotated.set_points(copies.clone());
        corotated.positions(&coarse, &u, &mut positions).unwrap();
        for r in (0..3).filter(|_| !copies.is_empty()) {
            let mean: f64 = copies.iter().zip(&positions).map(|(point, x)| point.share * x[r]).sum();
            let exact = model.node_position(node)[r] + fine[3 * node.0 + r];
            assert!((mean - exact).abs() < 1e-13 * 10.0, "node {node:?}: {mean} against {exact}");
        }
    }
}

#[test]
fn points_are_listed_in_the_order_in_which_they_were_given_and_have_their_share_of_the_potential() {
    let model = body(3, true, 7);
    let coarse = trained(&model, 3);
    let u = far(&model, &coarse, 1);
    let (corotated, bowls) = loaded(&model, &coarse, Integration::Stiffness);
    let points = corotated.points();
    assert!(!points.is_sorted_by_key(|point| point.element), "the order of elements tells nothing");
    let mut positions = Vec::new();
    corotated.positions(&coarse, &u, &mut positions).unwrap();
    let (mut alone, mut one) = (corotated.clone(), Vec::new());
    for (point, position) in points.iter().zip(&positions) {
        alone.set_points(vec![*point]);
        alone.positions(&coarse, &u, &mut one).unwrap();
        assert_eq!(one, [*position]);
    }
    let energy = |n: usize| points[n].share * bowls[n].evaluate(positions[n]).0;
    let exact: f64 = (0..points.len()).map(energy).sum();
    let found = corotated.energy(&coarse, &u, &bowls).unwrap().points;
    assert!((found / exact - 1.0).abs() < 1e-13, "{found} against {exact}");
}

#[test]
fn dead_loads_do_the_work_of_the_fine_forces_on_the_embedded_displacement_and_have_their_moment() {
    let model = body(3, false, 7);
    let coarse = trained(&model, 3);
    let (embedding, u) = (Embedding::new(&coarse), far(&model, &coarse, 1));
    let mut forces: Vec<f64> = loads(&model, 1.0);
    (0..forces.len()).filter(|n| !model.active()[n / 3]).for_each(|n| forces[n] = 0.0);
    let without = Corotated::new(&model, &coarse, Integration::Stiffness);
    let mut with = without.clone();
    with.set_loads(&coarse, &embedding, &forces);
    let moved = with.prolong(&coarse, &embedding, &u).unwrap();
    let work = -with.energy(&coarse, &u, NO_POTENTIALS).unwrap().loads;
    assert!((work / dot(&forces, &moved) - 1.0).abs() < 1e-12, "{work} against {}", dot(&forces, &moved));
    let [all, elastic] = [&with, &without].map(|corotated| gradient(corotated, &coarse, &u, NO_POTENTIALS));
    let at_vertices: Vec<f64> = all.iter().zip(&elastic).map(|(a, b)| b - a).collect();
    let moment = |places: Vec<[f64; 3]>, u: &[f64], f: &[f64]| {
        let mut sum = [0.0; 6];
        for ((x, u), f) in places.iter().zip(u.chunks_exact(3)).zip(f.chunks_exact(3)) {
            let part = cross(&std::array::from_fn(|r| x[r] + u[r]), &[f[0], f[1], f[2]]);
            (0..3).for_each(|r| sum[r] += part[r]);
            (0..3).for_each(|r| sum[3 + r] += f[r]);
        }
        sum
    };
    let fine_places = (0..model.active().len()).map(|n| model.node_position(Node(n))).collect();
    let exact = moment(fine_places, &moved, &forces);
    let found = moment(vertex_positions(&model, &coarse), &u, &at_vertices);
    assert!(relative(&found, &exact) < 1e-11, "{found:?} against {exact:?}");
}

#[test]
fn elements_of_small_displacement_do_not_rotate() {
    let model = body(2, true, 5);
    let coarse = trained(&model, 2);
    for integration in INTEGRATIONS {
        let corotated = Corotated::new(&model, &coarse, integration);
        let rotating: Vec<bool> = (0..coarse.elements().len()).map(|index| corotated.rotates(index)).collect();
        assert_eq!(rotating, [true, true, true, false], "{integration:?}");
    }
    let mut table = MaterialTable::new();
    table.insert(Label(0), Material::linear("linear", isotropic(7.0, 0.3), 1.0));
    let mut grid = model.grid().clone();
    grid.labels.fill(Label(0));
    let linear = FineModel::new(grid, &table).unwrap();
    let coarse_linear = trained(&linear, 2);
    let u = far(&linear, &coarse_linear, 2);
    let stiffness: Vec<_> = (0..coarse_linear.elements().len()).map(|index| *coarse_linear.stiffness(index)).collect();
    let exact = product_with(&coarse_linear, &stiffness, &u);
    for integration in INTEGRATIONS {
        let corotated = Corotated::new(&linear, &coarse_linear, integration);
        assert!(relative(&gradient(&corotated, &coarse_linear, &u, NO_POTENTIALS), &exact) < 1e-14);
        let matrices = tangents(&corotated, &coarse_linear, &u, (NO_POTENTIALS, Projection::Exact));
        assert_eq!(matrices, stiffness, "{integration:?}");
        let embedding = Embedding::new(&coarse_linear);
        let fine = corotated.prolong(&coarse_linear, &embedding, &u).unwrap();
        assert!(relative(&fine, &embedding.prolong(&u)) < 1e-14);
    }
}

#[test]
fn a_static_solution_balances_small_loads_with_penalty_springs_and_held_vertices() {
    let model = body(3, true, 4);
    let coarse = trained(&model, 3);
    let embedding = Embedding::new(&coarse);
    // A clamp that ends between coarse planes: whole coarse nodes at x = 0, a penalty beyond.
    let lattice = model.grid().lattice;
    let fixed: Vec<bool> = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] <= 1).collect();
    let supported = SupportedCoarse::new(&coarse, &embedding, &fixed);
    let penalties = supported.penalty_points();
    assert!(supported.held_by_penalty > 0 && !penalties.is_empty());
    for penalty in penalties {
        let sum: f64 = penalty.nodes.iter().map(|(_, weight)| weight).sum();
        assert!((sum - 1.0).abs() < 1e-14 && penalty.nodes.iter().all(|(node, _)| fixed[*node as usize]));
    }
    let target = |penalty: &grosgrain::coarse::PenaltyPoint| {
        let mut centre = [0.0; 3];
        for (node, weight) in &penalty.nodes {
            let x = model.node_position(Node(*node as usize));
            (0..3).for_each(|r| centre[r] += weight * x[r]);
        }
        let k = penalty.stiffness;
        Bowl { centre, stiffness: [[k, 0.0, 0.0], [0.0, k, 0.0], [0.0, 0.0, k]], quartic: 0.0 }
    };
    let springs: Vec<Bowl> = penalties.iter().map(target).collect();
    let rest = vec![0.0; 3 * coarse.mesh().vertices().len()];
    for integration in INTEGRATIONS {
        let residual = |size: f64| {
            let forces = loads(&model, size);
            let solution = solve_coarse(&coarse, &fixed, &forces, &silent).unwrap();
            let mut corotated = Corotated::new(&model, &coarse, integration);
            corotated.set_loads(&coarse, &embedding, &forces);
            corotated.set_points(penalties.iter().map(|penalty| penalty.point).collect());
            let energies = corotated.energy(&coarse, &rest, &springs).unwrap();
            assert!(energies.points < 1e-20, "springs rest at rest: {:.1e}", energies.points);
            let at_rest = tangents(&corotated, &coarse, &rest, (&springs, Projection::PositiveSemidefinite));
            for (index, matrix) in at_rest.iter().enumerate() {
                let error = relative(matrix, supported.stiffness(index));
                assert!(error < 1e-10, "{integration:?}, element {index}: off by {error:.1e}");
            }
            let mut out = gradient(&corotated, &coarse, &solution.coarse_displacement, &springs);
            (0..out.len()).filter(|n| supported.constraints.is_fixed(n / 3, n % 3)).for_each(|n| out[n] = 0.0);
            norm(&out) / norm(&embedding.restrict(&forces))
        };
        let residuals = [residual(1e-3), residual(1e-4)];
        assert!(residuals[0] < 1e-2, "{integration:?}: {residuals:?}");
        assert!((residuals[0] / residuals[1] - 10.0).abs() < 0.5, "{integration:?}: {residuals:?}");
    }
}

/// Bits of energies, forces and tangents in a state far from rest.
fn bits(corotated: &Corotated, model: &FineModel, coarse: &CoarseModel) -> Vec<u64> {
    let u = far(model, coarse, 8);
    let mut values = gradient(corotated, coarse, &u, NO_POTENTIALS);
    values.push(corotated.energy(coarse, &u, NO_POTENTIALS).unwrap().total());
    for projection in [Projection::Exact, Projection::PositiveSemidefinite] {
        values.extend(tangents(corotated, coarse, &u, (NO_POTENTIALS, projection)).iter().flatten());
    }
    values.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn renewing_what_an_edit_reaches_gives_the_model_of_the_edited_body_bit_for_bit() {
    let model = body(3, true, 5);
    let options = BuildOptions { method: Method::Trained(TrainingKind::SingleCell), ..BuildOptions::default() };
    let coarse = build(&model, 3, &options, &silent).unwrap().model;
    // A slot splits the first coarse cell in two; a cell of the last one changes its law, so that the element rotates.
    let mut grid = model.grid().clone();
    for cell in 0..grid.lattice.cell_count() {
        let at = grid.lattice.cell_position(Cell(cell));
        grid.void[cell] |= at[0] < 3 && at[1] < 3 && at[2] == 1;
    }
    let changed = grid.lattice.cell([5, 5, 1]);
    grid.labels[changed.0] = Label(0);
    let edited = FineModel::new(grid, &materials()).unwrap();
    let coarse_edited = build(&edited, 3, &options, &silent).unwrap().model;
    assert_eq!([coarse.elements().len(), coarse_edited.elements().len()], [4, 5]);
    let dirty: Vec<CellPart> =
        coarse_edited.elements().iter().copied().filter(|element| [0, 3].contains(&element.cell.0)).collect();
    for integration in INTEGRATIONS {
        let mut renewed = Corotated::new(&model, &coarse, integration);
        assert!(!renewed.rotates(3));
        renewed.set_loads(&coarse, &Embedding::new(&coarse), &loads(&model, 1.0));
        renewed.set_points(EmbeddedPoint::of_node(&coarse, Node(0)));
        renewed.renew(&edited, &coarse_edited, &dirty);
        let new = Corotated::new(&edited, &coarse_edited, integration);
        assert!(renewed.rotates(4));
        assert!(bits(&renewed, &edited, &coarse_edited) == bits(&new, &edited, &coarse_edited), "{integration:?}");
    }
}

#[test]
fn results_are_alike_for_any_number_of_threads() {
    let model = body(3, true, 5);
    let coarse = trained(&model, 3);
    let u = far(&model, &coarse, 8);
    for integration in INTEGRATIONS {
        let compute = || {
            let (corotated, bowls) = loaded(&model, &coarse, integration);
            let mut values = gradient(&corotated, &coarse, &u, &bowls);
            values.push(corotated.energy(&coarse, &u, &bowls).unwrap().total());
            values.extend(tangents(&corotated, &coarse, &u, (&bowls, Projection::Exact)).iter().flatten());
            values.extend(corotated.prolong(&coarse, &Embedding::new(&coarse), &u).unwrap());
            values.iter().map(|v| v.to_bits()).collect::<Vec<u64>>()
        };
        let with = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(compute);
        let one = with(1);
        assert!([2, 5].into_iter().all(|threads| with(threads) == one), "{integration:?}");
    }
}

#[test]
fn states_without_energy_are_refused_with_their_place() {
    let model = body(2, false, 5);
    let coarse = trained(&model, 2);
    let mirrored: Vec<f64> = vertex_positions(&model, &coarse).iter().flat_map(|x| [0.0, -2.0 * x[1], 0.0]).collect();
    let mut out = vec![0.0; mirrored.len()];
    for integration in INTEGRATIONS {
        let corotated = Corotated::new(&model, &coarse, integration);
        let error = corotated.gradient(&coarse, &mirrored, NO_POTENTIALS, &mut out).unwrap_err();
        assert!(
            matches!(error, CorotatedError::Collapsed { at: [0, 0, 0], determinant } if (determinant + 1.0).abs() < 1e-12)
        );
        assert!(error.to_string().starts_with("collapsed coarse cell (0, 0, 0): det = -1.000"), "{error}");
        let embedding = Embedding::new(&coarse);
        assert_eq!(corotated.prolong(&coarse, &embedding, &mirrored).unwrap_err(), error);
        let mut unknown = mirrored.clone();
        unknown[0] = f64::NAN;
        assert!(matches!(corotated.energy(&coarse, &unknown, NO_POTENTIALS), Err(CorotatedError::Collapsed { .. })));
    }
    assert!(out.iter().all(|f| *f == 0.0));
    // Two coarse cells of one material; in the second, fine cells at one edge are turned inside out while its centre is not.
    let mut table = MaterialTable::new();
    table.insert(Label(0), Material { law: Law::NeoHookean, ..Material::linear("soft", isotropic(1.0, 0.3), 1.0) });
    let grid = VoxelGrid { origin: [0.0; 3], ..VoxelGrid::uniform([4, 2, 2], [1.0; 3], Label(0)) };
    let model = FineModel::new(grid, &table).unwrap();
    let coarse = coarsened(&model, 2, Method::Trilinear);
    // The little push along y lets the nearer of two cells be inverted more, by more than rounding.
    let pushed = |x: &[f64; 3]| if *x == [4.0, 2.0, 2.0] { [-3.8, 0.1, 0.0] } else { [0.0; 3] };
    let u: Vec<f64> = vertex_positions(&model, &coarse).iter().flat_map(pushed).collect();
    for integration in [Integration::Gauss, Integration::Centre] {
        let corotated = Corotated::new(&model, &coarse, integration);
        let error = corotated.energy(&coarse, &u, NO_POTENTIALS).unwrap_err();
        let CorotatedError::Inverted(cell) = error else { panic!("{error}") };
        assert_eq!((cell.at, cell.cell), ([2, 1, 1], Cell(14)), "{error}");
        assert!(cell.determinant < 0.0);
        let mut matrices = Vec::new();
        let refused = corotated.tangents(&coarse, &u, NO_POTENTIALS, Projection::Exact, &mut matrices);
        assert_eq!(refused, Err(error));
    }
    assert!(Corotated::new(&model, &coarse, Integration::Stiffness).energy(&coarse, &u, NO_POTENTIALS).is_ok());
}
