//! The elastic energy of one cell and its derivatives.

use super::elasticity::SimplexMatrix;
use super::frame::{CellFrame, axial};
use crate::linalg::matrix3::{IDENTITY, Matrix3, product, skew, transposed};
use crate::material::Projection;
use crate::simplex::{Dimension, MandelTensor, SimplexMesh, mandel_strain};

/// Displacements of the corners \[m\]; those beyond d + 1 do not count.
pub(super) type Corners = [[f64; 3]; 4];

/// What the energy of a cell needs to know of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ElasticCell {
    dimension: Dimension,
    /// ∇λ_i \[1/m\], zero beyond d + 1.
    gradients: [[f64; 3]; 4],
    /// M = Σ_i (X_i − b₀)(X_i − b₀)ᵀ \[m²\].
    moment: Matrix3,
    /// C, times the measure of the cell.
    stiffness: [[f64; 6]; 6],
    /// Whether a frame rotates with the cell.
    rotates: bool,
}

/// ∂E/∂F in the frame, with what it was found by.
struct Stresses {
    frame: CellFrame,
    /// σ̂ = C ε with ε = sym(Y) − I.
    stress: Matrix3,
    /// t = −G⁻¹ ax(σ̂ Yᵀ).
    turning: [f64; 3],
    /// P̂ = σ̂ − \[t\]× M.
    pulled: Matrix3,
    energy: f64,
}

impl ElasticCell {
    pub fn new(mesh: &SimplexMesh, cell: usize, tensor: &MandelTensor, rotates: bool) -> Self {
        let corners = mesh.cell(cell).len();
        let places = |r: usize| (0..corners).map(move |n| mesh.corner(cell, n)[r]);
        let mean: [f64; 3] = std::array::from_fn(|r| places(r).sum::<f64>() / corners as f64);
        let entry = |r: usize, s: usize| places(r).zip(places(s)).map(|(x, y)| (x - mean[r]) * (y - mean[s])).sum();
        Self {
            dimension: mesh.dimension(),
            gradients: mesh.gradients(cell),
            moment: std::array::from_fn(|r| std::array::from_fn(|s| entry(r, s))),
            stiffness: tensor.scaled(mesh.measure(cell)).matrix,
            rotates,
        }
    }

    /// F = I + Σ_i u_i ⊗ ∇λ_i, by differences, so that far from rest it keeps its digits.
    fn deformation(&self, displacement: &Corners) -> Matrix3 {
        let mut gradient = IDENTITY;
        for n in 1..self.dimension.corners() {
            let edge: [f64; 3] = std::array::from_fn(|r| displacement[n][r] - displacement[0][r]);
            (0..9).for_each(|e| gradient[e / 3][e % 3] += edge[e / 3] * self.gradients[n][e % 3]);
        }
        gradient
    }

    fn frame(&self, displacement: &Corners) -> Option<CellFrame> {
        let gradient = self.deformation(displacement);
        match self.rotates {
            true => CellFrame::rotating(self.dimension, &gradient, &self.moment),
            false => Some(CellFrame::fixed(&gradient)),
        }
    }

    /// C times a strain, both Mandel vectors.
    fn stress(&self, strain: &[f64; 6]) -> [f64; 6] {
        std::array::from_fn(|i| self.stiffness[i].iter().zip(strain).map(|(c, e)| c * e).sum())
    }

    /// ½ ε : C : ε \[J\]; `None` where a displacement is not finite.
    pub fn energy(&self, displacement: &Corners) -> Option<f64> {
        self.frame(displacement).map(|frame| self.energy_in(&frame).0)
    }

    fn energy_in(&self, frame: &CellFrame) -> (f64, [f64; 6]) {
        let strain = mandel_strain(self.dimension, &difference(&frame.local, &IDENTITY));
        let stress = self.stress(&strain);
        (0.5 * strain.iter().zip(&stress).map(|(e, s)| e * s).sum::<f64>(), stress)
    }

    fn stresses(&self, displacement: &Corners) -> Option<Stresses> {
        let frame = self.frame(displacement)?;
        let (energy, stress) = self.energy_in(&frame);
        let stress = mandel_matrix(self.dimension, &stress);
        let turning = frame.turned_by(&axial(&product(&stress, &transposed(&frame.local))));
        let pulled = difference(&stress, &product(&skew(&turning), &self.moment));
        Some(Stresses { frame, stress, turning, pulled, energy })
    }

    /// Energy \[J\] and its gradient by the displacements of the corners \[N\].
    pub fn gradient(&self, displacement: &Corners) -> Option<(f64, Corners)> {
        let Stresses { frame, pulled, energy, .. } = self.stresses(displacement)?;
        let world = product(&frame.rotation, &pulled);
        let force = |n: usize| std::array::from_fn(|r| (0..3).map(|l| world[r][l] * self.gradients[n][l]).sum());
        Some((energy, std::array::from_fn(force)))
    }

