//! Steps in time against exact solutions, conservation laws and orders of convergence, for the fine model.

mod bodies;

use bodies::{Uniform, isotropic};
use grosgrain::contact::Ground;
use grosgrain::dynamics::{
    Conditions, Damping, FineMechanics, Hold, Holds, Integrator, Motion, NewtonOptions, Ramp, Schedule, State,
    StepOptions, StepReport, Stepper, TimedLoad, Twist,
};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::{Law, Material, MaterialTable};
use grosgrain::mesh::{Label, Node, VoxelGrid};

const GRAVITY: f64 = 9.81;

/// A bar of cells of 1 cm; every third cell is five times stiffer.
fn bar(cells: [usize; 3], law: Law) -> FineModel {
    let mut materials = MaterialTable::new();
    for (label, young) in [(0, 1e5), (1, 5e5)] {
        let material = Material { law, ..Material::linear("phase", isotropic(young, 0.4), 1000.0) };
        materials.insert(Label(label), material);
    }
    let mut grid = VoxelGrid::uniform(cells, [0.01; 3], Label(0));
    grid.labels.iter_mut().step_by(3).for_each(|label| *label = Label(1));
    FineModel::new(grid, &materials).unwrap()
}

fn weight(model: &FineModel, acceleration: [f64; 3]) -> TimedLoad {
    TimedLoad { forces: gravity(model, acceleration), schedule: Schedule::default() }
}

fn clamped(model: &FineModel) -> Hold {
    let lattice = model.grid().lattice;
    Hold::still("clamp", (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 0).collect())
}

fn options(integrator: Integrator, tolerance: f64) -> StepOptions {
    let newton = NewtonOptions { tolerance, ..NewtonOptions::default() };
    StepOptions { integrator, newton, ..StepOptions::default() }
}

/// Runs from rest; returns the last state and every step's report.
fn run(
    model: &FineModel,
    conditions: Conditions,
    options: StepOptions,
    (start, step, steps): (State, f64, usize),
) -> (State, Vec<StepReport>) {
    let mut mechanics = FineMechanics::new(model, conditions).unwrap();
    let (mut state, mut stepper) = (start, Stepper::new(options));
    let mut body = mechanics.on(model);
    let reports = (0..steps).map(|n| stepper.advance(&mut body, &mut state, n as f64 * step, step).unwrap()).collect();
    (state, reports)
}

