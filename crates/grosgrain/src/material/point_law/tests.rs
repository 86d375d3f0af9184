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
