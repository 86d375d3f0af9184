//! Abaqus input files (`.inp`), which CalculiX and many pre-processors read and write too.

mod constants;
mod deck;
mod elements;
mod lines;
mod names;
mod read;
mod sets;

pub use deck::{AbaqusDeck, AbaqusMaterials, AbaqusWriteError, write_abaqus};
pub use read::read_abaqus;
