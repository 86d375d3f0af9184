//! Ctrl-C: a run stops where it next reports progress, and unwinds so that unfinished files are removed.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// What unwinds through the library when the user interrupts it.
struct Unwinding;

/// Watches for Ctrl-C from now on. A second one ends the program at once.
///
/// # Errors
/// The system refuses the handler.
pub fn watch() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::SeqCst) {
            exit(1);
        }
    })
    .map_err(|error| Failure::Failed(format!("Ctrl-C cannot be watched for: {error}")))
}

/// Leaves the running computation if the user interrupted it; called where no result would be lost.
///
/// It unwinds without the message of a panic, through worker threads too, up to [`stoppable`].
pub fn stop_here_if_asked() {
    if INTERRUPTED.load(Ordering::Relaxed) {
        resume_unwind(Box::new(Unwinding));
    }
}

/// Runs `command` so that an interruption inside comes back as [`Failure::Interrupted`].
///
/// # Errors
/// Those of `command`; the interruption.
pub fn stoppable(command: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
    match catch_unwind(AssertUnwindSafe(command)) {
        Ok(result) => result,
        Err(payload) if payload.is::<Unwinding>() => Err(Failure::Interrupted),
        Err(payload) => resume_unwind(payload),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interruption_unwinds_through_workers_and_runs_destructors() {
        struct Guard<'a>(&'a AtomicBool);
        impl Drop for Guard<'_> {
            fn drop(&mut self) {
                self.0.store(true, Ordering::SeqCst);
            }
        }
        let removed = AtomicBool::new(false);
        INTERRUPTED.store(true, Ordering::SeqCst);
        let result = stoppable(|| {
            let _guard = Guard(&removed);
            rayon::join(stop_here_if_asked, || ());
            Ok(())
        });
        INTERRUPTED.store(false, Ordering::SeqCst);
        assert!(matches!(result, Err(Failure::Interrupted)));
        assert!(removed.load(Ordering::SeqCst));
    }
}
