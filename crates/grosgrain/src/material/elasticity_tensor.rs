//! The 21-constant elasticity tensor.

/// An elasticity tensor in Voigt form: 6×6 \[Pa\], order xx, yy, zz, yz, xz, xy, engineering shear (γ = 2ε).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticityTensor {
    voigt: [[f64; 6]; 6],
}

/// Why an elasticity tensor is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElasticityTensorError {
    /// An entry is not finite.
    #[error("stiffness entry ({row}, {column}) is {value}; every entry must be finite")]
    NotFinite {
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// Entries above and below the diagonal differ.
    #[error(
        "the stiffness is not symmetric: entries ({row}, {column}) and ({column}, {row}) differ by {difference} Pa"
    )]
    Asymmetric {
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// Difference \[Pa\].
        difference: f64,
    },
    /// The tensor has a direction without stiffness.
    #[error("the stiffness is not positive definite: leading minor {order} is not positive")]
    NotPositiveDefinite {
        /// Order of the first leading minor that is not positive, from 1.
        order: usize,
    },
}

impl ElasticityTensor {
    /// A tensor from its Voigt matrix \[Pa\].
    ///
    /// # Errors
    /// Entries that are not finite, asymmetry beyond 1e-9 of the largest entry, a matrix that is not positive definite.
    pub fn from_voigt(voigt: [[f64; 6]; 6]) -> Result<Self, ElasticityTensorError> {
        let largest = voigt.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
        for row in 0..6 {
            for column in 0..6 {
                let value = voigt[row][column];
                if !value.is_finite() {
                    return Err(ElasticityTensorError::NotFinite { row, column, value });
                }
                let difference = (value - voigt[column][row]).abs();
                if difference > 1e-9 * largest {
                    return Err(ElasticityTensorError::Asymmetric { row, column, difference });
                }
            }
        }
        let symmetric = std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (voigt[i][j] + voigt[j][i])));
        match first_nonpositive_pivot(symmetric) {
            Some(order) => Err(ElasticityTensorError::NotPositiveDefinite { order }),
            None => Ok(Self { voigt: symmetric }),
        }
    }

    pub(crate) const fn from_voigt_unchecked(voigt: [[f64; 6]; 6]) -> Self {
        Self { voigt }
    }

    /// The Voigt matrix \[Pa\].
    pub const fn voigt(&self) -> &[[f64; 6]; 6] {
        &self.voigt
    }

    /// The Mandel (Kelvin) matrix \[Pa\]: shear rows and columns times √2, so that a double contraction is a matrix product.
    pub fn mandel(&self) -> [[f64; 6]; 6] {
        let weight = |i: usize| if i < 3 { 1.0 } else { std::f64::consts::SQRT_2 };
        std::array::from_fn(|i| std::array::from_fn(|j| weight(i) * weight(j) * self.voigt[i][j]))
    }

    /// Young's modulus along x \[Pa\]: 1 / S₁₁ with S = C⁻¹, by eliminating the other five strains from C₁₁.
    pub fn young_along_x(&self) -> f64 {
        let mut a = self.voigt;
        for k in (1..6).rev() {
            let pivot = a[k];
            for row in a.iter_mut().take(k) {
                let factor = row[k] / pivot[k];
                row.iter_mut().zip(pivot).for_each(|(v, p)| *v -= factor * p);
            }
        }
        a[0][0]
    }

    /// The tensor times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { voigt: self.voigt.map(|row| row.map(|v| factor * v)) }
    }
}

/// Order (from 1) of the first pivot of Gaussian elimination that is not positive.
fn first_nonpositive_pivot(mut a: [[f64; 6]; 6]) -> Option<usize> {
    let scale = (0..6).fold(0.0f64, |m, i| m.max(a[i][i].abs()));
    for k in 0..6 {
        if a[k][k] <= 1e-14 * scale {
            return Some(k + 1);
        }
        let pivot = a[k];
        for row in a.iter_mut().skip(k + 1) {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(pivot).for_each(|(v, p)| *v -= factor * p);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::IsotropicMaterial;

    #[test]
    fn young_along_x_of_an_isotropic_tensor_is_its_modulus() {
        let tensor = IsotropicMaterial::new(7.0, 0.4).unwrap().tensor();
        assert!((tensor.young_along_x() - 7.0).abs() < 1e-14 * 7.0);
    }

    #[test]
    fn mandel_contraction_equals_tensor_contraction() {
        let tensor = IsotropicMaterial::new(2.0, 0.3).unwrap().tensor();
        let shear = 0.1f64;
        let mandel_strain = 2.0f64.sqrt() * shear;
        let energy = mandel_strain * tensor.mandel()[5][5] * mandel_strain;
        assert!((energy - 4.0 * shear * shear * tensor.voigt()[5][5]).abs() < 1e-15);
    }

    #[test]
    fn indefinite_and_asymmetric_matrices_are_refused() {
        let mut voigt = *IsotropicMaterial::new(2.0, 0.3).unwrap().tensor().voigt();
        voigt[5][5] = -1.0;
        assert_eq!(ElasticityTensor::from_voigt(voigt), Err(ElasticityTensorError::NotPositiveDefinite { order: 6 }));
        voigt[5][4] = 1.0;
        assert!(matches!(ElasticityTensor::from_voigt(voigt), Err(ElasticityTensorError::Asymmetric { .. })));
    }
}
