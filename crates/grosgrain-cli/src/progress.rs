//! What a run tells while it works: a bar on a terminal, plain lines elsewhere, nothing with `--quiet`.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::interruption::stop_here_if_asked;
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
    /// This is where an interrupted run stops.
    pub fn report(&self, name: &'static str, done: usize, total: usize) {
        stop_here_if_asked();
        let Ok(mut stage) = self.stage.lock() else { return };
        if stage.as_ref().is_none_or(|s| s.name != name) {
            self.finish(stage.take());
            *stage = Some(self.start(name, total));
        }
        match (&self.voice, stage.as_mut()) {
            (Voice::Bar(bar), _) => bar.set_position(done as u64),
            (Voice::Plain, Some(stage)) if stage.last_line.elapsed() >= PLAIN_INTERVAL => {
                stage.last_line = Instant::now();
                eprintln!("{name}: {} of {}", count(done), count(total));
            }
            _ => {}
        }
        if done >= total {
            self.finish(stage.take());
        }
    }

    /// Tells the user a sentence.
    pub fn say(&self, sentence: &str) {
        match &self.voice {
            Voice::Silent => {}
            Voice::Plain => eprintln!("{sentence}"),
            Voice::Bar(bar) => bar.suspend(|| eprintln!("{sentence}")),
        }
    }

    /// Warns the user, with `--quiet` too.
    pub fn warn(&self, sentence: &str) {
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
            bar.set_style(style());
            bar.set_message(name);
        }
        let now = Instant::now();
        Stage { name, total, start: now, last_line: now }
    }

    fn finish(&self, stage: Option<Stage>) {
        let Some(stage) = stage else { return };
        let line =
            format!("{}: {} in {}", stage.name, count(stage.total), seconds(stage.start.elapsed().as_secs_f64()));
        match &self.voice {
            Voice::Silent => {}
            Voice::Plain => eprintln!("{line}"),
            Voice::Bar(bar) => {
                bar.finish_and_clear();
                eprintln!("{line}");
            }
        }
    }
}

fn style() -> ProgressStyle {
    let template = "{msg} {bar:30} {human_pos} of {human_len}, {per_sec}, {eta} left";
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
