//! The rotation of a coarse element and its derivatives.

use super::second_order::{combined, rotated};
use crate::coarsening::COLUMNS;
use crate::element::trilinear_gradients;
use crate::linalg::Polar;
use crate::linalg::matrix3::{IDENTITY, Matrix3, apply, apply_transposed, cross, determinant, product, skew};

/// One value per unknown of an element.
pub(super) type Columns = [f64; COLUMNS];

/// What the coarse cells of a model have in common: their box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CoarseBox {
    /// Corners X_i relative to the centre \[m\].
    pub corners: [[f64; 3]; 8],
    /// ∇N_i at the centre \[1/m\].
    pub gradients: [[f64; 3]; 8],
}

impl CoarseBox {
    /// The box with edge lengths `spacing` \[m\].
    pub fn new(spacing: [f64; 3]) -> Self {
        let corner = |i: usize| std::array::from_fn(|a| spacing[a] * ((i >> a & 1) as f64 - 0.5));
        let gradients = trilinear_gradients([0.5; 3]).map(|g| std::array::from_fn(|a| g[a] / spacing[a]));
        Self { corners: std::array::from_fn(corner), gradients }
    }

    /// Position relative to the centre \[m\] of a node of the cell's lattice of `degree`³ fine cells.
    pub fn node(&self, at: [usize; 3], degree: usize) -> [f64; 3] {
        std::array::from_fn(|a| 2.0 * self.corners[7][a] * (at[a] as f64 / degree as f64 - 0.5))
    }
}

/// Where an element is: its rotation R and its corners in the frame that rotates with it.
///
/// With x_i the moved corners relative to their mean, A = Σ_i x_i ⊗ ∇N_i is the deformation gradient at the centre and A = R S its polar
/// decomposition. In the rotated frame the corners are y_i = Rᵀ x_i, and v_i = y_i − X_i is what has to be called deformation (`muller2004interactive`).
/// Energies that do not change with translations need no other displacement, and far from rest this one keeps its digits.
///
/// A change R ξ_i of the corners turns the frame by R exp(\[w\]×). That exp(−\[w\]×)(S + D), D = Σ_i ξ_i ⊗ ∇N_i, be symmetric again gives
/// G w = Σ_i ∇N_i × ξ_i to first order, with G = tr(S) I − S.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// R.
    pub rotation: Matrix3,
    /// Whether R follows the corners; if not, it is the identity.
    pub rotates: bool,
    stretch: Matrix3,
    /// G⁻¹.
    compliance: Matrix3,
    /// Mean displacement of the corners, in world axes; zero where the frame does not rotate \[m\].
    pub shift: [f64; 3],
    /// y_i \[m\].
    pub corners: [[f64; 3]; 8],
    /// v \[m\].
    pub local: Columns,
}

impl Frame {
    /// The frame that rotates with corners displaced by `displacement` \[m\].
    ///
    /// # Errors
    /// det A where it is not positive, or so small that there is no rotation to tell.
    pub fn rotating(cell: &CoarseBox, displacement: &Columns) -> Result<Self, f64> {
        let mean = |r: usize| 0.125 * (0..8).map(|i| displacement[3 * i + r]).sum::<f64>();
        let shift = [0, 1, 2].map(mean);
        let moved = moved_corners(cell, displacement).map(|x| [x[0] - shift[0], x[1] - shift[1], x[2] - shift[2]]);
        let mut gradient = [[0.0; 3]; 3];
        for (x, slope) in moved.iter().zip(&cell.gradients) {
            (0..9).for_each(|n| gradient[n / 3][n % 3] += x[n / 3] * slope[n % 3]);
        }
        let Polar { rotation, stretch, compliance } = Polar::by_iteration(&gradient)
            .or_else(|| Polar::by_svd(&gradient))
            .ok_or_else(|| determinant(&gradient))?;
        let corners = moved.map(|x| apply_transposed(&rotation, &x));
        Ok(Self {
            rotation,
            rotates: true,
            stretch,
            compliance,
            shift,
            corners,
            local: std::array::from_fn(|n| corners[n / 3][n % 3] - cell.corners[n / 3][n % 3]),
        })
    }

