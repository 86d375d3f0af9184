//! The rotation of a deformation gradient.

use super::matrix3::{Matrix3, Svd3, cofactors, determinant, product, svd, transposed};

/// Below this share of the largest singular value, the sum of the other two leaves the rotation undefined.
const COLLAPSED: f64 = 1e-9;
/// det A above this share of (‖A‖²/3)^{3/2}, which is its largest value, bounds the condition of A by about 100.
const REGULAR: f64 = 0.05;
/// Steps of the iteration; five are usual.
const STEPS: usize = 10;
/// A change of the rotation below this leaves, the iteration being of second order, an error of its square.
const SETTLED: f64 = 1e-8;

/// A = R S, and G⁻¹ for G = tr(S) I − S.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Polar {
    /// R.
    pub rotation: Matrix3,
    /// S.
    pub stretch: Matrix3,
    /// G⁻¹.
    pub compliance: Matrix3,
}

impl Polar {
    /// By Newton's iteration R ← ½ (R + R⁻ᵀ) from A (`higham1986computing`), a fifth of the operations of the singular values; `None` where A is
    /// far from a rotation times a number.
    pub fn by_iteration(gradient: &Matrix3) -> Option<Self> {
        let size = gradient.iter().flatten().map(|a| a * a).sum::<f64>() / 3.0;
        // Not-a-number is refused too.
        let is_regular = determinant(gradient) > REGULAR * size * size.sqrt();
        if !is_regular {
            return None;
        }
        let scale = 1.0 / size.sqrt();
        let mut rotation = gradient.map(|row| row.map(|a| scale * a));
        let mut is_settled = false;
        for _ in 0..STEPS {
            let (inverse, factor) = (cofactors(&rotation), 0.5 / determinant(&rotation));
            let mut change = 0.0f64;
            for (row, inverse) in rotation.iter_mut().zip(&inverse) {
                for (r, c) in row.iter_mut().zip(inverse) {
                    let next = 0.5 * *r + factor * c;
                    change = change.max((next - *r).abs());
                    *r = next;
                }
            }
            if is_settled {
                break;
            }
            is_settled = change < SETTLED;
        }
        if !is_settled {
            return None;
        }
        let stretch = product(&transposed(&rotation), gradient);
        let stretch: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (stretch[i][j] + stretch[j][i])));
        let trace = stretch[0][0] + stretch[1][1] + stretch[2][2];
        let stiffness: Matrix3 = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { trace - stretch[i][i] } else { -stretch[i][j] })
        });
        let factor = 1.0 / determinant(&stiffness);
        Some(Self { rotation, stretch, compliance: cofactors(&stiffness).map(|row| row.map(|c| factor * c)) })
    }

    /// By singular values; `None` where det A is not positive, or so small that there is no rotation to tell.
    pub fn by_svd(gradient: &Matrix3) -> Option<Self> {
        let decomposition = svd(gradient);
        let [a, b, c] = decomposition.values;
        // Written so that not-a-number is refused too.
        if !(c > 0.0 && b + c > COLLAPSED * a && a.is_finite()) {
            return None;
        }
        Some(Self::of_values(&decomposition, [1.0 / (b + c), 1.0 / (a + c), 1.0 / (a + b)]))
    }

    /// The rotation, det R = 1, that is nearest to any A, flat and inverted ones included: S is indefinite where det A is negative. A turn about an axis that A does
    /// not determine has no part in G⁻¹, as if the axis were held. `None` where A is not finite.
    pub fn nearest(gradient: &Matrix3) -> Option<Self> {
        if let Some(regular) = Self::by_iteration(gradient) {
            return Some(regular);
        }
        if !gradient.iter().flatten().all(|a| a.is_finite()) {
            return None;
        }
        let decomposition = svd(gradient);
        let [a, b, c] = decomposition.values;
        let inverse = |sum: f64| if sum > COLLAPSED * a { 1.0 / sum } else { 0.0 };
        Some(Self::of_values(&decomposition, [inverse(b + c), inverse(a + c), inverse(a + b)]))
    }

    fn of_values(Svd3 { left, values, right }: &Svd3, compliances: [f64; 3]) -> Self {
        let with = |values: &[f64; 3]| -> Matrix3 {
            let entry = |i: usize, j: usize| (0..3).map(|k| values[k] * (right[i][k] * right[j][k])).sum();
            std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
        };
        Self { rotation: product(left, &transposed(right)), stretch: with(values), compliance: with(&compliances) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    fn distance(a: &Matrix3, b: &Matrix3) -> f64 {
        a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn the_iteration_finds_what_singular_values_give_or_nothing() {
        let mut source = ChaCha8Rng::seed_from_u64(11);
        let mut signed = || source.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0;
        let mut found = 0;
        for n in 0..2000 {
            let size = 10f64.powi(n % 7 - 3);
            let gradient: Matrix3 = std::array::from_fn(|_| std::array::from_fn(|_| size * signed()));
            let (Some(one), two) = (Polar::by_iteration(&gradient), Polar::by_svd(&gradient)) else { continue };
            let two = two.unwrap();
            found += 1;
            assert!(distance(&one.rotation, &two.rotation) < 2e-14, "{gradient:?}");
            assert!(distance(&one.stretch, &two.stretch) < 1e-14 * size, "{gradient:?}");
            assert!(distance(&one.compliance, &two.compliance) < 1e-12 / size, "{gradient:?}");
        }
        assert!(found > 500, "{found}");
    }

    #[test]
    fn inverted_flat_and_broken_gradients_are_left_to_singular_values() {
        let diagonal = |d: [f64; 3]| -> Matrix3 { [[d[0], 0.0, 0.0], [0.0, d[1], 0.0], [0.0, 0.0, d[2]]] };
        for d in [[1.0, 1.0, -1.0], [1.0, 1.0, 1e-3], [f64::NAN, 1.0, 1.0], [0.0; 3], [f64::INFINITY, 1.0, 1.0]] {
            assert_eq!(Polar::by_iteration(&diagonal(d)), None, "{d:?}");
        }
        assert_eq!(Polar::by_svd(&diagonal([1.0, 1.0, -1.0])), None);
        assert!(Polar::by_svd(&diagonal([1.0, 1.0, 1e-3])).is_some());
    }

    #[test]
    fn no_rotation_is_nearer_than_the_nearest_one_also_where_the_gradient_is_inverted() {
        let mut source = ChaCha8Rng::seed_from_u64(5);
        let mut signed = || source.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0;
        let inner =
            |a: &Matrix3, b: &Matrix3| -> f64 { a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| x * y).sum() };
        let mut inverted = 0;
        for _ in 0..200 {
            let gradient: Matrix3 = std::array::from_fn(|_| std::array::from_fn(|_| signed()));
            inverted += usize::from(determinant(&gradient) < 0.0);
            let nearest = Polar::nearest(&gradient).unwrap();
            assert!((determinant(&nearest.rotation) - 1.0).abs() < 1e-14);
            assert!(distance(&product(&nearest.rotation, &nearest.stretch), &gradient) < 1e-14);
            for _ in 0..50 {
                // Any other rotation: that of a random matrix of positive determinant.
                let other: Matrix3 = std::array::from_fn(|_| std::array::from_fn(|_| signed()));
                let Some(other) = Polar::by_svd(&other) else { continue };
                assert!(inner(&other.rotation, &gradient) <= inner(&nearest.rotation, &gradient) + 1e-14);
            }
        }
        assert!(inverted > 50, "{inverted}");
    }

    #[test]
    fn flat_and_mirrored_gradients_have_a_rotation_and_broken_ones_have_none() {
        let diagonal = |d: [f64; 3]| -> Matrix3 { [[d[0], 0.0, 0.0], [0.0, d[1], 0.0], [0.0, 0.0, d[2]]] };
        for d in [[1.0, 1.0, -1.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]] {
            let nearest = Polar::nearest(&diagonal(d)).unwrap();
            assert!((determinant(&nearest.rotation) - 1.0).abs() < 1e-14, "{d:?}");
            assert!(nearest.compliance.iter().flatten().all(|entry| entry.is_finite()), "{d:?}");
        }
        assert_eq!(Polar::nearest(&diagonal([f64::NAN, 1.0, 1.0])), None);
        assert_eq!(Polar::nearest(&diagonal([f64::INFINITY, 1.0, 1.0])), None);
    }
}
