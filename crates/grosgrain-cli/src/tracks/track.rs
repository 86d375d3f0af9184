//! One model of a body, fine or coarse, on its way through a run.

use std::time::Instant;

use grosgrain::coarse::{CoarseModel, Embedding, build};
use grosgrain::coarsening::Objective;
use grosgrain::dynamics::{
    Body, CoarseMechanics, Energies, EquilibriumOptions, EquilibriumReport, FineMechanics, Inversion, LoadPath, Moment,
    NewtonOptions, State, StepOptions, StepReport, Stepper, check_state, find_equilibrium,
};
use grosgrain::mesh::{Cell, Node};
use grosgrain::training::RunTimeTraining;
use grosgrain::update::{LiveCoarse, LiveOptions, UpdateReport};

use super::acting::conditions;
use crate::failure::Failure;
use crate::interruption;
use crate::method::Method;
use crate::outcome::failed;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::report::ModelSize;

/// What a track runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The fine model.
    Fine,
    /// A coarse model.
    Coarse {
        /// How it is made.
        method: Method,
        /// Whether edits renew its shape functions.
        update: bool,
    },
}

/// What a model is called beside others.
impl std::fmt::Display for Kind {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Fine => formatter.write_str("fine"),
            Self::Coarse { method, update: true } => write!(formatter, "coarse, {method}"),
            Self::Coarse { method, update: false } => write!(formatter, "coarse, {method}, no update"),
        }
    }
}

/// A model in motion.
pub struct Track {
    /// What it is.
    pub kind: Kind,
    /// Motion of its nodes.
    pub state: State,
    /// What it costs and what it has done so far.
    pub books: Books,
    model: Model,
    stepper: Stepper,
    balance: EquilibriumOptions,
    /// Which fine nodes there are, to carry the fine motion over to an edited body.
    active: Vec<bool>,
    /// Motion and books before the last step.
    before: (State, Books),
}

/// Sums over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Books {
    /// Seconds for the first build: training, fitting, assembly.
    pub build: [f64; 3],
    /// Seconds for all updates after edits: training, fitting, all of it.
    pub updates: [f64; 3],
    /// Seconds for all steps or equilibria.
    pub solving: f64,
    /// Steps or equilibria made.
    pub steps: usize,
    /// Steps that were made in several parts.
    pub divided: usize,
    /// Newton steps.
    pub newton: usize,
    /// Iterations of linear solvers.
    pub linear: usize,
    /// Work of loads and of moved holds since the start \[J\].
    pub work: f64,
    /// Kinetic plus stored energy at the start \[J\].
    pub start: f64,
    /// Energy that edits have put in, negative where they took some away \[J\].
    pub edited: f64,
    /// Elastic energy \[J\].
    pub elastic: f64,
    /// The largest elastic energy of all steps \[J\].
    pub most_elastic: f64,
    /// Of springs and ground \[J\].
    pub points: f64,
    /// Kinetic energy \[J\].
    pub kinetic: f64,
    /// Worst relative residual of a step.
    pub residual: f64,
}

impl Books {
    /// What has gone since the start: work put in that is stored no more \[J\].
    pub fn dissipated(&self) -> f64 {
        self.start + self.work + self.edited - self.stored()
    }

    /// The largest elastic energy over that of the fine model, one where that has none: near zero the energies at the end tell little.
    pub fn ratio_of_peaks(&self, fine: &Self) -> f64 {
        if fine.most_elastic > 0.0 { self.most_elastic / fine.most_elastic } else { 1.0 }
    }

    /// Seconds of a step or an equilibrium.
    pub fn seconds_per_step(&self) -> f64 {
        self.solving / self.steps.max(1) as f64
    }

    /// Adds a step that took so many seconds.
    pub fn add_step(&mut self, seconds: f64, report: &StepReport) {
        self.add(seconds, report.substeps > 1, &report.energies);
        self.newton += report.newton_iterations;
        self.linear += report.linear_iterations;
        self.residual = self.residual.max(report.relative_residual);
        self.work += report.work_of_loads + report.work_of_holds;
        self.kinetic = report.kinetic;
    }

    /// Adds an equilibrium that took so many seconds.
    pub fn add_equilibrium(&mut self, seconds: f64, report: &EquilibriumReport) {
        self.add(seconds, report.failures > 0, &report.energies);
        self.newton += report.newton_iterations;
        self.linear += report.linear_iterations;
        self.residual = self.residual.max(report.relative_residual);
    }

    fn add(&mut self, seconds: f64, divided: bool, energies: &Energies) {
        self.solving += seconds;
        self.steps += 1;
        self.divided += usize::from(divided);
        (self.elastic, self.points) = (energies.elastic, energies.points);
        self.most_elastic = self.most_elastic.max(self.elastic);
    }

