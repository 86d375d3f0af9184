//! The formulas of `material/corotational.rs` in lanes, for points that are not inverted.

use super::{EightMatrices, EightTangents, matrix_at, store, twists, write};
use crate::linalg::lanes::Lanes;
use crate::linalg::matrix3::determinant;
use crate::linalg::matrix3_lanes::{LaneMatrix, LaneSvd, load, svd};
use crate::material::Projection;
use crate::material::corotational::SMALLEST_SUM;
use crate::material::spectral::PAIRS;

/// Flatter points are left to the scalar formulas, which know the sign of the smallest singular value.
const FLAT: f64 = 1e-6;

/// Whether no point is inverted or nearly flat.
pub(super) fn is_upright(f: &EightMatrices) -> bool {
    (0..8).all(|point| determinant(&matrix_at(f, point)) > FLAT)
}

/// ψ of each point, and P into `stress`.
pub(super) fn stress(lambda: f64, mu: f64, f: &EightMatrices, stress: &mut EightMatrices) -> [f64; 8] {
    let mut energies = [0.0; 8];
    pulp::Arch::new().dispatch(Stress { lambda, mu, f, energies: &mut energies, stress });
    energies
}

/// ∂P/∂F into `tangent`.
pub(super) fn tangent(lambda: f64, mu: f64, f: &EightMatrices, projection: Projection, tangent: &mut EightTangents) {
    let least = match projection {
        Projection::Exact => f64::NEG_INFINITY,
        Projection::PositiveSemidefinite => 0.0,
    };
    pulp::Arch::new().dispatch(Tangent { lambda, mu, f, least, tangent });
}

/// R = U Vᵀ.
#[inline(always)]
fn rotation<S: pulp::Simd>(svd: &LaneSvd<S>) -> LaneMatrix<S> {
    let product = |a: usize, i: usize, j: usize| svd.left[a][i] * svd.right[a][j];
    std::array::from_fn(|i| std::array::from_fn(|j| product(0, i, j) + product(1, i, j) + product(2, i, j)))
}

struct Stress<'a> {
    lambda: f64,
    mu: f64,
    f: &'a EightMatrices,
    energies: &'a mut [f64; 8],
    stress: &'a mut EightMatrices,
}

impl pulp::WithSimd for Stress<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let [lambda, mu, half, one] = [self.lambda, self.mu, 0.5, 1.0].map(|v| Lanes::splat(simd, v));
        for vector in 0..Lanes::<S>::VECTORS {
            let svd = svd(simd, &load(simd, self.f, vector));
            let strains = svd.values.map(|s| s - one);
            let trace = strains[0] + strains[1] + strains[2];
            let principal = strains.map(|e| (mu + mu).times_plus(e, lambda * trace));
            let scaled: LaneMatrix<S> = std::array::from_fn(|a| svd.left[a].map(|v| principal[a] * v));
            store(&rotation(&LaneSvd { left: scaled, ..svd }), self.stress, vector);
            let squares = strains[0] * strains[0] + strains[1] * strains[1] + strains[2] * strains[2];
            mu.times_plus(squares, half * lambda * trace * trace).store(self.energies, vector);
        }
    }
}

struct Tangent<'a> {
    lambda: f64,
    mu: f64,
    f: &'a EightMatrices,
    /// Eigenvalues below this are raised to it.
    least: f64,
    tangent: &'a mut EightTangents,
}

impl pulp::WithSimd for Tangent<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let [lambda, mu, half, zero] = [self.lambda, self.mu, 0.5, 0.0].map(|v| Lanes::splat(simd, v));
        let [three, smallest, least] = [3.0, SMALLEST_SUM, self.least].map(|v| Lanes::splat(simd, v));
        let stiff = mu + mu;
        for vector in 0..Lanes::<S>::VECTORS {
            let svd = svd(simd, &load(simd, self.f, vector));
            let trace = svd.values[0] + svd.values[1] + svd.values[2] - three;
            let excess = (lambda + lambda).times_plus(trace, -(stiff + stiff));
            // What a twist has beyond 2 μ, halved for the missing 1/√2.
            let beyond = PAIRS.map(|(a, b)| {
                let twist = stiff + excess / (svd.values[a] + svd.values[b]).max(smallest);
                half * (twist.max(least) - stiff)
            });
            let (twists, rotation) = (twists(&svd), rotation(&svd));
            let weighted: [[Lanes<S>; 9]; 3] = std::array::from_fn(|n| twists[n].map(|v| beyond[n] * v));
            write(self.tangent, vector, |row, column| {
                let identity = if row == column { stiff } else { zero };
                let along = |n: usize| rotation[n / 3][n % 3];
                let twist = |n: usize, sum: Lanes<S>| weighted[n][row].times_plus(twists[n][column], sum);
                twist(0, twist(1, twist(2, (lambda * along(row)).times_plus(along(column), identity))))
            });
        }
    }
}
