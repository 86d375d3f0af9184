//! Bodies of simplices in motion against exact solutions, conservation laws and orders of convergence.

mod bodies;
mod simplex_motion;

use bodies::Uniform;
use grosgrain::dynamics::{
    Body, Conditions, Damping, Hold, Integrator, Moment, Motion, NodeSpring, QuadraticWeights, Ramp, Schedule,
    SimplexBody, SimplexBodyError, StepOptions, TimedLoad, Twist,
};
use grosgrain::material::Projection;
use grosgrain::mesh::Node;
use grosgrain::simplex::{Dimension, SimplexLaw};
use simplex_motion::*;

#[test]
fn a_body_in_free_fall_moves_as_a_point() {
    let (h, n) = (0.01, 20);
    let exact = -0.5 * GRAVITY * (h * n as f64).powi(2);
    let summed = -GRAVITY * h * h * (n * (n + 1) / 2) as f64;
    for (dimension, axis) in [(Dimension::One, 0), (Dimension::Two, 1), (Dimension::Three, 2)] {
        for law in [SimplexLaw::Linear, SimplexLaw::Corotational] {
            let model = bar(dimension, [4, 2, 2]);
            // What pulls beyond the dimension moves nothing.
            let mut pull = [0.0, 0.0, -GRAVITY];
            pull[axis] = -GRAVITY;
            for (integrator, depth) in [(Integrator::ImplicitEuler, summed), (Integrator::Midpoint, exact)] {
                let body = SimplexBody::new(&model, law, conditions(vec![], vec![weight(&model, pull)])).unwrap();
                let (state, _) = run_from_rest(body, options(integrator, 1e-12), (h, n));
                for (i, u) in state.displacement.iter().enumerate() {
                    let expected = if i % 3 == axis { depth } else { 0.0 };
                    assert!(
                        (u - expected).abs() < 1e-9 * depth.abs(),
                        "{dimension} {law:?}: {u} instead of {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn free_flight_keeps_momentum_and_backward_euler_keeps_angular_momentum_to_first_order() {
    for dimension in [Dimension::Two, Dimension::Three] {
        let model = bar(dimension, [4, 2, 2]);
        for (integrator, bound) in [(Integrator::ImplicitEuler, 0.02), (Integrator::Midpoint, 1e-7)] {
            let mut body = SimplexBody::new(&model, SimplexLaw::Corotational, Conditions::default()).unwrap();
            let (mut state, places, mass) = (body.rest(), model.mesh().nodes().to_vec(), body.mass().to_vec());
            let mut random = Uniform(7);
            for (n, x) in places.iter().enumerate() {
                let spin = [-20.0 * x[1], 20.0 * x[0], 5.0 * x[0]];
                (0..dimension.axes()).for_each(|r| state.velocity[3 * n + r] = spin[r] + 0.05 * random.signed());
            }
            let before = state.momenta(&mass, |n| places[n]);
            run(&mut body, &mut state, options(integrator, 1e-11), (0.0005, 100));
            let after = state.momenta(&mass, |n| places[n]);
            let drift = |a: [f64; 3], b: [f64; 3]| distance(&a, &b) / size(&b);
            let (linear, angular) = (drift(after.0, before.0), drift(after.1, before.1));
            println!("{dimension} {integrator:?}: {linear:.1e}, {angular:.1e}");
            assert!(linear < 1e-9, "{dimension}, {integrator:?}: momentum drifts by {linear:.1e}");
            assert!(angular < bound, "{dimension}, {integrator:?}: angular momentum drifts by {angular:.1e}");
        }
    }
}

#[test]
fn backward_euler_converges_with_order_1_and_the_midpoint_rule_with_order_2() {
    let model = bar(Dimension::Three, [12, 2, 2]);
    // A load that grows slowly leaves fast vibrations, which no step resolves, alone.
    let schedule = Schedule { ramp: Ramp { from: 0.0, to: 0.2 }, until: None };
    let end = |integrator, steps: usize| {
        let load = TimedLoad { schedule, ..weight(&model, [0.0, 0.0, -GRAVITY]) };
        let conditions = conditions(vec![clamped(&model)], vec![load]);
        let body = SimplexBody::new(&model, SimplexLaw::Corotational, conditions).unwrap();
        run_from_rest(body, options(integrator, 1e-10), (0.2 / steps as f64, steps)).0.displacement
    };
    let exact = end(Integrator::Midpoint, 2048);
    for (integrator, order, steps) in [(Integrator::ImplicitEuler, 1.0, 256), (Integrator::Midpoint, 2.0, 256)] {
        let errors = [steps, 2 * steps].map(|n| distance(&end(integrator, n), &exact));
        let found = (errors[0] / errors[1]).log2();
        println!("{integrator:?}: errors {:.2e} and {:.2e}, order {found:.3}", errors[0], errors[1]);
        assert!((found - order).abs() < 0.15, "{integrator:?}: order {found:.3}");
    }
}

#[test]
fn the_books_balance_and_backward_euler_only_loses_energy() {
    let model = bar(Dimension::Three, [6, 2, 2]);
    let twist = Twist::about([1.0, 0.0, 0.0], [0.0, 0.01, 0.01], 1.5);
    let motion = Motion { twist, translation: [0.005, 0.0, 0.0] };
    let end = plane(&model, 0, 0.06);
    let turned = Hold { motion, ramp: Ramp { from: 0.0, to: 0.1 }, ..Hold::still("end", end) };
    let conditions = conditions(vec![clamped(&model), turned], vec![weight(&model, [0.0, 0.0, -GRAVITY])]);
    for damping in [Damping::default(), Damping { mass: 2.0, stiffness: 1e-3 }] {
        let body = SimplexBody::new(&model, SimplexLaw::Corotational, conditions.clone()).unwrap();
        let options = StepOptions { damping, ..options(Integrator::ImplicitEuler, 1e-9) };
        let (_, reports) = run_from_rest(body, options, (0.005, 60));
        let mut before = 0.0;
        for (n, report) in reports.iter().enumerate() {
            let energy = report.kinetic + report.energies.elastic;
            let loss = report.work_of_loads + report.work_of_holds - (energy - before);
            // While the end moves, the work of its hold is that of the forces at the ends of steps; afterwards nothing is approximate.
            let slack = if n < 20 { 1e-3 } else { 1e-9 };
            assert!(loss > -slack * energy, "step {n} gains {:.2e} of {energy:.2e} J", -loss);
            assert!(report.damped <= loss + slack * energy, "step {n}: damping took {} of {loss}", report.damped);
            before = energy;
        }
    }
}

#[test]
fn the_midpoint_rule_keeps_the_energy_of_a_swinging_bar() {
    for dimension in [Dimension::Two, Dimension::Three] {
        let model = bar(dimension, [6, 2, 2]);
        let pull = if dimension == Dimension::Two { [0.0, -3.0 * GRAVITY, 0.0] } else { [0.0, 0.0, -3.0 * GRAVITY] };
        let conditions = conditions(vec![clamped(&model)], vec![weight(&model, pull)]);
        let body = SimplexBody::new(&model, SimplexLaw::Corotational, conditions).unwrap();
        let (_, reports) = run_from_rest(body, options(Integrator::Midpoint, 1e-10), (0.001, 200));
        let largest = reports.iter().map(|r| r.energies.elastic).fold(0.0, f64::max);
        let error = reports.iter().map(|r| (r.kinetic + r.energies.total()).abs()).fold(0.0, f64::max) / largest;
        println!("{dimension}: energy error {error:.1e}");
        assert!(error < 1e-3, "{dimension}: the energy changes by {error:.1e} of the largest elastic energy");
    }
}

#[test]
fn cells_that_were_turned_inside_out_find_back_to_their_shape() {
    let model = bar(Dimension::Three, [3, 2, 2]);
    let mut body = SimplexBody::new(&model, SimplexLaw::Corotational, Conditions::default()).unwrap();
    let mut state = body.rest();
    // An inner node pushed out through the opposite side.
    let inner = model.mesh().nodes().iter().position(|x| distance(x, &[0.01, 0.01, 0.01]) < 1e-9).unwrap();
    state.displacement[3 * inner + 2] = 0.025;
    let start = body.energies(&state.displacement).unwrap().elastic;
    let damping = Damping { mass: 0.0, stiffness: 1e-2 };
    run(&mut body, &mut state, StepOptions { damping, ..options(Integrator::ImplicitEuler, 1e-8) }, (0.01, 200));
    let end = body.energies(&state.displacement).unwrap().elastic;
    assert!(end < 1e-8 * start, "{end:.1e} J are left of {start:.1e} J");
    let stretch = |a: usize, b: usize| {
        let at = |n: usize| -> [f64; 3] {
            std::array::from_fn(|r| model.mesh().nodes()[n][r] + state.displacement[3 * n + r])
        };
        distance(&at(a), &at(b)) / distance(&model.mesh().nodes()[a], &model.mesh().nodes()[b])
    };
    for n in (0..model.mesh().nodes().len()).filter(|n| *n != inner) {
        assert!((stretch(n, inner) - 1.0).abs() < 1e-3, "node {n}: {}", stretch(n, inner));
    }
}

#[test]
fn derivatives_of_a_body_are_those_of_its_energy() {
    let mut random = Uniform(3);
    for (dimension, law) in [Dimension::One, Dimension::Two, Dimension::Three]
        .iter()
        .flat_map(|d| [(*d, SimplexLaw::Linear), (*d, SimplexLaw::Corotational)])
    {
        let model = bar(dimension, [3, 2, 1]);
        let nodes = model.mesh().nodes().len();
        let spring =
            NodeSpring { node: Node(2), stiffness: 300.0, target: [0.05, 0.02, 0.0], schedule: Schedule::default() };
        let mut conditions = conditions(vec![], vec![weight(&model, [3.0, -5.0, 0.0])]);
        conditions.springs.push(spring);
        let mut body = SimplexBody::new(&model, law, conditions).unwrap();
        body.set_moment(Moment { loads: 0.0, share: 1.0, holds: 0.0 }).unwrap();
        let mut vector = |size: f64| -> Vec<f64> {
            (0..3 * nodes).map(|i| if i % 3 < dimension.axes() { size * random.signed() } else { 0.0 }).collect()
        };
        let (u, v) = (vector(0.0005), vector(1.0));
        let along = |s: f64| -> Vec<f64> { u.iter().zip(&v).map(|(u, v)| u + s * v).collect() };
        let at = |body: &SimplexBody, s: f64| {
            let mut gradient = vec![0.0; 3 * nodes];
            let energies = body.gradient(&along(s), &mut gradient).unwrap();
            assert_eq!(body.energies(&along(s)).unwrap(), energies);
            (energies.total(), gradient)
        };
        let step = 1e-6;
        let (ahead, behind, (_, gradient)) = (at(&body, step), at(&body, -step), at(&body, 0.0));
        let (slope, exact) = ((ahead.0 - behind.0) / (2.0 * step), bodies::dot(&gradient, &v));
        assert!((slope - exact).abs() < 1e-7 * size(&gradient) * size(&v), "{dimension} {law:?}: {slope}, {exact}");
        let mut product = vec![0.0; 3 * nodes];
        // So much that the exact Hessian of cells under pressure is definite, which its factorisation needs.
        let mass = 2e6;
        body.linearise(&u, QuadraticWeights { mass, damping: 0.0 }, Projection::Exact).unwrap();
        body.multiply(&v, &mut product);
        let largest = size(&product);
        for i in 0..3 * nodes {
            let inertia = mass * body.mass()[i / 3] * v[i];
            let slope = (ahead.1[i] - behind.1[i]) / (2.0 * step) + inertia;
            assert!((slope - product[i]).abs() < 1e-5 * largest, "{dimension} {law:?} {i}: {slope}, {}", product[i]);
        }
    }
}

#[test]
fn what_does_not_fit_the_mesh_is_refused() {
    let model = bar(Dimension::Two, [2, 1, 1]);
    let nodes = model.mesh().nodes().len();
    let make = |conditions| SimplexBody::new(&model, SimplexLaw::Corotational, conditions);
    let short = make(conditions(vec![Hold::still("foot", vec![true; 3])], vec![])).err().unwrap();
    assert_eq!(short.to_string(), "the mask of foot has 3 entries, but the mesh needs 6; make it for this mesh");
    let load = TimedLoad { forces: vec![0.0; 5], schedule: Schedule::default() };
    assert!(matches!(make(conditions(vec![], vec![load])), Err(SimplexBodyError::Length { given: 5, needed: 18, .. })));
    let ground = grosgrain::contact::Ground { height: 0.0, friction: 0.0, stiffness: 1.0 };
    let grounded = Conditions { ground: Some(ground), ..Conditions::default() };
    assert!(matches!(make(grounded), Err(SimplexBodyError::Ground { dimension: Dimension::Two })));
    let spring = NodeSpring { node: Node(nodes), stiffness: 1.0, target: [0.0; 3], schedule: Schedule::default() };
    let tied = Conditions { springs: vec![spring], ..Conditions::default() };
    assert!(matches!(make(tied), Err(SimplexBodyError::Spring { spring: 0, .. })));
    for wrong in [vec![1.0; nodes - 1], vec![-1.0; nodes], vec![f64::NAN; nodes]] {
        assert!(make(Conditions::default()).unwrap().with_mass(wrong).is_err());
    }
    let heavy = make(Conditions::default()).unwrap().with_mass(vec![2.0; nodes]).unwrap();
    assert_eq!(heavy.mass(), vec![2.0; nodes]);
}

#[test]
fn motion_has_the_same_bits_for_any_number_of_threads() {
    let model = bar(Dimension::Three, [16, 6, 6]);
    let motion = || {
        let conditions = conditions(vec![clamped(&model)], vec![weight(&model, [0.0, 0.0, -GRAVITY])]);
        let body = SimplexBody::new(&model, SimplexLaw::Corotational, conditions).unwrap();
        let damping = Damping { mass: 0.0, stiffness: 1e-3 };
        let options = StepOptions { damping, ..options(Integrator::ImplicitEuler, 1e-6) };
        let (state, reports) = run_from_rest(body, options, (0.01, 3));
        let energies = reports.iter().map(|report| report.energies.total());
        state.displacement.iter().copied().chain(energies).map(f64::to_bits).collect::<Vec<_>>()
    };
    let with = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(motion);
    let one = with(1);
    assert!(with(2) == one && with(5) == one);
}
