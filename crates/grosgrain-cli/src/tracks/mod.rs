//! Runs under large deformation: fine and coarse models go through the same steps and edits side by side.

mod acting;
mod run;
mod track;

pub use acting::ground;
pub use run::{Momenta, Outcome, TrackStep, errors_against, failed_step, run};
pub use track::{Books, Kind, Track, Update};
