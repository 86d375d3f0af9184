//! Linear elasticity in a frame that rotates with the point.
//!
//! In signed singular values σ: ψ = μ Σ (σᵢ − 1)² + λ/2 t² with t = Σ σᵢ − 3, so ψᵢ = 2 μ (σᵢ − 1) + λ t.

use super::point_law::{Matrix9, Projection};
use super::spectral::{PAIRS, SpectralTangent, compose};
use crate::linalg::matrix3::{Matrix3, svd};

/// Below this sum of two singular values the rotation has no derivative; the twist is stiffened no further.
pub(super) const SMALLEST_SUM: f64 = 1e-6;

pub(super) fn energy(lambda: f64, mu: f64, f: &Matrix3) -> f64 {
    energy_of(lambda, mu, &svd(f).values)
}

pub(super) fn stress(lambda: f64, mu: f64, f: &Matrix3) -> (f64, Matrix3) {
    let svd = svd(f);
    (energy_of(lambda, mu, &svd.values), compose(&svd, &principal_stresses(lambda, mu, &svd.values)))
}

pub(super) fn tangent(lambda: f64, mu: f64, f: &Matrix3, projection: Projection) -> (f64, Matrix3, Matrix9) {
    let svd = svd(f);
    let stress = compose(&svd, &principal_stresses(lambda, mu, &svd.values));
    let spectral = spectral(lambda, mu, &svd.values).projected(projection);
    (energy_of(lambda, mu, &svd.values), stress, spectral.assemble(&svd))
}

fn energy_of(lambda: f64, mu: f64, values: &[f64; 3]) -> f64 {
    let squares: f64 = values.iter().map(|s| (s - 1.0) * (s - 1.0)).sum();
    mu * squares + 0.5 * lambda * trace(values).powi(2)
}

fn principal_stresses(lambda: f64, mu: f64, values: &[f64; 3]) -> [f64; 3] {
    let pressure = lambda * trace(values);
    values.map(|s| 2.0 * mu * (s - 1.0) + pressure)
}

/// tr(S − I).
fn trace(values: &[f64; 3]) -> f64 {
    (values[0] - 1.0) + (values[1] - 1.0) + (values[2] - 1.0)
}

/// Twists 2 μ + (2 λ t − 4 μ)/(σₐ + σ_b), flips 2 μ, scalings 2 μ I + λ 1 1ᵀ.
fn spectral(lambda: f64, mu: f64, values: &[f64; 3]) -> SpectralTangent {
    let excess = 2.0 * lambda * trace(values) - 4.0 * mu;
    let twist = PAIRS.map(|(a, b)| 2.0 * mu + excess / (values[a] + values[b]).max(SMALLEST_SUM));
    let scaling = std::array::from_fn(|a| std::array::from_fn(|b| if a == b { 2.0 * mu + lambda } else { lambda }));
    SpectralTangent { twist, flip: [2.0 * mu; 3], scaling }
}
