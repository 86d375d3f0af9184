//! Ctrl-C: a run stops where it next reports progress; files are written beside and renamed, so none is left half-written.

use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Watches for Ctrl-C from now on. A second one ends the program at once.
///
/// # Errors
/// The system refuses the handler.
pub fn watch() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            exit(1);
        }
    })
    .map_err(|error| Failure::Failed(format!("Ctrl-C cannot be watched for: {error}")))
}

/// Whether the user has interrupted the program.
pub fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// Stops between two steps if the user has interrupted the program.
///
/// # Errors
/// [`Failure::Interrupted`].
pub fn check() -> Result<(), Failure> {
    if is_interrupted() { Err(Failure::Interrupted) } else { Ok(()) }
}
