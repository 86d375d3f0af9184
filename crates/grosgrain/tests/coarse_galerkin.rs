//! Galerkin stiffness: Wᵀ K W, symmetric, with rigid motions as its only zero-energy modes.

mod bodies;

use bodies::*;
use faer::{Mat, Side};
use grosgrain::coarse::{BuildOptions, Built, Method, build};
use grosgrain::coarsening::{BaseKind, COLUMNS, FIELDS};
use grosgrain::element::{CellMatrix, Hex8, gauss_2x2x2};
use grosgrain::fine::FineModel;
use grosgrain::mesh::{Cell, Label, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::training::TrainingKind;

const SPACING: [f64; 3] = [1.0, 0.5, 2.0];

fn built(model: &FineModel, degree: usize, method: Method, base: BaseKind) -> Built {
    build(model, degree, &BuildOptions { method, base, ..BuildOptions::default() }, &silent).unwrap()
}

fn all_models(model: &FineModel, degree: usize) -> Vec<(String, Built)> {
    let mut all = vec![("trilinear".to_owned(), built(model, degree, Method::Trilinear, BaseKind::Harmonic))];
    for kind in [TrainingKind::Global, TrainingKind::OneRing, TrainingKind::SingleCell] {
        for base in [BaseKind::Harmonic, BaseKind::Trilinear, BaseKind::Material] {
            all.push((format!("{kind:?} [{base:?}]"), built(model, degree, Method::Trained(kind), base)));
        }
    }
    all
}

fn eigenvalues(k: &CellMatrix) -> Vec<f64> {
    let matrix = Mat::from_fn(COLUMNS, COLUMNS, |i, j| k[COLUMNS * i + j]);
    matrix.self_adjoint_eigenvalues(Side::Lower).unwrap()
}

/// Wᵀ (K W) with the dense stiffness of the fine cells of one coarse cell.
fn brute_force(model: &FineModel, built: &Built, index: usize) -> (Vec<f64>, Mat<f64>) {
    let partition = built.model.partition();
    let local = partition.cell_lattice();
    let order = 3 * local.node_count();
    let mut dense = Mat::<f64>::zeros(order, order);
    for (c, fine) in built.model.mesh().fine_cells(built.model.elements()[index]) {
        let Some(tensor) = model.elasticity(fine) else { continue };
        let matrix = Hex8::new(model.grid().spacing).stiffness(&tensor);
        let corners = local.corners(Cell(c));
        let unknown = |i: usize| 3 * corners[i / 3].0 + i % 3;
        (0..576).for_each(|n| dense[(unknown(n / 24), unknown(n % 24))] += matrix[n]);
    }
    let functions = built.model.functions().of(index);
    let w = Mat::from_fn(order, COLUMNS, |i, j| functions[COLUMNS * i + j]);
    let product = w.transpose() * &dense * &w;
    ((0..576).map(|n| product[(n / COLUMNS, n % COLUMNS)]).collect(), dense)
}

#[test]
fn the_galerkin_stiffness_is_symmetric_bit_for_bit_and_equals_the_dense_product() {
    for (degree, contrast) in [(2, 1e4), (3, 50.0)] {
        let model = random_model([2 * degree, degree, degree], SPACING, contrast, 0.35, 3);
        for (name, built) in all_models(&model, degree) {
            for index in 0..built.model.elements().len() {
                let k = built.model.stiffness(index);
                for (i, j) in (0..576).map(|n| (n / 24, n % 24)) {
                    assert_eq!(k[24 * i + j].to_bits(), k[24 * j + i].to_bits(), "{name}: entries ({i}, {j})");
                }
                let (product, _) = brute_force(&model, &built, index);
                let error = relative(k, &product);
                assert!(error < 1e-12, "{name}, degree {degree}, cell {index}: {error:.1e}");
            }
        }
    }
}

#[test]
fn exactly_six_modes_of_the_galerkin_stiffness_carry_no_energy() {
    for seed in 0..3 {
        let model = random_model([4, 2, 2], SPACING, 50.0, 0.3, seed);
        for (name, built) in all_models(&model, 2) {
            for index in 0..built.model.elements().len() {
                let values = eigenvalues(built.model.stiffness(index));
                let top = values[COLUMNS - 1];
                assert!(largest(&values[..6]) < 1e-12 * top, "{name}: {:?} of {top:.2e}", &values[..6]);
                assert!(values[6] > 1e-4 * top, "{name}: the seventh is {:.1e} of {top:.1e}", values[6]);
            }
        }
    }
}

#[test]
fn trained_functions_give_harmonic_displacements_the_energy_of_the_fine_body() {
    let model = random_model([4, 2, 4], SPACING, 1e3, 0.3, 8);
    for base in [BaseKind::Harmonic, BaseKind::Trilinear, BaseKind::Material] {
        let built = built(&model, 2, Method::Trained(TrainingKind::Global), base);
        let training = built.training.as_ref().unwrap();
        let corners = built.model.partition().local_corners();
        let (mut coarse, mut fine) = ([0.0; FIELDS * FIELDS], [0.0; FIELDS * FIELDS]);
        for index in 0..built.model.elements().len() {
            let fields: Vec<Vec<f64>> =
                (0..FIELDS).map(|k| training.of(index).chunks_exact(FIELDS).map(|row| row[k]).collect()).collect();
            let at_corners = |k: usize| Mat::from_fn(COLUMNS, 1, |c, _| fields[k][3 * corners[c / 3] + c % 3]);
            let (_, dense) = brute_force(&model, &built, index);
            let k_coarse = Mat::from_fn(COLUMNS, COLUMNS, |i, j| built.model.stiffness(index)[COLUMNS * i + j]);
            for (a, b) in (0..36).map(|n| (n / FIELDS, n % FIELDS)) {
                let column = |k: usize| Mat::from_fn(fields[k].len(), 1, |i, _| fields[k][i]);
                coarse[FIELDS * a + b] += (at_corners(a).transpose() * &k_coarse * at_corners(b))[(0, 0)];
                fine[FIELDS * a + b] += (column(a).transpose() * &dense * column(b))[(0, 0)];
            }
        }
        let error = relative(&coarse, &fine);
        assert!(error < 1e-10, "{base:?}: the 36 energies differ by {error:.1e}");
    }
}

#[test]
fn the_trilinear_method_integrates_the_material_at_the_fine_quadrature_points() {
    let degree = 3;
    let model = random_model([6, 3, 3], SPACING, 1e3, 0.3, 2);
    let built = built(&model, degree, Method::Trilinear, BaseKind::Harmonic);
    let partition = built.model.partition();
    let coarse = Hex8::new(SPACING.map(|h| 3.0 * h));
    for (index, &element) in built.model.elements().iter().enumerate() {
        let mut exact = vec![0.0; 576];
        for (c, fine) in built.model.mesh().fine_cells(element) {
            let at = partition.cell_lattice().cell_position(Cell(c));
            let tensor = model.elasticity(fine).unwrap();
            for point in gauss_2x2x2() {
                let b = coarse.strain_matrix(std::array::from_fn(|a| (at[a] as f64 + point.at[a]) / 3.0));
                for (i, j) in (0..576).map(|n| (n / 24, n % 24)) {
                    let product: f64 = (0..36).map(|n| b[n / 6][i] * tensor.voigt()[n / 6][n % 6] * b[n % 6][j]).sum();
                    exact[24 * i + j] += point.weight * model.grid().cell_volume() * product;
                }
            }
        }
        let error = relative(built.model.stiffness(index), &exact);
        assert!(error < 1e-13, "cell {index}: {error:.1e}");
    }
}

#[test]
fn the_average_of_a_homogeneous_body_is_its_trilinear_model() {
    let grid = VoxelGrid::uniform([4, 2, 2], SPACING, Label(0));
    let elasticity = grosgrain::material::Elasticity::Anisotropic(random_tensor(3));
    let model = FineModel::new(grid, &table(&[elasticity])).unwrap();
    let trilinear = built(&model, 2, Method::Trilinear, BaseKind::Harmonic);
    let average = built(&model, 2, Method::Average, BaseKind::Harmonic);
    for cell in 0..2 {
        let error = relative(average.model.stiffness(cell), trilinear.model.stiffness(cell));
        assert!(error < 1e-14, "cell {cell}: {error:.1e}");
    }
}
