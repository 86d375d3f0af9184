//! Fitted functions meet their constraints, whatever the material.

mod bodies;

use bodies::*;
use grosgrain::coarsening::{BaseKind, COLUMNS, FIELDS, Objective, ShapeFunctions};
use grosgrain::fine::FineModel;
use grosgrain::mesh::Node;
use grosgrain::partition::{CoarseCell, Partition};
use grosgrain::progress::silent;
use grosgrain::training::{Training, TrainingKind, train};
use proptest::prelude::*;

const BASES: [BaseKind; 3] = [BaseKind::Harmonic, BaseKind::Trilinear, BaseKind::Material];
const KINDS: [TrainingKind; 4] =
    [TrainingKind::Global, TrainingKind::OneRing, TrainingKind::Substructured, TrainingKind::SingleCell];

struct Fit {
    model: FineModel,
    partition: Partition,
    training: Training,
    functions: ShapeFunctions,
}

impl Fit {
    fn new(model: FineModel, degree: usize, kind: TrainingKind, base: BaseKind) -> Self {
        let partition = Partition::new(model.grid().lattice, degree).unwrap();
        let cells: Vec<CoarseCell> = (0..partition.coarse().cell_count()).map(CoarseCell).collect();
        let (training, _) = train(&model, &partition, &cells, kind, &silent).unwrap();
        let options = (base, Objective::ClosedForm);
        let functions = ShapeFunctions::fit(&model, &partition, &training, options, &silent).unwrap();
        Self { model, partition, training, functions }
    }

    /// W times the corner values of a displacement field.
    fn interpolate(&self, index: usize, corners: &[f64; COLUMNS]) -> Vec<f64> {
        self.functions.of(index).chunks_exact(COLUMNS).map(|row| dot(row, corners)).collect()
    }

    /// Values of u(x) at the cell's fine nodes and at its corners, x from the cell's centre.
    fn sample(&self, u: impl Fn([f64; 3]) -> [f64; 3]) -> (Vec<f64>, [f64; COLUMNS]) {
        let (local, spacing) = (self.partition.cell_lattice(), self.model.grid().spacing);
        let half = 0.5 * self.partition.degree() as f64;
        let position = |n: usize| -> [f64; 3] {
            let at = local.node_position(Node(n));
            std::array::from_fn(|a| (at[a] as f64 - half) * spacing[a])
        };
        let values: Vec<f64> = (0..local.node_count()).flat_map(|n| u(position(n))).collect();
        let corners = self.partition.local_corners();
        let at_corners = std::array::from_fn(|c| values[3 * corners[c / 3] + c % 3]);
        (values, at_corners)
    }

    fn field(&self, index: usize, k: usize) -> (Vec<f64>, [f64; COLUMNS]) {
        let values: Vec<f64> = self.training.of(index).chunks_exact(FIELDS).map(|row| row[k]).collect();
        let corners = self.partition.local_corners();
        let at_corners = std::array::from_fn(|c| values[3 * corners[c / 3] + c % 3]);
        (values, at_corners)
    }
}

/// Largest |M_ij| of the functions times the largest corner value: what the sums Σ_i M_ij ũ_i are rounded against.
fn scale(functions: &[f64], corners: &[f64; COLUMNS]) -> f64 {
    largest(functions).max(1.0) * largest(corners)
}

fn check(fit: &Fit, what: &str) -> Result<(), TestCaseError> {
    for index in 0..fit.functions.cells().len() {
        let functions = fit.functions.of(index);
        for axis in 0..3 {
            let (translated, corners) = fit.sample(|_| std::array::from_fn(|a| f64::from(u8::from(a == axis))));
            let error = distance(&fit.interpolate(index, &corners), &translated) / scale(functions, &corners);
            prop_assert!(error < 1e-12, "{what}: partition of unity along {axis} off by {error:.1e}");
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            let (turned, corners) = fit.sample(|x| {
                let mut u = [0.0; 3];
                (u[b], u[c]) = (-x[c], x[b]);
                u
            });
            let error = distance(&fit.interpolate(index, &corners), &turned) / scale(functions, &corners);
            prop_assert!(error < 1e-12, "{what}: rotation about {axis} off by {error:.1e}");
        }
        prop_assert_eq!(fit.functions.fits[index].rank, FIELDS, "{}: the fields are independent", what);
        for k in 0..FIELDS {
            let (values, corners) = fit.field(index, k);
            let error = distance(&fit.interpolate(index, &corners), &values);
            let scale = scale(functions, &corners);
            prop_assert!(error < 1e-10 * scale, "{what}: field {k} off by {:.1e} of {scale:.1e}", error / scale);
        }
        for (i, node) in fit.partition.local_corners().into_iter().enumerate() {
            for (r, c) in (0..3 * COLUMNS).map(|n| (n / COLUMNS, n % COLUMNS)) {
                let exact = f64::from(u8::from(c == 3 * i + r));
                prop_assert_eq!(functions[(3 * node + r) * COLUMNS + c], exact, "{}: corner {} row {}", what, i, r);
            }
        }
    }
    Ok(())
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let difference: Vec<f64> = a.iter().zip(b).map(|(x, y)| x - y).collect();
    largest(&difference)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn fitted_functions_are_exact_for_rigid_motions_and_training_data_and_are_deltas_at_the_corners(
        degree in 2..5usize,
        spacing in prop::array::uniform3(0.2..5.0f64),
        decades in 0.0..6.0f64,
        poisson in 0.0..0.45f64,
        seed in any::<u64>(),
    ) {
        let cells = [2 * degree, degree, degree];
        for kind in KINDS {
            for base in BASES {
                let model = random_model(cells, spacing, 10f64.powf(decades), poisson, seed);
                check(&Fit::new(model, degree, kind, base), &format!("{kind:?}, {base:?}"))?;
            }
        }
    }
}

#[test]
fn dependent_training_fields_are_dropped_and_the_functions_stay_exact_for_rigid_motions() {
    let model = random_model([3, 3, 3], [1.0, 2.0, 0.5], 100.0, 0.3, 5);
    let partition = Partition::new(model.grid().lattice, 3).unwrap();
    let (training, _) = train(&model, &partition, &[CoarseCell(0)], TrainingKind::SingleCell, &silent).unwrap();
    let base = std::sync::Arc::new(grosgrain::coarsening::BaseFunctions::trilinear(3));
    let fitter = grosgrain::coarsening::Fitter::new(&partition, model.grid().spacing, &base);
    let mut dependent = training.of(0).to_vec();
    for row in dependent.chunks_exact_mut(FIELDS) {
        row[1] = -2.0 * row[0];
        row[4] = 0.0;
        row[5] = row[0] + row[3];
    }
    let mut functions = vec![f64::NAN; fitter.len()];
    let fit = fitter.fit_into(&dependent, &mut functions);
    assert_eq!(fit.rank, 3);
    let corners: [f64; COLUMNS] = std::array::from_fn(|c| f64::from(u8::from(c % 3 == 1)));
    for (row, w) in functions.chunks_exact(COLUMNS).enumerate() {
        let exact = f64::from(u8::from(row % 3 == 1));
        assert!((dot(w, &corners) - exact).abs() < 1e-12, "row {row}: {}", dot(w, &corners));
    }
}
