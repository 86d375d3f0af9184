//! The formulas of `material/neo_hookean.rs` in lanes.

use super::{EightMatrices, EightTangents, matrix_at, store, twists, write};
use crate::linalg::lanes::Lanes;
use crate::linalg::matrix3_lanes::{LaneMatrix, cofactors, dot, load, svd};
use crate::material::neo_hookean::logarithm;
use crate::material::spectral::PAIRS;
use crate::material::{PointLaw, Projection};

/// ψ of each point, and P into `stress`.
pub(super) fn stress(lambda: f64, mu: f64, f: &EightMatrices, stress: &mut EightMatrices) -> Option<[f64; 8]> {
    let logarithms = logarithms(f)?;
    let mut energies = [0.0; 8];
    pulp::Arch::new().dispatch(Stress { lambda, mu, f, logarithms: &logarithms, energies: &mut energies, stress });
    Some(energies)
}

/// ∂P/∂F into `tangent`.
pub(super) fn tangent(
    lambda: f64,
    mu: f64,
    f: &EightMatrices,
    projection: Projection,
    tangent: &mut EightTangents,
) -> Option<()> {
    let g = logarithms(f)?.map(|log| lambda * log - mu);
    let projected = projection == Projection::PositiveSemidefinite;
    pulp::Arch::new().dispatch(Tangent { lambda, mu, f, g: &g, projected, tangent });
    // Flips and scalings need care only where g > 0: under strong expansion.
    let expanded = (0..8).filter(|point| projected && g[*point] > 0.0);
    let law = PointLaw::NeoHookean { lambda, mu };
    expanded.into_iter().try_for_each(|point| law.tangent_at(f, point, projection, tangent))
}

fn logarithms(f: &EightMatrices) -> Option<[f64; 8]> {
    let mut logarithms = [0.0; 8];
    for (point, value) in logarithms.iter_mut().enumerate() {
        *value = logarithm(&matrix_at(f, point))?;
    }
    Some(logarithms)
}

/// F⁻ᵀ.
#[inline(always)]
fn inverse_transposed<S: pulp::Simd>(simd: S, f: &LaneMatrix<S>) -> LaneMatrix<S> {
    let cofactors = cofactors(f);
    let reciprocal = Lanes::splat(simd, 1.0) / dot(&f[0], &cofactors[0]);
    cofactors.map(|row| row.map(|v| v * reciprocal))
}

struct Stress<'a> {
    lambda: f64,
    mu: f64,
    f: &'a EightMatrices,
    logarithms: &'a [f64; 8],
    energies: &'a mut [f64; 8],
    stress: &'a mut EightMatrices,
}

impl pulp::WithSimd for Stress<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let [lambda, mu, half, one] = [self.lambda, self.mu, 0.5, 1.0].map(|v| Lanes::splat(simd, v));
        for vector in 0..Lanes::<S>::VECTORS {
            let f = load(simd, self.f, vector);
            let log = Lanes::load(simd, self.logarithms, vector);
            let (g, inverse) = (lambda.times_plus(log, -mu), inverse_transposed(simd, &f));
            let p = std::array::from_fn(|i| std::array::from_fn(|j| g.times_plus(inverse[i][j], mu * f[i][j])));
            store(&p, self.stress, vector);
            let mut h = f;
            (0..3).for_each(|i| h[i][i] = h[i][i] - one);
            let square = dot(&h[0], &h[0]) + dot(&h[1], &h[1]) + dot(&h[2], &h[2]);
            let shear = half.times_plus(square, h[0][0] + h[1][1] + h[2][2] - log);
            let energy = mu.times_plus(shear, half * lambda * log * log);
            energy.store(self.energies, vector);
        }
    }
}

struct Tangent<'a> {
    lambda: f64,
    mu: f64,
    f: &'a EightMatrices,
    g: &'a [f64; 8],
    projected: bool,
    tangent: &'a mut EightTangents,
}

impl pulp::WithSimd for Tangent<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let [lambda, mu, half, zero] = [self.lambda, self.mu, 0.5, 0.0].map(|v| Lanes::splat(simd, v));
        for vector in 0..Lanes::<S>::VECTORS {
            let f = load(simd, self.f, vector);
            let g = Lanes::load(simd, self.g, vector);
            let inverse = inverse_transposed(simd, &f);
            let scaled: LaneMatrix<S> = inverse.map(|row| row.map(|v| -(g * v)));
            let entry = |row: usize, column: usize| {
                let ((i, j), (k, l)) = ((row / 3, row % 3), (column / 3, column % 3));
                let identity = if row == column { mu } else { zero };
                let volume = (lambda * inverse[i][j]).times_plus(inverse[k][l], identity);
                scaled[i][l].times_plus(inverse[k][j], volume)
            };
            if !self.projected {
                write(self.tangent, vector, entry);
                continue;
            }
            let svd = svd(simd, &f);
            // Minus a negative eigenvalue, halved for the missing 1/√2 of the twists.
            let missing = PAIRS.map(|(a, b)| half * (-(g / (svd.values[a] * svd.values[b]) + mu)).max(zero));
            let twists = twists(&svd);
            let weighted: [[Lanes<S>; 9]; 3] = std::array::from_fn(|n| twists[n].map(|v| missing[n] * v));
            write(self.tangent, vector, |row, column| {
                let twist = |n: usize, sum: Lanes<S>| weighted[n][row].times_plus(twists[n][column], sum);
                twist(0, twist(1, twist(2, entry(row, column))))
            });
        }
    }
}
