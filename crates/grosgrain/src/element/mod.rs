//! Finite elements, one per file.

mod hex8;
mod quadrature;

pub use hex8::{CellMatrix, Hex8, trilinear, trilinear_gradients};
pub use quadrature::{QuadraturePoint, gauss_2x2x2};
