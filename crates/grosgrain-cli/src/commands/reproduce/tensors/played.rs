//! A fine body and its coarse models in motion side by side.

use grosgrain::dynamics::{Integrator, relative_error, simplex_mass};
use grosgrain::simplex::SimplexLaw;

use super::super::Study;
use super::pair::{Coarse, Fine, Task, Way};
use crate::failure::Failure;
use crate::interruption;
use crate::meshes::SimplexTrack;
use crate::scene::Time;

/// Residual of Newton's method, relative to the forces, in all models.
const TOLERANCE: f64 = 1e-5;

/// Steps in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// Seconds of each.
    pub length: f64,
    /// How many.
    pub count: usize,
}

/// The motion of one model.
#[derive(Clone, Debug, Default)]
pub struct Player {
    /// `fine`, or the way to its tensors.
    pub name: &'static str,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Mean displacement \[m\] of the fine nodes along the pull at the end of every step.
    pub means: Vec<f64>,
    /// RMS difference from the fine displacement at the end of every step, in percent of the largest RMS of the fine one.
    pub errors: Vec<f64>,
    /// Squares of the difference from the fine displacement, and of that, at the end of every step.
    squares: Vec<[f64; 2]>,
    /// Where it was farthest along the pull.
    pub extreme: Pose,
    /// Seconds for a step.
    pub step: f64,
    /// Newton steps for a step in time.
    pub newton: f64,
}

/// A displaced body.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    /// When \[s\].
    pub time: f64,
    /// Displacement \[m\] of the fine nodes, three per node.
    pub fine: Vec<f64>,
    /// Displacement \[m\] of the nodes of its own mesh.
    pub own: Vec<f64>,
}

impl Player {
    /// Largest mean displacement \[m\] along the pull.
    pub fn reach(&self) -> f64 {
        self.means.iter().copied().fold(0.0, f64::max)
    }

    /// Error over the whole motion in percent: √(Σ ‖u − v‖² / Σ ‖v‖²) over the steps.
    pub fn mean_error(&self) -> f64 {
        self.error_over(self.squares.len())
    }

    /// The same over the first swing: until the fine model turns back for the first time.
    pub fn swing_error(&self, fine: &Self) -> f64 {
        let turn = fine.means.windows(2).position(|pair| pair[1] < pair[0]);
        self.error_over(turn.map_or(self.squares.len(), |step| step + 1))
    }

    fn error_over(&self, steps: usize) -> f64 {
        let sum = |n: usize| self.squares[..steps].iter().map(|squares| squares[n]).sum::<f64>();
        100.0 * (sum(0) / sum(1)).sqrt()
    }

    /// Error at the worst step, in percent of the largest displacement of the fine model.
    pub fn worst_error(&self) -> f64 {
        self.errors.iter().copied().fold(0.0, f64::max)
    }

    /// Difference of its most extreme position from that of the fine model, each when it gets there, in percent.
    pub fn extreme_error(&self, fine: &Self) -> f64 {
        100.0 * relative_error(&self.extreme.fine, &fine.extreme.fine)
    }

    /// Takes in the end of a step.
    fn see(&mut self, time: f64, mean: f64, fine: Vec<f64>, own: &[f64]) {
        if self.means.iter().all(|before| mean > *before) {
            self.extreme = Pose { time, fine, own: own.to_vec() };
        }
        self.means.push(mean);
    }
}

