//! Small dense algebra of 3×3 matrices: what deformation gradients and rotations need.

/// A 3×3 matrix, `m[row][column]`.
pub type Matrix3 = [[f64; 3]; 3];

/// The identity.
pub const IDENTITY: Matrix3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Rotations that diagonalise are swept over the three pairs of columns at most this often; four are usual.
const SWEEPS: usize = 30;

/// a b.
#[inline]
pub fn product(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j]))
}

/// mᵀ.
#[inline]
pub fn transposed(m: &Matrix3) -> Matrix3 {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

/// m v.
#[inline]
pub fn apply(m: &Matrix3, v: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

/// mᵀ v.
#[inline]
pub fn apply_transposed(m: &Matrix3, v: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| m[0][i] * v[0] + m[1][i] * v[1] + m[2][i] * v[2])
}

/// a × b.
#[inline]
pub fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a · b.
#[inline]
pub fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The matrix \[v\]× with \[v\]× w = v × w.
#[inline]
pub fn skew(v: &[f64; 3]) -> Matrix3 {
    [[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]]
}

/// det m.
#[inline]
pub fn determinant(m: &Matrix3) -> f64 {
    dot(&m[0], &cross(&m[1], &m[2]))
}

/// The matrix of cofactors, ∂ det m / ∂m; m⁻ᵀ is cof m / det m.
#[inline]
pub fn cofactors(m: &Matrix3) -> Matrix3 {
    [cross(&m[1], &m[2]), cross(&m[2], &m[0]), cross(&m[0], &m[1])]
}

/// m⁻¹, `None` where det m is zero or not finite.
pub fn inverse(m: &Matrix3) -> Option<Matrix3> {
    let det = determinant(m);
    let cofactors = cofactors(m);
    (det != 0.0 && det.is_finite()).then(|| std::array::from_fn(|i| std::array::from_fn(|j| cofactors[j][i] / det)))
}

/// A singular value decomposition m = U diag(σ) Vᵀ with U and V proper rotations: |σ₀| ≥ |σ₁| ≥ |σ₂|, σ₀ and σ₁ are
/// not negative, and σ₂ has the sign of det m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Svd3 {
    /// U.
    pub left: Matrix3,
    /// σ.
    pub values: [f64; 3],
    /// V.
    pub right: Matrix3,
}

/// The decomposition of `m`, by rotations of pairs of its columns until all are orthogonal (one-sided Jacobi): small singular values
/// are as accurate as large ones.
pub fn svd(m: &Matrix3) -> Svd3 {
    // Rows of `columns` are the columns of m V.
    let (mut columns, mut right) = (transposed(m), IDENTITY);
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotated |= orthogonalise(&mut columns, &mut right, p, q);
        }
        if !rotated {
            break;
        }
    }
    sort(&mut columns, &mut right);
    let norm = |v: &[f64; 3]| dot(v, v).sqrt();
    let values = [norm(&columns[0]), norm(&columns[1])];
    let first = direction(&columns[0], values[0], [1.0, 0.0, 0.0]);
    let second = direction(&columns[1], values[1], perpendicular(&first));
    let third = cross(&first, &second);
    Svd3 {
        left: transposed(&[first, second, third]),
        values: [values[0], values[1], dot(&third, &columns[2])],
        right: transposed(&right),
    }
}

/// Rotates rows p and q of both matrices so that those of `columns` become orthogonal; whether they were not.
fn orthogonalise(columns: &mut Matrix3, right: &mut Matrix3, p: usize, q: usize) -> bool {
    let (pp, qq, pq) = (dot(&columns[p], &columns[p]), dot(&columns[q], &columns[q]), dot(&columns[p], &columns[q]));
    if pq == 0.0 || pq.abs() <= f64::EPSILON * 0.25 * (pp * qq).sqrt() {
        return false;
    }
    let zeta = (qq - pp) / (2.0 * pq);
    let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = cosine * tangent;
    for m in [columns, right] {
        let (a, b) = (m[p], m[q]);
        m[p] = std::array::from_fn(|i| cosine * a[i] - sine * b[i]);
        m[q] = std::array::from_fn(|i| sine * a[i] + cosine * b[i]);
    }
    true
}

/// Descending norms; a swap changes one sign, so that `right` stays a rotation.
fn sort(columns: &mut Matrix3, right: &mut Matrix3) {
    for (p, q) in [(0, 1), (1, 2), (0, 1)] {
        if dot(&columns[p], &columns[p]) < dot(&columns[q], &columns[q]) {
            for m in [&mut *columns, &mut *right] {
                let first = m[p];
                m[p] = m[q];
                m[q] = first.map(|v| -v);
            }
        }
    }
}

fn direction(v: &[f64; 3], norm: f64, otherwise: [f64; 3]) -> [f64; 3] {
    match norm > f64::MIN_POSITIVE {
        true => v.map(|x| x / norm),
        false => otherwise,
    }
}

fn perpendicular(v: &[f64; 3]) -> [f64; 3] {
    let axis = (0..3).min_by(|a, b| v[*a].abs().total_cmp(&v[*b].abs())).unwrap_or(0);
    let mut other = [0.0; 3];
    other[axis] = 1.0;
    let w = cross(v, &other);
    let norm = dot(&w, &w).sqrt();
    w.map(|x| x / norm)
}

