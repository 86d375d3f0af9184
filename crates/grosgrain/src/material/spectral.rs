//! The tangent of an isotropic law in the frame of singular vectors.
//!
//! With F = U diag(σ) Vᵀ (signed σ₂), ψ(F) = ψ(σ₀, σ₁, σ₂) and ψᵢ = ∂ψ/∂σᵢ, the nine directions uₐ ⊗ v_b split ∂P/∂F into
//! three *twists* (uₐ ⊗ v_b − u_b ⊗ vₐ)/√2 with eigenvalue (ψₐ + ψ_b)/(σₐ + σ_b), three *flips* (uₐ ⊗ v_b + u_b ⊗ vₐ)/√2
//! with (ψₐ − ψ_b)/(σₐ − σ_b), and the 3×3 block ∂²ψ/∂σₐ∂σ_b of the *scalings* uₐ ⊗ vₐ (`smith2019analytic`).

use super::point_law::{Matrix9, Projection};
use crate::linalg::matrix3::{Matrix3, Svd3, symmetric_eigen};

/// The pairs (a, b) of twists and flips: number n leaves out axis n.
pub(super) const PAIRS: [(usize, usize); 3] = [(1, 2), (0, 2), (0, 1)];

/// ∂P/∂F in the frame of singular vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpectralTangent {
    /// Eigenvalues of the twists \[Pa\], in the order of [`PAIRS`].
    pub twist: [f64; 3],
    /// Eigenvalues of the flips \[Pa\].
    pub flip: [f64; 3],
    /// ∂²ψ/∂σₐ∂σ_b \[Pa\].
    pub scaling: Matrix3,
}

impl SpectralTangent {
    /// The same with negative eigenvalues set to zero, or as it is.
    pub fn projected(self, projection: Projection) -> Self {
        if projection == Projection::Exact {
            return self;
        }
        let clamped = |values: [f64; 3]| values.map(|v| v.max(0.0));
        Self { twist: clamped(self.twist), flip: clamped(self.flip), scaling: semidefinite(&self.scaling) }
    }

    /// ∂P/∂F for these singular vectors.
    pub fn assemble(&self, svd: &Svd3) -> Matrix9 {
        let direction =
            |a: usize, b: usize| -> [f64; 9] { std::array::from_fn(|n| svd.left[n / 3][a] * svd.right[n % 3][b]) };
        let axes = [direction(0, 0), direction(1, 1), direction(2, 2)];
        let mut tangent = [[0.0; 9]; 9];
        for (a, b) in (0..9).map(|n| (n / 3, n % 3)) {
            add(&mut tangent, self.scaling[a][b], &axes[a], &axes[b]);
        }
        for (n, (a, b)) in PAIRS.into_iter().enumerate() {
            let (ab, ba) = (direction(a, b), direction(b, a));
            let twist: [f64; 9] = std::array::from_fn(|m| ab[m] - ba[m]);
            let flip: [f64; 9] = std::array::from_fn(|m| ab[m] + ba[m]);
            add(&mut tangent, 0.5 * self.twist[n], &twist, &twist);
            add(&mut tangent, 0.5 * self.flip[n], &flip, &flip);
        }
        tangent
    }
}

/// m += factor a bᵀ.
#[inline]
pub(super) fn add(m: &mut Matrix9, factor: f64, a: &[f64; 9], b: &[f64; 9]) {
    for (row, value) in m.iter_mut().zip(a) {
        let scaled = factor * value;
        row.iter_mut().zip(b).for_each(|(entry, value)| *entry += scaled * value);
    }
}

/// U diag(values) Vᵀ.
pub(super) fn compose(svd: &Svd3, values: &[f64; 3]) -> Matrix3 {
    let entry = |i: usize, j: usize| (0..3).map(|a| svd.left[i][a] * values[a] * svd.right[j][a]).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// A symmetric matrix with its negative eigenvalues set to zero.
fn semidefinite(m: &Matrix3) -> Matrix3 {
    let (values, vectors) = symmetric_eigen(m);
    if values[2] >= 0.0 {
        return *m;
    }
    let entry = |i: usize, j: usize| (0..3).map(|a| values[a].max(0.0) * vectors[i][a] * vectors[j][a]).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}
