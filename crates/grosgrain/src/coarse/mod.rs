//! The coarse model: Galerkin stiffness, lumped mass, the map from coarse to fine displacements, and energies under large rotations.

mod build;
mod corotated;
mod embedding;
mod galerkin;
mod lattice;
mod model;
mod support;

pub use build::{BuildError, BuildOptions, BuildReport, Built, Method, build};
pub use corotated::{
    Corotated, CorotatedError, ElementEnergies, EmbeddedPoint, Integration, NO_POTENTIALS, NoPotential, Potential,
};
pub use embedding::Embedding;
pub use galerkin::galerkin_stiffness;
pub use lattice::CoarseLattice;
pub use model::CoarseModel;
pub use support::{PenaltyPoint, SupportedCoarse};
