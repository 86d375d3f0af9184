//! The rotation and the stress that turn a coarse cell's deformation into a combination of harmonic displacements (KMOD09, `kharevych2009numerical`, eq. 9).

use crate::linalg::matrix3::{IDENTITY, Matrix3, determinant, inverse, polar, product, skew, transposed};
use crate::simplex::Dimension;

/// Gradients of harmonic displacements at a smaller angle to those before do not count as independent.
const DEPENDENT: f64 = 1e-6;
/// Steps of Newton's iteration; four are usual.
const STEPS: usize = 30;
/// Longest step \[rad\].
const LONGEST: f64 = 0.5;
/// A step \[rad\] below this is the last: the next would be its square.
const SETTLED: f64 = 1e-9;
/// Cosine of the largest angle between the rotation and that of the polar decomposition: 60°.
const NEAR: f64 = 0.5;

type Vector9 = [f64; 9];

/// What a cell needs to find its rotation: gradients A_n of the harmonic displacements, of which there are d (d + 1) / 2 in the d² dimensions of gradients.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CellRotation {
    dimension: Dimension,
    /// Rows of the pseudo-inverse of (A_1 … A_n).
    inverse: [Vector9; 6],
    /// Orthonormal basis of what no combination of A_n reaches, one vector per way to turn.
    complement: [Vector9; 3],
}

/// R F = I + Σ_n s_n A_n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turned {
    /// R.
    pub rotation: Matrix3,
    /// s_n \[Pa\]: S_αα for stretches, 2 S_αβ for shears.
    pub stress: [f64; 6],
}

fn dot(a: &Vector9, b: &Vector9) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn flat(m: &Matrix3) -> Vector9 {
    std::array::from_fn(|e| m[e / 3][e % 3])
}

/// Takes what lies along the orthonormal `basis` out of `vector`, twice against rounding, and returns what lay along each.
fn orthogonalise(vector: &mut Vector9, basis: &[Vector9]) -> [f64; 9] {
    let mut along = [0.0; 9];
    for (n, unit) in (0..2).flat_map(|_| basis.iter().enumerate()) {
        let part = dot(vector, unit);
        along[n] += part;
        vector.iter_mut().zip(unit).for_each(|(v, u)| *v -= part * u);
    }
    along
}

fn scaled(vector: &Vector9, factor: f64) -> Vector9 {
    vector.map(|v| factor * v)
}

impl CellRotation {
    /// From `gradients[n][k][l]` = ∂h_k/∂X_l \[1/Pa\] of the harmonic displacements; `None` where they are not independent.
    pub fn new(dimension: Dimension, gradients: &[Matrix3]) -> Option<Self> {
        let mut basis: Vec<Vector9> = Vec::with_capacity(9);
        // Â = Q T with Â_n = A_n / |A_n| and T upper triangular.
        let (mut triangle, mut lengths) = ([[0.0; 9]; 6], [0.0; 6]);
        for (n, gradient) in gradients.iter().enumerate() {
            let column = flat(gradient);
            lengths[n] = dot(&column, &column).sqrt();
            let mut rest = scaled(&column, 1.0 / lengths[n]);
            triangle[n] = orthogonalise(&mut rest, &basis);
            let left = dot(&rest, &rest).sqrt();
            // Not-a-number, of an empty column too, is refused.
            if !(left > DEPENDENT && left.is_finite()) {
                return None;
            }
            triangle[n][n] = left;
            basis.push(scaled(&rest, 1.0 / left));
        }
        let mut inverse = [[0.0; 9]; 6];
        for n in (0..gradients.len()).rev() {
            let mut row = basis[n];
            for m in n + 1..gradients.len() {
                (0..9).for_each(|e| row[e] -= triangle[m][n] * inverse[m][e] * lengths[m]);
            }
            inverse[n] = scaled(&row, 1.0 / (triangle[n][n] * lengths[n]));
        }
        Some(Self { dimension, inverse, complement: complement(dimension, &mut basis) })
    }

