//! One mesh of simplices, fine or coarse, on its way through a run.

use std::time::Instant;

use grosgrain::dynamics::{
    Body, EquilibriumOptions, EquilibriumReport, LoadPath, Moment, NewtonOptions, SimplexBody, State, StepOptions,
    StepReport, Stepper, check_state, find_equilibrium,
};

use crate::failure::Failure;
use crate::outcome::failed;
use crate::progress::Progress;
use crate::scene::Time;
use crate::tracks::Books;

/// A mesh in motion.
pub struct SimplexTrack {
    /// What it is called beside others.
    pub name: String,
    /// Motion of its own nodes.
    pub state: State,
    /// What it costs and what it has done so far.
    pub books: Books,
    body: SimplexBody,
    stepper: Stepper,
    balance: EquilibriumOptions,
    /// Motion and books before the last step.
    before: (State, Books),
}

impl SimplexTrack {
    /// A body at rest, run as `time` says.
    ///
    /// # Errors
    /// Energies that are not finite.
    pub fn new(name: impl Into<String>, body: SimplexBody, time: &Time) -> Result<Self, Failure> {
        let newton = NewtonOptions { tolerance: time.tolerance, ..NewtonOptions::default() };
        let stepper = Stepper::new(StepOptions {
            integrator: time.integrator,
            damping: time.damping,
            newton,
            max_halvings: time.halvings,
        });
        let balance = EquilibriumOptions {
            newton: NewtonOptions { max_iterations: 60, ..newton },
            increments: time.increments,
            max_halvings: time.halvings,
        };
        let state = body.rest();
        let before = (state.clone(), Books::default());
        let mut track = Self { name: name.into(), state, books: Books::default(), body, stepper, balance, before };
        track.stand(0.0)?;
        Ok(track)
    }

    /// What it is made of.
    pub fn body(&self) -> &SimplexBody {
        &self.body
    }

    /// Masses \[kg\] of the nodes.
    pub fn mass(&self) -> &[f64] {
        self.body.mass()
    }

    /// Starts from this motion at time zero instead of rest.
    ///
    /// # Errors
    /// A motion whose energies are not finite.
    pub fn start_from(&mut self, state: State) -> Result<(), Failure> {
        self.state = state;
        self.stand(0.0)
    }

    /// Brings the energies of the books up to date with the motion at a time \[s\], the start of the run.
    fn stand(&mut self, time: f64) -> Result<(), Failure> {
        let Self { body, state, .. } = self;
        body.set_moment(Moment { loads: time, share: 1.0, holds: time }).map_err(|error| failed(&error))?;
        let energies = check_state(body, state).map_err(|error| failed(&error))?;
        let books = &mut self.books;
        (books.elastic, books.points) = (energies.elastic, energies.points);
        books.kinetic = state.kinetic_energy(body.mass());
        books.start = books.stored();
        match books.start.is_finite() {
            true => Ok(()),
            false => Err(failed(&"the energy is not finite; check the units of velocities, moduli and densities")),
        }
    }

    fn keep(&mut self) {
        self.before.0.clone_from(&self.state);
        self.before.1 = self.books;
    }

    /// Takes the last step back, or what a step that failed has made of it.
    pub fn take_back(&mut self) {
        self.state.clone_from(&self.before.0);
        self.books = self.before.1;
    }

    /// Makes one step of `length` from `time` \[s\].
    ///
    /// # Errors
    /// A step that fails however short its parts are.
    pub fn advance(&mut self, time: f64, length: f64) -> Result<StepReport, Failure> {
        self.keep();
        let start = Instant::now();
        let report = self.stepper.advance(&mut self.body, &mut self.state, time, length);
        let report = report.map_err(|error| failed(&error))?;
        self.books.add_step(start.elapsed().as_secs_f64(), &report);
        Ok(report)
    }

    /// Finds the equilibrium at the end of a path.
    ///
    /// # Errors
    /// No equilibrium; an interruption.
    pub fn balance(&mut self, path: &LoadPath, progress: &Progress) -> Result<EquilibriumReport, Failure> {
        self.keep();
        let start = Instant::now();
        let told = |share: f64| progress.report("loading", (100.0 * share) as usize, 100);
        let Self { body, state, balance, .. } = self;
        let found = find_equilibrium(body, &mut state.displacement, path, balance, &told);
        progress.close();
        let report = found.map_err(|error| failed(&error))?;
        self.books.add_equilibrium(start.elapsed().as_secs_f64(), &report);
        Ok(report)
    }
}
