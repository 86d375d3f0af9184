//! Numerical coarsening of heterogeneous elastic solids.
//!
//! A fine voxel body in which every cell has its own material becomes a coarse
//! model with orders of magnitude fewer unknowns that moves like the fine one.
//! The modules stand in the order in which data flows; a module names only
//! modules above it (`tests/architecture.rs` checks that).
//!
//! Conventions: metres, pascals, kilograms, seconds; right-handed axes; grid
//! indices (i, j, k) along (x, y, z) with **x fastest** everywhere. A displacement
//! field u moves a point X to X + u.

pub mod linalg;
pub mod material;
pub mod mesh;
pub mod io;
