//! Newton's method for a minimum of Ψ(u) plus the quadratic terms of a time step.

use super::{Body, Energies, Inversion, QuadraticWeights, TangentError};
use crate::assembly::Constraints;
use crate::linalg::{dot, norm};
use crate::material::Projection;
use crate::solver::SolverError;

/// How Newton's method ends and what it tries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Residual force over the largest of internal, inertial and load forces (2-norms) at which a step is solved.
    pub tolerance: f64,
    /// Steps beyond this are a failure.
    pub max_iterations: usize,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self { tolerance: 1e-5, max_iterations: 50 }
    }
}

/// What the iteration did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NewtonReport {
    /// Newton steps.
    pub iterations: usize,
    /// Iterations of the linear solver over all of them.
    pub linear_iterations: usize,
    /// Steps for which the Hessian was projected.
    pub projected: usize,
    /// Relative residual at the end.
    pub relative_residual: f64,
    /// Potential energies at the end \[J\].
    pub energies: Energies,
}

/// Why no minimum was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NewtonError {
    /// The state to start from, with the held nodes where they must be, is inverted.
    #[error("{0}")]
    Start(Inversion),
    /// No shorter step lowers the energy.
    #[error("no step lowers the energy at a relative residual of {residual:.1e}{}", Inverted(.inverted))]
    LineSearch {
        /// Relative residual.
        residual: f64,
        /// What stood in the way of the longest step that was refused, where it was an inversion.
        inverted: Option<Inversion>,
    },
    /// Too many steps.
    #[error("the relative residual is still {residual:.1e} after {iterations} Newton steps{}", Inverted(.inverted))]
    Iterations {
        /// Relative residual.
        residual: f64,
        /// Steps made.
        iterations: usize,
        /// What stood in the way of the last step that was shortened, where it was an inversion.
        inverted: Option<Inversion>,
    },
    /// A linear system was not solved.
    #[error(transparent)]
    Linear(SolverError),
}

impl From<TangentError> for NewtonError {
    fn from(error: TangentError) -> Self {
        match error {
            TangentError::Inversion(inversion) => Self::Start(inversion),
            TangentError::Solver(failure) => Self::Linear(failure),
        }
    }
}

/// Says what was inverted, where anything was.
struct Inverted<'a>(&'a Option<Inversion>);

impl std::fmt::Display for Inverted<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.as_ref().map_or(Ok(()), |inversion| write!(formatter, " ({inversion})"))
    }
}

/// The quadratic terms that a time step adds to Ψ: ½ w Σ m ‖u − c‖² + ½ b (u − u₀)ᵀ K₀ (u − u₀).
#[derive(Clone, Copy, Debug)]
pub struct Inertia<'a> {
    /// w, zero for equilibrium, and b.
    pub weights: QuadraticWeights,
    /// c, three per node.
    pub centre: &'a [f64],
    /// u₀, three per node.
    pub from: &'a [f64],
}

/// Vectors that are kept from step to step.
#[derive(Clone, Debug, Default)]
pub struct NewtonWorkspace {
    gradient: Vec<f64>,
    inertial: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    product: Vec<f64>,
    /// What the gradient was at prescribed components, in their order: the forces that hold them, negative.
    reactions: Vec<f64>,
}

/// Shortest step that is tried, as a share of the full one.
const SHORTEST: f64 = 1e-6;
/// Share of the predicted decrease that a step must reach.
const ARMIJO: f64 = 1e-4;
/// Differences of energies below this share of the energies are rounding.
const ROUNDING: f64 = 1e-13;
/// Where a step promises less than this share of the energies, rounding may hide it, and a residual that falls is the better witness.
const INDISTINCT: f64 = 1e-11;
/// Loosest relative residual of a linear solve.
const LOOSEST: f64 = 0.1;