    /// The frame that stays: v is the displacement.
    pub fn fixed(cell: &CoarseBox, displacement: &Columns) -> Self {
        let corners = moved_corners(cell, displacement);
        let none = [[0.0; 3]; 3];
        Self {
            rotation: IDENTITY,
            rotates: false,
            stretch: none,
            compliance: none,
            shift: [0.0; 3],
            corners,
            local: *displacement,
        }
    }

    /// Ω: the rows say how the frame turns with the corners, w = Ω ξ.
    fn spin(&self, cell: &CoarseBox) -> [Columns; 3] {
        let mut spin = [[0.0; COLUMNS]; 3];
        for (i, slope) in cell.gradients.iter().enumerate() {
            let block = product(&self.compliance, &skew(slope));
            (0..9).for_each(|n| spin[n / 3][3 * i + n % 3] = block[n / 3][n % 3]);
        }
        spin
    }
}

fn moved_corners(cell: &CoarseBox, displacement: &Columns) -> [[f64; 3]; 8] {
    std::array::from_fn(|i| std::array::from_fn(|r| cell.corners[i][r] + displacement[3 * i + r]))
}

/// First derivatives of an energy E(v, R), R turned to R exp(\[w\]×): E + g · δv + θ · w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LocalForces {
    /// g = ∂E/∂v \[N\].
    pub gradient: Columns,
    /// θ = ∂E/∂w \[N m\].
    pub couple: [f64; 3],
}

impl LocalForces {
    pub const ZERO: Self = Self { gradient: [0.0; COLUMNS], couple: [0.0; 3] };
}

/// Second derivatives in the same variables: E + … + ½ δv · K δv + δv · B w + ½ w · C w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LocalCurvature {
    /// K \[N/m\].
    pub stiffness: [Columns; COLUMNS],
    /// Bᵀ \[N\].
    pub mixed: [Columns; 3],
    /// C \[N m\].
    pub rotational: Matrix3,
}

impl LocalCurvature {
    pub const ZERO: Self =
        Self { stiffness: [[0.0; COLUMNS]; COLUMNS], mixed: [[0.0; COLUMNS]; 3], rotational: [[0.0; 3]; 3] };
}

/// What the rotation adds to the derivatives: with τ = Σ_i y_i × g_i, t = G⁻¹ (τ − θ) and the pulled-back gradient h_i = g_i − t × ∇N_i.
struct PulledBack {
    /// t.
    turning: [f64; 3],
    /// h, in the rotated frame \[N\].
    gradient: Columns,
}

impl Frame {
    fn pull_back(&self, cell: &CoarseBox, forces: &LocalForces) -> PulledBack {
        let mut moment = forces.couple.map(|c| -c);
        for (y, g) in self.corners.iter().zip(forces.gradient.chunks_exact(3)) {
            let part = cross(y, &[g[0], g[1], g[2]]);
            (0..3).for_each(|r| moment[r] += part[r]);
        }
        let turning = apply(&self.compliance, &moment);
        let mut gradient = forces.gradient;
        for (h, slope) in gradient.chunks_exact_mut(3).zip(&cell.gradients) {
            let part = cross(&turning, slope);
            (0..3).for_each(|r| h[r] -= part[r]);
        }
        PulledBack { turning, gradient }
    }

    /// The gradient with respect to the displacements of the corners, in world axes \[N\].
    pub fn gradient(&self, cell: &CoarseBox, forces: &LocalForces) -> Columns {
        if !self.rotates {
            return forces.gradient;
        }
        let local = self.pull_back(cell, forces).gradient;
        let mut world = [0.0; COLUMNS];
        for (f, h) in world.chunks_exact_mut(3).zip(local.chunks_exact(3)) {
            f.copy_from_slice(&apply(&self.rotation, &[h[0], h[1], h[2]]));
        }
        world
    }

