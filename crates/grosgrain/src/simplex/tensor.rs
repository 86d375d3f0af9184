//! Elasticity in one, two or three dimensions as a Mandel matrix.

use super::Dimension;
use crate::material::ElasticityTensor;

/// Which of xx, yy, zz, yz, xz, xy a dimension has.
const COMPONENTS: [&[usize]; 3] = [&[0], &[0, 1, 5], &[0, 1, 2, 3, 4, 5]];

/// A symmetric map of symmetric tensors as a Mandel (Kelvin) matrix \[Pa\]: shear rows and columns carry √2, so that a double contraction is a matrix
/// product and the inverse tensor is the inverse matrix.
///
/// n × n with n = d (d + 1) / 2 and order xx | xx, yy, xy | xx, yy, zz, yz, xz, xy; entries beyond n are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MandelTensor {
    /// Of the space.
    pub dimension: Dimension,
    /// The matrix.
    pub matrix: [[f64; 6]; 6],
}

impl MandelTensor {
    /// The tensor of a material: as it is in three dimensions, in plane strain in two, of a bar (its Young's modulus along x) in one.
    pub fn of_material(dimension: Dimension, material: &ElasticityTensor) -> Self {
        let mut matrix = [[0.0; 6]; 6];
        if dimension == Dimension::One {
            matrix[0][0] = material.young_along_x();
            return Self { dimension, matrix };
        }
        let (full, components) = (material.mandel(), COMPONENTS[dimension.axes() - 1]);
        for (i, from) in components.iter().enumerate() {
            for (j, to) in components.iter().enumerate() {
                matrix[i][j] = full[*from][*to];
            }
        }
        Self { dimension, matrix }
    }

    /// The Voigt matrix \[Pa\] in the same order, engineering shear (γ = 2ε).
    pub fn voigt(&self) -> [[f64; 6]; 6] {
        let axes = self.dimension.axes();
        let weight = |i: usize| if i < axes { 1.0 } else { std::f64::consts::FRAC_1_SQRT_2 };
        std::array::from_fn(|i| std::array::from_fn(|j| weight(i) * weight(j) * self.matrix[i][j]))
    }

    /// n, the number of rows.
    pub fn rows(&self) -> usize {
        self.dimension.strains()
    }

    /// The tensor times a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { matrix: self.matrix.map(|row| row.map(|value| factor * value)), ..*self }
    }

    /// ε : C : ε for a strain in Mandel form.
    pub fn quadratic(&self, strain: &[f64; 6]) -> f64 {
        let row = |i: usize| -> f64 { self.matrix[i].iter().zip(strain).map(|(c, e)| c * e).sum() };
        (0..6).map(|i| strain[i] * row(i)).sum()
    }
}

/// The symmetric part of a displacement gradient `gradient[r][c]` = ∂u_r/∂x_c as a Mandel vector: xx | xx, yy, √2 xy | xx, yy, zz, √2 yz, √2 xz, √2 xy.
pub fn mandel_strain(dimension: Dimension, gradient: &[[f64; 3]; 3]) -> [f64; 6] {
    let shear = |a: usize, b: usize| std::f64::consts::FRAC_1_SQRT_2 * (gradient[a][b] + gradient[b][a]);
    let [xx, yy, zz] = [0, 1, 2].map(|i| gradient[i][i]);
    match dimension {
        Dimension::One => [xx, 0.0, 0.0, 0.0, 0.0, 0.0],
        Dimension::Two => [xx, yy, shear(0, 1), 0.0, 0.0, 0.0],
        Dimension::Three => [xx, yy, zz, shear(1, 2), shear(0, 2), shear(0, 1)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::IsotropicMaterial;

    #[test]
    fn energies_are_those_of_hookes_law_in_every_dimension() {
        let (young, poisson) = (7.0, 0.3);
        let material = IsotropicMaterial::new(young, poisson).unwrap().tensor();
        let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        let shear = young / (2.0 * (1.0 + poisson));
        let gradient = [[0.2, -0.4, 0.1], [0.9, 0.5, -0.3], [0.7, 0.6, -0.8]];
        for dimension in [Dimension::Two, Dimension::Three] {
            let axes = dimension.axes();
            let strain = |i: usize, j: usize| 0.5 * (gradient[i][j] + gradient[j][i]);
            let trace: f64 = (0..axes).map(|i| strain(i, i)).sum();
            let square: f64 = (0..axes * axes).map(|n| strain(n / axes, n % axes).powi(2)).sum();
            let tensor = MandelTensor::of_material(dimension, &material);
            let found = tensor.quadratic(&mandel_strain(dimension, &gradient));
            assert!((found - lambda * trace * trace - 2.0 * shear * square).abs() < 1e-13, "{dimension}: {found}");
            assert!((tensor.voigt()[axes][axes] - shear).abs() < 1e-14, "engineering shear");
        }
        let bar = MandelTensor::of_material(Dimension::One, &material);
        assert!(
            (bar.scaled(2.0).quadratic(&mandel_strain(Dimension::One, &gradient)) - 2.0 * young * 0.04).abs() < 1e-13
        );
    }
}
