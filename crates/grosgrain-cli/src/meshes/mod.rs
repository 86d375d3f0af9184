//! Bodies of simplices in a run: fine and coarse meshes side by side, and how they are drawn.

mod coarse;
mod conditions;
mod cut;
mod doubts;
mod frames;
mod harmonic_picture;
mod input;
mod method;
mod model;
mod picture;
mod problem;
mod run;
mod run_picture;
mod skin;
mod support;
mod track;

pub use coarse::{CoarseMade, coarse_of, homogenized};
pub use conditions::MeshConditions;
pub use cut::MeshCut;
pub use doubts::{stiffened, tell_doubts, worst_of};
pub use frames::{MeshFrames, ShownCoarseMesh, ShownMesh};
pub use harmonic_picture::harmonic_panels;
pub use input::{LEAST_FILLED, NamedMesh, lattice_around, material_table, read_checked, tell_unused};
pub use method::MeshMethod;
pub use model::MeshRun;
pub use picture::{Paint, Posed, SimplexLook, simplex_view};
pub use problem::MeshProblem;
pub use run::{MeshStep, run};
pub use run_picture::{DrawnMeshes, Skins, legend};
pub use skin::SimplexSkin;
pub use support::{Loose, Support};
pub use track::SimplexTrack;
