//! The commands, one file each.

mod coarsen;
mod compare;
mod convert;
mod homogenize;
mod inspect;
mod reproduce;
mod simulate;

use clap::Subcommand;

use crate::failure::Failure;
use crate::progress::Progress;

/// A command with its arguments.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Says what volumes, meshes, scenes and models hold
    Inspect(inspect::Arguments),
    /// Trains and fits the coarse model of a scene's body
    Coarsen(coarsen::Arguments),
    /// Runs a scene: coarsens its body, solves, writes frames, picture and report
    Simulate(simulate::Arguments),
    /// Runs the fine model and coarse methods on the same scene and tables their errors
    Compare(compare::Arguments),
    /// Runs a table or figure of the papers again and prints it next to the published figures
    Reproduce(reproduce::Arguments),
    /// Effective elasticity tensors of a coarse mesh from a fine one with a material per cell
    Homogenize(homogenize::Arguments),
    /// Converts a volume or a mesh from one format to another
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
            Self::Coarsen(arguments) => coarsen::run(arguments, progress),
            Self::Simulate(arguments) => simulate::run(arguments, progress),
            Self::Compare(arguments) => compare::run(arguments, progress),
            Self::Reproduce(arguments) => reproduce::run(arguments, progress),
            Self::Homogenize(arguments) => homogenize::run(arguments, progress),
            Self::Convert(arguments) => convert::run(arguments, progress),
        }
    }
}
