use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;
use crate::linalg::matrix3::{IDENTITY, determinant, product, svd, transposed};
use crate::material::IsotropicMaterial;

fn uniform(source: &mut ChaCha8Rng) -> f64 {
    source.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0
}

fn random(source: &mut ChaCha8Rng, amplitude: f64) -> Matrix3 {
    std::array::from_fn(|i| std::array::from_fn(|j| IDENTITY[i][j] + amplitude * uniform(source)))
}

fn rotation(source: &mut ChaCha8Rng) -> Matrix3 {
    let svd = svd(&std::array::from_fn(|_| std::array::from_fn(|_| uniform(source))));
    product(&svd.left, &transposed(&svd.right))
}

/// Q diag(values) Q'ᵀ for random rotations.
fn with_values(source: &mut ChaCha8Rng, values: [f64; 3]) -> Matrix3 {
    let left = rotation(source).map(|row| std::array::from_fn(|j| row[j] * values[j]));
    product(&left, &rotation(source))
}

fn material(law: Law) -> Material {
    let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(3.0, 0.35).unwrap());
    Material { law, ..Material::linear("m", elasticity, 1.0) }
}

fn laws() -> [PointLaw; 3] {
    [Law::Linear, Law::Corotational, Law::NeoHookean].map(|law| PointLaw::of(&material(law), 1.0))
}

/// Gradients with positive determinant: near the identity, anywhere, with equal singular values, strongly compressed and stretched.
fn upright() -> Vec<Matrix3> {
    let mut source = ChaCha8Rng::seed_from_u64(7);
    let mut all = vec![IDENTITY];
    for amplitude in [1e-9, 1e-4, 0.1, 0.5] {
        all.extend((0..20).map(|_| random(&mut source, amplitude)));
    }
    for values in [
        [1.3, 1.3, 1.3],
        [1.3, 1.3 - 1e-9, 0.8],
        [1.2, 0.7, 0.7],
        [0.4, 0.35, 0.36],
        [1.0, 1.0, 0.05],
        [2.0, 1.9, 1.7],
        [4.0, 0.5, 0.5],
    ] {
        all.extend((0..5).map(|_| with_values(&mut source, values)));
    }
    all.retain(|f| determinant(f) > 0.01);
    assert!(all.len() > 90);
    all
}

fn inverted() -> Vec<Matrix3> {
    let mut source = ChaCha8Rng::seed_from_u64(8);
    let values = [[1.2, 0.9, -0.5], [0.8, 0.8, -0.3], [3.0, 0.5, -0.2]];
    values.into_iter().flat_map(|v| [with_values(&mut source, v), with_values(&mut source, v)]).collect()
}

/// Every law with every gradient that it allows.
fn cases() -> Vec<(PointLaw, Matrix3)> {
    let of = |law: PointLaw| upright().into_iter().map(move |f| (law, f));
    let mut cases: Vec<_> = laws().into_iter().flat_map(of).collect();
    cases.extend(inverted().into_iter().map(|f| (laws()[1], f)));
    cases
}

/// F with entry n moved.
fn moved(f: &Matrix3, n: usize, by: f64) -> Matrix3 {
    let mut moved = *f;
    moved[n / 3][n % 3] += by;
    moved
}

/// (8 (g(h/2) − …) Richardson) slope along entry n: fourth order in the step.
fn slope(f: &Matrix3, n: usize, step: f64, value: impl Fn(&Matrix3) -> f64) -> f64 {
    let central = |h: f64| (value(&moved(f, n, h)) - value(&moved(f, n, -h))) / (2.0 * h);
    (4.0 * central(step) - central(2.0 * step)) / 3.0
}

/// Largest entry of the tangent, and with strong compression its growth: what differences are measured against.
fn scale(tangent: &Matrix9) -> f64 {
    tangent.iter().flatten().fold(1.0f64, |m, v| m.max(v.abs()))
}

/// Eigenvalues of a symmetric 9×9 matrix by cyclic Jacobi rotations.
fn eigenvalues(matrix: &Matrix9) -> [f64; 9] {
    let mut a = *matrix;
    for _ in 0..30 {
        for (p, q) in (0..9).flat_map(|p| (p + 1..9).map(move |q| (p, q))) {
            if a[p][q] == 0.0 {
                continue;
            }
            let zeta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
            let (cosine, sine) = (1.0 / tangent.hypot(1.0), tangent / tangent.hypot(1.0));
            for k in 0..9 {
                let (x, y) = (a[k][p], a[k][q]);
                (a[k][p], a[k][q]) = (cosine * x - sine * y, sine * x + cosine * y);
            }
            for k in 0..9 {
                let (x, y) = (a[p][k], a[q][k]);
                (a[p][k], a[q][k]) = (cosine * x - sine * y, sine * x + cosine * y);
            }
        }
    }
    let mut values: [f64; 9] = std::array::from_fn(|i| a[i][i]);
    values.sort_by(f64::total_cmp);
    values
}

