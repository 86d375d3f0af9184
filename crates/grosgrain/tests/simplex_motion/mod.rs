//! Bodies of simplices and runs of them, shared by the tests of their motion.
#![allow(dead_code, reason = "every test binary takes the part it needs")]

use crate::bodies::isotropic;
use grosgrain::dynamics::{
    Body, Conditions, Hold, Integrator, NewtonOptions, Schedule, SimplexBody, State, StepOptions, StepReport, Stepper,
    TimedLoad, simplex_mass,
};
use grosgrain::homogenization::SimplexModel;
use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, MandelTensor, SimplexLattice, SimplexMesh};

pub const GRAVITY: f64 = 9.81;

/// Boxes that fill `size` from the origin.
pub fn lattice(dimension: Dimension, boxes: [usize; 3], size: [f64; 3]) -> SimplexMesh {
    let around = BoundingBox { lower: [0.0; 3], upper: size };
    SimplexLattice { dimension, boxes, around, cut: BoxCut::Alternating }.mesh().unwrap()
}

pub fn tensor(dimension: Dimension, young: f64, poisson: f64) -> MandelTensor {
    MandelTensor::of_material(dimension, &isotropic(young, poisson).tensor())
}

pub fn uniform(mesh: SimplexMesh, (young, poisson): (f64, f64), density: f64) -> SimplexModel {
    let (cells, tensor) = (mesh.cell_count(), tensor(mesh.dimension(), young, poisson));
    SimplexModel::with_tensors(mesh, vec![tensor; cells], vec![density; cells]).unwrap()
}

/// A bar of boxes of 1 cm along x; every third cell is five times stiffer.
pub fn bar(dimension: Dimension, boxes: [usize; 3]) -> SimplexModel {
    let mesh = lattice(dimension, boxes, boxes.map(|n| 0.01 * n as f64));
    let young = |cell: usize| if cell.is_multiple_of(3) { 5e5 } else { 1e5 };
    let cells = mesh.cell_count();
    let tensors = (0..cells).map(|cell| tensor(dimension, young(cell), 0.4)).collect();
    SimplexModel::with_tensors(mesh, tensors, vec![1000.0; cells]).unwrap()
}

pub fn weight(model: &SimplexModel, acceleration: [f64; 3]) -> TimedLoad {
    let forces = simplex_mass(model).iter().flat_map(|mass| acceleration.map(|a| mass * a)).collect();
    TimedLoad { forces, schedule: Schedule::default() }
}

/// Nodes with this coordinate along an axis.
pub fn plane(model: &SimplexModel, axis: usize, at: f64) -> Vec<bool> {
    model.mesh().nodes().iter().map(|x| (x[axis] - at).abs() < 1e-9).collect()
}

pub fn clamped(model: &SimplexModel) -> Hold {
    Hold::still("clamp", plane(model, 0, 0.0))
}

pub fn options(integrator: Integrator, tolerance: f64) -> StepOptions {
    let newton = NewtonOptions { tolerance, ..NewtonOptions::default() };
    StepOptions { integrator, newton, ..StepOptions::default() }
}

pub fn run(
    body: &mut dyn Body,
    state: &mut State,
    options: StepOptions,
    (step, steps): (f64, usize),
) -> Vec<StepReport> {
    let mut stepper = Stepper::new(options);
    (0..steps).map(|n| stepper.advance(body, state, n as f64 * step, step).unwrap()).collect()
}

/// Runs from rest.
pub fn run_from_rest(mut body: SimplexBody, options: StepOptions, steps: (f64, usize)) -> (State, Vec<StepReport>) {
    let mut state = body.rest();
    let reports = run(&mut body, &mut state, options, steps);
    (state, reports)
}

pub fn conditions(holds: Vec<Hold>, loads: Vec<TimedLoad>) -> Conditions {
    Conditions { holds: grosgrain::dynamics::Holds(holds), loads, ..Conditions::default() }
}

pub fn size(a: &[f64]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}

pub fn mean_of(state: &[f64], component: usize) -> f64 {
    state.chunks_exact(3).map(|u| u[component]).sum::<f64>() / (state.len() / 3) as f64
}