fn rest(model: &FineModel) -> State {
    State::rest(model.grid().lattice.node_count())
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

fn size(a: &[f64]) -> f64 {
    a.iter().map(|a| a * a).sum::<f64>().sqrt()
}

#[test]
fn backward_euler_converges_with_order_1_and_the_midpoint_rule_with_order_2() {
    let model = bar([6, 1, 1], Law::NeoHookean);
    // A load that grows slowly leaves fast vibrations, which no step resolves, alone.
    let schedule = Schedule { ramp: Ramp { from: 0.0, to: 0.08 }, until: None };
    let end = |integrator, steps: usize| {
        let conditions = Conditions {
            holds: Holds(vec![clamped(&model)]),
            loads: vec![TimedLoad { schedule, ..weight(&model, [0.0, 0.0, -GRAVITY]) }],
            ..Conditions::default()
        };
        run(&model, conditions, options(integrator, 1e-10), (rest(&model), 0.08 / steps as f64, steps)).0.displacement
    };
    let exact = end(Integrator::Midpoint, 1024);
    for (integrator, order, steps) in [(Integrator::ImplicitEuler, 1.0, 256), (Integrator::Midpoint, 2.0, 128)] {
        let errors = [steps, 2 * steps].map(|n| distance(&end(integrator, n), &exact));
        let found = (errors[0] / errors[1]).log2();
        println!("{integrator:?}: errors {:.2e} and {:.2e}, order {found:.3}", errors[0], errors[1]);
        assert!((found - order).abs() < 0.15, "{integrator:?}: order {found:.3}");
    }
}

#[test]
fn a_body_in_free_fall_moves_as_a_point() {
    for law in [Law::Linear, Law::Corotational, Law::NeoHookean] {
        let model = bar([3, 2, 2], law);
        let fall = Conditions { loads: vec![weight(&model, [0.0, 0.0, -GRAVITY])], ..Conditions::default() };
        let (h, n) = (0.01, 20);
        let (euler, _) = run(&model, fall.clone(), options(Integrator::ImplicitEuler, 1e-12), (rest(&model), h, n));
        let (midpoint, _) = run(&model, fall, options(Integrator::Midpoint, 1e-12), (rest(&model), h, n));
        let exact = -0.5 * GRAVITY * (h * n as f64).powi(2);
        let summed = -GRAVITY * h * h * (n * (n + 1) / 2) as f64;
        for (state, depth) in [(euler, summed), (midpoint, exact)] {
            for (i, u) in state.displacement.iter().enumerate() {
                let expected = if i % 3 == 2 { depth } else { 0.0 };
                assert!((u - expected).abs() < 1e-9 * depth.abs(), "{law:?}: {u} instead of {expected}");
            }
        }
    }
}

/// A bar that spins freely and vibrates: every node of a rotating bar is given a little more.
fn spinning(model: &FineModel) -> State {
    let mut random = Uniform(7);
    let mut state = rest(model);
    for n in 0..state.velocity.len() / 3 {
        let x = model.node_position(Node(n));
        let spin = [-20.0 * x[1], 20.0 * x[0], 5.0 * x[0]];
        (0..3).for_each(|r| state.velocity[3 * n + r] = spin[r] + 0.05 * random.signed());
    }
    state
}

#[test]
fn free_flight_keeps_momentum_and_backward_euler_keeps_angular_momentum_to_first_order() {
    let model = bar([4, 2, 2], Law::NeoHookean);
    let mechanics = FineMechanics::new(&model, Conditions::default()).unwrap();
    let momenta = |state: &State| state.momenta(mechanics.mass(), |n| model.node_position(Node(n)));
    let start = spinning(&model);
    let before = momenta(&start);
    for (integrator, bound) in [(Integrator::ImplicitEuler, 0.12), (Integrator::Midpoint, 1e-6)] {
        let (end, _) =
            run(&model, Conditions::default(), options(integrator, 1e-11), (start.clone(), 0.0005, 100));
        let after = momenta(&end);
        let drift = |a: [f64; 3], b: [f64; 3]| distance(&a, &b) / size(&b);
        println!("{integrator:?}: {:.1e}, {:.1e}", drift(after.0, before.0), drift(after.1, before.1));
        assert!(drift(after.0, before.0) < 1e-9, "momentum drifts by {:.1e}", drift(after.0, before.0));
        assert!(drift(after.1, before.1) < bound, "angular momentum drifts by {:.1e}", drift(after.1, before.1));
    }
}

#[test]
fn the_books_balance_and_backward_euler_only_loses_energy() {
    let model = bar([5, 2, 2], Law::NeoHookean);
    let twist = Twist::about([1.0, 0.0, 0.0], [0.0, 0.01, 0.01], 1.5);
    let lattice = model.grid().lattice;
    let end = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 5).collect();
    let motion = Motion { twist, translation: [0.005, 0.0, 0.0] };
    let turned = Hold { motion, ramp: Ramp { from: 0.0, to: 0.1 }, ..Hold::still("end", end) };
    let conditions = Conditions {
        holds: Holds(vec![clamped(&model), turned]),
        loads: vec![weight(&model, [0.0, 0.0, -GRAVITY])],
        ..Conditions::default()
    };
    for damping in [Damping::default(), Damping { mass: 2.0, stiffness: 1e-3 }] {
        let options = StepOptions { damping, ..options(Integrator::ImplicitEuler, 1e-9) };
        let (_, reports) = run(&model, conditions.clone(), options, (rest(&model), 0.005, 60));
        let mut before = 0.0;
        let mut lost = 0.0;
        for (n, report) in reports.iter().enumerate() {
            let energy = report.kinetic + report.energies.elastic;
            let loss = report.work_of_loads + report.work_of_holds - (energy - before);
            assert!(loss > -1e-9 * energy, "step {n} gains {:.2e} J", -loss);
            assert!(report.damped <= loss * (1.0 + 1e-6) + 1e-12, "step {n}: {} of {loss}", report.damped);
            (before, lost) = (energy, lost + loss);
        }
        println!("elastic {:.3e}, lost {lost:.3e}", before);
    }
}

#[test]
fn the_midpoint_rule_keeps_the_energy_of_a_swinging_bar() {
    let model = bar([6, 1, 1], Law::NeoHookean);
    let conditions = Conditions {
        holds: Holds(vec![clamped(&model)]),
        loads: vec![weight(&model, [0.0, 0.0, -GRAVITY])],
        ..Conditions::default()
    };
    let (_, reports) = run(&model, conditions, options(Integrator::Midpoint, 1e-10), (rest(&model), 0.001, 200));
    let largest = reports.iter().map(|r| r.energies.elastic).fold(0.0, f64::max);
    let error = reports.iter().map(|r| (r.kinetic + r.energies.total()).abs()).fold(0.0, f64::max) / largest;
    println!("energy error {error:.1e}");
    assert!(error < 0.02, "the energy changes by {error:.1e} of the largest elastic energy");
}

