//! The arguments that all commands share, and those of commands on scenes.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args, Parser};

use crate::commands::Command;
use crate::method::Method;

/// Coarse models of heterogeneous elastic bodies that move like the fine ones
#[derive(Debug, Parser)]
#[command(name = "grosgrain", version, after_help = EXAMPLES)]
pub struct Arguments {
    /// What to do
    #[command(subcommand)]
    pub command: Command,
    /// Number of threads; all cores without it. Results do not depend on it
    #[arg(long, global = true, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
    /// No progress on stderr; warnings and errors stay
    #[arg(long, global = true)]
    pub quiet: bool,
}

const EXAMPLES: &str = "Examples:
  grosgrain inspect data/ct_torso/example_ct.nii.gz
  grosgrain convert scan.nii.gz scan.nrrd";

/// The arguments of `coarsen`.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct CoarsenArguments {
    /// The scene, a TOML file
    pub scene: PathBuf,
    /// Where the coarse model is written; beside the scene without it
    #[arg(short, long, value_name = "MODEL.npz")]
    pub output: Option<PathBuf>,
    /// The method; the scene's training without it
    #[arg(long)]
    pub method: Option<Method>,
    /// Write the figures as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// The arguments of `simulate`.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct SimulateArguments {
    /// The scene, a TOML file
    pub scene: PathBuf,
    /// The folder that receives frames, pictures and report.json
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// The method; the scene's training without it
    #[arg(long)]
    pub method: Option<Method>,
}

/// The arguments of `compare`.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct CompareArguments {
    /// The scene, a TOML file
    pub scene: PathBuf,
    /// The methods, with commas between them; all without it
    #[arg(long, value_delimiter = ',', value_name = "A,B")]
    pub methods: Vec<Method>,
    /// Write the table as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}