/// Runs the fine model and its coarse models from rest, the pull beginning at once: corotational cells, the implicit midpoint rule. The fine one comes first.
pub fn play(study: &Study, fine: &Fine, coarse: &Coarse, task: &Task, steps: Steps) -> Result<Vec<Player>, Failure> {
    let time = Time { tolerance: TOLERANCE, integrator: Integrator::Midpoint, ..Time::default() };
    let held = fine.held(study, task)?;
    let law = SimplexLaw::Corotational;
    let mut tracks = vec![SimplexTrack::new("fine", task.body(&fine.model, simplex_mass(&fine.model), law)?, &time)?];
    for (way, model) in Way::ALL.into_iter().zip(coarse.models(fine, &held)?) {
        tracks.push(SimplexTrack::new(way.name(), task.body(&model, coarse.mass.clone(), law)?, &time)?);
    }
    let names = std::iter::once("fine").chain(Way::ALL.map(Way::name));
    let mut players: Vec<Player> = names.map(|name| Player { name, ..Player::default() }).collect();
    let mut differences: Vec<Vec<f64>> = vec![Vec::new(); players.len()];
    let mut largest = 0.0f64;
    for step in 0..steps.count {
        interruption::check()?;
        let start = step as f64 * steps.length;
        for track in &mut tracks {
            track.advance(start, steps.length)?;
        }
        let reference = tracks[0].state.displacement.clone();
        let size = rms(&reference, None);
        largest = largest.max(size);
        for (n, (player, track)) in players.iter_mut().zip(&tracks).enumerate() {
            let own = &track.state.displacement;
            let at_fine = if n == 0 { own.clone() } else { coarse.embedding.prolong(own) };
            let difference = rms(&at_fine, Some(&reference));
            differences[n].push(difference);
            player.squares.push([difference * difference, size * size]);
            player.see(start + steps.length, along(&at_fine, task.acceleration), at_fine, own);
        }
        study.progress.report("moving", step + 1, steps.count);
    }
    study.progress.close();
    for ((player, track), differences) in players.iter_mut().zip(&tracks).zip(differences) {
        player.errors = differences.iter().map(|difference| 100.0 * difference / largest).collect();
        player.unknowns = unknowns(fine, coarse, player.name == "fine", task);
        player.step = track.books.solving / track.books.steps as f64;
        player.newton = track.books.newton as f64 / track.books.steps as f64;
    }
    Ok(players)
}

fn unknowns(fine: &Fine, coarse: &Coarse, is_fine: bool, task: &Task) -> usize {
    let mesh = if is_fine { fine.model.mesh() } else { &coarse.mesh };
    mesh.dimension().axes() * task.held(mesh).iter().filter(|held| !**held).count()
}

fn rms(u: &[f64], from: Option<&[f64]>) -> f64 {
    let square = |(i, u): (usize, &f64)| (u - from.map_or(0.0, |v| v[i])).powi(2);
    (u.iter().enumerate().map(square).sum::<f64>() / (u.len() / 3) as f64).sqrt()
}

/// Mean over the nodes of the displacement along a direction.
fn along(u: &[f64], direction: [f64; 3]) -> f64 {
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    let sum: f64 = u.chunks_exact(3).map(|u| (0..3).map(|r| u[r] * direction[r]).sum::<f64>()).sum();
    sum / (length * (u.len() / 3) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_motion_are_relative_to_the_fine_one() {
        assert!((rms(&[3.0, 0.0, 4.0, 0.0, 0.0, 0.0], None) - 12.5f64.sqrt()).abs() < 1e-14);
        assert!((rms(&[1.0, 2.0, 3.0], Some(&[1.0, 2.0, 5.0])) - 2.0).abs() < 1e-14);
        assert!((along(&[0.0, 0.0, -1.0, 0.0, 0.0, -3.0], [0.0, 0.0, -9.81]) - 2.0).abs() < 1e-14);
        let mut player = Player {
            squares: vec![[0.01, 1.0], [0.09, 1.0], [0.02, 1.0]],
            errors: vec![1.0, 30.0, 2.0],
            ..Player::default()
        };
        [(0.1, 1.0), (0.2, 4.0), (0.3, 3.0)].iter().for_each(|(t, mean)| player.see(*t, *mean, vec![*mean; 3], &[]));
        assert_eq!((player.extreme.time, player.reach(), player.worst_error()), (0.2, 4.0, 30.0));
        assert!((player.mean_error() - 20.0).abs() < 1e-12);
        let turning = Player { means: vec![1.0, 2.0, 1.5], ..Player::default() };
        assert!((player.swing_error(&turning) - 100.0 * 0.05f64.sqrt()).abs() < 1e-12);
        let fine = Player { extreme: Pose { fine: vec![5.0; 3], ..Pose::default() }, ..Player::default() };
        assert!((player.extreme_error(&fine) - 20.0).abs() < 1e-12);
    }
}
