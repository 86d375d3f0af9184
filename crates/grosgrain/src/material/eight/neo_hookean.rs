//! The formulas of `material/neo_hookean.rs` in lanes.

use super::{EightMatrices, EightTangents, directions, matrix_at, weighted, with_directions, write};
use crate::linalg::lanes::Lanes;
use crate::linalg::matrix3_lanes::{LaneMatrix, LaneVector, cofactors, dot, load, scaled, store, svd};
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
    let mut definite = [1.0; 8];
    pulp::Arch::new().dispatch(Tangent { lambda, mu, f, g: &g, projected, definite: &mut definite, tangent });
    // The block of scalings is indefinite under strong expansion only, so its eigenvalues are left to the scalar formulas.
    let expanded = (0..8).filter(|point| definite[*point] <= 0.0);
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
    [scaled(reciprocal, &cofactors[0]), scaled(reciprocal, &cofactors[1]), scaled(reciprocal, &cofactors[2])]
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
        let (lambda, mu) = (Lanes::splat(simd, self.lambda), Lanes::splat(simd, self.mu));
        let (half, one) = (Lanes::splat(simd, 0.5), Lanes::splat(simd, 1.0));
        for vector in 0..Lanes::<S>::VECTORS {
            let f = load(simd, self.f, vector);
            let log = Lanes::load(simd, self.logarithms, vector);
            let (g, inverse) = (lambda.times_plus(log, -mu), inverse_transposed(simd, &f));
            let (mut p, mut h) = (f, f);
            for i in 0..3 {
                for j in 0..3 {
                    p[i][j] = g.times_plus(inverse[i][j], mu * f[i][j]);
                }
                h[i][i] = h[i][i] - one;
            }
            store(&p, self.stress, vector);
            let square = dot(&h[0], &h[0]) + dot(&h[1], &h[1]) + dot(&h[2], &h[2]);
            let shear = half.times_plus(square, h[0][0] + h[1][1] + h[2][2] - log);
            let energy = mu.times_plus(shear, half * lambda * log * log);
            energy.store(self.energies, vector);
        }
    }
}

/// The smallest of the leading minors of the block of scalings δ_ab (μ − g / σₐ²) + λ / (σₐ σ_b), times squares of the σ.
#[inline(always)]
fn smallest_minor<S: pulp::Simd>(lambda: Lanes<S>, mu: Lanes<S>, g: Lanes<S>, values: &LaneVector<S>) -> Lanes<S> {
    let mut shifted = *values;
    for a in 0..3 {
        shifted[a] = (mu * values[a]).times_plus(values[a], -g);
    }
    let [x, y, z] = shifted;
    let first = x + lambda;
    let second = x.times_plus(y, lambda * (x + y));
    let third = (x * y).times_plus(z, lambda * (x * y + y * z + z * x));
    -(-first).max(-second).max(-third)
}

struct Tangent<'a> {
    lambda: f64,
    mu: f64,
    f: &'a EightMatrices,
    g: &'a [f64; 8],
    projected: bool,
    /// Not positive where the block of scalings is not positive definite; written if `projected`.
    definite: &'a mut [f64; 8],
    tangent: &'a mut EightTangents,
}

impl pulp::WithSimd for Tangent<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let (lambda, mu) = (Lanes::splat(simd, self.lambda), Lanes::splat(simd, self.mu));
        let (zero, half, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 0.5), Lanes::splat(simd, 1.0));
        for vector in 0..Lanes::<S>::VECTORS {
            let f = load(simd, self.f, vector);
            let g = Lanes::load(simd, self.g, vector);
            let inverse = inverse_transposed(simd, &f);
            if !self.projected {
                for row in 0..9 {
                    for column in row..9 {
                        let entry = exact(lambda, if row == column { mu } else { zero }, g, &inverse, (row, column));
                        write(entry, self.tangent, (row, column), vector);
                    }
                }
                continue;
            }
            let svd = svd(simd, &f);
            smallest_minor(lambda, mu, g, &svd.values).store(self.definite, vector);
            // A twist can be negative where g is, a flip where g is positive. Minus that eigenvalue, halved for the missing 1/√2:
            let mut missing = [zero; 3];
            for n in 0..3 {
                let ratio = g.abs() / (svd.values[PAIRS[n].0] * svd.values[PAIRS[n].1]);
                missing[n] = half * (ratio - mu).max(zero);
            }
            let directions = directions(&svd, one.negated_where_negative(g));
            let weighted = weighted(&directions, &missing);
            for row in 0..9 {
                for column in row..9 {
                    let start = exact(lambda, if row == column { mu } else { zero }, g, &inverse, (row, column));
                    let entry = with_directions(start, &weighted, &directions, (row, column));
                    write(entry, self.tangent, (row, column), vector);
                }
            }
        }
    }
}

/// Entry (row, column) of μ δ_ik δ_jl − g A_il A_kj + λ A_ij A_kl with A = F⁻ᵀ; `identity` is μ on the diagonal.
#[inline(always)]
fn exact<S: pulp::Simd>(
    lambda: Lanes<S>,
    identity: Lanes<S>,
    g: Lanes<S>,
    inverse: &LaneMatrix<S>,
    (row, column): (usize, usize),
) -> Lanes<S> {
    let (i, j, k, l) = (row / 3, row % 3, column / 3, column % 3);
    let volume = (lambda * inverse[i][j]).times_plus(inverse[k][l], identity);
    (-(g * inverse[i][l])).times_plus(inverse[k][j], volume)
}
