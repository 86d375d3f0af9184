//! Voxel lattices and the bodies on them: what turns a volume or a pattern into a body, and what picks its parts.

mod components;
mod exact_rank;
mod hull;
mod labelling;
mod lattice;
mod modulus;
mod neighbourhood;
mod padding;
mod pattern;
mod resample;
mod selection;
mod spheres;
mod support;
mod surface;
mod uniform;
mod volume;
mod voxel_grid;
mod warp;

pub use components::{Components, Removed, keep_largest, remove_floating};
pub use hull::hull;
pub use labelling::{LabelRule, LabellingError, label_by_integers, label_by_rules};
pub use lattice::{Cell, Lattice, Node};
pub use modulus::{DensityLaw, ModulusError, ModulusField, ModulusLaw};
pub use neighbourhood::Neighbourhood;
pub use padding::{Crop, Padding, crop_to_body, pad_to_multiple};
pub use pattern::{Pattern, PatternError};
pub use resample::{ResampleError, resample};
pub use selection::{Axis, NodeSelection, PlaneAt, SelectionError, Selector};
pub use spheres::SphereCentres;
pub use support::{HeldBy, LoosePart, loose_parts, parts_loose_from_largest};
pub use surface::{BoundaryFace, boundary_faces};
pub use uniform::random_subset;
pub use volume::Volume;
pub use voxel_grid::{Label, VoxelGrid, VoxelGridError};
pub use warp::{WarpedBody, warp};
