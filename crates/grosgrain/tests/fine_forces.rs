//! Energy, forces and tangents of the fine model under large deformation.

mod bodies;

use bodies::*;
use grosgrain::assembly::CellStiffness;
use grosgrain::fine::{
    CellState, CellTangents, FineForces, FineModel, FineModelError, InvertedCell, cauchy_stresses, centre_stresses,
    smallest_determinant,
};
use grosgrain::material::{Elasticity, Law, Material, MaterialTable, PointLaw, Projection};
use grosgrain::mesh::{Cell, Label, VoxelGrid};

const SPACING: [f64; 3] = [1.0, 0.5, 0.8];
const LAWS: [Law; 3] = [Law::Linear, Law::Corotational, Law::NeoHookean];
/// A rotation by 2 rad about (1, 2, 2)/3, then a shift.
const AXIS: [f64; 3] = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];

fn material(law: Law, elasticity: Elasticity) -> Material {
    Material { law, ..Material::linear(law.to_string(), elasticity, 1000.0) }
}

/// Labels 0, 1, 2 follow the three laws with unlike constants.
fn three_laws() -> MaterialTable {
    let mut table = MaterialTable::new();
    for (label, (law, young)) in LAWS.into_iter().zip([2.0, 3.0, 5.0]).enumerate() {
        table.insert(Label(label as i32), material(law, isotropic(young, 0.3)));
    }
    table
}

/// All laws side by side, a modulus per voxel, one void inside and one at the surface.
fn mixed() -> FineModel {
    let mut grid = VoxelGrid::uniform([4, 3, 3], SPACING, Label(0));
    let mut random = Uniform(3);
    for c in 0..grid.lattice.cell_count() {
        grid.labels[c] = Label((3.0 * random.next()) as i32);
    }
    (grid.void[0], grid.void[17]) = (true, true);
    grid.young = Some((0..grid.lattice.cell_count()).map(|_| 1.0 + 9.0 * random.next()).collect());
    let model = FineModel::new(grid, &three_laws()).unwrap();
    assert_eq!(model.solid_count(), 34);
    model
}

/// A body of one law.
fn single(law: Law, cells: [usize; 3]) -> FineModel {
    let mut table = MaterialTable::new();
    table.insert(Label(0), material(law, isotropic(3.0, 0.35)));
    FineModel::new(VoxelGrid::uniform(cells, SPACING, Label(0)), &table).unwrap()
}

/// The law that a solid cell follows.
fn law_of(model: &FineModel, cell: Cell) -> Option<Law> {
    let state = model.state(cell);
    model.material(state.label).filter(|_| !state.void).map(|material| material.law)
}

/// A linear field with noise, which inverts no cell.
fn deformed(model: &FineModel, noise: f64) -> Vec<f64> {
    let gradient = [[0.15, 0.1, -0.05], [-0.2, -0.1, 0.1], [0.05, 0.1, 0.2]];
    let mut random = Uniform(11);
    let u: Vec<f64> =
        lattice_vector(model.grid(), |x| apply(gradient, x)).iter().map(|v| v + noise * random.signed()).collect();
    assert!(smallest_determinant(model, &u).1 > 0.3);
    u
}

fn rotation(angle: f64) -> [[f64; 3]; 3] {
    let [x, y, z] = AXIS;
    let skew = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let identity = f64::from(u8::from(i == j));
            angle.cos() * identity + angle.sin() * skew[i][j] + (1.0 - angle.cos()) * AXIS[i] * AXIS[j]
        })
    })
}

/// The displacement x → F x − x.
fn homogeneous(model: &FineModel, f: [[f64; 3]; 3]) -> Vec<f64> {
    lattice_vector(model.grid(), |x| {
        let y = apply(f, x);
        std::array::from_fn(|i| y[i] - x[i])
    })
}

fn gradient(model: &FineModel, u: &[f64]) -> (f64, Vec<f64>) {
    let mut out = vec![0.0; u.len()];
    let energy = FineForces::new(model).gradient(model, u, &mut out).unwrap();
    (energy, out)
}

