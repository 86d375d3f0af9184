//! Static equilibrium under large deformation: Newton's method with load stepping.

use super::newton::{Inertia, NewtonError, NewtonOptions, NewtonReport, NewtonWorkspace, minimise};
use super::{Body, Energies, Moment, QuadraticWeights};

/// The way from one static problem to the next: loads are scaled, and they and prescribed motions go on in time together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadPath {
    /// Share of the loads at the start and at the end.
    pub share: [f64; 2],
    /// Time of prescribed motions at the start and at the end \[s\].
    pub time: [f64; 2],
    /// Time of the loads at the start and at the end \[s\].
    pub loads: [f64; 2],
}

/// Options of [`find_equilibrium`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquilibriumOptions {
    /// Newton's method.
    pub newton: NewtonOptions,
    /// Number of equal increments that are tried first.
    pub increments: usize,
    /// How often an increment that fails is halved.
    pub max_halvings: usize,
}

impl Default for EquilibriumOptions {
    fn default() -> Self {
        Self { newton: NewtonOptions { tolerance: 1e-8, max_iterations: 60 }, increments: 1, max_halvings: 10 }
    }
}

/// How an equilibrium was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EquilibriumReport {
    /// Increments made.
    pub increments: usize,
    /// Increments that failed.
    pub failures: usize,
    /// Newton steps.
    pub newton_iterations: usize,
    /// Iterations of linear solvers.
    pub linear_iterations: usize,
    /// Relative residual at the end.
    pub relative_residual: f64,
    /// Energies at the end \[J\].
    pub energies: Energies,
}

/// An equilibrium that was not found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EquilibriumError {
    /// Newton's method fails however short the increment is.
    #[error("no equilibrium beyond {percent:.2} % of the load: {reason}; lower the load, or make the run dynamic with damping", percent = 100.0 * .reached)]
    Failed {
        /// Share of the path up to which equilibria were found.
        reached: f64,
        /// Why not further.
        reason: NewtonError,
    },
    /// The caller's progress callback asked to stop.
    #[error("interrupted while solving for equilibrium")]
    Interrupted,
}

/// Follows equilibria along a path from `u`, the equilibrium at its start. An increment that fails is halved, after one that succeeds the
/// next is twice as long. `progress` is told the share of the path and answers whether to go on.
///
/// # Errors
/// An increment that fails however short it is, an interruption; `u` is then the last equilibrium.
pub fn find_equilibrium(
    body: &mut dyn Body,
    u: &mut Vec<f64>,
    path: &LoadPath,
    options: &EquilibriumOptions,
    progress: &dyn Fn(f64) -> bool,
) -> Result<EquilibriumReport, EquilibriumError> {
    let mut report = EquilibriumReport::default();
    let mut workspace = NewtonWorkspace::default();
    let (mut reached, mut length) = (0.0, 1.0 / options.increments.max(1) as f64);
    let shortest = length * 0.5f64.powi(options.max_halvings as i32);
    let mut trial = Vec::new();
    while reached < 1.0 {
        if !progress(reached) {
            return Err(EquilibriumError::Interrupted);
        }
        let target = if reached + length > 1.0 - 1e-9 { 1.0 } else { reached + length };
        match increment(body, u, &mut trial, path.moment(target), options, &mut workspace) {
            Ok(newton) => {
                std::mem::swap(u, &mut trial);
                body.settle_friction(u);
                report.add(&newton);
                (reached, length) = (target, 2.0 * length);
            }
            Err(reason) if 0.5 * length < shortest => return Err(EquilibriumError::Failed { reached, reason }),
            Err(_) => {
                body.restore_friction();
                report.failures += 1;
                length *= 0.5;
            }
        }
    }
    let start = |error| EquilibriumError::Failed { reached, reason: NewtonError::Start(error) };
    report.energies = body.energies(u).map_err(start)?;
    Ok(report)
}

fn increment(
    body: &mut dyn Body,
    from: &[f64],
    u: &mut Vec<f64>,
    moment: Moment,
    options: &EquilibriumOptions,
    workspace: &mut NewtonWorkspace,
) -> Result<NewtonReport, NewtonError> {
    body.set_moment(moment)?;
    let inertia = Inertia { weights: QuadraticWeights::default(), centre: from, from };
    u.clear();
    u.extend_from_slice(from);
    body.prescribe(u);
    if u != from {
        workspace.follow(body, &inertia, from, u)?;
        body.prescribe(u);
    }
    let start = workspace.evaluate(body, &inertia, u).map_err(NewtonError::Start)?;
    minimise(body, &inertia, &options.newton, (u, start), workspace)
}

impl LoadPath {
    fn moment(&self, share: f64) -> Moment {
        // Ends may be infinite: after all ramps.
        let is_end = |ends: [f64; 2]| share == 1.0 || ends[0] == ends[1];
        let at = |ends: [f64; 2]| if is_end(ends) { ends[1] } else { ends[0] + share * (ends[1] - ends[0]) };
        Moment { loads: at(self.loads), share: at(self.share), holds: at(self.time) }
    }
}

impl EquilibriumReport {
    fn add(&mut self, newton: &NewtonReport) {
        self.increments += 1;
        self.newton_iterations += newton.iterations;
        self.linear_iterations += newton.linear_iterations;
        self.relative_residual = newton.relative_residual;
    }
}
