//! Linear elasticity in the displacement gradient.

use super::ElasticityTensor;
use super::point_law::Matrix9;
use crate::linalg::matrix3::Matrix3;

/// The Voigt index of entry (i, j) of a symmetric tensor.
const VOIGT: [[usize; 3]; 3] = [[0, 5, 4], [5, 1, 3], [4, 3, 2]];

/// ψ = ½ ε:C:ε and P = C:ε with ε = sym F − I.
pub(super) fn stress(tensor: &ElasticityTensor, f: &Matrix3) -> (f64, Matrix3) {
    let strain = [f[0][0] - 1.0, f[1][1] - 1.0, f[2][2] - 1.0, f[1][2] + f[2][1], f[0][2] + f[2][0], f[0][1] + f[1][0]];
    let voigt: [f64; 6] = std::array::from_fn(|m| (0..6).map(|n| tensor.voigt()[m][n] * strain[n]).sum());
    let energy = 0.5 * (0..6).map(|m| strain[m] * voigt[m]).sum::<f64>();
    (energy, VOIGT.map(|row| row.map(|m| voigt[m])))
}

/// C with a full index for each entry of F.
pub(super) fn tangent(tensor: &ElasticityTensor) -> Matrix9 {
    let index = |n: usize| VOIGT[n / 3][n % 3];
    std::array::from_fn(|row| std::array::from_fn(|column| tensor.voigt()[index(row)][index(column)]))
}