    /// What is there: kinetic, elastic, in springs and in the ground \[J\].
    pub fn stored(&self) -> f64 {
        self.kinetic + self.elastic + self.points
    }
}

enum Model {
    Fine(Box<FineMechanics>),
    Coarse { source: Source, mechanics: Box<CoarseMechanics> },
}

/// Where the coarse model comes from.
enum Source {
    /// Renewed where an edit reaches.
    Live(Box<LiveCoarse>),
    /// Built anew after every edit.
    Built(Box<CoarseModel>),
}

impl Source {
    fn model(&self) -> &CoarseModel {
        match self {
            Self::Live(live) => live.model(),
            Self::Built(model) => model,
        }
    }
}

/// What an edit cost a track.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Update {
    /// Elements that were made anew.
    pub dirty: usize,
    /// Seconds for training, fitting, all of it.
    pub seconds: [f64; 3],
}

impl Track {
    /// A model of the body as it is now, at the start of the run.
    ///
    /// # Errors
    /// A coarse model that cannot be built; systems that do not fit into memory; an interruption.
    pub fn new(problem: &Problem, kind: Kind, progress: &Progress) -> Result<Self, Failure> {
        let mut books = Books::default();
        let model = match kind {
            Kind::Fine => {
                let mechanics = FineMechanics::new(&problem.model, conditions(problem));
                Model::Fine(Box::new(mechanics.map_err(|error| failed(&error))?))
            }
            Kind::Coarse { method, update } => {
                progress.say(&format!("building the coarse model: {method}"));
                let source = source(problem, (method, update), &mut books, progress)?;
                let integration = match method {
                    // Its material is the volume's mean, which has no fine cells to integrate over.
                    Method::Average => grosgrain::coarse::Integration::Stiffness,
                    _ => problem.scene.coarsening.integration_or_default(),
                };
                let mechanics = CoarseMechanics::new(&problem.model, source.model(), integration, conditions(problem));
                Model::Coarse { source, mechanics: Box::new(mechanics.map_err(|error| failed(&error))?) }
            }
        };
        let time = &problem.scene.time;
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
        let active = problem.model.active().to_vec();
        let before = (State::default(), books);
        let mut track = Self { kind, state: State::default(), books, model, stepper, balance, active, before };
        track.state = track.start(problem);
        if problem.scene.is_dynamic() {
            track.stand(problem, 0.0)?;
            track.books.start = track.books.stored();
        }
        Ok(track)
    }

    /// Brings the energies of the books up to date with the motion at a time \[s\].
    fn stand(&mut self, problem: &Problem, time: f64) -> Result<(), Failure> {
        let Self { model, state, .. } = self;
        let energies = with_body(model, problem, |body| {
            body.set_moment(Moment { loads: time, share: 1.0, holds: time }).map_err(|error| failed(&error))?;
            let energies: Energies = check_state(body, state).map_err(|error| failed(&error))?;
            Ok::<_, Failure>((energies, state.kinetic_energy(body.mass())))
        });
        let (energies, kinetic) = energies?;
        let books = &mut self.books;
        (books.elastic, books.points, books.kinetic) = (energies.elastic, energies.points, kinetic);
        match books.stored().is_finite() {
            true => Ok(()),
            false => Err(failed(&"the energy is not finite; check the units of velocities, moduli and densities")),
        }
    }

    /// Keeps motion and books, for [`Track::take_back`].
    fn keep(&mut self) {
        self.before.0.clone_from(&self.state);
        self.before.1 = self.books;
    }

    /// Takes the last step back, or what a step that failed has made of it.
    pub fn take_back(&mut self) {
        self.state.clone_from(&self.before.0);
        self.books = self.before.1;
    }

    /// Rest, or the velocity of `[start]` at all nodes.
    fn start(&self, problem: &Problem) -> State {
        let positions = self.rest_positions(problem);
        let mut state = State::rest(positions.len());
        if !problem.scene.start.is_at_rest() {
            let motion = problem.initial_velocity();
            let mass = self.mass();
            for (n, position) in positions.iter().enumerate().filter(|(n, _)| mass[*n] > 0.0) {
                state.velocity[3 * n..3 * n + 3].copy_from_slice(&motion.at(*position));
            }
        }
        state
    }

    fn rest_positions(&self, problem: &Problem) -> Vec<[f64; 3]> {
        let place = |node| problem.model.node_position(node);
        match self.coarse() {
            None => (0..problem.model.grid().lattice.node_count()).map(|n| place(Node(n))).collect(),
            Some(coarse) => {
                let node = |v: &grosgrain::partition::Vertex| coarse.partition().coincident_node(v.node);
                coarse.mesh().vertices().iter().map(|v| place(node(v))).collect()
            }
        }
    }