/// A block on the ground under gravity that is tilted by an angle in the x direction.
fn block_on_slope(angle: f64, friction: f64, steps: usize) -> (FineModel, State, f64) {
    let model = bar([4, 4, 2], Law::NeoHookean);
    let pull = [GRAVITY * angle.sin(), 0.0, -GRAVITY * angle.cos()];
    let conditions = Conditions {
        loads: vec![weight(&model, pull)],
        ground: Some(Ground { height: 0.0, friction, stiffness: 1e7 }),
        ..Conditions::default()
    };
    let h = 0.005;
    let damping = Damping { mass: 0.0, stiffness: 2e-3 };
    let options = StepOptions { damping, ..options(Integrator::ImplicitEuler, 1e-8) };
    let (state, _) = run(&model, conditions, options, (rest(&model), h, steps));
    (model, state, h * steps as f64)
}

fn mean_of(state: &[f64], component: usize) -> f64 {
    state.chunks_exact(3).map(|u| u[component]).sum::<f64>() / (state.len() / 3) as f64
}

#[test]
fn static_friction_holds_and_does_not_creep() {
    let angle = 0.2f64;
    let friction = 1.3 * angle.tan();
    let (_, early, _) = block_on_slope(angle, friction, 200);
    let (_, late, _) = block_on_slope(angle, friction, 400);
    let creep = mean_of(&late.displacement, 0) - mean_of(&early.displacement, 0);
    assert!(mean_of(&early.displacement, 0) < 2e-3, "slid by {}", mean_of(&early.displacement, 0));
    assert!(creep.abs() < 1e-6, "creeps by {creep:.1e} m in a second");
}

#[test]
fn a_block_slides_down_a_slope_with_coulombs_acceleration() {
    let (angle, friction) = (0.5f64, 0.2);
    let (_, early, t0) = block_on_slope(angle, friction, 60);
    let (_, late, t1) = block_on_slope(angle, friction, 100);
    let found = (mean_of(&late.velocity, 0) - mean_of(&early.velocity, 0)) / (t1 - t0);
    let exact = GRAVITY * (angle.sin() - friction * angle.cos());
    assert!((found / exact - 1.0).abs() < 0.01, "{found} instead of {exact} m/s²");
}

#[test]
fn a_step_that_is_too_large_is_halved_and_what_cannot_be_made_is_told() {
    let model = bar([6, 2, 2], Law::NeoHookean);
    let lattice = model.grid().lattice;
    let end: Vec<bool> = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 6).collect();
    let moved = |motion, to| Hold { motion, ramp: Ramp { from: 0.0, to }, ..Hold::still("end", end.clone()) };
    let conditions = |hold| Conditions { holds: Holds(vec![clamped(&model), hold]), ..Conditions::default() };
    // Turned by 140 degrees in one step, which takes more than six Newton steps.
    let twist = Twist::about([1.0, 0.0, 0.0], [0.0, 0.01, 0.01], 2.5);
    let turn = moved(Motion { twist, ..Motion::default() }, 0.1);
    let newton = NewtonOptions { tolerance: 1e-6, max_iterations: 6 };
    let hasty = StepOptions { newton, ..StepOptions::default() };
    let (state, reports) = run(&model, conditions(turn.clone()), hasty, (rest(&model), 0.1, 1));
    assert!(reports[0].substeps > 1, "{:?}", reports[0]);
    let substeps = reports[0].substeps;
    assert!(substeps.is_power_of_two() && state.displacement.iter().all(|u| u.is_finite()));
    let patient = options(Integrator::ImplicitEuler, 1e-6);
    let (same, _) = run(&model, conditions(turn), patient, (rest(&model), 0.1 / substeps as f64, substeps));
    let difference = distance(&state.displacement, &same.displacement) / size(&same.displacement);
    assert!(difference < 0.05, "a halved step differs from two steps by {difference:.1e}");
    // Pulled through its clamp: no state without inverted cells.
    let mut mechanics = FineMechanics::new(&model, conditions(moved(Motion::translate([-0.08, 0.0, 0.0]), 0.0))).unwrap();
    let mut state = rest(&model);
    let mut stepper = Stepper::new(options(Integrator::ImplicitEuler, 1e-6));
    let error = stepper.advance(&mut mechanics.on(&model), &mut state, 0.0, 0.1).unwrap_err().to_string();
    assert!(error.contains("cell (") && error.contains("det J"), "{error}");
    assert!(state.displacement.iter().all(|u| *u == 0.0), "the state is the last good one");
}
