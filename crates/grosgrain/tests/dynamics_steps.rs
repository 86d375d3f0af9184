//! Steps in time against exact solutions, conservation laws and orders of convergence, for the fine and the coarse model.

mod bodies;
mod motion;

use bodies::Uniform;
use grosgrain::coarse::Integration;
use grosgrain::contact::Ground;
use grosgrain::dynamics::{
    Conditions, Damping, Hold, Holds, Integrator, Motion, NewtonOptions, Ramp, Schedule, State, StepOptions, Stepper,
    TimedLoad, Twist,
};
use grosgrain::material::Law;
use grosgrain::mesh::Node;
use motion::{GRAVITY, KINDS, Kind, Runner, bar, clamped, distance, options, run, size, weight};

#[test]
fn backward_euler_converges_with_order_1_and_the_midpoint_rule_with_order_2() {
    let model = bar([12, 2, 2], Law::NeoHookean);
    // A load that grows slowly leaves fast vibrations, which no step resolves, alone.
    let schedule = Schedule { ramp: Ramp { from: 0.0, to: 0.2 }, until: None };
    for kind in [Kind::Fine, Kind::Coarse(Integration::Gauss)] {
        let end = |integrator, steps: usize| {
            let conditions = Conditions {
                holds: Holds(vec![clamped(&model)]),
                loads: vec![TimedLoad { schedule, ..weight(&model, [0.0, 0.0, -GRAVITY]) }],
                ..Conditions::default()
            };
            run(kind, &model, conditions, options(integrator, 1e-10), (0.2 / steps as f64, steps)).0.displacement
        };
        let exact = end(Integrator::Midpoint, 1024);
        for (integrator, order, steps) in [(Integrator::ImplicitEuler, 1.0, 256), (Integrator::Midpoint, 2.0, 128)] {
            let errors = [steps, 2 * steps].map(|n| distance(&end(integrator, n), &exact));
            let found = (errors[0] / errors[1]).log2();
            println!("{kind:?} {integrator:?}: errors {:.2e} and {:.2e}, order {found:.3}", errors[0], errors[1]);
            assert!((found - order).abs() < 0.15, "{kind:?}, {integrator:?}: order {found:.3}");
        }
    }
}

#[test]
fn a_body_in_free_fall_moves_as_a_point() {
    for (law, kind) in [Law::Linear, Law::Corotational, Law::NeoHookean].into_iter().flat_map(|l| KINDS.map(|k| (l, k)))
    {
        let model = bar([4, 2, 2], law);
        let fall = Conditions { loads: vec![weight(&model, [0.0, 0.0, -GRAVITY])], ..Conditions::default() };
        let (h, n) = (0.01, 20);
        let (euler, _) = run(kind, &model, fall.clone(), options(Integrator::ImplicitEuler, 1e-12), (h, n));
        let (midpoint, _) = run(kind, &model, fall, options(Integrator::Midpoint, 1e-12), (h, n));
        let exact = -0.5 * GRAVITY * (h * n as f64).powi(2);
        let summed = -GRAVITY * h * h * (n * (n + 1) / 2) as f64;
        for (state, depth) in [(euler, summed), (midpoint, exact)] {
            for (i, u) in state.displacement.iter().enumerate() {
                let expected = if i % 3 == 2 { depth } else { 0.0 };
                // Fine loads are spread over vertices by shape functions, masses by trilinear ones: a coarse body falls as a whole.
                let slack = if kind == Kind::Fine { 1e-9 } else { 0.02 };
                assert!((u - expected).abs() < slack * depth.abs(), "{law:?}, {kind:?}: {u} instead of {expected}");
            }
            let mean = mean_of(&state.displacement, 2);
            assert!((mean - depth).abs() < 5e-3 * depth.abs(), "{law:?}, {kind:?}: {mean} instead of {depth}");
        }
    }
}

#[test]
fn free_flight_keeps_momentum_and_backward_euler_keeps_angular_momentum_to_first_order() {
    let model = bar([4, 2, 2], Law::NeoHookean);
    for kind in KINDS {
        for (integrator, bound) in [(Integrator::ImplicitEuler, 0.02), (Integrator::Midpoint, 1e-7)] {
            let mut runner = Runner::new(kind, &model, Conditions::default());
            let places = runner.rest_positions();
            let mass = runner.with_body(|body| body.mass().to_vec());
            let mut state = runner.rest();
            // A bar that spins freely and vibrates: every node is given a little more than the spin.
            let mut random = Uniform(7);
            for (n, x) in places.iter().enumerate() {
                let spin = [-20.0 * x[1], 20.0 * x[0], 5.0 * x[0]];
                (0..3).for_each(|r| state.velocity[3 * n + r] = spin[r] + 0.05 * random.signed());
            }
            let before = state.momenta(&mass, |n| places[n]);
            runner.run(options(integrator, 1e-11), &mut state, 0.0005, 100);
            let after = state.momenta(&mass, |n| places[n]);
            let drift = |a: [f64; 3], b: [f64; 3]| distance(&a, &b) / size(&b);
            let (linear, angular) = (drift(after.0, before.0), drift(after.1, before.1));
            println!("{kind:?} {integrator:?}: {linear:.1e}, {angular:.1e}");
            assert!(linear < 1e-9, "{kind:?}, {integrator:?}: momentum drifts by {linear:.1e}");
            assert!(angular < bound, "{kind:?}, {integrator:?}: angular momentum drifts by {angular:.1e}");
        }
    }
}