#[test]
fn the_stress_is_the_derivative_of_the_energy() {
    for (law, f) in cases() {
        let (energy, stress, tangent) = law.tangent(&f, Projection::Exact).unwrap();
        let (energy_too, stress_too) = law.stress(&f).unwrap();
        assert_eq!((energy, stress), (energy_too, stress_too), "{law:?}");
        assert_eq!(energy, law.energy(&f).unwrap());
        for n in 0..9 {
            let numeric = slope(&f, n, 1e-4, |g| law.energy(g).unwrap());
            let error = (stress[n / 3][n % 3] - numeric).abs();
            // Fourth-order truncation, 1e-16 times fifth derivatives, which compression to σ raises by σ⁻³; rounding 1e-12.
            assert!(error < 1e-10 * scale(&tangent), "{law:?}, {f:?}, entry {n}: {error:.1e}");
        }
    }
}

#[test]
fn the_exact_tangent_is_the_derivative_of_the_stress() {
    for (law, f) in cases() {
        let tangent = law.tangent(&f, Projection::Exact).unwrap().2;
        for (row, column) in (0..81).map(|n| (n / 9, n % 9)) {
            let numeric = slope(&f, column, 1e-4, |g| law.stress(g).unwrap().1[row / 3][row % 3]);
            let error = (tangent[row][column] - numeric).abs();
            assert!(error < 1e-9 * scale(&tangent), "{law:?}, {f:?}, ({row}, {column}): {error:.1e}");
            assert!((tangent[row][column] - tangent[column][row]).abs() < 1e-14 * scale(&tangent));
        }
    }
}

#[test]
fn rotating_the_observer_changes_no_energy_and_turns_the_stress() {
    let mut source = ChaCha8Rng::seed_from_u64(9);
    for (law, f) in cases().into_iter().filter(|(law, _)| !matches!(law, PointLaw::Linear(_))) {
        let turn = rotation(&mut source);
        let ((energy, stress), (turned_energy, turned)) =
            (law.stress(&f).unwrap(), law.stress(&product(&turn, &f)).unwrap());
        let size = stress.iter().flatten().fold(1.0f64, |m, v| m.max(v.abs()));
        assert!((energy - turned_energy).abs() < 1e-13 * size, "{law:?}, {f:?}");
        for (a, b) in product(&turn, &stress).iter().flatten().zip(turned.iter().flatten()) {
            assert!((a - b).abs() < 1e-12 * size, "{law:?}, {f:?}: {a} against {b}");
        }
    }
}

#[test]
fn without_deformation_all_laws_are_linear_elasticity() {
    let reference = laws()[0].tangent(&IDENTITY, Projection::Exact).unwrap().2;
    let tensor = material(Law::Linear).elasticity.tensor();
    assert_eq!(reference[0][4], tensor.voigt()[0][1]);
    assert_eq!(reference[5][7], tensor.voigt()[3][3]);
    for law in laws() {
        let (energy, stress, tangent) = law.tangent(&IDENTITY, Projection::Exact).unwrap();
        assert_eq!((energy, stress), (0.0, [[0.0; 3]; 3]), "{law:?}");
        for (a, b) in tangent.iter().flatten().zip(reference.iter().flatten()) {
            assert!((a - b).abs() < 1e-14 * scale(&reference), "{law:?}: {a} against {b}");
        }
    }
}

#[test]
fn small_deformations_have_the_energy_of_linear_elasticity() {
    let mut source = ChaCha8Rng::seed_from_u64(10);
    let [linear, others @ ..] = laws();
    for size in [1e-3, 1e-5, 1e-7] {
        let f = random(&mut source, size);
        let exact = linear.energy(&f).unwrap();
        for law in others {
            let error = (law.energy(&f).unwrap() / exact - 1.0).abs();
            // Third order terms, and the rounding of F itself.
            assert!(error < 30.0 * size + 4e-16 / size, "{law:?}, {size}: {error:.1e}");
        }
    }
}

#[test]
fn a_projected_tangent_is_semidefinite_and_the_exact_one_where_that_is() {
    let (mut definite, mut changed) = (0, 0);
    for (law, f) in cases() {
        let (energy, stress, exact) = law.tangent(&f, Projection::Exact).unwrap();
        let (energy_too, stress_too, projected) = law.tangent(&f, Projection::PositiveSemidefinite).unwrap();
        assert_eq!((energy, stress), (energy_too, stress_too));
        let (before, after) = (eigenvalues(&exact), eigenvalues(&projected));
        let size = scale(&exact);
        assert!(after[0] > -1e-13 * size, "{law:?}, {f:?}: {after:?}");
        for (a, b) in before.iter().zip(&after) {
            assert!((a.max(0.0) - b).abs() < 1e-12 * size, "{law:?}, {f:?}: {before:?} against {after:?}");
        }
        let difference = exact.iter().flatten().zip(projected.iter().flatten()).map(|(a, b)| (a - b).abs());
        let difference = difference.fold(0.0, f64::max);
        match before[0] >= 0.0 {
            true => assert!(difference < 1e-12 * size, "{law:?}, {f:?}: {difference:.1e}"),
            false => assert!(difference <= -before.iter().filter(|v| **v < 0.0).sum::<f64>() + 1e-12 * size),
        }
        definite += usize::from(before[0] > 1e-3);
        changed += usize::from(before[0] < -1e-3);
    }
    assert!(definite > 50 && changed > 50, "{definite} definite, {changed} not");
}

