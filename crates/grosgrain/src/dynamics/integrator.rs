//! Steps in time: backward Euler and the implicit midpoint rule, each as the minimum of an incremental potential.

use super::newton::{Inertia, NewtonError, NewtonOptions, NewtonReport, NewtonWorkspace, Standing, minimise};
use super::{Body, Energies, Inversion, Moment, QuadraticWeights, State};

/// How velocities and displacements advance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// Backward Euler: order 1, takes energy out of fast motion, never puts any in (`gast2015optimization`).
    #[default]
    ImplicitEuler,
    /// The implicit midpoint rule: order 2, keeps energy up to oscillation.
    Midpoint,
}

/// Rayleigh damping: forces −(α M + β K) v, K the projected tangent at the start of the step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Damping {
    /// α \[1/s\].
    pub mass: f64,
    /// β \[s\].
    pub stiffness: f64,
}

/// Options of [`Stepper`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepOptions {
    /// The rule.
    pub integrator: Integrator,
    /// Damping.
    pub damping: Damping,
    /// Newton's method.
    pub newton: NewtonOptions,
    /// How often a step that fails is halved before the run is given up.
    pub max_halvings: usize,
}

impl Default for StepOptions {
    fn default() -> Self {
        Self {
            integrator: Integrator::ImplicitEuler,
            damping: Damping::default(),
            newton: NewtonOptions::default(),
            max_halvings: 8,
        }
    }
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Newton steps over all substeps.
    pub newton_iterations: usize,
    /// Iterations of linear solvers.
    pub linear_iterations: usize,
    /// Newton steps with a projected Hessian.
    pub projected: usize,
    /// Substeps that the step was made of; 1 where nothing failed.
    pub substeps: usize,
    /// Worst relative residual at the end of a substep.
    pub relative_residual: f64,
    /// Potential energies at the end \[J\].
    pub energies: Energies,
    /// Kinetic energy at the end \[J\].
    pub kinetic: f64,
    /// Work of the loads during the step, and what springs store more because they grow stiffer or are tied to another place \[J\].
    pub work_of_loads: f64,
    /// Work of prescribed motions during the step \[J\].
    pub work_of_holds: f64,
    /// What damping took during the step \[J\].
    pub damped: f64,
}

/// A step that was not made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "no solution for the step to {time:.6} s, even in parts of {smallest:.2e} s: {reason}; use a smaller step, or move the body more slowly"
)]
pub struct StepError {
    /// The end of the smallest part that failed \[s\].
    pub time: f64,
    /// Its length \[s\].
    pub smallest: f64,
    /// Why.
    pub reason: NewtonError,
}

/// Makes steps; keeps the vectors that they need.
#[derive(Clone, Debug, Default)]
pub struct Stepper {
    options: StepOptions,
    workspace: NewtonWorkspace,
    centre: Vec<f64>,
    start: Vec<f64>,
    u: Vec<f64>,
    product: Vec<f64>,
}

/// Rounds of friction within a step: the normal forces that limit it follow the solution.
const FRICTION_ROUNDS: usize = 3;
/// Relative change of normal forces that ends these rounds.
const FRICTION_CHANGE: f64 = 0.02;

impl Stepper {
    /// A stepper with these options.
    pub fn new(options: StepOptions) -> Self {
        Self { options, ..Self::default() }
    }

    /// The options.
    pub fn options(&self) -> &StepOptions {
        &self.options
    }

    /// Advances `state` from `time` by `step` \[s\]. A step that fails is made in two halves, and so on.
    ///
    /// # Errors
    /// A part of the step fails however short it is. The state is then the last one that was reached, and the error says when.
    pub fn advance(
        &mut self,
        body: &mut dyn Body,
        state: &mut State,
        time: f64,
        step: f64,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        // Ends of the parts still to be made, the next one last, with the number of halvings.
        let mut ends = vec![(time + step, 0)];
        let mut now = time;
        while let Some(&(end, halvings)) = ends.last() {
            match self.attempt(body, state, now, end - now, &mut report) {
                Ok(()) => {
                    now = end;
                    report.substeps += 1;
                    ends.pop();
                }
                Err(reason) if halvings >= self.options.max_halvings => {
                    return Err(StepError { time: end, smallest: end - now, reason });
                }
                Err(_) => {
                    body.restore_friction();
                    if let Some(last) = ends.last_mut() {
                        last.1 += 1;
                    }
                    ends.push((0.5 * (now + end), halvings + 1));
                }
            }
        }
        report.kinetic = state.kinetic_energy(body.mass());
        Ok(report)
    }

