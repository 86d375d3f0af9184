//! Medians and spreads of run times.

use std::time::Instant;

/// Which cases are measured, and how often.
pub struct Effort {
    pub samples: usize,
    pub largest_degree: usize,
    pub largest_coupled: usize,
    pub largest_simplicial: usize,
    pub lattices: &'static [usize],
    pub iterative: &'static [usize],
    /// Steps in time of the coarse and of the fine model of a body.
    pub steps: [usize; 2],
    /// Whether the largest moving body is stepped.
    pub largest_motion: bool,
}

impl Effort {
    pub fn full() -> Self {
        Self {
            samples: 15,
            largest_degree: 7,
            largest_coupled: 4,
            largest_simplicial: 4,
            lattices: &[16, 24, 32],
            iterative: &[32, 64],
            steps: [60, 20],
            largest_motion: true,
        }
    }

    pub fn quick() -> Self {
        Self {
            samples: 3,
            largest_degree: 2,
            largest_coupled: 2,
            largest_simplicial: 2,
            lattices: &[4],
            iterative: &[8],
            steps: [3, 2],
            largest_motion: false,
        }
    }
}

/// Samples of a batch last at least this long [s], so that the clock's resolution does not matter.
const BATCH: f64 = 1e-3;
/// Samples are fewer when all together would last longer than this [s].
const BUDGET: f64 = 15.0;

/// Seconds of one run.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    pub median: f64,
    pub low: f64,
    pub high: f64,
}

/// Times `run`: one run to warm up, then `samples` batches, at least three.
pub fn measure<T>(samples: usize, mut run: impl FnMut() -> T) -> Spread {
    let mut batch = |count: usize| {
        let start = Instant::now();
        (0..count).for_each(|_| drop(std::hint::black_box(run())));
        start.elapsed().as_secs_f64() / count as f64
    };
    let first = batch(1).min(batch(1));
    let count = (BATCH / first).ceil().max(1.0) as usize;
    let affordable = (BUDGET / (first * count as f64)) as usize;
    let mut seconds: Vec<f64> = (0..samples.min(affordable).max(3)).map(|_| batch(count)).collect();
    seconds.sort_by(f64::total_cmp);
    Spread { median: seconds[seconds.len() / 2], low: seconds[0], high: seconds[seconds.len() - 1] }
}

/// Times a single run, for what takes long; median, low and high are equal.
pub fn measure_once<T>(run: impl FnOnce() -> T) -> (T, Spread) {
    let start = Instant::now();
    let value = run();
    let seconds = start.elapsed().as_secs_f64();
    (value, Spread { median: seconds, low: seconds, high: seconds })
}

impl Spread {
    /// Median and range in units of `unit` seconds.
    pub fn show(&self, unit: f64) -> String {
        format!("{} ({} – {})", digits(self.median / unit), digits(self.low / unit), digits(self.high / unit))
    }

    /// The median in units of `unit` seconds.
    pub fn show_median(&self, unit: f64) -> String {
        digits(self.median / unit)
    }
}

pub const MILLI: f64 = 1e-3;
pub const MICRO: f64 = 1e-6;

/// Three significant digits.
pub fn digits(value: f64) -> String {
    match value.abs() {
        v if !v.is_finite() => "–".to_owned(),
        v if v >= 1e5 => format!("{value:.2e}"),
        v if v >= 99.95 => format!("{value:.0}"),
        v if v >= 9.995 => format!("{value:.1}"),
        v if v >= 0.9995 => format!("{value:.2}"),
        v if v >= 0.09995 => format!("{value:.3}"),
        v if v >= 0.001 => format!("{value:.4}"),
        0.0 => "0".to_owned(),
        _ => format!("{value:.1e}"),
    }
}
