//! The coarse model under large rotations: energies, their derivatives, and what they must not depend on.

mod bodies;
mod corotated;

use bodies::*;
use corotated::*;
use faer::{Mat, Side};
use grosgrain::coarse::{Corotated, ElementEnergies, Method, NO_POTENTIALS};
use grosgrain::linalg::matrix3::cross;
use grosgrain::material::Projection;

/// Derivative at zero from values at four places: the error goes with the fourth power of the step.
const STENCIL: [(f64, f64); 4] = [(1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0)];
const STEP: f64 = 1e-3;

#[test]
fn the_gradient_is_the_derivative_of_the_energy() {
    for (degree, with_linear) in [(2, false), (2, true), (3, true)] {
        let model = body(degree, with_linear, 5);
        let coarse = trained(&model, degree);
        let u = far(&model, &coarse, 8);
        for integration in INTEGRATIONS {
            let (corotated, bowls) = loaded(&model, &coarse, integration);
            let mut exact = vec![0.0; u.len()];
            let energies = corotated.gradient(&coarse, &u, &bowls, &mut exact).unwrap();
            assert_eq!(energies, corotated.energy(&coarse, &u, &bowls).unwrap());
            assert!(energies.elastic > 0.0 && energies.loads != 0.0 && energies.points > 0.0);
            for seed in 0..6 {
                let p = random_direction(u.len(), 40 + seed);
                let at = |s: f64| corotated.energy(&coarse, &stepped(&u, s * STEP, &p), &bowls).unwrap().total();
                let slope = STENCIL.iter().map(|(s, w)| w * at(*s)).sum::<f64>() / (12.0 * STEP);
                let error = (slope - dot(&exact, &p)).abs() / norm(&exact);
                assert!(error < 1e-9, "{integration:?}, degree {degree}: {slope} against {}", dot(&exact, &p));
            }
        }
    }
}

#[test]
fn exact_tangents_are_the_derivative_of_the_gradient() {
    for (degree, with_linear) in [(2, false), (2, true), (3, true)] {
        let model = body(degree, with_linear, 5);
        let coarse = trained(&model, degree);
        let u = far(&model, &coarse, 8);
        for integration in INTEGRATIONS {
            let (corotated, bowls) = loaded(&model, &coarse, integration);
            let matrices = tangents(&corotated, &coarse, &u, (&bowls, Projection::Exact));
            for seed in 0..4 {
                let p = random_direction(u.len(), 60 + seed);
                let exact = product_with(&coarse, &matrices, &p);
                let mut slope = vec![0.0; u.len()];
                for (s, w) in STENCIL {
                    let there = gradient(&corotated, &coarse, &stepped(&u, s * STEP, &p), &bowls);
                    slope.iter_mut().zip(there).for_each(|(sum, g)| *sum += w * g / (12.0 * STEP));
                }
                let error = relative(&slope, &exact);
                assert!(error < 1e-8, "{integration:?}, degree {degree}, linear {with_linear}: off by {error:.1e}");
            }
        }
    }
}

#[test]
fn tangents_are_symmetric_and_projected_ones_positive_semidefinite() {
    let model = body(2, true, 6);
    let coarse = trained(&model, 2);
    let u = moved(&model, &coarse, &rotation([1.0, 2.0, -0.5], 100.0), 0.25, 9);
    for integration in INTEGRATIONS {
        let (corotated, bowls) = loaded(&model, &coarse, integration);
        let smallest = |projection: Projection| -> f64 {
            let of_matrix = |matrix: &[f64; 576]| {
                assert!(
                    (0..576).all(|n| matrix[n] == matrix[24 * (n % 24) + n / 24]),
                    "{integration:?}: not symmetric"
                );
                let dense = Mat::from_fn(24, 24, |i, j| matrix[24 * i + j]);
                let values = dense.self_adjoint_eigenvalues(Side::Lower).unwrap();
                values[0] / values[23]
            };
            tangents(&corotated, &coarse, &u, (&bowls, projection)).iter().map(of_matrix).fold(f64::INFINITY, f64::min)
        };
        let (exact, projected) = (smallest(Projection::Exact), smallest(Projection::PositiveSemidefinite));
        assert!(projected > -1e-13, "{integration:?}: {projected:.1e}");
        assert!(exact < -1e-4, "{integration:?}: the state does not tell exact from projected, {exact:.1e}");
    }
}

