//! Isotropic linear elasticity.

use super::ElasticityTensor;

/// An isotropic linear elastic material.
///
/// σ = λ tr(ε) I + 2 μ ε with λ = E ν / ((1 + ν)(1 − 2ν)), μ = E / (2 (1 + ν)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsotropicMaterial {
    young: f64,
    poisson: f64,
}

/// Why elastic constants are refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IsotropicMaterialError {
    /// E is not a positive finite number.
    #[error("Young's modulus {0} Pa must be positive and finite")]
    Young(f64),
    /// ν lies outside (−1, ½).
    #[error("Poisson's ratio {0} must lie between -1 and 0.5, both excluded")]
    Poisson(f64),
}

impl IsotropicMaterial {
    /// A material of Young's modulus `young` \[Pa\] and Poisson's ratio `poisson`.
    ///
    /// # Errors
    /// E ≤ 0 or not finite; ν outside (−1, ½).
    pub fn new(young: f64, poisson: f64) -> Result<Self, IsotropicMaterialError> {
        if !(young.is_finite() && young > 0.0) {
            return Err(IsotropicMaterialError::Young(young));
        }
        if !(poisson > -1.0 && poisson < 0.5) {
            return Err(IsotropicMaterialError::Poisson(poisson));
        }
        Ok(Self { young, poisson })
    }

    /// Young's modulus E \[Pa\].
    pub const fn young(&self) -> f64 {
        self.young
    }

    /// Poisson's ratio ν.
    pub const fn poisson(&self) -> f64 {
        self.poisson
    }

    /// Lamé's constants (λ, μ) \[Pa\].
    pub fn lame(&self) -> (f64, f64) {
        let (e, nu) = (self.young, self.poisson);
        (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
    }

    /// The elasticity tensor in Voigt form \[Pa\].
    pub fn tensor(&self) -> ElasticityTensor {
        let (lambda, mu) = self.lame();
        let mut c = [[0.0; 6]; 6];
        for (i, row) in c.iter_mut().enumerate().take(3) {
            row[..3].fill(lambda);
            row[i] += 2.0 * mu;
        }
        for (i, row) in c.iter_mut().enumerate().skip(3) {
            row[i] = mu;
        }
        ElasticityTensor::from_voigt_unchecked(c)
    }
}
