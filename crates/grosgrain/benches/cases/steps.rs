//! Steps in time of the papers' moving bodies, fine and coarse.

use grosgrain::coarse::{BuildOptions, CoarseModel, Embedding, Integration, Method, build};
use grosgrain::dynamics::{
    Body, CoarseMechanics, Conditions, FineMechanics, Hold, Holds, Motion, Ramp, Schedule, State, StepOptions,
    StepReport, Stepper, TimedLoad, Twist,
};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::{Elasticity, IsotropicMaterial, Law, Material, MaterialTable};
use grosgrain::mesh::{Label, Node, Pattern, VoxelGrid, pad_to_multiple};
use grosgrain::progress::silent;
use grosgrain::training::TrainingKind;

use super::Outcome;
use super::updates::trunk_on;

/// Acceleration of gravity [m/s²].
const GRAVITY: f64 = 9.81;
/// Edge lengths of the cells of the beam and of the plate [m].
const SPACING: [f64; 3] = [0.01; 3];

/// A body that is held and loaded, and how it is stepped.
pub struct MovingBody {
    pub name: &'static str,
    pub fine: FineModel,
    pub degree: usize,
    pub training: TrainingKind,
    pub conditions: Conditions,
    /// Length of a step [s].
    pub step: f64,
}

impl MovingBody {
    /// 24 × 8 × 8 cells in oblique layers two cells thick, ratio of moduli 50, that hang from one end: 24 coarse cells of degree 4.
    pub fn beam() -> Outcome<Self> {
        let grid = layers([24, 8, 8], [1.0; 3])?;
        let fine = FineModel::new(grid, &two([1e5, 5e6], 1000.0)?)?;
        let conditions = hanging(&fine, 0, [0.0, 0.0, -GRAVITY]);
        Ok(Self { name: "beam", fine, degree: 4, training: TrainingKind::Global, conditions, step: 0.01 })
    }

    /// 24 × 24 × 8 cells with a grid of stiff bars that is held at one side and twisted at the other by a quarter turn a second: 72 coarse
    /// cells of degree 4.
    pub fn plate() -> Outcome<Self> {
        let mut grid = VoxelGrid::uniform([24, 24, 8], SPACING, Label(1));
        for (c, label) in grid.labels.iter_mut().enumerate() {
            let (i, j) = (c % 24, c / 24 % 24);
            let is_bar = |x: usize| matches!(x % 6, 2 | 3);
            *label = if is_bar(i) || is_bar(j) { Label(2) } else { Label(1) };
        }
        let fine = FineModel::new(grid, &two([1e5, 1e7], 1000.0)?)?;
        let axis = [0.0, 0.12, 0.04];
        let motion = Motion { twist: Twist::about([1.0, 0.0, 0.0], axis, std::f64::consts::PI), ..Motion::default() };
        let twisted = Hold { motion, ramp: Ramp { from: 0.0, to: 2.0 }, ..Hold::still("twisted", side(&fine, 0, 24)) };
        let holds = Holds(vec![Hold::still("held", side(&fine, 0, 0)), twisted]);
        let conditions = Conditions { holds, ..Conditions::default() };
        Ok(Self { name: "plate", fine, degree: 4, training: TrainingKind::OneRing, conditions, step: 0.01 })
    }

    /// The trunk from a CT on 48 × 48 × 36 voxels, 0.1 and 100 MPa, held where the scan ends, under its weight, in coarse cells of degree 2.
    pub fn trunk() -> Outcome<Self> {
        Self::trunk_of("trunk", [48, 48, 36], 2, 1.0)
    }

    /// The same on 36 × 30 × 34 voxels in coarse cells of degree 3, its weight multiplied by `load`.
    pub fn torso(name: &'static str, load: f64) -> Outcome<Self> {
        Self::trunk_of(name, [36, 30, 34], 3, load)
    }

    fn trunk_of(name: &'static str, cells: [usize; 3], degree: usize, load: f64) -> Outcome<Self> {
        let grid = pad_to_multiple(&trunk_on(cells)?, degree, Label(-1)).grid;
        let fine = FineModel::new(grid, &two([1e5, 1e8], 1500.0)?)?;
        let conditions = hanging(&fine, 2, [0.0, load * GRAVITY, 0.0]);
        Ok(Self { name, fine, degree, training: TrainingKind::OneRing, conditions, step: 0.01 })
    }

    /// Its coarse model.
    pub fn coarse(&self) -> Outcome<CoarseModel> {
        let options = BuildOptions { method: Method::Trained(self.training), ..BuildOptions::default() };
        Ok(build(&self.fine, self.degree, &options, &silent)?.model)
    }

