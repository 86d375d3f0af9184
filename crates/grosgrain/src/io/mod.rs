//! Files.

pub mod vtk;
