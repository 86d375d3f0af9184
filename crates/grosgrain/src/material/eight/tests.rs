use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;
use crate::linalg::matrix3::{IDENTITY, determinant};
use crate::material::IsotropicMaterial;

/// Eight matrices near a multiple of the identity.
fn random(source: &mut ChaCha8Rng, size: f64, amplitude: f64) -> EightMatrices {
    let mut signed = || source.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0;
    std::array::from_fn(|i| {
        std::array::from_fn(|j| std::array::from_fn(|_| size * (IDENTITY[i][j] + amplitude * signed())))
    })
}

/// Near and far from the identity, equal singular values, compressed, expanded beyond exp(μ/λ), with inverted points.
fn examples() -> Vec<EightMatrices> {
    let mut source = ChaCha8Rng::seed_from_u64(21);
    let sizes = [(1.0, 0.0), (1.0, 1e-9), (1.0, 1e-3), (1.0, 0.3), (0.4, 0.1), (2.0, 0.1), (4.0, 0.2), (1.0, 1.0)];
    sizes.into_iter().flat_map(|(size, amplitude)| [(); 6].map(|()| random(&mut source, size, amplitude))).collect()
}

/// The last one is auxetic: its λ is negative.
fn laws() -> [PointLaw; 5] {
    let (lambda, mu) = (3.0, 1.0);
    let tensor = IsotropicMaterial::new(2.0, 0.3).unwrap().tensor();
    [
        PointLaw::Linear(tensor),
        PointLaw::Corotational { lambda, mu },
        PointLaw::NeoHookean { lambda, mu },
        PointLaw::Corotational { lambda: -0.4, mu },
        PointLaw::NeoHookean { lambda: -0.4, mu },
    ]
}

#[test]
fn stresses_at_eight_points_are_those_of_one() {
    let (mut found, mut refused) = (0, 0);
    for (law, f) in laws().into_iter().flat_map(|law| examples().into_iter().map(move |f| (law, f))) {
        let mut stresses = [[[f64::NAN; 8]; 3]; 3];
        let single: Option<Vec<_>> = (0..8).map(|point| law.stress(&matrix_at(&f, point))).collect();
        let Some(energy) = law.stress_at_eight(&f, &mut stresses) else {
            assert!(single.is_none());
            refused += 1;
            continue;
        };
        let single = single.unwrap();
        let largest = single.iter().flat_map(|(_, p)| p.iter().flatten()).fold(1.0f64, |m, v| m.max(v.abs()));
        let sum: f64 = single.iter().map(|(energy, _)| energy).sum();
        assert!((energy - sum).abs() < 1e-14 * sum.abs().max(largest), "{law:?}: {energy} against {sum}");
        for (point, (_, p)) in single.iter().enumerate() {
            let error = (0..9).map(|n| (p[n / 3][n % 3] - stresses[n / 3][n % 3][point]).abs()).fold(0.0, f64::max);
            assert!(error < 1e-13 * largest, "{law:?}, {:?}: {error:.1e}", matrix_at(&f, point));
        }
        found += 1;
    }
    assert!(found > 100 && refused > 2, "{found} found, {refused} refused");
}

#[test]
fn tangents_at_eight_points_are_those_of_one() {
    let (mut expanded, mut inverted) = (0, 0);
    for (law, f) in laws().into_iter().flat_map(|law| examples().into_iter().map(move |f| (law, f))) {
        for projection in [Projection::Exact, Projection::PositiveSemidefinite] {
            let mut tangents = [[[f64::NAN; 8]; 9]; 9];
            let single: Option<Vec<_>> = (0..8).map(|point| law.tangent(&matrix_at(&f, point), projection)).collect();
            assert_eq!(law.tangent_at_eight(&f, projection, &mut tangents).is_some(), single.is_some());
            for (point, (_, _, tangent)) in single.iter().flatten().enumerate() {
                let largest = tangent.iter().flatten().fold(1.0f64, |m, v| m.max(v.abs()));
                let errors = (0..81).map(|n| (tangent[n / 9][n % 9] - tangents[n / 9][n % 9][point]).abs());
                let error = errors.fold(0.0, f64::max);
                assert!(error < 1e-12 * largest, "{law:?}, {projection:?}, {:?}: {error:.1e}", matrix_at(&f, point));
                let volume = determinant(&matrix_at(&f, point));
                expanded += usize::from(volume > (1.0f64 / 3.0).exp());
                inverted += usize::from(volume < 0.0);
            }
        }
    }
    assert!(expanded > 100 && inverted > 10, "{expanded} expanded, {inverted} inverted");
}
