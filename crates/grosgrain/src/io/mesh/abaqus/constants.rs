//! The order of elastic constants in Abaqus input files.

use crate::simplex::{Dimension, MandelTensor};

/// Abaqus' components 11, 22, 33, 12, 13, 23 in our order xx, yy, zz, yz, xz, xy.
const COMPONENTS: [usize; 6] = [0, 1, 2, 5, 4, 3];
/// Our components of plane strain (xx, yy, xy) in Abaqus' order.
const PLANE: [usize; 3] = [0, 1, 3];

/// The 21 constants of `*ELASTIC, TYPE=ANISOTROPIC`: the upper triangle of the matrix that maps strains 11, 22, 33, γ12, γ13, γ23 to stresses, column
/// by column: D1111, D1122, D2222, D1133, D2233, D3333, D1112, D2212, D3312, D1212, D1113, D2213, D3313, D1213, D1313, D1123, D2223, D3323, D1223,
/// D1323, D2323 \[abaqus2024keywords\]. None in one dimension.
pub(super) fn constants(tensor: &MandelTensor) -> Option<[f64; 21]> {
    let voigt = tensor.voigt();
    let mut matrix = [[0.0; 6]; 6];
    match tensor.dimension {
        Dimension::One => return None,
        Dimension::Two => {
            let largest = (0..3).map(|i| voigt[i][i]).fold(0.0, f64::max);
            (0..6).for_each(|i| matrix[i][i] = largest);
            for (i, row) in PLANE.into_iter().enumerate() {
                PLANE.into_iter().enumerate().for_each(|(j, column)| matrix[row][column] = voigt[i][j]);
            }
        }
        Dimension::Three => {
            matrix = COMPONENTS.map(|row| COMPONENTS.map(|column| voigt[row][column]));
        }
    }
    let mut constants = [0.0; 21];
    let upper = (0..6).flat_map(|column| (0..=column).map(move |row| (row, column)));
    constants.iter_mut().zip(upper).for_each(|(constant, (row, column))| *constant = matrix[row][column]);
    Some(constants)
}

/// Young's modulus of a bar along x.
pub(super) fn young_of_bar(tensor: &MandelTensor) -> f64 {
    tensor.matrix[0][0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simplex::mandel_strain;

    /// As printed in the manual, three lines of 8, 8 and 5 constants.
    const MANUAL: [[u8; 4]; 21] = [
        *b"1111", *b"1122", *b"2222", *b"1133", *b"2233", *b"3333", *b"1112", *b"2212", // first line
        *b"3312", *b"1212", *b"1113", *b"2213", *b"3313", *b"1213", *b"1313", *b"1123", // second line
        *b"2223", *b"3323", *b"1223", *b"1323", *b"2323",
    ];

    /// ½ (e_i ⊗ e_j + e_j ⊗ e_i) in Mandel form, for indices as letters from 1.
    fn dyad(dimension: Dimension, i: u8, j: u8) -> [f64; 6] {
        let mut gradient = [[0.0; 3]; 3];
        gradient[usize::from(i - b'1')][usize::from(j - b'1')] = 1.0;
        mandel_strain(dimension, &gradient)
    }

    /// D_ijkl = E_ij : C : E_kl, from the definition of the tensor and not through Voigt's matrix.
    fn component(tensor: &MandelTensor, [i, j, k, l]: [u8; 4]) -> f64 {
        let (left, right) = (dyad(tensor.dimension, i, j), dyad(tensor.dimension, k, l));
        (0..6).flat_map(|r| (0..6).map(move |c| (r, c))).map(|(r, c)| left[r] * tensor.matrix[r][c] * right[c]).sum()
    }

    /// A symmetric matrix whose 21 entries all differ: no symmetry of the material hides a wrong place.
    fn without_symmetry(dimension: Dimension) -> MandelTensor {
        let n = dimension.strains();
        let entry = |i: usize, j: usize| match i.max(j) < n {
            true => (0.05 * (6 * i.min(j) + i.max(j)) as f64).exp() + if i == j { 20.0 } else { 0.0 },
            false => 0.0,
        };
        MandelTensor { dimension, matrix: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))) }
    }

    #[test]
    fn the_21_constants_stand_in_the_order_of_the_manual() {
        let tensor = without_symmetry(Dimension::Three);
        let found = constants(&tensor).unwrap();
        for (found, name) in found.iter().zip(MANUAL) {
            let expected = component(&tensor, name);
            assert!((found - expected).abs() < 1e-14 * expected.abs(), "D{}: {found}", String::from_utf8_lossy(&name));
        }
        let mut different = found;
        different.sort_by(f64::total_cmp);
        assert!(different.windows(2).all(|pair| pair[1] - pair[0] > 1e-3), "{different:?}");
    }

    #[test]
    fn plane_strain_keeps_its_six_constants_and_is_positive_definite_beside_them() {
        let tensor = without_symmetry(Dimension::Two);
        for (found, name) in constants(&tensor).unwrap().iter().zip(MANUAL) {
            let text = String::from_utf8_lossy(&name);
            let expected = match () {
                () if !name.contains(&b'3') => component(&tensor, name),
                () if ["3333", "1313", "2323"].contains(&&*text) => component(&tensor, *b"2222"),
                () => 0.0,
            };
            assert!((found - expected).abs() < 1e-14 * tensor.matrix[1][1], "D{text}: {found}, not {expected}");
        }
        let bar = without_symmetry(Dimension::One);
        assert!(constants(&bar).is_none() && young_of_bar(&bar) == component(&bar, *b"1111"));
    }
}
