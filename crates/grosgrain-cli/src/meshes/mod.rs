//! Bodies of simplices in a run: fine and coarse meshes side by side.

mod track;

pub use track::SimplexTrack;