fn tangents(model: &FineModel, u: &[f64], projection: Projection) -> CellTangents {
    let mut out = CellTangents::new(model);
    FineForces::new(model).tangents(model, u, projection, &mut out).unwrap();
    out
}

/// Fourth-order difference quotient of `values` along a direction.
fn slope(u: &[f64], direction: &[f64], step: f64, values: impl Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let at = |t: f64| values(&u.iter().zip(direction).map(|(u, d)| u + t * d).collect::<Vec<_>>());
    let [far_below, below, above, far_above] = [-2.0 * step, -step, step, 2.0 * step].map(at);
    (0..below.len()).map(|i| (8.0 * (above[i] - below[i]) - (far_above[i] - far_below[i])) / (12.0 * step)).collect()
}

#[test]
fn forces_are_the_derivative_of_the_energy() {
    let model = mixed();
    let u = deformed(&model, 0.04);
    let forces = FineForces::new(&model);
    let (energy, exact) = gradient(&model, &u);
    assert!((energy - forces.energy(&model, &u).unwrap()).abs() < 1e-14 * energy);
    let numeric: Vec<f64> = (0..u.len())
        .map(|n| {
            let mut direction = vec![0.0; u.len()];
            direction[n] = 1.0;
            slope(&u, &direction, 1e-3, |u| vec![forces.energy(&model, u).unwrap()])[0]
        })
        .collect();
    // Truncation step⁴ f⁗'/30, about 1e-11 of the forces; rounding 1e-16 E / step.
    let error = relative(&numeric, &exact);
    assert!(error < 1e-9, "{error:.1e}");
}

#[test]
fn tangents_are_the_derivative_of_the_forces() {
    let model = mixed();
    let u = deformed(&model, 0.04);
    let exact = tangents(&model, &u, Projection::Exact);
    let mut random = Uniform(5);
    for _ in 0..10 {
        let direction: Vec<f64> = (0..u.len()).map(|_| random.signed()).collect();
        let numeric = slope(&u, &direction, 1e-4, |u| gradient(&model, u).1);
        let error = relative(&multiply(&exact, &direction), &numeric);
        assert!(error < 1e-9, "{error:.1e}");
    }
    for matrix in (0..36).filter_map(|c| exact.stiffness(c)).map(|(_, matrix)| matrix) {
        assert!((0..576).all(|n| matrix[n] == matrix[24 * (n % 24) + n / 24]));
    }
}

/// Compression makes exact tangents of nonlinear cells indefinite; projected ones never are.
#[test]
fn projected_tangents_are_semidefinite_in_every_cell() {
    let model = mixed();
    let u: Vec<f64> = homogeneous(&model, [[0.55, 0.0, 0.0], [0.2, 0.6, 0.0], [0.0, 0.0, 1.1]]);
    let mut random = Uniform(6);
    let mut negative = 0;
    let (exact, projected) =
        (tangents(&model, &u, Projection::Exact), tangents(&model, &u, Projection::PositiveSemidefinite));
    for cell in (0..36).filter(|c| model.stiffness(*c).is_some()) {
        let (exact, projected) = (exact.stiffness(cell).unwrap().1, projected.stiffness(cell).unwrap().1);
        for _ in 0..200 {
            let v: [f64; 24] = std::array::from_fn(|_| random.signed());
            let form = |k: &[f64; 576]| (0..576).map(|n| v[n / 24] * k[n] * v[n % 24]).sum::<f64>();
            assert!(form(projected) > -1e-13 * largest(projected));
            assert!(form(projected) >= form(exact) - 1e-12 * largest(projected));
        }
        // A rotation is the direction in which compressed material gives way.
        let spin: [f64; 24] = std::array::from_fn(|i| {
            let x: [f64; 3] = std::array::from_fn(|r| SPACING[r] * f64::from((i as u32 / 3) >> r & 1));
            [-x[1], x[0], 0.0][i % 3]
        });
        let form = |k: &[f64; 576]| (0..576).map(|n| spin[n / 24] * k[n] * spin[n % 24]).sum::<f64>();
        negative += usize::from(form(exact) < 0.0);
        assert!(form(projected) > -1e-13 * largest(projected));
    }
    assert!(negative > 10, "{negative} indefinite cells");
}

