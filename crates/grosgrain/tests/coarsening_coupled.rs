//! The closed form is the optimum of the coupled constrained problem.

mod bodies;

use bodies::*;
use grosgrain::coarsening::{BaseKind, Objective, ShapeFunctions};
use grosgrain::partition::{CoarseMesh, Partition};
use grosgrain::progress::silent;
use grosgrain::training::{TrainingKind, train};

#[test]
fn the_closed_form_equals_the_solution_of_the_coupled_saddle_point_system() {
    for (degree, spacing, contrast, poisson, seed) in [
        (2, [1.0, 1.0, 1.0], 1e3, 0.3, 1),
        (2, [0.3, 1.0, 2.0], 1e6, 0.45, 2),
        (2, [5.0, 1.0, 1.0], 10.0, 0.0, 3),
        (3, [1.0, 0.5, 2.0], 1e3, 0.4, 4),
    ] {
        let model = random_model([degree; 3], spacing, contrast, poisson, seed);
        let partition = Partition::new(model.grid().lattice, degree).unwrap();
        let mesh = CoarseMesh::new(&model.grid().void, &partition);
        let (training, _) = train(&model, &mesh, mesh.elements(), TrainingKind::SingleCell, &silent).unwrap();
        let fit = |objective| {
            ShapeFunctions::fit(&model, &mesh, &training, (BaseKind::Harmonic, objective), &silent).unwrap()
        };
        let error = relative(fit(Objective::ClosedForm).of(0), fit(Objective::Coupled).of(0));
        assert!(error < 1e-9, "d = {degree}, contrast {contrast:.0e}: {error:.1e}");
    }
}

#[test]
fn the_coupled_system_of_dependent_fields_is_refused_with_a_sentence() {
    let model = random_model([2; 3], [1.0; 3], 10.0, 0.3, 1);
    let partition = Partition::new(model.grid().lattice, 2).unwrap();
    let zeros = vec![0.0; 3 * 27 * 6];
    let error = grosgrain::coarsening::fit_coupled(&partition, model.grid().spacing, &zeros).unwrap_err();
    assert!(error.to_string().contains("depend on each other"), "{error}");
}