    /// The coarse model; `None` for the fine track.
    pub fn coarse(&self) -> Option<&CoarseModel> {
        match &self.model {
            Model::Fine(_) => None,
            Model::Coarse { source, .. } => Some(source.model()),
        }
    }

    fn mass(&self) -> &[f64] {
        match &self.model {
            Model::Fine(mechanics) => mechanics.mass(),
            Model::Coarse { source, .. } => source.model().mass(),
        }
    }

    /// Momentum \[N s\] and angular momentum about the origin \[N m s\].
    pub fn momenta(&self, problem: &Problem) -> ([f64; 3], [f64; 3]) {
        let positions = self.rest_positions(problem);
        self.state.momenta(self.mass(), |n| positions[n])
    }

    /// Size of the model.
    pub fn size(&self, problem: &Problem) -> ModelSize {
        match self.coarse() {
            None => problem.fine_size(),
            Some(coarse) => {
                let nodes = coarse.mesh().vertices().len();
                ModelSize { cells: coarse.elements().len(), nodes, unknowns: 3 * nodes }
            }
        }
    }

    /// Displacement \[m\] of the fine nodes, three per lattice node.
    ///
    /// # Errors
    /// A coarse cell that is inverted.
    pub fn displacement(&self, problem: &Problem) -> Result<Vec<f64>, Failure> {
        self.embedded(problem, &self.state.displacement).map_err(|error| failed(&error))
    }

    /// Velocity \[m/s\] of the fine nodes: for a coarse model the change of the embedded displacement in a very short time.
    ///
    /// # Errors
    /// A coarse cell that is inverted.
    pub fn velocity(&self, problem: &Problem) -> Result<Vec<f64>, Failure> {
        let State { displacement, velocity } = &self.state;
        if self.coarse().is_none() {
            return Ok(velocity.clone());
        }
        let fastest = velocity.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        let size = problem.model.grid().spacing.iter().fold(f64::INFINITY, |least, h| least.min(*h));
        let instant = if fastest > 0.0 { 1e-6 * size / fastest } else { 1.0 };
        let shifted = |by: f64| -> Vec<f64> { displacement.iter().zip(velocity).map(|(u, v)| u + by * v).collect() };
        let (after, before) = (self.embedded(problem, &shifted(instant)), self.embedded(problem, &shifted(-instant)));
        let (after, before) = (after.map_err(|e| failed(&e))?, before.map_err(|e| failed(&e))?);
        Ok(after.iter().zip(&before).map(|(a, b)| (a - b) / (2.0 * instant)).collect())
    }

    fn embedded(&self, problem: &Problem, displacement: &[f64]) -> Result<Vec<f64>, Inversion> {
        match &self.model {
            Model::Fine(_) => {
                let active = problem.model.active();
                Ok(displacement.iter().enumerate().map(|(i, u)| if active[i / 3] { *u } else { 0.0 }).collect())
            }
            Model::Coarse { source, mechanics } => {
                let coarse = source.model();
                mechanics.prolong(coarse, &Embedding::new(coarse), displacement)
            }
        }
    }

    /// Makes one step of `length` from `time` \[s\].
    ///
    /// # Errors
    /// A step that fails however short its parts are.
    pub fn advance(&mut self, problem: &Problem, time: f64, length: f64) -> Result<StepReport, Failure> {
        self.keep();
        let start = Instant::now();
        let Self { model, state, stepper, .. } = self;
        let report = with_body(model, problem, |body| stepper.advance(body, state, time, length));
        let report = report.map_err(|error| failed(&error))?;
        self.books.add_step(start.elapsed().as_secs_f64(), &report);
        Ok(report)
    }

    /// Finds the equilibrium at the end of a path.
    ///
    /// # Errors
    /// No equilibrium; an interruption.
    pub fn balance(
        &mut self,
        problem: &Problem,
        path: &LoadPath,
        progress: &Progress,
    ) -> Result<EquilibriumReport, Failure> {
        self.keep();
        let start = Instant::now();
        let Self { model, state, balance, .. } = self;
        let told = |share: f64| progress.report("loading", (100.0 * share) as usize, 100);
        let found =
            with_body(model, problem, |body| find_equilibrium(body, &mut state.displacement, path, balance, &told));
        progress.close();
        let report = found.map_err(|error| failed(&error))?;
        self.books.add_equilibrium(start.elapsed().as_secs_f64(), &report);
        Ok(report)
    }

