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
//!
//! Start with `examples/coarsen_beam.rs`. In short:
//!
//! ```
//! use grosgrain::coarse::{BuildOptions, build};
//! use grosgrain::fine::FineModel;
//! use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
//! use grosgrain::mesh::{Label, VoxelGrid};
//!
//! let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(1e5, 0.45)?);
//! let mut materials = MaterialTable::new();
//! materials.insert(Label(0), Material::linear("gel", elasticity, 1000.0));
//! let model = FineModel::new(VoxelGrid::uniform([8, 4, 4], [0.01; 3], Label(0)), &materials)?;
//! let coarse = build(&model, 2, &BuildOptions::default(), &grosgrain::progress::silent)?.model;
//! assert_eq!(coarse.elements().len(), 4 * 2 * 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod progress;
pub mod linalg;
pub mod mesh;
pub mod material;
pub mod simplex;
pub mod element;
pub mod assembly;
pub mod solver;
pub mod homogenization;
pub mod fine;
pub mod contact;
pub mod partition;
pub mod training;
pub mod coarsening;
pub mod coarse;
pub mod dynamics;
pub mod update;
pub mod io;
