//! Compressible neo-Hookean elasticity.
//!
//! P = μ F + g F⁻ᵀ with g = λ ln J − μ; in singular values ψᵢ = μ σᵢ + g / σᵢ.

use super::point_law::{Matrix9, Projection};
use super::spectral::{PAIRS, SpectralTangent};
use crate::linalg::matrix3::{Matrix3, cofactors, determinant, dot, svd};

pub(super) fn energy(lambda: f64, mu: f64, f: &Matrix3) -> Option<f64> {
    let log = logarithm(f)?;
    Some(energy_of(lambda, mu, f, log))
}

pub(super) fn stress(lambda: f64, mu: f64, f: &Matrix3) -> Option<(f64, Matrix3)> {
    let log = logarithm(f)?;
    let inverse = inverse_transposed(f);
    Some((energy_of(lambda, mu, f, log), stress_of(mu, lambda * log - mu, f, &inverse)))
}

pub(super) fn tangent(lambda: f64, mu: f64, f: &Matrix3, projection: Projection) -> Option<(f64, Matrix3, Matrix9)> {
    let log = logarithm(f)?;
    let inverse = inverse_transposed(f);
    let g = lambda * log - mu;
    let tangent = match projection {
        Projection::Exact => exact(lambda, mu, g, &inverse),
        Projection::PositiveSemidefinite => {
            let svd = svd(f);
            spectral(lambda, mu, g, &svd.values).projected(projection).assemble(&svd)
        }
    };
    Some((energy_of(lambda, mu, f, log), stress_of(mu, g, f, &inverse), tangent))
}

/// J − 1 from H = F − I, so that small strains keep their digits: tr H + tr cof H + det H.
fn volume_change(h: &Matrix3) -> f64 {
    let cofactors = cofactors(h);
    (h[0][0] + h[1][1] + h[2][2]) + (cofactors[0][0] + cofactors[1][1] + cofactors[2][2]) + dot(&h[0], &cofactors[0])
}

fn displacement_gradient(f: &Matrix3) -> Matrix3 {
    std::array::from_fn(|i| std::array::from_fn(|j| f[i][j] - f64::from(u8::from(i == j))))
}

/// ln J, `None` unless J is positive and finite.
pub(super) fn logarithm(f: &Matrix3) -> Option<f64> {
    let determinant = determinant(f);
    if !(determinant > 0.0 && determinant.is_finite()) {
        return None;
    }
    let change = volume_change(&displacement_gradient(f));
    // Far from one the sum above cancels where the determinant does not.
    Some(if change.abs() < 0.5 { change.ln_1p() } else { determinant.ln() })
}

/// μ (tr H + ½ ‖H‖² − ln J) + λ/2 (ln J)², which is ψ because ‖F‖² − 3 = 2 tr H + ‖H‖².
fn energy_of(lambda: f64, mu: f64, f: &Matrix3, log: f64) -> f64 {
    let h = displacement_gradient(f);
    let square: f64 = h.iter().flatten().map(|v| v * v).sum();
    let trace = h[0][0] + h[1][1] + h[2][2];
    mu * ((trace - log) + 0.5 * square) + 0.5 * lambda * log * log
}

/// F⁻ᵀ of a matrix whose determinant is positive.
fn inverse_transposed(f: &Matrix3) -> Matrix3 {
    let determinant = determinant(f);
    cofactors(f).map(|row| row.map(|v| v / determinant))
}

fn stress_of(mu: f64, g: f64, f: &Matrix3, inverse: &Matrix3) -> Matrix3 {
    std::array::from_fn(|i| std::array::from_fn(|j| mu * f[i][j] + g * inverse[i][j]))
}

/// ∂P_ij/∂F_kl = μ δ_ik δ_jl − g A_il A_kj + λ A_ij A_kl with A = F⁻ᵀ.
fn exact(lambda: f64, mu: f64, g: f64, inverse: &Matrix3) -> Matrix9 {
    let entry = |(i, j): (usize, usize), (k, l): (usize, usize)| {
        let identity = if (i, j) == (k, l) { mu } else { 0.0 };
        identity - g * inverse[i][l] * inverse[k][j] + lambda * inverse[i][j] * inverse[k][l]
    };
    std::array::from_fn(|row| std::array::from_fn(|column| entry((row / 3, row % 3), (column / 3, column % 3))))
}

/// Twists μ + g / (σₐ σ_b), flips μ − g / (σₐ σ_b), scalings δ_ab (μ − g / σₐ²) + λ / (σₐ σ_b): no differences of stresses,
/// so equal singular values need no care.
fn spectral(lambda: f64, mu: f64, g: f64, values: &[f64; 3]) -> SpectralTangent {
    let ratio = PAIRS.map(|(a, b)| g / (values[a] * values[b]));
    let scaling = std::array::from_fn(|a| {
        std::array::from_fn(|b| {
            let diagonal = if a == b { mu - g / (values[a] * values[a]) } else { 0.0 };
            diagonal + lambda / (values[a] * values[b])
        })
    });
    SpectralTangent { twist: ratio.map(|r| mu + r), flip: ratio.map(|r| mu - r), scaling }
}