    /// The Hessian with respect to the displacements of the corners, in world axes \[N/m\]; symmetric bit for bit. With `forces` it is exact;
    /// without, what the forces do as the frame turns is left out, and what remains is as definite as the curvature.
    ///
    /// v changes by J ξ to first order, J = I + Y Ω with Y the stacked \[y_i\]×; to second order the frame turns by w' with
    /// G w' = ax(½ \[w\]×² S − \[w\]× D), and v by −w' × y_i − w × ξ_i + ½ w × (w × y_i). Collected, the Hessian in the rotated frame is
    /// K + N Ω + Ωᵀ Nᵀ + Ωᵀ Z Ω with N = K Y + B − stack(\[h_i\]×),
    /// Z = Yᵀ K Y + Yᵀ B + Bᵀ Y + C + sym Γ − tr Γ I − sym(\[t\]× S) and Γ = Σ_i y_i ⊗ g_i.
    pub fn hessian(
        &self,
        cell: &CoarseBox,
        curvature: &LocalCurvature,
        forces: Option<&LocalForces>,
    ) -> [Columns; COLUMNS] {
        if !self.rotates {
            return curvature.stiffness;
        }
        let spin = self.spin(cell);
        // Rows of `side` are the columns of N, in the end those of N + ½ Ωᵀ Z.
        let mut side = turned(&curvature.stiffness, &self.corners);
        let mut square = turned_columns(&self.corners, &side);
        let mixed = turned_columns(&self.corners, &curvature.mixed);
        for (k, l) in (0..9).map(|n| (n / 3, n % 3)) {
            square[k][l] += mixed[k][l] + mixed[l][k] + curvature.rotational[k][l];
        }
        side.iter_mut().flatten().zip(curvature.mixed.iter().flatten()).for_each(|(n, b)| *n += b);
        if let Some(forces) = forces {
            let pulled = self.pull_back(cell, forces);
            self.add_turning(&pulled, forces, &mut side, &mut square);
        }
        for k in 0..3 {
            for c in 0..COLUMNS {
                side[k][c] += 0.5 * (0..3).map(|l| spin[l][c] * square[l][k]).sum::<f64>();
            }
        }
        let mut hessian = [[0.0; COLUMNS]; COLUMNS];
        combined(&curvature.stiffness, &side, &spin, &mut hessian);
        rotated(&self.rotation, &hessian)
    }

    fn add_turning(&self, pulled: &PulledBack, forces: &LocalForces, side: &mut [Columns; 3], square: &mut Matrix3) {
        for (i, h) in pulled.gradient.chunks_exact(3).enumerate() {
            let block = skew(&[h[0], h[1], h[2]]);
            (0..9).for_each(|n| side[n % 3][3 * i + n / 3] -= block[n / 3][n % 3]);
        }
        let mut change = product(&skew(&pulled.turning), &self.stretch).map(|row| row.map(|v| -v));
        for (y, g) in self.corners.iter().zip(forces.gradient.chunks_exact(3)) {
            (0..9).for_each(|n| change[n / 3][n % 3] += y[n / 3] * g[n % 3]);
            let work = y[0] * g[0] + y[1] * g[1] + y[2] * g[2];
            (0..3).for_each(|r| square[r][r] -= work);
        }
        (0..9).for_each(|n| square[n / 3][n % 3] += 0.5 * (change[n / 3][n % 3] + change[n % 3][n / 3]));
    }
}

/// Columns of K Y, each as a row, for a symmetric K: Y has the blocks \[y_i\]×.
fn turned(stiffness: &[Columns; COLUMNS], corners: &[[f64; 3]; 8]) -> [Columns; 3] {
    let mut columns = [[0.0; COLUMNS]; 3];
    for (i, y) in corners.iter().enumerate() {
        let block = skew(y);
        for (r, k) in (0..9).map(|n| (n / 3, n % 3)).filter(|(r, k)| r != k) {
            let factor = block[r][k];
            columns[k].iter_mut().zip(&stiffness[3 * i + r]).for_each(|(sum, entry)| *sum += factor * entry);
        }
    }
    columns
}

/// Yᵀ M for a 24×3 matrix M given by its columns.
fn turned_columns(corners: &[[f64; 3]; 8], columns: &[Columns; 3]) -> Matrix3 {
    let mut result = [[0.0; 3]; 3];
    for (l, column) in columns.iter().enumerate() {
        for (y, m) in corners.iter().zip(column.chunks_exact(3)) {
            // [y]×ᵀ m = m × y
            let part = cross(&[m[0], m[1], m[2]], y);
            (0..3).for_each(|k| result[k][l] += part[k]);
        }
    }
    result
}

#[cfg(test)]
mod tests;