#[test]
fn small_displacements_meet_the_forces_of_linear_elasticity() {
    let model = mixed();
    let u: Vec<f64> = deformed(&model, 0.04).iter().map(|v| 1e-6 * v).collect();
    let error = relative(&gradient(&model, &u).1, &multiply(&model, &u));
    // Second-order terms, and the rounding of F divided by the strain.
    assert!(error < 3e-6, "{error:.1e}");
    let zero = tangents(&model, &vec![0.0; u.len()], Projection::Exact);
    for cell in 0..36 {
        let Some((factor, reference)) = model.stiffness(cell) else { continue };
        let expected: Vec<f64> = reference.iter().map(|k| factor * k).collect();
        assert!(relative(zero.stiffness(cell).unwrap().1, &expected) < 1e-14);
    }
}

#[test]
fn a_rigidly_moved_body_carries_no_force() {
    for law in [Law::Corotational, Law::NeoHookean] {
        let model = single(law, [3, 2, 4]);
        let mut u = homogeneous(&model, rotation(2.0));
        u.iter_mut().enumerate().for_each(|(i, v)| *v += [3.0, -1.0, 2.0][i % 3]);
        let (energy, forces) = gradient(&model, &u);
        assert!(energy.abs() < 1e-13 && largest(&forces) < 1e-13, "{law}: {energy:.1e}, {:.1e}", largest(&forces));
    }
}

/// Nodes of a box under homogeneous deformation carry P N A of the faces that they lie on, a quarter of each.
#[test]
fn homogeneous_deformation_needs_tractions_on_the_surface_only() {
    let f = [[1.3, 0.2, 0.0], [-0.1, 0.8, 0.3], [0.2, 0.1, 1.1]];
    for law in LAWS {
        let model = single(law, [3, 2, 4]);
        let lattice = model.grid().lattice;
        let point = PointLaw::of(model.material(Label(0)).unwrap(), 1.0);
        let (density, stress) = point.stress(&f).unwrap();
        let (energy, forces) = gradient(&model, &homogeneous(&model, f));
        let mut expected = vec![0.0; forces.len()];
        for cell in (0..lattice.cell_count()).map(Cell) {
            let at = lattice.cell_position(cell);
            for (axis, side) in (0..6).map(|n| (n / 2, n % 2)) {
                if at[axis] != side * (lattice.cells[axis] - 1) {
                    continue;
                }
                let area = SPACING.iter().product::<f64>() / SPACING[axis] * [-1.0, 1.0][side];
                for (_, node) in lattice.corners(cell).iter().enumerate().filter(|(a, _)| a >> axis & 1 == side) {
                    (0..3).for_each(|r| expected[3 * node.0 + r] += 0.25 * area * stress[r][axis]);
                }
            }
        }
        assert!(relative(&forces, &expected) < 1e-13, "{law}");
        let volume = lattice.cell_count() as f64 * model.grid().cell_volume();
        assert!((energy / (volume * density) - 1.0).abs() < 1e-13, "{law}");
    }
}

#[test]
fn the_first_inverted_neo_hookean_cell_is_named_with_its_determinant() {
    let mut model = mixed();
    let first = (0..36).map(Cell).find(|c| law_of(&model, *c) == Some(Law::NeoHookean)).unwrap();
    let u = homogeneous(&model, [[1.0, 0.0, 0.0], [0.0, -0.25, 0.0], [0.0, 0.0, 1.0]]);
    let forces = FineForces::new(&model);
    let found = forces.energy(&model, &u).unwrap_err();
    let InvertedCell { cell, at, determinant } = found;
    assert_eq!((cell, at), (first, model.grid().lattice.cell_position(first)));
    assert!((determinant + 0.25).abs() < 1e-14);
    assert!(
        found
            .to_string()
            .starts_with(&format!("cell ({}, {}, {}) is inverted: det F = -2.500e-1", at[0], at[1], at[2]))
    );
    assert_eq!(forces.gradient(&model, &u, &mut vec![0.0; u.len()]).unwrap_err().cell, first);
    let mut out = CellTangents::new(&model);
    assert_eq!(forces.tangents(&model, &u, Projection::Exact, &mut out).unwrap_err().cell, first);
    // Without neo-Hookean cells the same displacement has an energy.
    let corotational = CellState { label: Label(1), ..model.state(first) };
    let changes: Vec<(Cell, CellState)> = (0..36)
        .map(Cell)
        .filter(|c| !model.is_void(*c))
        .map(|c| (c, CellState { young: Some(1.0), ..corotational }))
        .collect();
    model.change(&changes, &mut Vec::new()).unwrap();
    assert!(forces.energy(&model, &u).unwrap() > 0.0);
}