    /// Takes over a body that was edited in these cells at a time \[s\].
    ///
    /// # Errors
    /// Training, fits or systems that fail; a motion that the edited body cannot have; an interruption.
    pub fn follow(
        &mut self,
        problem: &Problem,
        (time, changed): (f64, &[Cell]),
        progress: &Progress,
    ) -> Result<Update, Failure> {
        let start = Instant::now();
        let Self { model, state, .. } = self;
        let points = with_body(model, problem, |body| body.energy_of_points(&state.displacement));
        self.books.points = points.map_err(|error| failed(&error))?;
        let before = self.books.stored();
        let acting = conditions(problem);
        let mut update = Update::default();
        match &mut self.model {
            Model::Fine(mechanics) => {
                mechanics.renew(&problem.model, acting).map_err(|error| failed(&error))?;
                let grid = problem.model.grid();
                self.state.carry((grid.lattice, grid.spacing), &self.active, problem.model.active());
                self.active = problem.model.active().to_vec();
            }
            Model::Coarse { source, mechanics } => {
                let before = source.model().mesh().clone();
                let dirty = match source {
                    Source::Live(live) => {
                        let mut report = UpdateReport::default();
                        let told = |stage, done, total| progress.report(stage, done, total);
                        let renewed = live.renew(&problem.model, changed, true, &mut report, &told);
                        progress.close();
                        renewed.map_err(|error| failed(&error))?;
                        update.seconds = [report.seconds.training, report.seconds.fitting, 0.0];
                        live.renewed().to_vec()
                    }
                    Source::Built(model) => {
                        let Kind::Coarse { method, .. } = self.kind else { return Ok(update) };
                        **model = build_anew(problem, method, progress)?;
                        model.elements().to_vec()
                    }
                };
                let coarse = source.model();
                update.dirty = dirty.len();
                let renewed = mechanics.renew((&problem.model, coarse), &dirty, acting);
                renewed.map_err(|error| failed(&error))?;
                self.state.carry_vertices(&before, coarse.mesh(), coarse.spacing());
            }
        }
        self.stand(problem, time).map_err(|failure| match failure {
            Failure::Failed(sentence) => Failure::Failed(format!(
                "the edit leaves a motion that the body cannot have: {sentence}; edit where it is deformed less"
            )),
            other => other,
        })?;
        self.books.edited += self.books.stored() - before;
        update.seconds[2] = start.elapsed().as_secs_f64();
        (0..3).for_each(|n| self.books.updates[n] += update.seconds[n]);
        Ok(update)
    }
}

fn with_body<T>(model: &mut Model, problem: &Problem, act: impl FnOnce(&mut dyn Body) -> T) -> T {
    match model {
        Model::Fine(mechanics) => act(&mut mechanics.on(&problem.model)),
        Model::Coarse { source, mechanics } => act(&mut mechanics.on(&problem.model, source.model())),
    }
}

fn source(
    problem: &Problem,
    (method, update): (Method, bool),
    books: &mut Books,
    progress: &Progress,
) -> Result<Source, Failure> {
    interruption::check()?;
    let coarsening = &problem.scene.coarsening;
    let start = Instant::now();
    let kind = problem.run_time_training(method).filter(|_| coarsening.objective == Objective::ClosedForm);
    let Some(kind) = kind else {
        let model = build_anew(problem, method, progress)?;
        books.build = [0.0, 0.0, start.elapsed().as_secs_f64()];
        return Ok(Source::Built(Box::new(model)));
    };
    let options = LiveOptions {
        training: RunTimeTraining::Fixed(kind),
        data_tolerance: coarsening.data_tolerance,
        base: coarsening.base,
        split: coarsening.split,
        renew_functions: update,
        ..LiveOptions::default()
    };
    let mut report = UpdateReport::default();
    let told = |stage, done, total| progress.report(stage, done, total);
    let live = LiveCoarse::new(&problem.model, coarsening.degree, &options, &mut report, &told);
    progress.close();
    let seconds = report.seconds;
    books.build = [seconds.training, seconds.fitting, seconds.assembly];
    Ok(Source::Live(Box::new(live.map_err(|error| failed(&error))?)))
}

fn build_anew(problem: &Problem, method: Method, progress: &Progress) -> Result<CoarseModel, Failure> {
    let Some(options) = problem.build_options(method) else {
        return Err(Failure::Unusable("the method fine has no coarse model; expected a coarse method".into()));
    };
    let told = |stage, done, total| progress.report(stage, done, total);
    let built = build(&problem.model, problem.scene.coarsening.degree, &options, &told);
    progress.close();
    Ok(built.map_err(|error| failed(&error))?.model)
}
