//! 3×3 matrices in the lanes of vector registers.

use super::lanes::Lanes;

/// A matrix per lane, `m[row][column]`.
pub(crate) type LaneMatrix<S> = [[Lanes<S>; 3]; 3];
type LaneVector<S> = [Lanes<S>; 3];

/// Rotations sweep over the pairs of columns at most this often.
const SWEEPS: usize = 15;
/// Squared cosine between columns that counts as zero. Rounding leaves 1e-31; a larger bound would stop too early where singular
/// values nearly agree, because sweeps converge quadratically only once their distance is resolved.
const ORTHOGONAL: f64 = 1e-30;

/// The matrices at register `vector` of eight, `m[row][column][problem]`.
#[inline(always)]
pub(crate) fn load<S: pulp::Simd>(simd: S, m: &[[[f64; 8]; 3]; 3], vector: usize) -> LaneMatrix<S> {
    std::array::from_fn(|i| std::array::from_fn(|j| Lanes::load(simd, &m[i][j], vector)))
}

/// a · b.
#[inline(always)]
pub(crate) fn dot<S: pulp::Simd>(a: &LaneVector<S>, b: &LaneVector<S>) -> Lanes<S> {
    a[0].times_plus(b[0], a[1].times_plus(b[1], a[2] * b[2]))
}

/// The matrix of cofactors.
#[inline(always)]
pub(crate) fn cofactors<S: pulp::Simd>(m: &LaneMatrix<S>) -> LaneMatrix<S> {
    let cross = |a: &LaneVector<S>, b: &LaneVector<S>| {
        let entry = |p: usize, q: usize| a[p].times_plus(b[q], -(a[q] * b[p]));
        [entry(1, 2), entry(2, 0), entry(0, 1)]
    };
    [cross(&m[1], &m[2]), cross(&m[2], &m[0]), cross(&m[0], &m[1])]
}

/// Singular vectors and values of matrices with positive determinants, in no order: `left[a]` and `right[a]` are those of `values[a]`.
pub(crate) struct LaneSvd<S: pulp::Simd> {
    pub left: LaneMatrix<S>,
    pub values: LaneVector<S>,
    pub right: LaneMatrix<S>,
}

/// The decomposition by rotations of pairs of columns, as [`matrix3::svd`](super::matrix3::svd) but without branches for each matrix.
#[inline(always)]
pub(crate) fn svd<S: pulp::Simd>(simd: S, m: &LaneMatrix<S>) -> LaneSvd<S> {
    let mut columns: LaneMatrix<S> = std::array::from_fn(|a| std::array::from_fn(|i| m[i][a]));
    let mut right: LaneMatrix<S> =
        std::array::from_fn(|a| std::array::from_fn(|i| Lanes::splat(simd, if a == i { 1.0 } else { 0.0 })));
    for _ in 0..SWEEPS {
        let mut oblique = Lanes::splat(simd, 0.0);
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            oblique = oblique.max(orthogonalise(simd, &mut columns, &mut right, (p, q)));
        }
        if oblique.largest() <= 0.0 {
            break;
        }
    }
    let values: LaneVector<S> = std::array::from_fn(|a| dot(&columns[a], &columns[a]).sqrt());
    let one = Lanes::splat(simd, 1.0);
    let left = std::array::from_fn(|a| {
        let inverse = one / values[a];
        columns[a].map(|v| v * inverse)
    });
    LaneSvd { left, values, right }
}

/// Rotates columns p and q until they are orthogonal; positive where they were not.
#[inline(always)]
fn orthogonalise<S: pulp::Simd>(
    simd: S,
    columns: &mut LaneMatrix<S>,
    right: &mut LaneMatrix<S>,
    (p, q): (usize, usize),
) -> Lanes<S> {
    let (pp, qq, pq) = (dot(&columns[p], &columns[p]), dot(&columns[q], &columns[q]), dot(&columns[p], &columns[q]));
    let (difference, twice) = (qq - pp, pq + pq);
    let root = difference.times_plus(difference, twice * twice).sqrt();
    let denominator = (difference.abs() + root).max(Lanes::splat(simd, f64::MIN_POSITIVE));
    let tangent = (twice / denominator).negated_where_negative(difference);
    let one = Lanes::splat(simd, 1.0);
    let cosine = one / tangent.times_plus(tangent, one).sqrt();
    let sine = cosine * tangent;
    for m in [columns, right] {
        let (a, b) = (m[p], m[q]);
        m[p] = std::array::from_fn(|i| cosine.times_plus(a[i], -(sine * b[i])));
        m[q] = std::array::from_fn(|i| sine.times_plus(a[i], cosine * b[i]));
    }
    pq.times_plus(pq, -(Lanes::splat(simd, ORTHOGONAL) * pp * qq))
}