    /// Second derivatives by the displacements of the corners \[N/m\], symmetric bit for bit. Exact, or without what the stress does as the frame turns,
    /// (∂ε/∂u)ᵀ C ∂ε/∂u, which is as definite as C.
    pub fn hessian(&self, displacement: &Corners, projection: Projection) -> Option<SimplexMatrix> {
        let stresses = self.stresses(displacement)?;
        let axes = self.dimension.axes();
        let mut columns = [[0.0; 9]; 9];
        let units = (0..9).filter(|n| n / 3 < axes && n % 3 < axes);
        for n in units.clone() {
            let mut unit = [[0.0; 3]; 3];
            unit[n / 3][n % 3] = 1.0;
            let column = match projection {
                Projection::Exact => self.exact_column(&stresses, &unit),
                Projection::PositiveSemidefinite => self.definite_column(&stresses.frame, &unit),
            };
            (0..9).for_each(|m| columns[n][m] = column[m / 3][m % 3]);
        }
        Some(self.at_corners(&columns, &stresses.frame.rotation))
    }

    /// dY = D − \[w\]× Y for a change R D of F, and w.
    fn change(&self, frame: &CellFrame, unit: &Matrix3) -> (Matrix3, [f64; 3]) {
        let w = frame.spin(unit, &self.moment);
        (difference(unit, &product(&skew(&w), &frame.local)), w)
    }

    /// Rᵀ dP: \[w\]× P̂ + dσ̂ − \[dt\]× M with dt = −G⁻¹ (ax(dσ̂ Yᵀ + σ̂ dYᵀ) + dG t).
    fn exact_column(&self, stresses: &Stresses, unit: &Matrix3) -> Matrix3 {
        let Stresses { frame, stress, turning, pulled, .. } = stresses;
        let (change, w) = self.change(frame, unit);
        let stress_change = mandel_matrix(self.dimension, &self.stress(&mandel_strain(self.dimension, &change)));
        let by_stress = axial(&product(&stress_change, &transposed(&frame.local)));
        let by_place = axial(&product(stress, &transposed(&change)));
        let by_stretch = frame.stiffening(unit, &self.moment, &w, turning);
        let turning_change = frame.turned_by(&std::array::from_fn(|k| by_stress[k] + by_place[k] + by_stretch[k]));
        let carried = product(&skew(&w), pulled);
        let turned = product(&skew(&turning_change), &self.moment);
        std::array::from_fn(|i| std::array::from_fn(|j| carried[i][j] + stress_change[i][j] - turned[i][j]))
    }

    /// The same for a stress that stays: J ᵀ C J D, J the derivative of the strain.
    fn definite_column(&self, frame: &CellFrame, unit: &Matrix3) -> Matrix3 {
        let (change, _) = self.change(frame, unit);
        let stress = mandel_matrix(self.dimension, &self.stress(&mandel_strain(self.dimension, &change)));
        let turning = frame.turned_by(&axial(&product(&stress, &transposed(&frame.local))));
        difference(&stress, &product(&skew(&turning), &self.moment))
    }

    /// From second derivatives by Rᵀ F, one column per entry, to those by the displacements of the corners in world axes.
    fn at_corners(&self, columns: &[[f64; 9]; 9], rotation: &Matrix3) -> SimplexMatrix {
        let g = &self.gradients;
        // Rows: corner and component in the frame; columns: entries of Rᵀ F.
        let mut half = [[0.0; 9]; 12];
        for (a, row) in half.iter_mut().enumerate() {
            let (n, i) = (a / 3, a % 3);
            for (entry, column) in row.iter_mut().zip(columns) {
                *entry = (0..3).map(|l| g[n][l] * column[3 * i + l]).sum();
            }
        }
        let mut matrix = [0.0; 144];
        for (n, m) in (0..4).flat_map(|n| (n..4).map(move |m| (n, m))) {
            let entry = |i: usize, p: usize| (0..3).map(|q| half[3 * n + i][3 * p + q] * g[m][q]).sum();
            let block: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|p| entry(i, p)));
            let block = product(&product(rotation, &block), &transposed(rotation));
            for (r, s) in (0..9).map(|e| (e / 3, e % 3)).filter(|(r, s)| n < m || r <= s) {
                matrix[12 * (3 * n + r) + 3 * m + s] = block[r][s];
                matrix[12 * (3 * m + s) + 3 * n + r] = block[r][s];
            }
        }
        matrix
    }
}

fn difference(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] - b[i][j]))
}

/// The symmetric matrix of a Mandel vector.
fn mandel_matrix(dimension: Dimension, v: &[f64; 6]) -> Matrix3 {
    let shear = |n: usize| std::f64::consts::FRAC_1_SQRT_2 * v[n];
    match dimension {
        Dimension::One => [[v[0], 0.0, 0.0], [0.0; 3], [0.0; 3]],
        Dimension::Two => [[v[0], shear(2), 0.0], [shear(2), v[1], 0.0], [0.0; 3]],
        Dimension::Three => [[v[0], shear(5), shear(4)], [shear(5), v[1], shear(3)], [shear(4), shear(3), v[2]]],
    }
}

#[cfg(test)]
mod tests;