/// The minimum near `u`, whose prescribed components are already in place; `start` is how [`NewtonWorkspace::evaluate`] has found it.
///
/// Steps with the exact Hessian where it is positive definite and with the projected one where it is not; linear systems are solved to
/// min(0.1, √r) of the relative residual r, no further than to 0.4 of the tolerance; steps are halved until the energy falls and no cell is inverted. Where the
/// energy can fall by no more than rounding and the residual stays, the iteration ends too: rounding keeps it above the tolerance.
///
/// # Errors
/// A start that is inverted, a line search that ends, too many iterations, a linear system that is not solved.
pub fn minimise(
    body: &mut dyn Body,
    inertia: &Inertia<'_>,
    options: &NewtonOptions,
    (u, start): (&mut Vec<f64>, Standing),
    workspace: &mut NewtonWorkspace,
) -> Result<NewtonReport, NewtonError> {
    let mut report = NewtonReport::default();
    let mut state = start;
    let mut projection = Projection::Exact;
    let mut inverted = None;
    loop {
        report.relative_residual = state.residual;
        report.energies = state.energies;
        if state.residual <= options.tolerance {
            return Ok(report);
        }
        if report.iterations == options.max_iterations {
            let (residual, iterations) = (state.residual, report.iterations);
            return Err(NewtonError::Iterations { residual, iterations, inverted });
        }
        let forcing = LOOSEST.min(state.residual.sqrt()).max(0.4 * options.tolerance / state.residual).min(0.5);
        let slope = workspace.find_step(body, inertia, (u, forcing), &mut projection, &mut report)?;
        report.iterations += 1;
        let before = state;
        state = workspace.search(body, inertia, (u, slope), &before)?;
        inverted = state.inverted.or(inverted);
        if -slope <= ROUNDING * before.scale && state.residual > 0.5 * before.residual {
            report.relative_residual = state.residual;
            report.energies = state.energies;
            return Ok(report);
        }
        if projection == Projection::PositiveSemidefinite && state.full_step {
            projection = Projection::Exact;
        }
    }
}

/// Where the iteration stands.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    pub energies: Energies,
    objective: f64,
    scale: f64,
    residual: f64,
    full_step: bool,
    /// What longer steps would have inverted.
    inverted: Option<Inversion>,
}

impl NewtonWorkspace {
    fn resize(&mut self, n: usize) {
        for vector in [&mut self.gradient, &mut self.inertial, &mut self.step, &mut self.trial, &mut self.product] {
            vector.resize(n, 0.0);
        }
    }

    /// The objective and its gradient at u; the gradient is zero at prescribed components afterwards.
    ///
    /// # Errors
    /// An inverted state.
    pub fn evaluate(&mut self, body: &dyn Body, inertia: &Inertia<'_>, u: &[f64]) -> Result<Standing, Inversion> {
        self.resize(u.len());
        let energies = body.gradient(u, &mut self.gradient)?;
        let internal = norm(&self.gradient);
        let kinetic = self.add_inertia(body, inertia, u);
        let inertial = norm(&self.inertial);
        add(&self.inertial, &mut self.gradient);
        self.reactions.clear();
        let reaction = clear_fixed(body, &mut self.gradient, |reaction| self.reactions.push(reaction));
        let size = internal.max(inertial).max(reaction).max(body.load_norm());
        let residual = norm(&self.gradient);
        if !residual.is_finite() {
            return Err(Inversion::NotFinite);
        }
        Ok(Standing {
            energies,
            objective: energies.total() + kinetic,
            scale: energies.scale() + kinetic,
            residual: if residual == 0.0 { 0.0 } else { residual / size },
            full_step: true,
            inverted: None,
        })
    }

    /// Sets `inertial` to the gradient of the quadratic terms; returns their value.
    fn add_inertia(&mut self, body: &dyn Body, inertia: &Inertia<'_>, u: &[f64]) -> f64 {
        let Inertia { weights: QuadraticWeights { mass: weight, damping }, centre, from } = *inertia;
        self.inertial.fill(0.0);
        let mut energy = 0.0;
        if weight > 0.0 {
            for (n, mass) in body.mass().iter().enumerate() {
                for i in 3 * n..3 * n + 3 {
                    let distance = u[i] - centre[i];
                    self.inertial[i] = weight * mass * distance;
                    energy += 0.5 * self.inertial[i] * distance;
                }
            }
        }
        if damping > 0.0 {
            self.trial.iter_mut().zip(u.iter().zip(from)).for_each(|(d, (u, f))| *d = u - f);
            self.product.fill(0.0);
            body.add_damping(damping, &self.trial, &mut self.product);
            energy += 0.5 * dot(&self.product, &self.trial);
            add(&self.product, &mut self.inertial);
        }
        energy
    }

    /// Sets `step` to the Newton step; returns the slope of the objective along it.
    fn find_step(
        &mut self,
        body: &mut dyn Body,
        inertia: &Inertia<'_>,
        (u, forcing): (&[f64], f64),
        projection: &mut Projection,
        report: &mut NewtonReport,
    ) -> Result<f64, NewtonError> {
        loop {
            let outcome = self.try_step(body, inertia, (u, forcing), *projection);
            match outcome {
                Ok(iterations) => {
                    report.linear_iterations += iterations;
                    report.projected += usize::from(*projection == Projection::PositiveSemidefinite);
                    let slope = dot(&self.gradient, &self.step);
                    if slope < 0.0 || *projection == Projection::PositiveSemidefinite {
                        return Ok(slope);
                    }
                }
                Err(TangentError::Inversion(inversion)) => return Err(NewtonError::Start(inversion)),
                Err(TangentError::Solver(failure)) => {
                    if *projection == Projection::PositiveSemidefinite {
                        return Err(NewtonError::Linear(failure));
                    }
                }
            }
            *projection = Projection::PositiveSemidefinite;
        }
    }

