//! The rotation of a cell.

use crate::linalg::Polar;
use crate::linalg::matrix3::{IDENTITY, Matrix3, apply, product, skew, transposed};
use crate::simplex::Dimension;

/// Below this share of the size of A, its trace in the rotated plane leaves the rotation undefined.
const COLLAPSED: f64 = 1e-9;

/// The rotation R of a cell and how it follows the deformation gradient F.
///
/// R minimises Σ_i |Rᵀ (x_i − b) − (X_i − b₀)|² over the corners, b and b₀ their means (`kharevych2009numerical`, §4.4): it is the rotation nearest to A = F M with
/// M = Σ_i (X_i − b₀)(X_i − b₀)ᵀ, A = R S. Inverted cells have one too, det R = 1 always.
///
/// A change R D of F turns the frame by R exp(\[w\]×) with G w = −ax(D M), G = tr(S) I − S and ax(B)_k = ε_ijk B_ij.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CellFrame {
    /// R.
    pub rotation: Matrix3,
    /// Y = Rᵀ F.
    pub local: Matrix3,
    stretch: Matrix3,
    compliance: Matrix3,
}

/// ε_ijk B_ij.
pub(super) fn axial(b: &Matrix3) -> [f64; 3] {
    [b[1][2] - b[2][1], b[2][0] - b[0][2], b[0][1] - b[1][0]]
}

impl CellFrame {
    /// The frame that stays.
    pub fn fixed(gradient: &Matrix3) -> Self {
        let none = [[0.0; 3]; 3];
        Self { rotation: IDENTITY, local: *gradient, stretch: none, compliance: none }
    }

    /// The frame that rotates with F = `gradient`, M being `moment`; `None` where F is not finite.
    pub fn rotating(dimension: Dimension, gradient: &Matrix3, moment: &Matrix3) -> Option<Self> {
        let turned = product(gradient, moment);
        let Polar { rotation, stretch, compliance } = match dimension {
            Dimension::One => return gradient[0][0].is_finite().then(|| Self::fixed(gradient)),
            Dimension::Two => in_plane(&turned)?,
            Dimension::Three => Polar::nearest(&turned)?,
        };
        Some(Self { rotation, local: product(&transposed(&rotation), gradient), stretch, compliance })
    }

    /// w for a change R D of F.
    pub fn spin(&self, change: &Matrix3, moment: &Matrix3) -> [f64; 3] {
        self.turned_by(&axial(&product(change, moment)))
    }

    /// −G⁻¹ v.
    pub fn turned_by(&self, v: &[f64; 3]) -> [f64; 3] {
        apply(&self.compliance, v).map(|w| -w)
    }

    /// What −G⁻¹ v changes by for a fixed v, `t` being its value, as the frame turns by w with a change R D of F: −G⁻¹ (dG t), where
    /// dG = tr(dS) I − dS and dS = D M − \[w\]× S. Returned before the multiplication by −G⁻¹.
    pub fn stiffening(&self, change: &Matrix3, moment: &Matrix3, w: &[f64; 3], t: &[f64; 3]) -> [f64; 3] {
        let (pushed, spun) = (product(change, moment), product(&skew(w), &self.stretch));
        let change: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|j| pushed[i][j] - spun[i][j]));
        let trace = change[0][0] + change[1][1] + change[2][2];
        let along = apply(&change, t);
        std::array::from_fn(|k| trace * t[k] - along[k])
    }
}

/// The rotation about z nearest to the x and y part of A.
fn in_plane(a: &Matrix3) -> Option<Polar> {
    let (cosine, sine) = (a[0][0] + a[1][1], a[1][0] - a[0][1]);
    let trace = cosine.hypot(sine);
    let size = (0..4).map(|n| a[n / 2][n % 2].powi(2)).sum::<f64>().sqrt();
    if !size.is_finite() {
        return None;
    }
    let is_defined = trace > COLLAPSED * size;
    let (c, s) = if is_defined { (cosine / trace, sine / trace) } else { (1.0, 0.0) };
    let mut compliance = [[0.0; 3]; 3];
    compliance[2][2] = if is_defined { 1.0 / trace } else { 0.0 };
    let shear = 0.5 * (c * (a[0][1] + a[1][0]) + s * (a[1][1] - a[0][0]));
    let stretch = [[c * a[0][0] + s * a[1][0], shear, 0.0], [shear, c * a[1][1] - s * a[0][1], 0.0], [0.0; 3]];
    Some(Polar { rotation: [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], stretch, compliance })
}
