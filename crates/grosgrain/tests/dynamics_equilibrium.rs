//! Static equilibrium under large deformation, fine and coarse.

mod bodies;
mod motion;

use grosgrain::coarse::Integration;
use grosgrain::dynamics::{
    Conditions, Damping, EquilibriumOptions, Hold, Holds, Integrator, LoadPath, Motion, Ramp, StepOptions,
    find_equilibrium, solve_fine,
};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::Law;
use grosgrain::mesh::Node;
use grosgrain::progress::silent;
use grosgrain::solver::SolverChoice;
use motion::{GRAVITY, KINDS, Kind, Runner, bar, clamped, distance, options, run, size, weight};

const WHOLE: LoadPath = LoadPath { share: [0.0, 1.0], time: [0.0, 1.0], loads: [1.0, 1.0] };

fn hanging(model: &FineModel, times: f64) -> Conditions {
    Conditions {
        holds: Holds(vec![clamped(model)]),
        loads: vec![weight(model, [0.0, 0.0, -times * GRAVITY])],
        ..Conditions::default()
    }
}

fn equilibrium(kind: Kind, model: &FineModel, conditions: Conditions, options: &EquilibriumOptions) -> Vec<f64> {
    let mut runner = Runner::new(kind, model, conditions);
    let mut u = runner.rest().displacement;
    let found = runner.with_body(|body| find_equilibrium(body, &mut u, &WHOLE, options, &|_| true));
    found.unwrap();
    u
}

#[test]
fn a_damped_motion_comes_to_rest_in_the_equilibrium() {
    let model = bar([12, 2, 2], Law::NeoHookean);
    for kind in KINDS {
        let still = equilibrium(kind, &model, hanging(&model, 2.0), &EquilibriumOptions::default());
        let damping = Damping { mass: 0.0, stiffness: 0.02 };
        let steps = StepOptions { damping, ..options(Integrator::ImplicitEuler, 1e-9) };
        let (moving, _) = run(kind, &model, hanging(&model, 2.0), steps, (0.05, 200));
        let difference = distance(&still, &moving.displacement) / size(&still);
        println!("{kind:?}: {difference:.1e}, size {:.3e}", size(&still));
        assert!(difference < 1e-6, "{kind:?}: {difference:.1e}");
    }
}

#[test]
fn small_loads_give_the_linear_solution_and_the_difference_falls_with_the_load() {
    for law in [Law::Corotational, Law::NeoHookean] {
        let model = bar([8, 2, 2], law);
        let fixed = clamped(&model).nodes;
        let error = |times: f64| {
            let loads = gravity(&model, [0.0, 0.0, -times * GRAVITY]);
            let linear = solve_fine(&model, &fixed, &loads, SolverChoice::Direct, &silent).unwrap().displacement;
            let found = equilibrium(Kind::Fine, &model, hanging(&model, times), &EquilibriumOptions::default());
            distance(&found, &linear) / size(&linear)
        };
        let (small, smaller) = (error(1e-2), error(1e-3));
        println!("{law:?}: {small:.2e}, {smaller:.2e}");
        // The difference is of second order in the displacement, so its relative size falls like the load.
        assert!((small / smaller - 10.0).abs() < 0.5, "{law:?}: {small:.2e} and {smaller:.2e}");
    }
}

#[test]
fn the_equilibrium_does_not_depend_on_the_increments_and_stiff_paths_are_halved() {
    let model = bar([12, 2, 2], Law::NeoHookean);
    let several = EquilibriumOptions { increments: 8, ..EquilibriumOptions::default() };
    let mut hasty = EquilibriumOptions::default();
    hasty.newton.max_iterations = 7;
    for kind in [Kind::Fine, Kind::Coarse(Integration::Gauss)] {
        let mut runner = Runner::new(kind, &model, hanging(&model, 12.0));
        let mut u = runner.rest().displacement;
        let report = runner.with_body(|body| find_equilibrium(body, &mut u, &WHOLE, &hasty, &|_| true)).unwrap();
        assert!(report.failures > 0, "{report:?}");
        let other = equilibrium(kind, &model, hanging(&model, 12.0), &several);
        let difference = distance(&u, &other) / size(&other);
        assert!(difference < 1e-6, "{kind:?}: {difference:.1e}");
    }
}

#[test]
fn what_has_no_equilibrium_is_told_with_the_share_of_the_load_and_the_cell() {
    let model = bar([6, 2, 2], Law::NeoHookean);
    let lattice = model.grid().lattice;
    let end = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 6).collect();
    let through = Hold {
        motion: Motion::translate([-0.08, 0.0, 0.0]),
        ramp: Ramp { from: 0.0, to: 1.0 },
        ..Hold::still("end", end)
    };
    let conditions = Conditions { holds: Holds(vec![clamped(&model), through]), ..Conditions::default() };
    let mut runner = Runner::new(Kind::Fine, &model, conditions);
    let mut u = runner.rest().displacement;
    let options = EquilibriumOptions { max_halvings: 4, ..EquilibriumOptions::default() };
    let outcome = runner.with_body(|body| find_equilibrium(body, &mut u, &WHOLE, &options, &|_| true));
    let error = outcome.unwrap_err().to_string();
    assert!(error.starts_with("no equilibrium beyond") && error.contains("% of the load"), "{error}");
    assert!(u.iter().all(|u| u.is_finite()));
}
