//! Medians of run times.

use std::hint::black_box;
use std::time::Instant;

use crate::failure::Failure;
use crate::interruption;

/// Samples of a quick run.
const SAMPLES: usize = 15;
/// A sample repeats what is quick until it lasts this long \[s\], so that the clock's resolution does not matter.
const BATCH: f64 = 1e-3;
/// Samples are fewer, at least three, when all together would last longer than this \[s\].
const BUDGET: f64 = 15.0;

/// Seconds of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Median of the samples.
    pub median: f64,
    /// The fastest sample.
    pub low: f64,
    /// The slowest sample.
    pub high: f64,
}

/// Times `run`: twice to warm up, then samples, after each of which the user may interrupt.
///
/// # Errors
/// What `run` returns first; an interruption.
pub fn measure<T>(mut run: impl FnMut() -> Result<T, Failure>) -> Result<Spread, Failure> {
    let mut sample = |count: usize| -> Result<f64, Failure> {
        interruption::check()?;
        let start = Instant::now();
        for _ in 0..count {
            drop(black_box(run()?));
        }
        Ok(start.elapsed().as_secs_f64() / count as f64)
    };
    let first = sample(1)?.min(sample(1)?);
    let count = (BATCH / first).ceil().max(1.0) as usize;
    let affordable = (BUDGET / (first * count as f64)) as usize;
    let seconds: Result<Vec<f64>, Failure> = (0..SAMPLES.min(affordable).max(3)).map(|_| sample(count)).collect();
    Ok(spread(seconds?))
}

fn spread(mut seconds: Vec<f64>) -> Spread {
    seconds.sort_by(f64::total_cmp);
    Spread { median: seconds[seconds.len() / 2], low: seconds[0], high: seconds[seconds.len() - 1] }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn the_median_lies_in_the_middle_of_the_samples() {
        assert_eq!(spread(vec![3.0, 1.0, 9.0]), Spread { median: 3.0, low: 1.0, high: 9.0 });
    }

    #[test]
    fn a_run_is_timed_one_by_one_and_a_failure_ends_it() {
        let nap = || {
            std::thread::sleep(Duration::from_millis(2));
            Ok(())
        };
        let found = measure(nap).unwrap();
        assert!(found.low >= 2e-3 && found.low <= found.median && found.median <= found.high, "{found:?}");
        let failed = measure::<()>(|| Err(Failure::Failed("no".into()))).unwrap_err();
        assert_eq!(failed.to_string(), "no");
    }
}