/// Only one Gauss point of one cell is inverted: the one near a corner that is pushed in.
#[test]
fn a_corner_that_is_pushed_through_its_cell_inverts_it() {
    let model = single(Law::NeoHookean, [3, 3, 3]);
    let mut u = vec![0.0; 3 * 64];
    let push = |u: &mut [f64], by: f64| u[..3].iter_mut().zip(SPACING).for_each(|(v, h)| *v = by * h);
    push(&mut u, 0.3);
    assert!(FineForces::new(&model).energy(&model, &u).is_ok());
    push(&mut u, 0.9);
    let error = FineForces::new(&model).energy(&model, &u).unwrap_err();
    // N₀ = Π (1 − ξ_i), so det F = 1 − 0.9 Σ_i Π_{j≠i} (1 − ξ_j) = 1 − 2.7 p² at p = 1 − ξ = (1 + 1/√3)/2.
    let p = 0.5 + 0.5 / 3f64.sqrt();
    let exact = 1.0 - 2.7 * p * p;
    assert!(error.cell == Cell(0) && (error.determinant - exact).abs() < 1e-14, "{error:?}, {exact}");
    assert_eq!(smallest_determinant(&model, &u), (error.cell, error.determinant));
}

#[test]
fn results_have_the_same_bits_for_any_number_of_threads() {
    let mut grid = VoxelGrid::uniform([5, 4, 7], SPACING, Label(0));
    grid.labels.iter_mut().enumerate().for_each(|(c, label)| *label = Label((c % 3) as i32));
    let model = FineModel::new(grid, &three_laws()).unwrap();
    let u = deformed(&model, 0.04);
    let compute = || {
        let (energy, mut values) = gradient(&model, &u);
        let tangents = tangents(&model, &u, Projection::PositiveSemidefinite);
        values.extend((0..140).flat_map(|c| *tangents.stiffness(c).unwrap().1));
        values.extend([energy, FineForces::new(&model).energy(&model, &u).unwrap()]);
        values.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    let with = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(compute);
    let one = with(1);
    assert!([2, 5].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn forces_and_tangents_follow_an_edited_model() {
    let mut model = mixed();
    let (forces, mut kept) = (FineForces::new(&model), CellTangents::new(&model));
    let u = deformed(&model, 0.02);
    forces.tangents(&model, &u, Projection::Exact, &mut kept).unwrap();
    let states = [(2, 20), (0, 21), (1, 0)].map(|(label, cell)| {
        let state = CellState { label: Label(label), void: false, young: Some(4.0), density: None };
        (Cell(cell), state)
    });
    let removed = CellState { void: true, ..model.state(Cell(5)) };
    model.change(&[&states[..], &[(Cell(5), removed)]].concat(), &mut Vec::new()).unwrap();
    forces.tangents(&model, &u, Projection::Exact, &mut kept).unwrap();
    let fresh = FineModel::new(model.grid().clone(), &three_laws()).unwrap();
    let new = tangents(&fresh, &u, Projection::Exact);
    assert!((0..36).all(|c| kept.stiffness(c) == new.stiffness(c)));
    assert!(kept.stiffness(5).is_none() && kept.stiffness(0).is_some());
    let mut out = vec![0.0; u.len()];
    let energy = forces.gradient(&model, &u, &mut out).unwrap();
    assert_eq!((energy, out), gradient(&fresh, &u));
}

#[test]
fn blocks_are_added_to_the_diagonal_of_a_corner() {
    let model = mixed();
    let u = deformed(&model, 0.02);
    let mut all = tangents(&model, &u, Projection::Exact);
    let before = *all.stiffness(7).unwrap().1;
    let block = [[1.0, 2.0, 3.0], [2.0, 5.0, 6.0], [3.0, 6.0, 9.0]];
    all.add_to_corner_diagonal(Cell(7), 6, &block);
    let after = *all.stiffness(7).unwrap().1;
    for (row, column) in (0..576).map(|n| (n / 24, n % 24)) {
        let added = if row / 3 == 6 && column / 3 == 6 { block[row % 3][column % 3] } else { 0.0 };
        assert_eq!(after[24 * row + column], before[24 * row + column] + added);
    }
}

#[test]
fn cauchy_stresses_turn_with_the_body() {
    let f = [[1.2, 0.1, 0.0], [0.0, 0.9, 0.2], [-0.1, 0.0, 1.1]];
    let turn = rotation(1.0);
    let turned: [[f64; 3]; 3] =
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| turn[i][k] * f[k][j]).sum()));
    let full = |s: &[f64; 6]| [[s[0], s[5], s[4]], [s[5], s[1], s[3]], [s[4], s[3], s[2]]];
    for law in [Law::Corotational, Law::NeoHookean] {
        let model = single(law, [2, 2, 2]);
        let before = full(&cauchy_stresses(&model, &homogeneous(&model, f))[3]);
        let after = full(&cauchy_stresses(&model, &homogeneous(&model, turned))[3]);
        for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
            let expected: f64 = (0..9).map(|n| turn[i][n / 3] * before[n / 3][n % 3] * turn[j][n % 3]).sum();
            assert!((after[i][j] - expected).abs() < 1e-13, "{law}");
        }
        // Hydrostatic stretch s: σ = ψ'(s) / s² with ψ' = 2 μ (s − 1) + 3 λ (s − 1), or μ (s − 1/s) + 3 λ ln s / s.
        let (s, mu, lambda) = (1.2f64, 3.0 / 2.7, 3.0 * 0.35 / (1.35 * 0.3));
        let principal = match law {
            Law::NeoHookean => mu * (s - 1.0 / s) + 3.0 * lambda * s.ln() / s,
            _ => (2.0 * mu + 3.0 * lambda) * (s - 1.0),
        };
        let u = homogeneous(&model, [[s, 0.0, 0.0], [0.0, s, 0.0], [0.0, 0.0, s]]);
        let found = cauchy_stresses(&model, &u)[0];
        assert!((0..6).all(|m| (found[m] - if m < 3 { principal / (s * s) } else { 0.0 }).abs() < 1e-13), "{found:?}");
    }
}

