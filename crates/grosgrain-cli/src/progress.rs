//! What a run tells while it works: a bar on a terminal, plain lines elsewhere, nothing with `--quiet`.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use grosgrain::progress::SOLVING;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::interruption::is_interrupted;
use crate::quantities::{count, seconds};

/// How often plain lines are written within a stage.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// Where a run tells what it does; everything goes to stderr.
pub struct Progress {
    voice: Voice,
    stage: Mutex<Option<Stage>>,
}

enum Voice {
    Silent,
    Plain,
    Bar(ProgressBar),
}

struct Stage {
    name: &'static str,
    total: usize,
    start: Instant,
    last_line: Instant,
    /// How long it took, once its last piece is done.
    duration: Option<Duration>,
}

impl Progress {
    /// A bar on a terminal, plain lines elsewhere; nothing if `quiet`.
    pub fn new(quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        let voice = match (quiet, bar.is_hidden()) {
            (true, _) => Voice::Silent,
            (false, true) => Voice::Plain,
            (false, false) => Voice::Bar(bar),
        };
        Self { voice, stage: Mutex::new(None) }
    }

    /// Takes the report of a stage: `done` of `total` pieces; may be called from any thread.
    ///
    /// Returns `false` if the user has interrupted the run: the work is to stop.
    pub fn report(&self, name: &'static str, done: usize, total: usize) -> bool {
        let Ok(mut stage) = self.stage.lock() else { return !is_interrupted() };
        if stage.as_ref().is_none_or(|s| s.name != name) {
            self.finish(stage.take());
            *stage = Some(self.start(name, total));
        }
        match (&self.voice, stage.as_mut()) {
            (Voice::Bar(bar), _) => bar.set_position(bar.position().max(done as u64)),
            (Voice::Plain, Some(stage)) if stage.last_line.elapsed() >= PLAIN_INTERVAL => {
                stage.last_line = Instant::now();
                match name {
                    SOLVING => eprintln!("{name}: {done} %"),
                    _ => eprintln!("{name}: {} of {}", count(done), count(total)),
                }
            }
            _ => {}
        }
        if let Some(stage) = stage.as_mut().filter(|stage| done >= total && stage.duration.is_none()) {
            stage.duration = Some(stage.start.elapsed());
        }
        !is_interrupted()
    }

    /// Ends the running stage: its line is told if it was completed, and its bar goes.
    ///
    /// A stage ends here or with the next one, not with its last piece: other threads may still report earlier ones.
    pub fn close(&self) {
        let stage = self.stage.lock().map_or(None, |mut stage| stage.take());
        self.finish(stage);
    }

    /// Tells the user a sentence.
    pub fn say(&self, sentence: &str) {
        self.close();
        match &self.voice {
            Voice::Silent => {}
            Voice::Plain => eprintln!("{sentence}"),
            Voice::Bar(bar) => bar.suspend(|| eprintln!("{sentence}")),
        }
    }

    /// Warns the user, with `--quiet` too.
    pub fn warn(&self, sentence: &str) {
        self.close();
        let line = format!("warning: {sentence}");
        match &self.voice {
            Voice::Bar(bar) => bar.suspend(|| eprintln!("{line}")),
            _ => eprintln!("{line}"),
        }
    }

    fn start(&self, name: &'static str, total: usize) -> Stage {
        if let Voice::Bar(bar) = &self.voice {
            bar.reset();
            bar.set_length(total as u64);
            bar.set_style(style(name));
            bar.set_message(name);
        }
        let now = Instant::now();
        Stage { name, total, start: now, last_line: now, duration: None }
    }

    fn finish(&self, stage: Option<Stage>) {
        let Some(stage) = stage else { return };
        if let Voice::Bar(bar) = &self.voice {
            bar.finish_and_clear();
        }
        // Who solved tells the number of iterations.
        let is_told = matches!(self.voice, Voice::Silent) || stage.name == SOLVING;
        if let (Some(duration), false) = (stage.duration, is_told) {
            eprintln!("{}: {} in {}", stage.name, count(stage.total), seconds(duration.as_secs_f64()));
        }
    }
}

fn style(stage: &str) -> ProgressStyle {
    let template = match stage {
        SOLVING => "{msg} {bar:30} {percent} %, {eta} left",
        _ => "{msg} {bar:30} {human_pos} of {human_len}, {per_sec}, {eta} left",
    };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_stays_until_the_next_so_that_late_reports_of_other_threads_start_none() {
        let progress = Progress::new(true);
        let stage = |progress: &Progress| {
            progress.stage.lock().unwrap().as_ref().map(|s| (s.name, s.total, s.duration.is_some()))
        };
        assert!(progress.report("training", 1, 8));
        assert_eq!(stage(&progress), Some(("training", 8, false)));
        assert!(progress.report("training", 8, 8));
        assert!(progress.report("training", 7, 8));
        assert_eq!(stage(&progress), Some(("training", 8, true)));
        assert!(progress.report("fitting", 0, 4));
        assert_eq!(stage(&progress), Some(("fitting", 4, false)));
        progress.close();
        assert_eq!(stage(&progress), None);
    }
}
