//! The frames of several runs by time, and which of them a picture shows.

/// Frames per second at most, and the longest that one stands \[s\].
const DELAYS: [f64; 2] = [0.03, 0.25];

/// The frames of several runs.
#[derive(Clone, Debug)]
pub struct Reel<T> {
    /// Labels of the runs.
    pub runs: Vec<String>,
    frames: Vec<Vec<Recorded<T>>>,
}

/// A frame, when it was, and a line about it.
#[derive(Clone, Debug)]
pub struct Recorded<T> {
    /// Time \[s\].
    pub time: f64,
    /// A line under it; empty for none.
    pub note: String,
    /// What is shown.
    pub frame: T,
}

impl<T> Reel<T> {
    /// No frames yet of these runs.
    pub fn new(runs: &[&str]) -> Self {
        Self {
            runs: runs.iter().map(|run| (*run).to_owned()).collect(),
            frames: runs.iter().map(|_| Vec::new()).collect(),
        }
    }

    /// Adds a frame of a run.
    pub fn push(&mut self, run: usize, time: f64, frame: T) {
        self.frames[run].push(Recorded { time, note: String::new(), frame });
    }

    /// The frame of a run that was added last.
    pub fn last_mut(&mut self, run: usize) -> Option<&mut Recorded<T>> {
        self.frames[run].last_mut()
    }

    /// All frames.
    pub fn iter(&self) -> impl Iterator<Item = &Recorded<T>> + Clone {
        self.frames.iter().flatten()
    }

    /// The frame of a run closest to `time`; the earlier of two.
    pub fn at(&self, run: usize, time: f64) -> Option<&Recorded<T>> {
        let distance = |frame: &&Recorded<T>| (frame.time - time).abs();
        self.frames[run].iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// At most `most` times, evenly picked from those of the run with the most frames, its first and its last among them.
    pub fn times(&self, most: usize) -> Vec<f64> {
        let longest = self.frames.iter().rev().max_by_key(|frames| frames.len());
        let all: Vec<f64> = longest.into_iter().flatten().map(|frame| frame.time).collect();
        match most {
            _ if all.len() <= most => all,
            0 => Vec::new(),
            1 => all[all.len() - 1..].to_vec(),
            _ => (0..most).map(|i| all[(i * (all.len() - 1) + (most - 1) / 2) / (most - 1)]).collect(),
        }
    }

    /// Whether any frame has a line under it.
    pub fn has_notes(&self) -> bool {
        self.iter().any(|frame| !frame.note.is_empty())
    }
}

/// A line under a frame; never empty where others have one, so that all frames have the same size.
pub fn note<T>(frame: Option<&Recorded<T>>, has_notes: bool) -> String {
    match frame {
        Some(frame) if !frame.note.is_empty() => frame.note.clone(),
        _ if has_notes => " ".into(),
        _ => String::new(),
    }
}

/// `t = 0.50 s` for each time, with as many decimals as show their distances, two at least and six at most.
pub fn time_labels(times: &[f64]) -> Vec<String> {
    let closest = times.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(f64::INFINITY, f64::min);
    let rounded_off = |t: &f64, decimals: i32| (t - (t * 10f64.powi(decimals)).round() / 10f64.powi(decimals)).abs();
    let shown = |decimals: &usize| times.iter().all(|t| rounded_off(t, *decimals as i32) <= 0.05 * closest);
    let decimals = (2..6).find(shown).unwrap_or(6);
    times.iter().map(|t| format!("t = {t:.decimals$} s")).collect()
}

/// Time that each frame stands for motion at its true speed, within what can be seen.
pub fn delay(times: &[f64]) -> f64 {
    let span = times.last().unwrap_or(&0.0) - times.first().unwrap_or(&0.0);
    let mean = span / times.len().saturating_sub(1).max(1) as f64;
    mean.clamp(DELAYS[0], DELAYS[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reel(times: &[f64]) -> Reel<usize> {
        let mut reel = Reel::new(&["fine", "coarse"]);
        times.iter().enumerate().for_each(|(i, t)| reel.push(0, *t, i));
        reel.push(1, 0.0, 100);
        reel
    }

    #[test]
    fn picked_times_are_even_and_hold_the_ends() {
        let times: Vec<f64> = (0..=20).map(|i| f64::from(i) * 0.1).collect();
        let reel = reel(&times);
        assert_eq!(reel.times(5), [times[0], times[5], times[10], times[15], times[20]]);
        assert_eq!(reel.times(2), [times[0], times[20]]);
        assert_eq!((reel.times(1), reel.times(0)), (vec![times[20]], vec![]));
        assert_eq!(reel.times(99), times);
    }

    #[test]
    fn the_closest_frame_is_taken() {
        let reel = reel(&[0.0, 0.5, 1.0]);
        let found = |t: f64| reel.at(0, t).map(|f| f.frame);
        assert_eq!((found(0.1), found(0.9), found(0.25), found(7.0)), (Some(0), Some(2), Some(0), Some(2)));
        assert_eq!(reel.at(1, 5.0).map(|f| f.frame), Some(100));
    }

    #[test]
    fn labels_of_times_differ() {
        assert_eq!(time_labels(&[0.0, 0.5]), ["t = 0.00 s", "t = 0.50 s"]);
        assert_eq!(time_labels(&[0.001, 0.0015]), ["t = 0.0010 s", "t = 0.0015 s"]);
        assert_eq!(time_labels(&[1.0 / 3.0, 2.0 / 3.0]), ["t = 0.33 s", "t = 0.67 s"]);
        assert_eq!((delay(&[0.0, 0.1, 0.2]), delay(&[0.0]), delay(&[0.0, 1e-6])), (0.1, 0.03, 0.03));
    }
}
