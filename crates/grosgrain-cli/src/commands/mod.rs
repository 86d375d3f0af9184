//! The commands, one file each.

mod convert;
mod inspect;

use clap::Subcommand;

use crate::failure::Failure;
use crate::progress::Progress;

/// A command with its arguments.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Says what volumes, scenes and models hold
    Inspect(inspect::Arguments),
    /// Converts a volume from one format to another
    Convert(convert::Arguments),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// What the user must know: see [`Failure`].
    pub fn run(&self, progress: &Progress) -> Result<(), Failure> {
        match self {
            Self::Inspect(arguments) => inspect::run(arguments, progress),
            Self::Convert(arguments) => convert::run(arguments, progress),
        }
    }
}
