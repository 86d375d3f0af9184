//! Forces at single points of the body: springs, and a ground with friction.
//!
//! A potential knows a point's position in space only. The fine model puts it on nodes, the coarse one on embedded points, so
//! that both feel the same ground.

mod friction;
mod ground;
mod potential;
mod simplex_surface;
mod surface;

pub use friction::Grip;
pub use ground::Ground;
pub use potential::{PointPotential, PointResponse};
pub use simplex_surface::simplex_surface_areas;
pub use surface::surface_areas;