    /// One step without halving; the state is as it was where it fails.
    fn attempt(
        &mut self,
        body: &mut dyn Body,
        state: &mut State,
        time: f64,
        step: f64,
        report: &mut StepReport,
    ) -> Result<(), NewtonError> {
        let options = self.options;
        // The midpoint rule is a backward Euler step of half the length to the midpoint, and the same motion once more.
        let (half, length) = match options.integrator {
            Integrator::ImplicitEuler => (false, step),
            Integrator::Midpoint => (true, 0.5 * step),
        };
        let moment = Moment { loads: time + length, share: 1.0, holds: time + step };
        self.start.clone_from(&state.displacement);
        let stored = body.energy_of_points(&self.start).map_err(NewtonError::Start)?;
        body.set_moment(moment).map_err(NewtonError::from)?;
        if options.damping.stiffness > 0.0 {
            body.lag_damping(&self.start).map_err(NewtonError::Start)?;
        }
        let loads_before = body.load_energy(&self.start).map_err(NewtonError::Start)?;
        let points_before = body.energy_of_points(&self.start).map_err(NewtonError::Start)?;
        let weights = self.set_centre(state, length);
        let guess = self.guess(body, state, (length, half), weights)?;
        let newton = self.minimise(body, weights, guess)?;
        let mut made = *report;
        self.account(body, weights, (length, half), newton.energies.loads - loads_before, &mut made);
        made.work_of_loads += points_before - stored;
        made.energies = self.finish(body, state, (length, half), newton.energies)?;
        made.newton_iterations += newton.iterations;
        made.linear_iterations += newton.linear_iterations;
        made.projected += newton.projected;
        made.relative_residual = made.relative_residual.max(newton.relative_residual);
        // What failed on the way is in no book.
        *report = made;
        Ok(())
    }

    /// Sets the centre of the inertial terms of a backward Euler step; returns their weight and that of stiffness damping.
    fn set_centre(&mut self, state: &State, length: f64) -> QuadraticWeights {
        let Damping { mass, stiffness } = self.options.damping;
        let (inertia, drag) = (1.0 / (length * length), mass / length);
        let weight = inertia + drag;
        self.centre.clear();
        let centre = |(u, v): (&f64, &f64)| (inertia * (u + length * v) + drag * u) / weight;
        self.centre.extend(state.displacement.iter().zip(&state.velocity).map(centre));
        QuadraticWeights { mass: weight, damping: stiffness / length }
    }

    /// Sets `u` to a state with the held nodes in place: the motion goes on as it was, or where that inverts cells, the body follows the
    /// held nodes in linear approximation.
    fn guess(
        &mut self,
        body: &mut dyn Body,
        state: &State,
        (length, half): (f64, bool),
        weights: QuadraticWeights,
    ) -> Result<Standing, NewtonError> {
        self.u.clear();
        self.u.extend(state.displacement.iter().zip(&state.velocity).map(|(u, v)| u + length * v));
        self.place_held(body, half);
        let inertia = Inertia { weights, centre: &self.centre, from: &self.start };
        if let Ok(standing) = self.workspace.evaluate(body, &inertia, &self.u) {
            return Ok(standing);
        }
        self.workspace.follow(body, &inertia, &self.start, &mut self.u)?;
        self.place_held(body, half);
        let inertia = Inertia { weights, centre: &self.centre, from: &self.start };
        self.workspace.evaluate(body, &inertia, &self.u).map_err(NewtonError::Start)
    }

    /// Puts held nodes of `u` where they must be at the end of the step, or half-way there.
    fn place_held(&mut self, body: &dyn Body, half: bool) {
        body.prescribe(&mut self.u);
        if half {
            for (i, u) in self.u.iter_mut().enumerate() {
                if body.constraints().is_fixed(i / 3, i % 3) {
                    *u = 0.5 * (*u + self.start[i]);
                }
            }
        }
    }