    /// The directions about which a cell can turn.
    fn turns(&self) -> &'static [[f64; 3]] {
        match self.dimension {
            Dimension::One => &[],
            Dimension::Two => &[[0.0, 0.0, 1.0]],
            Dimension::Three => &IDENTITY,
        }
    }

    /// R and s for a deformation gradient F, R being near Pᵀ of F = P U; `None` where F is inverted or no such rotation is found.
    ///
    /// R F − I has no part in the complement of the span of A_n: Newton's iteration R ← exp(\[w\]×) R with as many equations as ways to turn.
    pub fn turned(&self, gradient: &Matrix3) -> Option<Turned> {
        let size = determinant(gradient);
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let (of_polar, _) = polar(gradient);
        let (mut rotation, mut is_settled) = (transposed(&of_polar), false);
        for _ in 0..STEPS {
            let turned = product(&rotation, gradient);
            let step = self.step(&turned)?;
            let length = step.iter().map(|w| w * w).sum::<f64>().sqrt();
            let factor = (LONGEST / length).min(1.0);
            rotation = product(&rotation_by(&step.map(|w| factor * w)), &rotation);
            is_settled = length < SETTLED;
            if is_settled {
                break;
            }
        }
        let between = product(&rotation, &of_polar);
        let cosine = 0.5 * (between[0][0] + between[1][1] + between[2][2] - 1.0);
        let strain = less_identity(&product(&rotation, gradient));
        let stress = std::array::from_fn(|n| dot(&self.inverse[n], &strain));
        let is_found = is_settled && cosine > NEAR && stress.iter().all(|s| s.is_finite());
        is_found.then_some(Turned { rotation, stress })
    }

    /// w with N_i : (\[w\]× G) = −N_i : (G − I) for all i.
    fn step(&self, turned: &Matrix3) -> Option<[f64; 3]> {
        let (turns, strain) = (self.turns(), less_identity(turned));
        let (mut matrix, mut right) = (IDENTITY, [0.0; 3]);
        for (i, normal) in self.complement[..turns.len()].iter().enumerate() {
            right[i] = -dot(normal, &strain);
            for (j, axis) in turns.iter().enumerate() {
                matrix[i][j] = dot(normal, &flat(&product(&skew(axis), turned)));
            }
        }
        let inverse = inverse(&matrix)?;
        let mut step = [0.0; 3];
        for (j, axis) in turns.iter().enumerate() {
            let angle: f64 = (0..3).map(|i| inverse[j][i] * right[i]).sum();
            (0..3).for_each(|r| step[r] += angle * axis[r]);
        }
        step.iter().all(|w| w.is_finite()).then_some(step)
    }
}

/// Completes an orthonormal basis of the gradients of a dimension: each new vector comes from the unit gradient that has the most left.
fn complement(dimension: Dimension, basis: &mut Vec<Vector9>) -> [Vector9; 3] {
    let (axes, given) = (dimension.axes(), basis.len());
    let mut found = [[0.0; 9]; 3];
    for vector in &mut found[..axes * axes - given] {
        let rest = |e: usize| {
            let mut unit = [0.0; 9];
            unit[3 * (e / axes) + e % axes] = 1.0;
            orthogonalise(&mut unit, basis);
            let length = dot(&unit, &unit).sqrt();
            (length, scaled(&unit, 1.0 / length))
        };
        let best = (0..axes * axes).map(rest).max_by(|a, b| a.0.total_cmp(&b.0));
        *vector = best.map_or([0.0; 9], |(_, unit)| unit);
        basis.push(*vector);
    }
    found
}

fn less_identity(m: &Matrix3) -> Vector9 {
    std::array::from_fn(|e| m[e / 3][e % 3] - IDENTITY[e / 3][e % 3])
}

