//! The coarse model: Galerkin stiffness, lumped mass, and the map from coarse to fine displacements.

mod build;
mod embedding;
mod galerkin;
mod lattice;
mod model;
mod support;

pub use build::{BuildError, BuildOptions, BuildReport, Built, Method, build};
pub use embedding::Embedding;
pub use galerkin::galerkin_stiffness;
pub use lattice::CoarseLattice;
pub use model::CoarseModel;
pub use support::SupportedCoarse;
