//! A bar, the kinds of models that step it, and runs from rest, shared by the tests of motion.
#![allow(dead_code, reason = "every test binary takes the part it needs")]

use crate::bodies::isotropic;
use grosgrain::coarse::{BuildOptions, CoarseModel, Integration, build};
use grosgrain::dynamics::{
    Body, CoarseMechanics, Conditions, FineMechanics, Hold, Integrator, NewtonOptions, Schedule, State, StepOptions,
    StepReport, Stepper, TimedLoad,
};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::{Law, Material, MaterialTable};
use grosgrain::mesh::{Label, Node, VoxelGrid};

pub const GRAVITY: f64 = 9.81;

/// A bar of cells of 1 cm; every third cell is five times stiffer.
pub fn bar(cells: [usize; 3], law: Law) -> FineModel {
    let mut materials = MaterialTable::new();
    for (label, young) in [(0, 1e5), (1, 5e5)] {
        let material = Material { law, ..Material::linear("phase", isotropic(young, 0.4), 1000.0) };
        materials.insert(Label(label), material);
    }
    let mut grid = VoxelGrid::uniform(cells, [0.01; 3], Label(0));
    grid.labels.iter_mut().step_by(3).for_each(|label| *label = Label(1));
    FineModel::new(grid, &materials).unwrap()
}

pub fn weight(model: &FineModel, acceleration: [f64; 3]) -> TimedLoad {
    TimedLoad { forces: gravity(model, acceleration), schedule: Schedule::default() }
}

pub fn clamped(model: &FineModel) -> Hold {
    let lattice = model.grid().lattice;
    Hold::still("clamp", (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 0).collect())
}

pub fn options(integrator: Integrator, tolerance: f64) -> StepOptions {
    let newton = NewtonOptions { tolerance, ..NewtonOptions::default() };
    StepOptions { integrator, newton, ..StepOptions::default() }
}

/// What is stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Fine,
    Coarse(Integration),
}

pub const KINDS: [Kind; 4] = [
    Kind::Fine,
    Kind::Coarse(Integration::Gauss),
    Kind::Coarse(Integration::Centre),
    Kind::Coarse(Integration::Stiffness),
];

/// A model of one kind with what it needs to move.
pub enum Runner<'m> {
    Fine(&'m FineModel, Box<FineMechanics>),
    Coarse(&'m FineModel, Box<CoarseModel>, Box<CoarseMechanics>),
}

impl<'m> Runner<'m> {
    /// The coarse model has degree 2.
    pub fn new(kind: Kind, model: &'m FineModel, conditions: Conditions) -> Self {
        match kind {
            Kind::Fine => Self::Fine(model, Box::new(FineMechanics::new(model, conditions).unwrap())),
            Kind::Coarse(integration) => {
                let coarse = build(model, 2, &BuildOptions::default(), &grosgrain::progress::silent).unwrap().model;
                let mechanics = CoarseMechanics::new(model, &coarse, integration, conditions).unwrap();
                Self::Coarse(model, Box::new(coarse), Box::new(mechanics))
            }
        }
    }

    pub fn rest_positions(&self) -> Vec<[f64; 3]> {
        match self {
            Self::Fine(model, _) => {
                (0..model.grid().lattice.node_count()).map(|n| model.node_position(Node(n))).collect()
            }
            Self::Coarse(model, coarse, _) => {
                let place = |v: &grosgrain::partition::Vertex| coarse.partition().coincident_node(v.node);
                coarse.mesh().vertices().iter().map(|v| model.node_position(place(v))).collect()
            }
        }
    }

    pub fn rest(&self) -> State {
        State::rest(self.rest_positions().len())
    }

    pub fn with_body<T>(&mut self, act: impl FnOnce(&mut dyn Body) -> T) -> T {
        match self {
            Self::Fine(model, mechanics) => act(&mut mechanics.on(model)),
            Self::Coarse(model, coarse, mechanics) => act(&mut mechanics.on(model, coarse)),
        }
    }

    pub fn run(&mut self, options: StepOptions, state: &mut State, step: f64, steps: usize) -> Vec<StepReport> {
        let mut stepper = Stepper::new(options);
        self.with_body(|body| {
            let mut advance = |n: usize| stepper.advance(body, state, n as f64 * step, step).unwrap();
            (0..steps).map(&mut advance).collect()
        })
    }
}

/// Runs from rest; returns the last state and every step's report.
pub fn run(
    kind: Kind,
    model: &FineModel,
    conditions: Conditions,
    options: StepOptions,
    (step, steps): (f64, usize),
) -> (State, Vec<StepReport>) {
    let mut runner = Runner::new(kind, model, conditions);
    let mut state = runner.rest();
    let reports = runner.run(options, &mut state, step, steps);
    (state, reports)
}

pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

pub fn size(a: &[f64]) -> f64 {
    a.iter().map(|a| a * a).sum::<f64>().sqrt()
}
