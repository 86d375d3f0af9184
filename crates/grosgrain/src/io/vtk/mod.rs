//! VTK files for ParaView, pyvista and meshio: unstructured grids (`.vtu`) and time series of them (`.pvd`).
//!
//! Arrays are inline base64 of zlib blocks, little-endian, with `header_type="UInt64"`; connectivity and offsets are
//! `Int64`, cell types `UInt8`. Hexahedra go in with our corner order (x fastest) and tensors with our Voigt order
//! (xx, yy, zz, yz, xz, xy); the writer converts both to VTK's.

mod data_array;
mod encoding;
mod error;
mod pvd;
mod vtu;

pub use data_array::{DataArray, Values};
pub use error::VtkError;
pub use pvd::{Frame, write_pvd};
pub use vtu::{UnstructuredGrid, write_vtu};
