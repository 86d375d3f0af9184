//! Films of runs: a strip of pictures and an animation, all runs side by side under one camera.

mod bodies;
mod footage;
mod reel;
mod scans;
mod simplices;

pub use bodies::Film;
pub use footage::FilmOptions;
pub use scans::{ScanFilm, ScanLook};
pub use simplices::SimplexFilm;
