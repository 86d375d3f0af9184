//! The coarse model under large rotations: every element in a frame that rotates with it (`muller2004interactive`, `he2022fast`).
//!
//! Energies of an element are functions of its displacement v in the rotated frame, of points that move with it, and of the rotation itself; the
//! rotation is a function of the corners, and all derivatives say so. `docs/theory/coarse-model.md` has the formulas.

mod cells;
mod elastic;
mod error;
mod frame;
mod integration;
mod linear_cells;
mod loads;
mod model;
mod place;
mod points;
mod potential;
mod products;
mod second_order;

pub use error::CorotatedError;
pub use integration::Integration;
pub use model::{Corotated, ElementEnergies};
pub use points::EmbeddedPoint;
pub use potential::{NO_POTENTIALS, NoPotential, Potential};