#[test]
fn rigid_motions_change_no_energy_and_forces_have_no_resultant_and_no_moment() {
    for degree in [2, 3] {
        let model = body(degree, false, 7);
        let coarse = trained(&model, degree);
        let turn = rotation([0.7, 0.1, -0.4], 100.0);
        let (still, turned) =
            (moved(&model, &coarse, &rotation([1.0; 3], 0.0), 0.1, 3), moved(&model, &coarse, &turn, 0.1, 3));
        let rigid = moved(&model, &coarse, &turn, 0.0, 3);
        for integration in INTEGRATIONS {
            let corotated = Corotated::new(&model, &coarse, integration);
            let energy = |u: &[f64]| corotated.energy(&coarse, u, NO_POTENTIALS).unwrap().elastic;
            assert!((energy(&turned) / energy(&still) - 1.0).abs() < 1e-12, "{integration:?}");
            assert!(energy(&rigid) < 1e-24 * energy(&still).max(1.0), "{integration:?}: {:.1e}", energy(&rigid));
            let forces = gradient(&corotated, &coarse, &turned, NO_POTENTIALS);
            let (mut resultant, mut moment) = ([0.0; 3], [0.0; 3]);
            let places = vertex_positions(&model, &coarse);
            for ((x, u), f) in places.iter().zip(turned.chunks_exact(3)).zip(forces.chunks_exact(3)) {
                let part = cross(&std::array::from_fn(|r| x[r] + u[r]), &[f[0], f[1], f[2]]);
                (0..3).for_each(|r| resultant[r] += f[r]);
                (0..3).for_each(|r| moment[r] += part[r]);
            }
            let scale = norm(&forces);
            assert!(
                norm(&resultant) < 1e-12 * scale && norm(&moment) < 1e-12 * scale,
                "{integration:?}, degree {degree}"
            );
        }
    }
}

#[test]
fn at_rest_every_integration_has_the_stiffness_of_the_coarse_model() {
    for degree in [2, 3] {
        let model = body(degree, true, 4);
        let coarse = trained(&model, degree);
        let rest = vec![0.0; 3 * coarse.mesh().vertices().len()];
        for integration in INTEGRATIONS {
            let corotated = Corotated::new(&model, &coarse, integration);
            let energies = corotated.energy(&coarse, &rest, NO_POTENTIALS).unwrap();
            assert!(
                energies.elastic.abs() < 1e-28
                    && energies == ElementEnergies { elastic: energies.elastic, ..Default::default() }
            );
            for projection in [Projection::Exact, Projection::PositiveSemidefinite] {
                let matrices = tangents(&corotated, &coarse, &rest, (NO_POTENTIALS, projection));
                for (index, matrix) in matrices.iter().enumerate() {
                    let error = relative(matrix, coarse.stiffness(index));
                    assert!(error < 1e-10, "{integration:?}, {projection:?}, element {index}: off by {error:.1e}");
                }
            }
        }
    }
}

#[test]
fn forces_of_small_displacements_are_those_of_the_linear_model() {
    let model = body(3, true, 4);
    let coarse = trained(&model, 3);
    let direction = random_direction(3 * coarse.mesh().vertices().len(), 2);
    let stiffness: Vec<_> = (0..coarse.elements().len()).map(|index| *coarse.stiffness(index)).collect();
    let linear = product_with(&coarse, &stiffness, &direction);
    for integration in INTEGRATIONS {
        let corotated = Corotated::new(&model, &coarse, integration);
        let error = |size: f64| {
            let u: Vec<f64> = direction.iter().map(|p| size * p).collect();
            let forces = gradient(&corotated, &coarse, &u, NO_POTENTIALS);
            relative(&forces.iter().map(|f| f / size).collect::<Vec<f64>>(), &linear)
        };
        let errors = [error(1e-4), error(1e-5)];
        assert!(errors[0] < 1e-3, "{integration:?}: {errors:?}");
        assert!(
            (errors[0] / errors[1] - 10.0).abs() < 0.1,
            "first order in the displacement: {integration:?}, {errors:?}"
        );
    }
}

#[test]
fn an_averaged_model_rotates_with_its_own_stiffness() {
    let model = body(2, false, 4);
    let coarse = coarsened(&model, 2, Method::Average);
    let corotated = Corotated::new(&model, &coarse, grosgrain::coarse::Integration::Stiffness);
    let small = moved(&model, &coarse, &rotation([1.0; 3], 0.0), 1e-5, 3);
    let turned = moved(&model, &coarse, &rotation([0.2, 0.4, 1.0], 100.0), 1e-5, 3);
    let stiffness: Vec<_> = (0..coarse.elements().len()).map(|index| *coarse.stiffness(index)).collect();
    let linear = 0.5 * dot(&small, &product_with(&coarse, &stiffness, &small));
    let energy = corotated.energy(&coarse, &turned, NO_POTENTIALS).unwrap().elastic;
    assert!((energy / linear - 1.0).abs() < 1e-4, "{energy} against {linear}");
}
