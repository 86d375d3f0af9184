//! Films of runs: a strip of pictures and an animation, all runs side by side under one camera.

mod bodies;
mod reel;
mod scans;

pub use bodies::{Film, FilmOptions};
pub use scans::{ScanFilm, ScanLook};