/// All three kinds of eigenvalues are clamped somewhere: scalings and flips of the neo-Hookean law only under strong expansion.
#[test]
fn expansion_makes_the_neo_hookean_law_concave_in_its_scalings_too() {
    let stretch = [[4.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 0.3]];
    let law = PointLaw::NeoHookean { lambda: 10.0, mu: 1.0 };
    let exact = law.tangent(&stretch, Projection::Exact).unwrap().2;
    let scalings: Matrix3 = std::array::from_fn(|a| std::array::from_fn(|b| exact[4 * a][4 * b]));
    assert!(determinant(&scalings) < 0.0, "{scalings:?}");
    let (before, after) =
        (eigenvalues(&exact), eigenvalues(&law.tangent(&stretch, Projection::PositiveSemidefinite).unwrap().2));
    assert!(before.iter().zip(&after).all(|(a, b)| (a.max(0.0) - b).abs() < 1e-12 * scale(&exact)));
}

/// Uniaxial stress: the lateral stretch b solves μ (b² − 1) + λ ln(a b²) = 0, and P₁₁ = μ (a − 1/a) + λ ln(a b²) / a.
#[test]
fn uniaxial_tension_of_the_neo_hookean_law_is_the_closed_form() {
    let (lambda, mu) = (2.0, 1.5);
    let law = PointLaw::NeoHookean { lambda, mu };
    for a in [0.3, 0.9, 1.0, 1.5, 3.0] {
        let lateral = |b: f64| mu * (b * b - 1.0) + lambda * (a * b * b).ln();
        let (mut low, mut high) = (0.01, 10.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if lateral(middle) < 0.0 { low = middle } else { high = middle }
        }
        let (b, turn) = (low, rotation(&mut ChaCha8Rng::seed_from_u64(11)));
        let f = product(&turn, &[[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, b]]);
        let stress = product(&transposed(&turn), &law.stress(&f).unwrap().1);
        let axial = mu * (a - 1.0 / a) + lambda * (a * b * b).ln() / a;
        for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
            let exact = if (i, j) == (0, 0) { axial } else { 0.0 };
            assert!((stress[i][j] - exact).abs() < 1e-13 * (mu + lambda) / a, "{a}: {stress:?}, {axial}");
        }
    }
}

#[test]
fn simple_extension_of_the_corotational_law_is_that_of_linear_elasticity_at_any_size() {
    let law = PointLaw::Corotational { lambda: 2.0, mu: 1.5 };
    let turn = rotation(&mut ChaCha8Rng::seed_from_u64(12));
    for stretch in [0.2, 1.0, 3.0] {
        let f = product(&turn, &[[stretch, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let stress = product(&transposed(&turn), &law.stress(&f).unwrap().1);
        let e: f64 = stretch - 1.0;
        let exact = [[5.0 * e, 0.0, 0.0], [0.0, 2.0 * e, 0.0], [0.0, 0.0, 2.0 * e]];
        let close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-13;
        assert!(stress.iter().flatten().zip(exact.iter().flatten()).all(close), "{stress:?}");
        assert!((law.energy(&f).unwrap() - 2.5 * e * e).abs() < 1e-13);
    }
}

#[test]
fn an_inverted_point_has_no_neo_hookean_energy_and_a_finite_corotational_one() {
    let [_, corotational, neo_hookean] = laws();
    for f in inverted().into_iter().chain([[[0.0; 3]; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]]) {
        assert_eq!(neo_hookean.energy(&f), None);
        assert_eq!(neo_hookean.stress(&f), None);
        assert!(neo_hookean.tangent(&f, Projection::PositiveSemidefinite).is_none());
        let (energy, stress, tangent) = corotational.tangent(&f, Projection::PositiveSemidefinite).unwrap();
        assert!(energy.is_finite() && stress.iter().flatten().chain(tangent.iter().flatten()).all(|v| v.is_finite()));
        assert!(eigenvalues(&tangent)[0] > -1e-13 * scale(&tangent));
    }
    assert_eq!(neo_hookean.energy(&[[f64::NAN; 3]; 3]), None);
}

#[test]
fn a_factor_multiplies_energy_stress_and_tangent() {
    let f = random(&mut ChaCha8Rng::seed_from_u64(13), 0.2);
    for law in [Law::Linear, Law::Corotational, Law::NeoHookean] {
        let one = PointLaw::of(&material(law), 1.0).tangent(&f, Projection::Exact).unwrap();
        let four = PointLaw::of(&material(law), 4.0).tangent(&f, Projection::Exact).unwrap();
        let close = |a: f64, b: f64| (4.0 * a - b).abs() <= 1e-14 * b.abs().max(1.0);
        assert!(close(one.0, four.0));
        assert!(one.1.iter().flatten().zip(four.1.iter().flatten()).all(|(a, b)| close(*a, *b)));
        assert!(one.2.iter().flatten().zip(four.2.iter().flatten()).all(|(a, b)| close(*a, *b)));
    }
}
