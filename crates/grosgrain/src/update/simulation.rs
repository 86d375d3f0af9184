//! A body that moves while it is edited.

use super::{Edit, LiveError, LiveModel, LiveOptions, UpdateReport};
use crate::coarse::{CoarseModel, Embedding, Integration};
use crate::dynamics::{
    CoarseMechanics, Conditions, Inversion, State, StepError, StepOptions, StepReport, Stepper, TangentError,
};
use crate::fine::FineModel;
use crate::progress::{Progress, silent};

/// What acts on a body, as a function of the body: its weight changes when cells are removed.
pub type Acting = Box<dyn Fn(&FineModel) -> Conditions + Send>;

/// Options of a [`Simulation`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SimulationOptions {
    /// How the coarse model is made and renewed.
    pub live: LiveOptions,
    /// Where the elastic energy is evaluated.
    pub integration: Integration,
    /// How steps are made.
    pub steps: StepOptions,
}

/// Why there is no simulation, or why an edit was not made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// The coarse model was not made or renewed.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// The systems of its steps cannot be analysed.
    #[error(transparent)]
    Steps(#[from] TangentError),
}

/// A body, its coarse model, and its motion in time: steps and edits in any order.
pub struct Simulation {
    live: LiveModel,
    mechanics: CoarseMechanics,
    stepper: Stepper,
    acting: Acting,
    time: f64,
}

impl Simulation {
    /// A body at rest at time zero. Nodes that `acting` holds at time zero are what loose parts are loose from.
    ///
    /// # Errors
    /// A degree that does not divide the lattice, training or fitting that fails, a mesh that cannot be analysed, an interruption.
    pub fn new(
        fine: FineModel,
        degree: usize,
        options: &SimulationOptions,
        acting: Acting,
        progress: Progress<'_>,
    ) -> Result<Self, SimulationError> {
        let conditions = acting(&fine);
        let held = conditions.holds.fixed_at(0.0, fine.grid().lattice.node_count());
        let live = LiveModel::new(fine, degree, &options.live, held, progress)?;
        let mechanics = CoarseMechanics::new(live.fine(), live.coarse(), options.integration, conditions)?;
        Ok(Self { live, mechanics, stepper: Stepper::new(options.steps), acting, time: 0.0 })
    }

    /// Advances by `step` \[s\].
    ///
    /// # Errors
    /// As [`Stepper::advance`]: motion and [`time`](Self::time) are then the last ones that were reached.
    pub fn step(&mut self, step: f64) -> Result<StepReport, StepError> {
        let Self { live, mechanics, stepper, time, .. } = self;
        let (fine, coarse, state) = live.parts_mut();
        let made = stepper.advance(&mut mechanics.on(fine, coarse), state, *time, step);
        *time = match &made {
            Ok(_) => *time + step,
            Err(failed) => failed.time - failed.smallest,
        };
        made
    }

    /// Makes an edit between two steps; the motion goes on.
    ///
    /// # Errors
    /// An edit that is refused, training or fitting that fails ([`SimulationError::Live`]); everything is then as it was. After
    /// [`SimulationError::Steps`], a system that does not fit into memory, body and motion are those after the edit, but no step can be made.
    pub fn apply(&mut self, edit: &Edit) -> Result<UpdateReport, SimulationError> {
        self.apply_all(std::slice::from_ref(edit), &silent)
    }

    /// Makes several edits as one update.
    ///
    /// # Errors
    /// As [`Simulation::apply`]; an interruption.
    pub fn apply_all(&mut self, edits: &[Edit], progress: Progress<'_>) -> Result<UpdateReport, SimulationError> {
        let report = self.live.apply_all(edits, progress)?;
        if report.changed_fine > 0 {
            self.follow()?;
        }
        Ok(report)
    }

    /// Undoes the last update, `None` where there is none; the motion goes on.
    ///
    /// # Errors
    /// As [`Simulation::apply`].
    pub fn undo(&mut self) -> Result<Option<UpdateReport>, SimulationError> {
        let report = self.live.undo(&silent)?;
        if report.is_some() {
            self.follow()?;
        }
        Ok(report)
    }

    fn follow(&mut self) -> Result<(), SimulationError> {
        let conditions = (self.acting)(self.live.fine());
        let (fine, coarse) = (self.live.fine(), self.live.coarse());
        self.mechanics.renew((fine, coarse), self.live.renewed(), conditions)?;
        Ok(())
    }

    /// The body.
    pub fn fine(&self) -> &FineModel {
        self.live.fine()
    }

    /// Its coarse model.
    pub fn coarse(&self) -> &CoarseModel {
        self.live.coarse()
    }

    /// Motion of the coarse vertices.
    pub fn state(&self) -> &State {
        &self.live.state
    }

    /// The same, to be set: a start, a push.
    pub fn state_mut(&mut self) -> &mut State {
        &mut self.live.state
    }

    /// Time \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Displacement \[m\] of the fine nodes, three per lattice node: the coarse motion embedded.
    ///
    /// # Errors
    /// A coarse cell that is inverted: never after a step.
    pub fn fine_displacement(&self) -> Result<Vec<f64>, Inversion> {
        let coarse = self.live.coarse();
        self.mechanics.prolong(coarse, &Embedding::new(coarse), &self.live.state.displacement)
    }
}
