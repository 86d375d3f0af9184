//! A law at eight points at once, a point per lane of vector registers.

mod corotational;
mod neo_hookean;

use super::spectral::PAIRS;
use super::{PointLaw, Projection};
use crate::linalg::lanes::Lanes;
use crate::linalg::matrix3::Matrix3;
use crate::linalg::matrix3_lanes::{LaneSvd, LaneVector, scaled};

/// Eight 3×3 matrices, `m[row][column][point]`.
pub type EightMatrices = [[[f64; 8]; 3]; 3];

/// Eight tangents ∂P/∂F \[Pa\], indexed like [`Matrix9`](super::Matrix9), the point last.
pub type EightTangents = [[[f64; 8]; 9]; 9];

impl PointLaw {
    /// What [`stress`](Self::stress) gives at eight points: Σ ψ \[J/m³\], and P into `stress` \[Pa\]; `None` if one of them is inverted.
    /// Equal to rounding.
    pub fn stress_at_eight(&self, f: &EightMatrices, stress: &mut EightMatrices) -> Option<f64> {
        Some(self.energies_at_eight(f, stress)?.iter().sum())
    }

    /// The same with ψ \[J/m³\] of every point.
    pub fn energies_at_eight(&self, f: &EightMatrices, stress: &mut EightMatrices) -> Option<[f64; 8]> {
        let energies = match *self {
            Self::NeoHookean { lambda, mu } => neo_hookean::stress(lambda, mu, f, stress)?,
            Self::Corotational { lambda, mu } if corotational::is_upright(f) => {
                corotational::stress(lambda, mu, f, stress)
            }
            _ => {
                let mut energies = [0.0; 8];
                for (point, energy) in energies.iter_mut().enumerate() {
                    let (value, p) = self.stress(&matrix_at(f, point))?;
                    *energy = value;
                    (0..9).for_each(|n| stress[n / 3][n % 3][point] = p[n / 3][n % 3]);
                }
                energies
            }
        };
        Some(energies)
    }

    /// What [`tangent`](Self::tangent) gives at eight points: ∂P/∂F into `tangent` \[Pa\]; `None` if one of them is inverted.
    /// Equal to rounding.
    pub fn tangent_at_eight(
        &self,
        f: &EightMatrices,
        projection: Projection,
        tangent: &mut EightTangents,
    ) -> Option<()> {
        match *self {
            Self::NeoHookean { lambda, mu } => neo_hookean::tangent(lambda, mu, f, projection, tangent),
            Self::Corotational { lambda, mu } if corotational::is_upright(f) => {
                corotational::tangent(lambda, mu, f, projection, tangent);
                Some(())
            }
            _ => (0..8).try_for_each(|point| self.tangent_at(f, point, projection, tangent)),
        }
    }

    /// The tangent of one point by [`tangent`](Self::tangent).
    fn tangent_at(
        &self,
        f: &EightMatrices,
        point: usize,
        projection: Projection,
        out: &mut EightTangents,
    ) -> Option<()> {
        let (_, _, tangent) = self.tangent(&matrix_at(f, point), projection)?;
        for (to, from) in out.iter_mut().flatten().zip(tangent.iter().flatten()) {
            to[point] = *from;
        }
        Some(())
    }
}

/// The matrix of one point.
pub(crate) fn matrix_at(m: &EightMatrices, point: usize) -> Matrix3 {
    std::array::from_fn(|i| std::array::from_fn(|j| m[i][j][point]))
}

/// uₐ ⊗ v_b + sign u_b ⊗ vₐ in the order of [`PAIRS`]: twists for −1, flips for 1, without 1/√2.
#[inline(always)]
fn directions<S: pulp::Simd>(svd: &LaneSvd<S>, sign: Lanes<S>) -> [[Lanes<S>; 9]; 3] {
    let mut directions = [[sign; 9]; 3];
    for n in 0..3 {
        let (a, b) = PAIRS[n];
        let signed = scaled(sign, &svd.left[b]);
        for i in 0..3 {
            for j in 0..3 {
                directions[n][3 * i + j] = svd.left[a][i].times_plus(svd.right[b][j], signed[i] * svd.right[a][j]);
            }
        }
    }
    directions
}

/// `start` plus entry (row, column) of Σ wₙ dₙ dₙᵀ, with the directions dₙ and wₙ dₙ.
#[inline(always)]
fn with_directions<S: pulp::Simd>(
    start: Lanes<S>,
    weighted: &[[Lanes<S>; 9]; 3],
    directions: &[[Lanes<S>; 9]; 3],
    (row, column): (usize, usize),
) -> Lanes<S> {
    let third = weighted[2][row].times_plus(directions[2][column], start);
    weighted[0][row].times_plus(directions[0][column], weighted[1][row].times_plus(directions[1][column], third))
}

/// Directions times a weight each.
#[inline(always)]
fn weighted<S: pulp::Simd>(directions: &[[Lanes<S>; 9]; 3], weights: &LaneVector<S>) -> [[Lanes<S>; 9]; 3] {
    let mut weighted = *directions;
    for n in 0..3 {
        for m in 0..9 {
            weighted[n][m] = weights[n] * directions[n][m];
        }
    }
    weighted
}

/// Writes an entry of a symmetric tangent and its mirror image.
#[inline(always)]
fn write<S: pulp::Simd>(value: Lanes<S>, out: &mut EightTangents, (row, column): (usize, usize), vector: usize) {
    value.store(&mut out[row][column], vector);
    value.store(&mut out[column][row], vector);
}

#[cfg(test)]
mod tests;
