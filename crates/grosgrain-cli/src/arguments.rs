//! The arguments that all commands share.

use std::num::NonZeroUsize;

use clap::Parser;

use crate::commands::Command;

/// Coarse models of heterogeneous elastic bodies that move like the fine ones
#[derive(Debug, Parser)]
#[command(name = "grosgrain", version, after_help = EXAMPLES)]
pub struct Arguments {
    /// What to do
    #[command(subcommand)]
    pub command: Command,
    /// Number of threads; all cores without it. Results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = parse_threads)]
    pub threads: Option<NonZeroUsize>,
    /// No progress on stderr; warnings and errors stay
    #[arg(long, global = true)]
    pub quiet: bool,
}

fn parse_threads(text: &str) -> Result<NonZeroUsize, String> {
    text.parse().map_err(|_| "expected a whole number of at least 1; leave the option out for all cores".into())
}

const EXAMPLES: &str = "Examples:
  grosgrain inspect data/ct_torso/example_ct.nii.gz
  grosgrain simulate scenes/torso.toml -o out/torso";
