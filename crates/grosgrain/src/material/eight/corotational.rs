//! The formulas of `material/corotational.rs` in lanes, for points that are not inverted.

use super::{EightMatrices, EightTangents, directions, matrix_at, weighted, with_directions, write};
use crate::linalg::lanes::Lanes;
use crate::linalg::matrix3::determinant;
use crate::linalg::matrix3_lanes::{LaneMatrix, LaneSvd, load, scaled, store, svd};
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

/// Σ left[a] ⊗ right[a]; R for singular vectors.
#[inline(always)]
fn sum_of_products<S: pulp::Simd>(left: &LaneMatrix<S>, right: &LaneMatrix<S>) -> LaneMatrix<S> {
    let mut sum = *left;
    for i in 0..3 {
        for j in 0..3 {
            let last = left[2][i] * right[2][j];
            sum[i][j] = left[0][i].times_plus(right[0][j], left[1][i].times_plus(right[1][j], last));
        }
    }
    sum
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
        let (lambda, mu) = (Lanes::splat(simd, self.lambda), Lanes::splat(simd, self.mu));
        let (half, one) = (Lanes::splat(simd, 0.5), Lanes::splat(simd, 1.0));
        for vector in 0..Lanes::<S>::VECTORS {
            let LaneSvd { left, values, right } = svd(simd, &load(simd, self.f, vector));
            let strains = [values[0] - one, values[1] - one, values[2] - one];
            let trace = strains[0] + strains[1] + strains[2];
            let mut forces = left;
            for a in 0..3 {
                forces[a] = scaled((mu + mu).times_plus(strains[a], lambda * trace), &left[a]);
            }
            store(&sum_of_products(&forces, &right), self.stress, vector);
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
        let (lambda, mu) = (Lanes::splat(simd, self.lambda), Lanes::splat(simd, self.mu));
        let (zero, half, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 0.5), Lanes::splat(simd, 1.0));
        let (smallest, least) = (Lanes::splat(simd, SMALLEST_SUM), Lanes::splat(simd, self.least));
        let stiff = mu + mu;
        for vector in 0..Lanes::<S>::VECTORS {
            let svd = svd(simd, &load(simd, self.f, vector));
            let trace = (svd.values[0] - one) + (svd.values[1] - one) + (svd.values[2] - one);
            let excess = (lambda + lambda).times_plus(trace, -(stiff + stiff));
            // What a twist has beyond 2 μ, halved for the missing 1/√2.
            let mut beyond = [zero; 3];
            for n in 0..3 {
                let sum = svd.values[PAIRS[n].0] + svd.values[PAIRS[n].1];
                let twist = stiff + excess / sum.max(smallest);
                beyond[n] = half * (twist.max(least) - stiff);
            }
            let rotation = sum_of_products(&svd.left, &svd.right);
            let directions = directions(&svd, -one);
            let weighted = weighted(&directions, &beyond);
            for row in 0..9 {
                let stretched = lambda * rotation[row / 3][row % 3];
                for column in row..9 {
                    let identity = if row == column { stiff } else { zero };
                    let start = stretched.times_plus(rotation[column / 3][column % 3], identity);
                    let entry = with_directions(start, &weighted, &directions, (row, column));
                    write(entry, self.tangent, (row, column), vector);
                }
            }
        }
    }
}