    /// The fine model at rest.
    pub fn fine_steps(&self, options: StepOptions) -> Outcome<Steps<'_>> {
        let mechanics = FineMechanics::new(&self.fine, self.conditions.clone())?;
        let state = State::rest(self.fine.grid().lattice.node_count());
        Ok(self.steps(Mechanics::Fine(Box::new(mechanics)), state, options))
    }

    /// The coarse model at rest.
    pub fn coarse_steps<'a>(
        &'a self,
        coarse: &'a CoarseModel,
        integration: Integration,
        options: StepOptions,
    ) -> Outcome<Steps<'a>> {
        let mechanics = CoarseMechanics::new(&self.fine, coarse, integration, self.conditions.clone())?;
        Ok(self.steps(Mechanics::Coarse(coarse, Box::new(mechanics)), CoarseMechanics::rest(coarse), options))
    }

    fn steps<'a>(&'a self, mechanics: Mechanics<'a>, state: State, options: StepOptions) -> Steps<'a> {
        Steps { body: self, mechanics, state, stepper: Stepper::new(options), made: 0 }
    }
}

enum Mechanics<'a> {
    Fine(Box<FineMechanics>),
    Coarse(&'a CoarseModel, Box<CoarseMechanics>),
}

/// A body in motion.
pub struct Steps<'a> {
    body: &'a MovingBody,
    mechanics: Mechanics<'a>,
    pub state: State,
    stepper: Stepper,
    made: usize,
}

impl Steps<'_> {
    /// Number of unknowns, held ones included.
    pub fn unknowns(&self) -> usize {
        self.state.displacement.len()
    }

    /// Lets the body, and the motion, be used.
    pub fn with_body<T>(&mut self, act: impl FnOnce(&mut dyn Body, &mut State) -> T) -> T {
        let Self { body, mechanics, state, .. } = self;
        match mechanics {
            Mechanics::Fine(mechanics) => act(&mut mechanics.on(&body.fine), state),
            Mechanics::Coarse(coarse, mechanics) => act(&mut mechanics.on(&body.fine, coarse), state),
        }
    }

    /// Displacement of the fine nodes.
    pub fn fine_displacement(&self) -> Outcome<Vec<f64>> {
        match &self.mechanics {
            Mechanics::Fine(_) => Ok(self.state.displacement.clone()),
            Mechanics::Coarse(coarse, mechanics) => {
                Ok(mechanics.prolong(coarse, &Embedding::new(coarse), &self.state.displacement)?)
            }
        }
    }

    /// Makes the next step.
    pub fn advance(&mut self) -> Outcome<StepReport> {
        let Self { body, mechanics, state, stepper, made } = self;
        let time = *made as f64 * body.step;
        let report = match mechanics {
            Mechanics::Fine(mechanics) => stepper.advance(&mut mechanics.on(&body.fine), state, time, body.step)?,
            Mechanics::Coarse(coarse, mechanics) => {
                stepper.advance(&mut mechanics.on(&body.fine, coarse), state, time, body.step)?
            }
        };
        *made += 1;
        Ok(report)
    }
}

fn layers(cells: [usize; 3], direction: [f64; 3]) -> Outcome<VoxelGrid> {
    let mut grid = VoxelGrid::uniform(cells, SPACING, Label(1));
    Pattern::Layers { direction, period: 4.0, labels: vec![Label(1), Label(2)] }.paint(&mut grid)?;
    Ok(grid)
}

/// Two neo-Hookean materials, Poisson's ratio 0.45.
fn two(young: [f64; 2], stiff_density: f64) -> Outcome<MaterialTable> {
    let mut table = MaterialTable::new();
    for (label, young, density) in [(1, young[0], 1000.0), (2, young[1], stiff_density)] {
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45)?);
        let material = Material::linear(format!("material {label}"), elasticity, density);
        table.insert(Label(label), Material { law: Law::NeoHookean, ..material });
    }
    Ok(table)
}

fn hanging(fine: &FineModel, axis: usize, acceleration: [f64; 3]) -> Conditions {
    let load = TimedLoad { forces: gravity(fine, acceleration), schedule: Schedule::default() };
    let holds = Holds(vec![Hold::still("held", side(fine, axis, 0))]);
    Conditions { holds, loads: vec![load], ..Conditions::default() }
}

/// The nodes of a plane of the lattice.
fn side(fine: &FineModel, axis: usize, at: usize) -> Vec<bool> {
    let lattice = fine.grid().lattice;
    (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[axis] == at).collect()
}