#[test]
fn linear_cells_have_linear_stresses_voids_none_and_inverted_centres_no_number() {
    let model = mixed();
    let u = deformed(&model, 0.02);
    let (cauchy, linear) = (cauchy_stresses(&model, &u), centre_stresses(&model, &u));
    let law = |c: usize| law_of(&model, Cell(c));
    assert!((0..36).filter(|c| law(*c) == Some(Law::Linear)).all(|c| cauchy[c] == linear[c]));
    assert!((0..36).filter(|c| law(*c) == Some(Law::NeoHookean)).all(|c| cauchy[c] != linear[c]));
    assert_eq!(cauchy[17], [0.0; 6]);
    let flat = homogeneous(&model, [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]);
    let flat = cauchy_stresses(&model, &flat);
    assert!((0..36).all(|c| flat[c][0].is_nan() == law(c).is_some_and(|law| law != Law::Linear)));
}

#[test]
fn a_stiffness_matrix_with_a_law_of_large_deformation_is_refused_by_name() {
    for law in LAWS {
        let mut table = MaterialTable::new();
        table.insert(Label(0), material(law, Elasticity::Anisotropic(random_tensor(4))));
        let built = FineModel::new(VoxelGrid::uniform([1; 3], SPACING, Label(0)), &table);
        match law {
            Law::Linear => assert!(built.is_ok()),
            _ => {
                let name = law.to_string();
                let error = built.unwrap_err();
                assert_eq!(error, FineModelError::AnisotropicLaw { name: name.clone(), law });
                assert!(error.to_string().contains(&format!("\"{name}\"")), "{error}");
            }
        }
    }
}
