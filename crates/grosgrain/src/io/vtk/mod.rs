//! VTK files for ParaView, pyvista and meshio: unstructured grids (`.vtu`) and time series of them (`.pvd`).
//!
//! Arrays are inline base64 of zlib blocks, little-endian, with `header_type="UInt64"`; connectivity and offsets are
//! `Int64`, cell types `UInt8`. Hexahedra go in with our corner order (x fastest) and tensors with our Voigt order
//! (xx, yy, zz, yz, xz, xy); the writer converts both to VTK's. Elasticity tensors keep our order, which the file names.
//!
//! Meshes of simplices are read from `.vtu` and from legacy `.vtk` in all encodings but LZ4 and LZMA.

mod cell_grid;
mod data_array;
mod encoding;
mod error;
mod numbers;
mod piece;
mod pvd;
mod read_legacy;
mod read_vtu;
mod simplex_grid;
mod vtu;

pub use data_array::{DataArray, Values};
pub use error::VtkError;
pub use pvd::{Frame, write_pvd};
pub use read_legacy::read_vtk_legacy;
pub use read_vtu::read_vtu;
pub use simplex_grid::{SimplexGrid, write_simplex_vtu};
pub use vtu::{UnstructuredGrid, write_vtu};