/// exp(\[w\]×) by Rodrigues' formula, I + sin θ / θ \[w\]× + 2 sin²(θ/2) / θ² \[w\]×².
fn rotation_by(w: &[f64; 3]) -> Matrix3 {
    let angle = w.iter().map(|w| w * w).sum::<f64>().sqrt();
    let (first, second) = match angle < 1e-8 {
        true => (1.0, 0.5),
        false => (angle.sin() / angle, 2.0 * ((0.5 * angle).sin() / angle).powi(2)),
    };
    let turn = skew(w);
    let square = product(&turn, &turn);
    std::array::from_fn(|i| std::array::from_fn(|j| IDENTITY[i][j] + first * turn[i][j] + second * square[i][j]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A gradient of the dimension, from numbers of [-1, 1).
    fn gradient(dimension: Dimension, numbers: &[f64]) -> Matrix3 {
        let axes = dimension.axes();
        std::array::from_fn(|i| std::array::from_fn(|j| if i < axes && j < axes { numbers[3 * i + j] } else { 0.0 }))
    }

    /// Strains of unit stresses of a soft material, disturbed by `share` of gradients of any kind.
    fn fields(dimension: Dimension, numbers: &[f64], share: f64) -> Vec<Matrix3> {
        let pairs: &[(usize, usize)] = match dimension {
            Dimension::One => &[(0, 0)],
            Dimension::Two => &[(0, 0), (1, 1), (0, 1)],
            Dimension::Three => &[(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)],
        };
        let field = |(n, (a, b)): (usize, &(usize, usize))| {
            let mut field = gradient(dimension, &numbers[9 * n..]).map(|row| row.map(|v| 1e-6 * share * v));
            field[*a][*b] += 0.5e-6;
            field[*b][*a] += 0.5e-6;
            field
        };
        pairs.iter().enumerate().map(field).collect()
    }

    fn deformation(dimension: Dimension, numbers: &[f64], turn: f64) -> Matrix3 {
        let strain = gradient(dimension, numbers);
        let stretched = std::array::from_fn(|i| std::array::from_fn(|j| IDENTITY[i][j] + 0.2 * strain[i][j]));
        let axis = match dimension {
            Dimension::One => [0.0; 3],
            Dimension::Two => [0.0, 0.0, turn],
            Dimension::Three => [0.3 * turn, -0.8 * turn, 0.5 * turn],
        };
        product(&rotation_by(&axis), &stretched)
    }

    proptest! {
        #[test]
        fn equation_nine_holds(
            numbers in prop::collection::vec(-1.0..1.0f64, 54), strain in prop::collection::vec(-1.0..1.0f64, 9), turn in -3.0..3.0f64, which in 0..3usize,
        ) {
            let dimension = [Dimension::One, Dimension::Two, Dimension::Three][which];
            let fields = fields(dimension, &numbers, 0.15);
            let cell = CellRotation::new(dimension, &fields).unwrap();
            let f = deformation(dimension, &strain, turn);
            let Turned { rotation, stress } = cell.turned(&f).unwrap();
            let (turned, unit) = (product(&rotation, &f), product(&rotation, &transposed(&rotation)));
            for (i, j) in (0..9).map(|e| (e / 3, e % 3)) {
                let combined: f64 = fields.iter().zip(stress).map(|(a, s)| s * a[i][j]).sum();
                prop_assert!((turned[i][j] - IDENTITY[i][j] - combined).abs() < 1e-12, "{turned:?}, {combined}");
                prop_assert!((unit[i][j] - IDENTITY[i][j]).abs() < 1e-13);
            }
        }

        /// In the plane the condition is a cos θ + b sin θ = c for the angle of R, with N the gradient orthogonal to all A_n.
        #[test]
        fn rotations_in_the_plane_are_those_of_the_closed_form(
            numbers in prop::collection::vec(-1.0..1.0f64, 27), strain in prop::collection::vec(-1.0..1.0f64, 9), turn in -3.0..3.0f64,
        ) {
            let fields = fields(Dimension::Two, &numbers, 0.2);
            let f = deformation(Dimension::Two, &strain, turn);
            // The generalised cross product of three vectors of four entries.
            let rows: Vec<[f64; 4]> = fields.iter().map(|a| [a[0][0], a[0][1], a[1][0], a[1][1]].map(|v| 1e6 * v)).collect();
            let minor = |k: usize| {
                let others: Vec<usize> = (0..4).filter(|c| *c != k).collect();
                let m: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|j| rows[i][others[j]]));
                if k.is_multiple_of(2) { determinant(&m) } else { -determinant(&m) }
            };
            let n: [f64; 4] = std::array::from_fn(minor);
            let a = n[0] * f[0][0] + n[1] * f[0][1] + n[2] * f[1][0] + n[3] * f[1][1];
            let b = -n[0] * f[1][0] - n[1] * f[1][1] + n[2] * f[0][0] + n[3] * f[0][1];
            let (middle, half) = (b.atan2(a), ((n[0] + n[3]) / a.hypot(b)).acos());
            let found = CellRotation::new(Dimension::Two, &fields).unwrap().turned(&f).unwrap().rotation;
            let angle = found[1][0].atan2(found[0][0]);
            let off = |exact: f64| (angle - exact).sin().abs() + 1.0 - (angle - exact).cos();
            prop_assert!(off(middle + half).min(off(middle - half)) < 1e-10, "{angle} for {middle} ± {half}");
        }
    }

    #[test]
    fn symmetric_gradients_turn_as_the_polar_decomposition_does() {
        let cell = CellRotation::new(Dimension::Three, &fields(Dimension::Three, &[0.0; 54], 0.0)).unwrap();
        let f = deformation(Dimension::Three, &[0.4, 0.9, -0.7, 0.1, -0.3, 0.6, 0.8, -0.2, 0.5], 2.5);
        let (found, expected) = (cell.turned(&f).unwrap(), polar(&f));
        for (i, j) in (0..9).map(|e| (e / 3, e % 3)) {
            assert!((found.rotation[i][j] - expected.0[j][i]).abs() < 1e-14);
        }
        assert!((1e-6 * found.stress[0] - (expected.1[0][0] - 1.0)).abs() < 1e-13);
        assert!((0.5e-6 * found.stress[3] - expected.1[1][2]).abs() < 1e-13);
    }

    #[test]
    fn dependent_fields_and_inverted_cells_have_no_rotation() {
        let mut dependent = fields(Dimension::Three, &[0.0; 54], 0.0);
        dependent[4] = dependent[3];
        assert_eq!(CellRotation::new(Dimension::Three, &dependent), None);
        dependent[4] = [[0.0; 3]; 3];
        assert_eq!(CellRotation::new(Dimension::Three, &dependent), None);
        let cell = CellRotation::new(Dimension::Two, &fields(Dimension::Two, &[0.0; 27], 0.0)).unwrap();
        let mirrored = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(cell.turned(&mirrored).is_none() && cell.turned(&[[f64::NAN; 3]; 3]).is_none());
        assert!(cell.turned(&IDENTITY).is_some());
    }
}