#[test]
fn the_books_balance_and_backward_euler_only_loses_energy() {
    let model = bar([6, 2, 2], Law::NeoHookean);
    let twist = Twist::about([1.0, 0.0, 0.0], [0.0, 0.01, 0.01], 1.5);
    let lattice = model.grid().lattice;
    let end = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 6).collect();
    let motion = Motion { twist, translation: [0.005, 0.0, 0.0] };
    let turned = Hold { motion, ramp: Ramp { from: 0.0, to: 0.1 }, ..Hold::still("end", end) };
    let conditions = Conditions {
        holds: Holds(vec![clamped(&model), turned]),
        loads: vec![weight(&model, [0.0, 0.0, -GRAVITY])],
        ..Conditions::default()
    };
    for (kind, damping) in
        KINDS.into_iter().flat_map(|k| [(k, Damping::default()), (k, Damping { mass: 2.0, stiffness: 1e-3 })])
    {
        let options = StepOptions { damping, ..options(Integrator::ImplicitEuler, 1e-9) };
        let (_, reports) = run(kind, &model, conditions.clone(), options, (0.005, 60));
        let mut before = 0.0;
        for (n, report) in reports.iter().enumerate() {
            let energy = report.kinetic + report.energies.elastic;
            let loss = report.work_of_loads + report.work_of_holds - (energy - before);
            // While the end moves, the work of its hold is that of the forces at the ends of steps; afterwards nothing is approximate.
            let slack = if n < 20 { 1e-3 } else { 1e-9 };
            assert!(loss > -slack * energy, "{kind:?}: step {n} gains {:.2e} of {energy:.2e} J", -loss);
            let damped = report.damped;
            assert!(damped <= loss + slack * energy, "{kind:?}: step {n}: damping took {damped} of {loss}");
            before = energy;
        }
    }
}

#[test]
fn the_midpoint_rule_keeps_the_energy_of_a_swinging_bar() {
    let model = bar([6, 2, 2], Law::NeoHookean);
    let conditions = Conditions {
        holds: Holds(vec![clamped(&model)]),
        loads: vec![weight(&model, [0.0, 0.0, -3.0 * GRAVITY])],
        ..Conditions::default()
    };
    for kind in KINDS {
        let (_, reports) = run(kind, &model, conditions.clone(), options(Integrator::Midpoint, 1e-10), (0.001, 200));
        let largest = reports.iter().map(|r| r.energies.elastic).fold(0.0, f64::max);
        let error = reports.iter().map(|r| (r.kinetic + r.energies.total()).abs()).fold(0.0, f64::max) / largest;
        println!("{kind:?}: energy error {error:.1e}");
        assert!(error < 1e-3, "{kind:?}: the energy changes by {error:.1e} of the largest elastic energy");
    }
}

/// A block on the ground under gravity that is tilted by an angle in the x direction.
fn block_on_slope(kind: Kind, angle: f64, friction: f64, steps: usize) -> (State, f64) {
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
    let (state, _) = run(kind, &model, conditions, options, (h, steps));
    (state, h * steps as f64)
}

fn mean_of(state: &[f64], component: usize) -> f64 {
    state.chunks_exact(3).map(|u| u[component]).sum::<f64>() / (state.len() / 3) as f64
}

#[test]
fn static_friction_holds_and_does_not_creep() {
    let angle = 0.2f64;
    let friction = 1.3 * angle.tan();
    for kind in [Kind::Fine, Kind::Coarse(Integration::Stiffness)] {
        let (early, _) = block_on_slope(kind, angle, friction, 200);
        let (late, _) = block_on_slope(kind, angle, friction, 400);
        let (slide, end) = (mean_of(&early.displacement, 0), mean_of(&late.displacement, 0));
        assert!(slide.abs() < 2e-3, "{kind:?} slid by {slide}");
        assert!((end - slide).abs() < 1e-6, "{kind:?} creeps by {:.1e} m in a second", end - slide);
    }
}

#[test]
fn a_block_slides_down_a_slope_with_coulombs_acceleration() {
    let (angle, friction) = (0.5f64, 0.2);
    for kind in [Kind::Fine, Kind::Coarse(Integration::Stiffness)] {
        let (early, t0) = block_on_slope(kind, angle, friction, 60);
        let (late, t1) = block_on_slope(kind, angle, friction, 100);
        let found = (mean_of(&late.velocity, 0) - mean_of(&early.velocity, 0)) / (t1 - t0);
        let exact = GRAVITY * (angle.sin() - friction * angle.cos());
        assert!((found / exact - 1.0).abs() < 0.01, "{kind:?}: {found} instead of {exact} m/s²");
    }
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
    let (state, reports) = run(Kind::Fine, &model, conditions(turn.clone()), hasty, (0.1, 1));
    let substeps = reports[0].substeps;
    assert!(substeps > 1, "{:?}", reports[0]);
    let patient = options(Integrator::ImplicitEuler, 1e-6);
    let (same, _) = run(Kind::Fine, &model, conditions(turn), patient, (0.1 / substeps as f64, substeps));
    let difference = distance(&state.displacement, &same.displacement) / size(&same.displacement);
    assert!(difference < 0.05, "a halved step differs from two steps by {difference:.1e}");
    // Pulled through its clamp: no state without inverted cells.
    let through = moved(Motion::translate([-0.08, 0.0, 0.0]), 0.0);
    for (kind, words) in [(Kind::Fine, "cell ("), (Kind::Coarse(Integration::Stiffness), "coarse cell (")] {
        let mut runner = Runner::new(kind, &model, conditions(through.clone()));
        let mut state = runner.rest();
        let mut stepper = Stepper::new(options(Integrator::ImplicitEuler, 1e-6));
        let outcome = runner.with_body(|body| stepper.advance(body, &mut state, 0.0, 0.1));
        let error = outcome.unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("det J"), "{error}");
        assert!(state.displacement.iter().all(|u| *u == 0.0), "the state is the last good one");
    }
}
