//! Entry point of the program `grosgrain`.

use std::process::ExitCode;

use clap::Parser;
use grosgrain_cli::arguments::Arguments;
use grosgrain_cli::failure::Failure;
use grosgrain_cli::interruption::{is_interrupted, watch};
use grosgrain_cli::progress::Progress;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::ReaderGone) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            failure.exit_code()
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    watch()?;
    let threads = arguments.threads.map_or(0, |n| n.get());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    pool.map_err(|error| Failure::Failed(format!("the threads cannot be started: {error}")))?;
    let progress = Progress::new(arguments.quiet);
    let result = arguments.command.run(&progress);
    progress.close();
    // Whatever stage stopped, the user's Ctrl-C is the reason.
    if result.is_err() && is_interrupted() { Err(Failure::Interrupted) } else { result }
}
