//! 3×3 matrices in the lanes of vector registers.

use super::lanes::Lanes;

/// A matrix per lane, `m[row][column]`.
pub(crate) type LaneMatrix<S> = [[Lanes<S>; 3]; 3];
/// A vector per lane.
pub(crate) type LaneVector<S> = [Lanes<S>; 3];

/// Rotations sweep over the pairs of columns at most this often.
const SWEEPS: usize = 15;
/// Squared cosine between columns that counts as zero. Rounding leaves 1e-31; a larger bound would stop too early where singular
/// values nearly agree, because sweeps converge quadratically only once their distance is resolved.
const ORTHOGONAL: f64 = 1e-30;

/// The matrices at register `vector` of eight, `m[row][column][problem]`.
#[inline(always)]
pub(crate) fn load<S: pulp::Simd>(simd: S, m: &[[[f64; 8]; 3]; 3], vector: usize) -> LaneMatrix<S> {
    let mut lanes = [[Lanes::splat(simd, 0.0); 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            lanes[i][j] = Lanes::load(simd, &m[i][j], vector);
        }
    }
    lanes
}

/// Writes register `vector` of eight matrices.
#[inline(always)]
pub(crate) fn store<S: pulp::Simd>(m: &LaneMatrix<S>, out: &mut [[[f64; 8]; 3]; 3], vector: usize) {
    for i in 0..3 {
        for j in 0..3 {
            m[i][j].store(&mut out[i][j], vector);
        }
    }
}

/// a · b.
#[inline(always)]
pub(crate) fn dot<S: pulp::Simd>(a: &LaneVector<S>, b: &LaneVector<S>) -> Lanes<S> {
    a[0].times_plus(b[0], a[1].times_plus(b[1], a[2] * b[2]))
}

/// factor v.
#[inline(always)]
pub(crate) fn scaled<S: pulp::Simd>(factor: Lanes<S>, v: &LaneVector<S>) -> LaneVector<S> {
    [factor * v[0], factor * v[1], factor * v[2]]
}

#[inline(always)]
fn cross<S: pulp::Simd>(a: &LaneVector<S>, b: &LaneVector<S>) -> LaneVector<S> {
    [
        a[1].times_plus(b[2], -(a[2] * b[1])),
        a[2].times_plus(b[0], -(a[0] * b[2])),
        a[0].times_plus(b[1], -(a[1] * b[0])),
    ]
}

/// The matrix of cofactors.
#[inline(always)]
pub(crate) fn cofactors<S: pulp::Simd>(m: &LaneMatrix<S>) -> LaneMatrix<S> {
    [cross(&m[1], &m[2]), cross(&m[2], &m[0]), cross(&m[0], &m[1])]
}

/// Singular vectors and values of matrices with positive determinants, in no order: `left[a]` and `right[a]` are those of `values[a]`.
#[derive(Clone, Copy)]
pub(crate) struct LaneSvd<S: pulp::Simd> {
    pub left: LaneMatrix<S>,
    pub values: LaneVector<S>,
    pub right: LaneMatrix<S>,
}

/// The decomposition by rotations of pairs of columns, as [`matrix3::svd`](super::matrix3::svd) but without branches for each matrix.
#[inline(always)]
pub(crate) fn svd<S: pulp::Simd>(simd: S, m: &LaneMatrix<S>) -> LaneSvd<S> {
    let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
    let mut columns = [[m[0][0], m[1][0], m[2][0]], [m[0][1], m[1][1], m[2][1]], [m[0][2], m[1][2], m[2][2]]];
    let mut right = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    for _ in 0..SWEEPS {
        let oblique = orthogonalise(simd, &mut columns, &mut right, 0, 1)
            .max(orthogonalise(simd, &mut columns, &mut right, 0, 2))
            .max(orthogonalise(simd, &mut columns, &mut right, 1, 2));
        if oblique.largest() <= 0.0 {
            break;
        }
    }
    let mut values = [zero; 3];
    for a in 0..3 {
        values[a] = dot(&columns[a], &columns[a]).sqrt();
        columns[a] = scaled(one / values[a], &columns[a]);
    }
    LaneSvd { left: columns, values, right }
}

/// Rotates columns p and q until they are orthogonal; positive where they were not.
#[inline(always)]
fn orthogonalise<S: pulp::Simd>(
    simd: S,
    columns: &mut LaneMatrix<S>,
    right: &mut LaneMatrix<S>,
    p: usize,
    q: usize,
) -> Lanes<S> {
    let (pp, qq, pq) = (dot(&columns[p], &columns[p]), dot(&columns[q], &columns[q]), dot(&columns[p], &columns[q]));
    let (difference, twice) = (qq - pp, pq + pq);
    let root = difference.times_plus(difference, twice * twice).sqrt();
    let denominator = (difference.abs() + root).max(Lanes::splat(simd, f64::MIN_POSITIVE));
    let tangent = (twice / denominator).negated_where_negative(difference);
    let one = Lanes::splat(simd, 1.0);
    let cosine = one / tangent.times_plus(tangent, one).sqrt();
    let sine = cosine * tangent;
    turn(columns, p, q, cosine, sine);
    turn(right, p, q, cosine, sine);
    pq.times_plus(pq, -(Lanes::splat(simd, ORTHOGONAL) * pp * qq))
}

#[inline(always)]
fn turn<S: pulp::Simd>(m: &mut LaneMatrix<S>, p: usize, q: usize, cosine: Lanes<S>, sine: Lanes<S>) {
    for i in 0..3 {
        let (a, b) = (m[p][i], m[q][i]);
        m[p][i] = cosine.times_plus(a, -(sine * b));
        m[q][i] = sine.times_plus(a, cosine * b);
    }
}
