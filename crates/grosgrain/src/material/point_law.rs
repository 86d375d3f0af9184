//! Energy, stress and tangent of a material at one point.

use super::{Elasticity, ElasticityTensor, Law, Material, corotational, linear, neo_hookean};
use crate::linalg::matrix3::Matrix3;

/// ∂P/∂F \[Pa\]: row and column 3 i + j belong to entry (i, j) of P and of F.
pub type Matrix9 = [[f64; 9]; 9];

/// What is done with directions in which the energy is concave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Nothing: the tangent is the derivative of the stress.
    Exact,
    /// Negative eigenvalues of ∂P/∂F are set to zero, so that Newton's method on a sum of energies always descends.
    PositiveSemidefinite,
}

/// A hyperelastic law at one point: the energy per reference volume ψ(F) of the deformation gradient F = I + ∂u/∂X.
///
/// All laws have the same tangent at F = I. Formulas: `docs/theory/large-deformation.md`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a copy lives for one cell or one material, never for each point")]
pub enum PointLaw {
    /// ψ = ½ ε:C:ε with ε = sym F − I: small displacements only.
    Linear(ElasticityTensor),
    /// ψ = μ ‖S − I‖² + λ/2 tr(S − I)² with F = R S (`sifakis2012fem`). Finite for inverted points too.
    Corotational {
        /// Lamé's first constant λ \[Pa\].
        lambda: f64,
        /// The shear modulus μ \[Pa\].
        mu: f64,
    },
    /// ψ = μ/2 (‖F‖² − 3) − μ ln J + λ/2 (ln J)² with J = det F (`bonet2008nonlinear`).
    NeoHookean {
        /// Lamé's first constant λ \[Pa\].
        lambda: f64,
        /// The shear modulus μ \[Pa\].
        mu: f64,
    },
}

impl PointLaw {
    /// The law of a material whose moduli are multiplied by `factor`. An anisotropic one is linear, whatever its [`Law`]:
    /// [`FineModel::new`](../fine/struct.FineModel.html#method.new) refuses other combinations.
    pub fn of(material: &Material, factor: f64) -> Self {
        match (&material.elasticity, material.law) {
            (Elasticity::Isotropic(constants), Law::Corotational) => {
                let (lambda, mu) = constants.lame();
                Self::Corotational { lambda: factor * lambda, mu: factor * mu }
            }
            (Elasticity::Isotropic(constants), Law::NeoHookean) => {
                let (lambda, mu) = constants.lame();
                Self::NeoHookean { lambda: factor * lambda, mu: factor * mu }
            }
            (elasticity, _) => Self::Linear(elasticity.tensor().scaled(factor)),
        }
    }

    /// ψ(F) \[J/m³\]; `None` where the point is inverted and the law has no energy there (neo-Hookean with det F ≤ 0).
    pub fn energy(&self, f: &Matrix3) -> Option<f64> {
        match *self {
            Self::Linear(ref tensor) => Some(linear::stress(tensor, f).0),
            Self::Corotational { lambda, mu } => Some(corotational::energy(lambda, mu, f)),
            Self::NeoHookean { lambda, mu } => neo_hookean::energy(lambda, mu, f),
        }
    }

    /// ψ(F) \[J/m³\] and the first Piola–Kirchhoff stress P = ∂ψ/∂F \[Pa\]; `None` as for [`energy`](Self::energy).
    pub fn stress(&self, f: &Matrix3) -> Option<(f64, Matrix3)> {
        match *self {
            Self::Linear(ref tensor) => Some(linear::stress(tensor, f)),
            Self::Corotational { lambda, mu } => Some(corotational::stress(lambda, mu, f)),
            Self::NeoHookean { lambda, mu } => neo_hookean::stress(lambda, mu, f),
        }
    }

    /// ψ(F) \[J/m³\], P \[Pa\] and ∂P/∂F \[Pa\]; `None` as for [`energy`](Self::energy).
    pub fn tangent(&self, f: &Matrix3, projection: Projection) -> Option<(f64, Matrix3, Matrix9)> {
        match *self {
            Self::Linear(ref tensor) => {
                let (energy, stress) = linear::stress(tensor, f);
                Some((energy, stress, linear::tangent(tensor)))
            }
            Self::Corotational { lambda, mu } => Some(corotational::tangent(lambda, mu, f, projection)),
            Self::NeoHookean { lambda, mu } => neo_hookean::tangent(lambda, mu, f, projection),
        }
    }
}

#[cfg(test)]
mod tests;
