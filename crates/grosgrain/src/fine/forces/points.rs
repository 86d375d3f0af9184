//! Displacements, gradients and forces at the Gauss points of a box-shaped cell.
//!
//! Inside a cell, vectors are stored component by component, `u[component][corner]`: the eight corners fill a vector register.

use crate::element::{CellMatrix, gauss_2x2x2, trilinear_gradients};
use crate::linalg::matrix3::Matrix3;
use crate::material::Matrix9;
use crate::mesh::{Cell, Lattice};

/// Displacements \[m\] or forces \[N\] of a cell's corners, `[component][corner]`.
pub(in crate::fine) type CornerVectors = [[f64; 8]; 3];

/// ∂N_a/∂X_l \[1/m\] at one point, `[l][corner a]`.
pub(in crate::fine) type Gradients = [[f64; 8]; 3];

/// Gradients at a point ξ of a cell with edge lengths `spacing` \[m\].
pub(in crate::fine) fn gradients_at(spacing: [f64; 3], at: [f64; 3]) -> Gradients {
    let slopes = trilinear_gradients(at);
    std::array::from_fn(|l| std::array::from_fn(|a| slopes[a][l] / spacing[l]))
}

/// Gradients at the eight Gauss points.
pub(in crate::fine) fn gauss_gradients(spacing: [f64; 3]) -> [Gradients; 8] {
    gauss_2x2x2().map(|point| gradients_at(spacing, point.at))
}

/// The corner displacements of a cell out of a lattice vector.
#[inline]
pub(in crate::fine) fn corner_displacements(lattice: Lattice, cell: Cell, u: &[f64]) -> CornerVectors {
    let corners = lattice.corners(cell);
    std::array::from_fn(|r| std::array::from_fn(|a| u[3 * corners[a].0 + r]))
}

/// F = I + Σ_a u_a ⊗ ∇N_a.
#[inline]
pub(in crate::fine) fn deformation_gradient(gradients: &Gradients, u: &CornerVectors) -> Matrix3 {
    std::array::from_fn(|i| {
        std::array::from_fn(|l| {
            let sum: f64 = (0..8).map(|a| u[i][a] * gradients[l][a]).sum();
            if i == l { 1.0 + sum } else { sum }
        })
    })
}

/// forces += weight P ∇N_a for every corner a.
#[inline]
pub(super) fn add_forces(weight: f64, stress: &Matrix3, gradients: &Gradients, forces: &mut CornerVectors) {
    for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
        let scaled = weight * stress[i][j];
        for a in 0..8 {
            forces[i][a] += scaled * gradients[j][a];
        }
    }
}

/// out = Σ_q weight Bᵀ A B: entry (a i, b k) is Σ_q Σ_jl ∂N_a/∂X_j A_ij,kl ∂N_b/∂X_l times `weight`. Symmetric bit for bit.
pub(super) struct Contraction<'a> {
    pub weight: f64,
    pub points: &'a [Gradients; 8],
    pub tangents: &'a [Matrix9; 8],
    pub out: &'a mut CellMatrix,
}

impl pulp::WithSimd for Contraction<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        for (i, k) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let mut block = [[0.0; 8]; 8];
            for vector in 0..8 / S::F64_LANES {
                let sums = self.columns(simd, (i, k), vector);
                for (row, sum) in block.iter_mut().zip(sums) {
                    S::as_mut_simd_f64s(row).0[vector] = sum;
                }
            }
            write(self.weight, &block, (i, k), self.out);
        }
    }
}

impl Contraction<'_> {
    /// Rows a of the block of components (i, k), for one vector of corners b.
    #[inline(always)]
    fn columns<S: pulp::Simd>(&self, simd: S, (i, k): (usize, usize), vector: usize) -> [S::f64s; 8] {
        let mut sums = [simd.splat_f64s(0.0); 8];
        for (gradients, tangent) in self.points.iter().zip(self.tangents) {
            for j in 0..3 {
                let mut stress = simd.splat_f64s(0.0);
                for l in 0..3 {
                    let columns = S::as_simd_f64s(&gradients[l]).0[vector];
                    stress = simd.mul_add_f64s(simd.splat_f64s(tangent[3 * i + j][3 * k + l]), columns, stress);
                }
                for (a, sum) in sums.iter_mut().enumerate() {
                    *sum = simd.mul_add_f64s(simd.splat_f64s(gradients[j][a]), stress, *sum);
                }
            }
        }
        sums
    }
}

/// Writes weight times a block of components (i, k) and its transpose; of the diagonal blocks the upper triangle counts.
#[inline(always)]
fn write(weight: f64, block: &[[f64; 8]; 8], (i, k): (usize, usize), out: &mut CellMatrix) {
    for (a, row) in block.iter().enumerate() {
        for (b, value) in row.iter().enumerate() {
            if i == k && b < a {
                continue;
            }
            out[24 * (3 * a + i) + 3 * b + k] = weight * value;
            out[24 * (3 * b + k) + 3 * a + i] = weight * value;
        }
    }
}
