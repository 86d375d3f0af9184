//! Displacements, gradients and forces at the Gauss points of a box-shaped cell.
//!
//! Inside a cell, vectors are stored component by component, `u[component][corner]`: the eight corners fill a vector register.

use crate::element::{CellMatrix, gauss_2x2x2, trilinear_gradients};
use crate::linalg::lanes::Lanes;
use crate::linalg::matrix3::Matrix3;
use crate::material::{EightMatrices, EightTangents};
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
#[derive(Clone, Debug)]
pub(in crate::fine) struct GaussPoints {
    /// Point by point.
    pub gradients: [Gradients; 8],
    /// The same as `[l][corner a][point]`.
    across: [[[f64; 8]; 8]; 3],
}

impl GaussPoints {
    /// The points of a cell with edge lengths `spacing` \[m\].
    pub fn new(spacing: [f64; 3]) -> Self {
        let gradients = gauss_2x2x2().map(|point| gradients_at(spacing, point.at));
        let across = std::array::from_fn(|l| std::array::from_fn(|a| gradients.map(|point| point[l][a])));
        Self { gradients, across }
    }

    /// F at all points.
    #[inline]
    pub fn deformation_gradients(&self, u: &CornerVectors) -> EightMatrices {
        let mut f = [[[0.0; 8]; 3]; 3];
        pulp::Arch::new().dispatch(DeformationGradients { across: &self.across, u, f: &mut f });
        f
    }

    /// Σ_q weight P_q ∇N_a for every corner a.
    #[inline]
    pub fn forces(&self, weight: f64, stress: &EightMatrices) -> CornerVectors {
        let mut forces = [[0.0; 8]; 3];
        pulp::Arch::new().dispatch(Forces { gradients: &self.gradients, weight, stress, forces: &mut forces });
        forces
    }
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

struct DeformationGradients<'a> {
    across: &'a [[[f64; 8]; 8]; 3],
    u: &'a CornerVectors,
    f: &'a mut EightMatrices,
}

impl pulp::WithSimd for DeformationGradients<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        for vector in 0..Lanes::<S>::VECTORS {
            for i in 0..3 {
                let mut row = [Lanes::splat(simd, 0.0); 3];
                row[i] = Lanes::splat(simd, 1.0);
                for (a, u) in self.u[i].iter().enumerate() {
                    let u = Lanes::splat(simd, *u);
                    for l in 0..3 {
                        row[l] = u.times_plus(Lanes::load(simd, &self.across[l][a], vector), row[l]);
                    }
                }
                for l in 0..3 {
                    row[l].store(&mut self.f[i][l], vector);
                }
            }
        }
    }
}

struct Forces<'a> {
    gradients: &'a [Gradients; 8],
    weight: f64,
    stress: &'a EightMatrices,
    forces: &'a mut CornerVectors,
}

impl pulp::WithSimd for Forces<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let weight = Lanes::splat(simd, self.weight);
        for vector in 0..Lanes::<S>::VECTORS {
            let mut sums = [Lanes::splat(simd, 0.0); 3];
            for (q, gradients) in self.gradients.iter().enumerate() {
                for j in 0..3 {
                    let corners = Lanes::load(simd, &gradients[j], vector);
                    for i in 0..3 {
                        sums[i] = Lanes::splat(simd, self.stress[i][j][q]).times_plus(corners, sums[i]);
                    }
                }
            }
            for i in 0..3 {
                (weight * sums[i]).store(&mut self.forces[i], vector);
            }
        }
    }
}

/// out = Σ_q weight Bᵀ A B: entry (a i, b k) is Σ_q Σ_jl ∂N_a/∂X_j A_ij,kl ∂N_b/∂X_l times `weight`. Symmetric bit for bit.
pub(super) struct Contraction<'a> {
    pub weight: f64,
    pub gradients: &'a [Gradients; 8],
    pub tangents: &'a EightTangents,
    pub out: &'a mut CellMatrix,
}

impl pulp::WithSimd for Contraction<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        for (i, k) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let mut block = [[0.0; 8]; 8];
            for vector in 0..Lanes::<S>::VECTORS {
                let sums = self.columns(simd, (i, k), vector);
                for (row, sum) in block.iter_mut().zip(sums) {
                    sum.store(row, vector);
                }
            }
            write(self.weight, &block, (i, k), self.out);
        }
    }
}

impl Contraction<'_> {
    /// Rows a of the block of components (i, k), for one register of corners b.
    #[inline(always)]
    fn columns<S: pulp::Simd>(&self, simd: S, (i, k): (usize, usize), vector: usize) -> [Lanes<S>; 8] {
        let mut sums = [Lanes::splat(simd, 0.0); 8];
        for (q, gradients) in self.gradients.iter().enumerate() {
            let x = Lanes::load(simd, &gradients[0], vector);
            let y = Lanes::load(simd, &gradients[1], vector);
            let z = Lanes::load(simd, &gradients[2], vector);
            for j in 0..3 {
                let row = &self.tangents[3 * i + j];
                let last = Lanes::splat(simd, row[3 * k + 2][q]) * z;
                let partial = Lanes::splat(simd, row[3 * k + 1][q]).times_plus(y, last);
                let stress = Lanes::splat(simd, row[3 * k][q]).times_plus(x, partial);
                for (a, sum) in sums.iter_mut().enumerate() {
                    *sum = Lanes::splat(simd, gradients[j][a]).times_plus(stress, *sum);
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