    /// The minimum from the guess, with the limits of friction that belong to it.
    fn minimise(
        &mut self,
        body: &mut dyn Body,
        weights: QuadraticWeights,
        guess: Standing,
    ) -> Result<NewtonReport, NewtonError> {
        let inertia = Inertia { weights, centre: &self.centre, from: &self.start };
        let (mut total, mut standing) = (NewtonReport::default(), guess);
        for _ in 0..FRICTION_ROUNDS {
            let report = minimise(body, &inertia, &self.options.newton, (&mut self.u, standing), &mut self.workspace)?;
            total.iterations += report.iterations;
            total.linear_iterations += report.linear_iterations;
            total.projected += report.projected;
            (total.relative_residual, total.energies) = (report.relative_residual, report.energies);
            let change = body.renew_friction(&self.u);
            if change == 0.0 {
                break;
            }
            // With other limits the energy is another one.
            standing = self.workspace.evaluate(body, &inertia, &self.u).map_err(NewtonError::Start)?;
            total.energies = standing.energies;
            if change < FRICTION_CHANGE {
                break;
            }
        }
        Ok(total)
    }

    /// Adds the work done during the step to the books, `lifted` being the change of the energy of the loads. For the midpoint rule forces are
    /// those at the midpoint.
    fn account(
        &mut self,
        body: &dyn Body,
        weights: QuadraticWeights,
        (length, half): (f64, bool),
        lifted: f64,
        report: &mut StepReport,
    ) {
        let factor = if half { 2.0 } else { 1.0 };
        let (u, start) = (&self.u, &self.start);
        report.work_of_holds += self.workspace.work_of_holds(body, |i| factor * (u[i] - start[i]));
        report.work_of_loads -= factor * lifted;
        let Damping { mass, stiffness } = self.options.damping;
        if mass > 0.0 {
            let square = |n: usize| (3 * n..3 * n + 3).map(|i| (u[i] - start[i]).powi(2)).sum::<f64>();
            let drag: f64 = body.mass().iter().enumerate().map(|(n, m)| m * square(n)).sum();
            report.damped += factor * mass / length * drag;
        }
        if stiffness > 0.0 {
            self.product.clear();
            self.product.resize(u.len(), 0.0);
            let difference: Vec<f64> = u.iter().zip(start).map(|(u, s)| u - s).collect();
            body.add_damping(weights.damping, &difference, &mut self.product);
            report.damped += factor * difference.iter().zip(&self.product).map(|(d, p)| d * p).sum::<f64>();
        }
    }

    /// Takes the new displacements and velocities over into the state.
    fn finish(
        &mut self,
        body: &mut dyn Body,
        state: &mut State,
        (length, half): (f64, bool),
        energies: Energies,
    ) -> Result<Energies, NewtonError> {
        let mut energies = energies;
        if half {
            self.u.iter_mut().zip(&self.start).for_each(|(u, start)| *u = 2.0 * *u - start);
            // The second half of the motion is not a minimum: it may invert what the first half did not.
            energies = body.energies(&self.u).map_err(NewtonError::Start)?;
        }
        body.settle_friction(&self.u);
        let step = if half { 2.0 * length } else { length };
        for i in 0..self.u.len() {
            let mean = (self.u[i] - self.start[i]) / step;
            let goes_on = half && !body.constraints().is_fixed(i / 3, i % 3);
            state.velocity[i] = if goes_on { 2.0 * mean - state.velocity[i] } else { mean };
        }
        state.displacement.clone_from(&self.u);
        Ok(energies)
    }
}

/// Refuses a state that has no energy, e.g. to start from.
///
/// # Errors
/// What is inverted.
pub fn check_state(body: &dyn Body, state: &State) -> Result<Energies, Inversion> {
    match state.displacement.iter().chain(&state.velocity).all(|value| value.is_finite()) {
        true => body.energies(&state.displacement),
        false => Err(Inversion::NotFinite),
    }
}
