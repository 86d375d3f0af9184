//! A fall, step by step in all models.

use grosgrain::dynamics::relative_error;

use super::super::super::Study;
use super::Model;
use super::pair::{Fall, Pair};
use crate::failure::Failure;
use crate::interruption;
use crate::meshes::SimplexTrack;
use crate::tracks::Books;

/// A moment of a fall.
pub struct Seen<'a> {
    /// Number of the step, 0 at the start.
    pub number: usize,
    /// Time \[s\].
    pub time: f64,
    /// Displacements \[m\] of the fine nodes in the order of [`Model::ALL`], three per node.
    pub displacements: &'a [Vec<f64>],
    /// Displacements \[m\] of the coarse nodes under effective tensors.
    pub coarse: &'a [f64],
    /// Errors in percent in the order of [`Model::COARSE`].
    pub errors: [f64; 3],
}

/// What came out of a fall.
pub struct Course {
    /// Times \[s\] and errors \[%\] in the order of [`Model::COARSE`].
    pub errors: Vec<(f64, [f64; 3])>,
    /// What each model cost, in the order of [`Model::ALL`].
    pub books: Vec<Books>,
    /// Why it ended early.
    pub stopped: Option<Failure>,
}

/// Steps that a model makes in a row. What else the machine does burdens all models alike, and a coarse model finds its own numbers in the caches, as it does in an
/// animation of its own.
const IN_A_ROW: usize = 10;

/// Makes the steps; `see` is shown the start and every step.
///
/// # Errors
/// Models that cannot be built; an interruption. A step that cannot be made is in the outcome.
pub fn run(study: &Study, pair: &Pair, fall: &Fall, mut see: impl FnMut(&Seen<'_>)) -> Result<Course, Failure> {
    let mut tracks = pair.tracks(fall)?;
    let steps = study.steps.map_or(fall.steps, |steps| steps.min(fall.steps));
    let mut course = Course { errors: Vec::new(), books: Vec::new(), stopped: None };
    show(pair, &own(&tracks), (0, 0.0), &mut see);
    for done in (0..steps).step_by(IN_A_ROW) {
        let row = done..steps.min(done + IN_A_ROW);
        let mut made: Vec<Vec<Vec<f64>>> = Vec::new();
        // The coarse ones first; what they did is shown beside the fine one.
        for n in (0..tracks.len()).rev() {
            let mut displacements = Vec::new();
            for number in row.clone() {
                interruption::check()?;
                if n == 0 {
                    study.progress.report("steps", number + 1, steps);
                }
                if let Err(failure) = tracks[n].advance(number as f64 * fall.step, fall.step) {
                    course.stopped = course.stopped.or(Some(failure));
                    break;
                }
                displacements.push(tracks[n].state.displacement.clone());
            }
            made.push(displacements);
        }
        made.reverse();
        let complete = made.iter().map(Vec::len).min().unwrap_or(0);
        for k in 0..complete {
            let (number, time) = (row.start + k + 1, (row.start + k + 1) as f64 * fall.step);
            let displacements: Vec<&[f64]> = made.iter().map(|steps| &steps[k][..]).collect();
            course.errors.push((time, show(pair, &displacements, (number, time), &mut see)));
        }
        if course.stopped.is_some() {
            break;
        }
    }
    study.progress.close();
    course.books = tracks.iter().map(|track| track.books).collect();
    Ok(course)
}

fn own(tracks: &[SimplexTrack]) -> Vec<&[f64]> {
    tracks.iter().map(|track| &track.state.displacement[..]).collect()
}

/// Shows the displacements \[m\] of each model, of its own nodes; returns the errors.
fn show(pair: &Pair, own: &[&[f64]], (number, time): (usize, f64), see: &mut impl FnMut(&Seen<'_>)) -> [f64; 3] {
    let at_fine_nodes = |n: usize| if n == 0 { own[0].to_vec() } else { pair.embedding.prolong(own[n]) };
    let displacements: Vec<Vec<f64>> = (0..Model::ALL.len()).map(at_fine_nodes).collect();
    let errors = [1, 2, 3].map(|n| 100.0 * relative_error(&displacements[n], &displacements[0]));
    see(&Seen { number, time, displacements: &displacements, coarse: own[1], errors });
    errors
}

impl Course {
    /// Seconds and Newton steps of a step.
    pub fn cost(&self, model: usize) -> [f64; 2] {
        self.books.get(model).map_or([f64::NAN; 2], |books| {
            let steps = books.steps.max(1) as f64;
            [books.solving / steps, books.newton as f64 / steps]
        })
    }

    /// How many times longer a step of the fine mesh takes than one of a coarse model.
    pub fn ratio(&self, model: usize) -> Option<f64> {
        let ratio = self.cost(0)[0] / self.cost(model)[0];
        (model > 0 && ratio.is_finite()).then_some(ratio)
    }

    /// Error at the end, mean and worst in percent, in the order of [`Model::COARSE`]; `None` without a step.
    pub fn summary(&self, coarse: usize) -> Option<[f64; 3]> {
        let (_, last) = self.errors.last()?;
        let all = self.errors.iter().map(|(_, errors)| errors[coarse]);
        Some([last[coarse], all.clone().sum::<f64>() / self.errors.len() as f64, all.fold(0.0, f64::max)])
    }
}