    fn try_step(
        &mut self,
        body: &mut dyn Body,
        inertia: &Inertia<'_>,
        (u, forcing): (&[f64], f64),
        projection: Projection,
    ) -> Result<usize, TangentError> {
        body.linearise(u, inertia.weights, projection)?;
        self.step.iter_mut().zip(&self.gradient).for_each(|(s, g)| *s = -g);
        Ok(body.solve(&mut self.step, forcing)?.iterations)
    }

    /// Goes along `step` as far as the objective falls.
    fn search(
        &mut self,
        body: &dyn Body,
        inertia: &Inertia<'_>,
        (u, slope): (&mut Vec<f64>, f64),
        before: &Standing,
    ) -> Result<Standing, NewtonError> {
        let (mut share, mut inverted) = (1.0, None);
        let start = std::mem::take(u);
        while share >= SHORTEST {
            u.clear();
            u.extend(start.iter().zip(&self.step).map(|(u, s)| u + share * s));
            match self.evaluate(body, inertia, u) {
                Ok(after) => {
                    let rounding = ROUNDING * (before.scale + after.scale);
                    let falls = after.objective <= before.objective + ARMIJO * share * slope + rounding;
                    let converges = -slope <= INDISTINCT * before.scale && after.residual < before.residual;
                    if falls || converges {
                        return Ok(Standing { full_step: share == 1.0, inverted, ..after });
                    }
                }
                Err(inversion) => inverted = inverted.or(Some(inversion)),
            }
            share *= 0.5;
        }
        *u = start;
        Err(NewtonError::LineSearch { residual: before.residual, inverted })
    }

    /// Sets `u` to `from` moved so that prescribed components are in place and the others follow in linear approximation.
    ///
    /// # Errors
    /// An inverted `from`; a linear system that is not solved.
    pub fn follow(
        &mut self,
        body: &mut dyn Body,
        inertia: &Inertia<'_>,
        from: &[f64],
        u: &mut Vec<f64>,
    ) -> Result<(), NewtonError> {
        self.resize(from.len());
        self.evaluate(body, inertia, from).map_err(NewtonError::Start)?;
        body.linearise(from, inertia.weights, Projection::PositiveSemidefinite).map_err(NewtonError::from)?;
        u.clear();
        u.extend_from_slice(from);
        body.prescribe(u);
        self.trial.iter_mut().zip(u.iter().zip(from)).for_each(|(d, (u, f))| *d = u - f);
        body.multiply(&self.trial, &mut self.product);
        self.step.iter_mut().zip(self.gradient.iter().zip(&self.product)).for_each(|(s, (g, p))| *s = -g - p);
        clear_fixed(body, &mut self.step, |_| {});
        body.solve(&mut self.step, 1e-3).map_err(NewtonError::from)?;
        add(&self.step, u);
        Ok(())
    }

    /// The work \[J\] of the forces that hold the prescribed components where the last evaluation was, on a displacement of these.
    pub fn work_of_holds(&self, body: &dyn Body, moved: impl Fn(usize) -> f64) -> f64 {
        prescribed(body.constraints()).zip(&self.reactions).map(|(i, reaction)| reaction * moved(i)).sum()
    }
}

fn add(from: &[f64], to: &mut [f64]) {
    to.iter_mut().zip(from).for_each(|(t, f)| *t += f);
}

/// The prescribed components.
fn prescribed(constraints: &Constraints) -> impl Iterator<Item = usize> {
    let held = (0..constraints.node_count()).filter(|n| !constraints.is_free(*n));
    held.flat_map(move |n| (3 * n..3 * n + 3).filter(move |i| constraints.is_fixed(n, i - 3 * n)))
}

/// Sets prescribed components to zero; returns the norm of what was there, which `visit` is told one by one.
fn clear_fixed(body: &dyn Body, vector: &mut [f64], mut visit: impl FnMut(f64)) -> f64 {
    let mut square = 0.0;
    for i in prescribed(body.constraints()) {
        visit(vector[i]);
        square += vector[i] * vector[i];
        vector[i] = 0.0;
    }
    square.sqrt()
}