/// The polar decomposition m = R S: R the proper rotation that is nearest to m, S symmetric (indefinite where det m < 0).
pub fn polar(m: &Matrix3) -> (Matrix3, Matrix3) {
    let Svd3 { left, values, right } = svd(m);
    let rotation = product(&left, &transposed(&right));
    let scaled = std::array::from_fn(|i| std::array::from_fn(|j| right[i][j] * values[j]));
    let stretch = product(&scaled, &transposed(&right));
    (rotation, std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (stretch[i][j] + stretch[j][i]))))
}

/// Eigenvalues of a symmetric matrix, descending, and its eigenvectors as columns of a matrix, by Jacobi rotations.
pub fn symmetric_eigen(m: &Matrix3) -> ([f64; 3], Matrix3) {
    let (mut a, mut vectors) = (*m, IDENTITY);
    for _ in 0..SWEEPS {
        let off: f64 = a[0][1].abs() + a[0][2].abs() + a[1][2].abs();
        if off <= f64::EPSILON * 0.01 * (a[0][0].abs() + a[1][1].abs() + a[2][2].abs()) {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            annihilate(&mut a, &mut vectors, p, q);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| a[*j][*j].total_cmp(&a[*i][*i]));
    (order.map(|i| a[i][i]), std::array::from_fn(|r| order.map(|i| vectors[r][i])))
}

fn annihilate(a: &mut Matrix3, vectors: &mut Matrix3, p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let zeta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = cosine * tangent;
    let mut rotation = IDENTITY;
    (rotation[p][p], rotation[q][q], rotation[p][q], rotation[q][p]) = (cosine, cosine, sine, -sine);
    *a = product(&transposed(&rotation), &product(a, &rotation));
    *vectors = product(vectors, &rotation);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    fn random(source: &mut ChaCha8Rng) -> Matrix3 {
        std::array::from_fn(|_| std::array::from_fn(|_| source.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0))
    }

    fn distance(a: &Matrix3, b: &Matrix3) -> f64 {
        a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    }

    fn examples() -> Vec<Matrix3> {
        let mut source = ChaCha8Rng::seed_from_u64(5);
        let mut examples: Vec<Matrix3> = (0..200).map(|_| random(&mut source)).collect();
        examples.extend([
            IDENTITY,
            [[0.0; 3]; 3],
            [[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [-1.0, -2.0, -3.0]],
            [[1.0, 0.0, 0.0], [0.0, 1e-9, 0.0], [0.0, 0.0, -1e-12]],
            [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        ]);
        examples
    }

    fn is_rotation(m: &Matrix3) -> bool {
        distance(&product(&transposed(m), m), &IDENTITY) < 1e-14 && (determinant(m) - 1.0).abs() < 1e-14
    }

    #[test]
    fn a_decomposition_consists_of_rotations_and_gives_the_matrix_back() {
        for m in examples() {
            let Svd3 { left, values, right } = svd(&m);
            assert!(is_rotation(&left) && is_rotation(&right), "{m:?}: {left:?}, {right:?}");
            assert!(values[0] >= values[1] && values[1] >= values[2].abs(), "{values:?}");
            let scaled = std::array::from_fn(|i| std::array::from_fn(|j| left[i][j] * values[j]));
            let back = product(&scaled, &transposed(&right));
            assert!(distance(&back, &m) < 2e-15, "{m:?}: {:.1e}", distance(&back, &m));
        }
    }

    #[test]
    fn small_singular_values_keep_their_digits() {
        let values = svd(&[[1.0, 0.0, 0.0], [0.0, 1e-9, 0.0], [0.0, 0.0, -1e-12]]).values;
        assert!((values[2] / -1e-12 - 1.0).abs() < 1e-15, "{values:?}");
    }

    #[test]
    fn the_polar_factors_are_a_rotation_and_a_symmetric_matrix() {
        for m in examples() {
            let (rotation, stretch) = polar(&m);
            assert!(is_rotation(&rotation));
            assert!(distance(&product(&rotation, &stretch), &m) < 4e-15);
            assert!(distance(&stretch, &transposed(&stretch)) == 0.0);
        }
    }

    #[test]
    fn eigenvectors_diagonalise() {
        for m in examples() {
            let symmetric = std::array::from_fn(|i| std::array::from_fn(|j| m[i][j] + m[j][i]));
            let (values, vectors) = symmetric_eigen(&symmetric);
            assert!(distance(&product(&transposed(&vectors), &vectors), &IDENTITY) < 1e-14);
            let diagonal = product(&transposed(&vectors), &product(&symmetric, &vectors));
            let exact = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { values[i] } else { 0.0 }));
            assert!(distance(&diagonal, &exact) < 1e-14, "{diagonal:?}");
        }
    }

    #[test]
    fn inverse_and_cofactors_agree_with_the_determinant() {
        for m in examples().into_iter().take(200) {
            let inverse = inverse(&m).unwrap();
            let error = distance(&product(&m, &inverse), &IDENTITY);
            assert!(error < 1e-12 / determinant(&m).abs().min(1.0), "{error:.1e}");
            let (step, cofactors) = (1e-6, cofactors(&m));
            for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
                let (mut above, mut below) = (m, m);
                (above[i][j], below[i][j]) = (m[i][j] + step, m[i][j] - step);
                let slope = (determinant(&above) - determinant(&below)) / (2.0 * step);
                assert!((slope - cofactors[i][j]).abs() < 1e-9);
            }
        }
        assert_eq!(inverse(&[[0.0; 3]; 3]), None);
    }
}
