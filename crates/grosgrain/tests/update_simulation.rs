//! Edits while a body moves.

mod bodies;
mod motion;

use grosgrain::coarse::Integration;
use grosgrain::dynamics::{CoarseMechanics, Conditions, Hold, Holds, Motion, Ramp, State, Stepper};
use grosgrain::fine::FineModel;
use grosgrain::material::Law;
use grosgrain::mesh::{Label, Node, Selector};
use grosgrain::progress::silent;
use grosgrain::update::{Change, Edit, Region, Simulation, SimulationOptions};
use motion::{GRAVITY, bar, clamped, distance, size, weight};

fn acting(model: &FineModel) -> Conditions {
    let holds = Holds(vec![clamped(model)]);
    Conditions { holds, loads: vec![weight(model, [0.0, 0.0, -GRAVITY])], ..Conditions::default() }
}

fn simulation(integration: Integration) -> Simulation {
    let options = SimulationOptions { integration, ..SimulationOptions::default() };
    Simulation::new(bar([12, 4, 4], Law::NeoHookean), 2, &options, Box::new(acting), &silent).unwrap()
}

fn in_box(low: [f64; 3], high: [f64; 3], change: Change) -> Edit {
    Edit { region: Region::Selector(Selector::Box { low, high }), change }
}

#[test]
fn an_edit_to_the_same_material_changes_nothing() {
    let (mut edited, mut left) = (simulation(Integration::Gauss), simulation(Integration::Gauss));
    let stiff = Edit { region: Region::Selector(Selector::Label(Label(1))), change: Change::Material(Label(1)) };
    for _ in 0..10 {
        let report = edited.apply(&stiff).unwrap();
        assert_eq!(report.changed_fine, 0);
        assert_eq!(edited.step(0.01).unwrap(), left.step(0.01).unwrap());
    }
    assert_eq!(edited.state(), left.state());
    assert!(size(&left.state().displacement) > 1e-3);
}

#[test]
fn after_an_edit_the_body_moves_as_one_made_anew_with_the_same_motion() {
    for integration in [Integration::Gauss, Integration::Centre, Integration::Stiffness] {
        let mut simulation = simulation(integration);
        (0..5).for_each(|_| assert!(simulation.step(0.01).is_ok()));
        for edit in [
            in_box([0.04, 0.0, 0.0], [0.08, 0.04, 0.02], Change::Material(Label(1))),
            in_box([0.05, 0.0, 0.02], [0.06, 0.04, 0.04], Change::Remove),
        ] {
            let velocity = simulation.state().velocity.clone();
            let report = simulation.apply(&edit).unwrap();
            assert!(report.changed_fine > 0);
            if matches!(edit.change, Change::Material(_)) {
                assert_eq!(simulation.state().velocity, velocity, "an edit does not push");
            }
            let mechanics =
                CoarseMechanics::new(simulation.fine(), simulation.coarse(), integration, acting(simulation.fine()));
            let (mut mechanics, mut state) = (mechanics.unwrap(), simulation.state().clone());
            let mut stepper = Stepper::new(SimulationOptions::default().steps);
            for _ in 0..5 {
                let time = simulation.time();
                let mut body = mechanics.on(simulation.fine(), simulation.coarse());
                stepper.advance(&mut body, &mut state, time, 0.01).unwrap();
                simulation.step(0.01).unwrap();
            }
            let difference = |a: &State, b: &State| distance(&a.displacement, &b.displacement) / size(&b.displacement);
            let difference = difference(simulation.state(), &state);
            // Both solve to a relative residual of 1e-5, from preconditioners of different age.
            assert!(difference < 1e-4, "{integration:?}: {difference:.1e}");
        }
    }
}

#[test]
fn removing_and_softening_cells_gives_the_body_no_energy() {
    let mut simulation = simulation(Integration::Gauss);
    let mut energy = 0.0;
    for n in 0..60 {
        let mut work = 0.0;
        if n == 10 {
            simulation.apply(&in_box([0.04, 0.0, 0.0], [0.08, 0.04, 0.04], Change::Material(Label(0)))).unwrap();
        }
        if n == 20 {
            simulation.apply(&in_box([0.09, 0.0, 0.02], [0.1, 0.04, 0.04], Change::Remove)).unwrap();
        }
        let report = simulation.step(0.01).unwrap();
        work += report.work_of_loads;
        let now = report.kinetic + report.energies.elastic;
        if n != 10 && n != 20 {
            assert!(now - energy <= work + 1e-6 * now, "step {n} gains {:.2e} J", now - energy - work);
        } else {
            // What the edit leaves has less elastic energy at the same displacement, but for the change of shape functions.
            assert!(now - energy <= work + 0.02 * now, "edit {n} gives {:.2e} of {now:.2e} J", now - energy - work);
        }
        energy = now;
    }
}

#[test]
fn an_undone_edit_leaves_the_model_as_before() {
    let mut simulation = simulation(Integration::Stiffness);
    (0..3).for_each(|_| assert!(simulation.step(0.01).is_ok()));
    let before =
        (0..simulation.coarse().elements().len()).map(|n| *simulation.coarse().stiffness(n)).collect::<Vec<_>>();
    simulation.apply(&in_box([0.04, 0.0, 0.0], [0.08, 0.04, 0.02], Change::Remove)).unwrap();
    simulation.step(0.01).unwrap();
    assert!(simulation.undo().unwrap().is_some());
    let after =
        (0..simulation.coarse().elements().len()).map(|n| *simulation.coarse().stiffness(n)).collect::<Vec<_>>();
    assert!(before == after);
    simulation.step(0.01).unwrap();
    assert!(simulation.fine_displacement().unwrap().iter().all(|u| u.is_finite()));
}

#[test]
fn a_step_that_fails_leaves_motion_and_time_together() {
    let acting = |model: &FineModel| {
        let lattice = model.grid().lattice;
        let at = |x: usize| (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == x).collect();
        // The last layer of coarse cells, all of whose corners are held, is pressed flat and beyond within half a second.
        let middle = Hold::still("middle", at(10));
        let through = Hold {
            motion: Motion::translate([-0.2, 0.0, 0.0]),
            ramp: Ramp { from: 0.0, to: 0.5 },
            ..Hold::still("end", at(12))
        };
        Conditions { holds: Holds(vec![clamped(model), middle, through]), ..Conditions::default() }
    };
    let mut options = SimulationOptions::default();
    options.steps.max_halvings = 5;
    let mut simulation =
        Simulation::new(bar([12, 4, 4], Law::NeoHookean), 2, &options, Box::new(acting), &silent).unwrap();
    let error = simulation.step(0.5).unwrap_err();
    assert!((simulation.time() - (error.time - error.smallest)).abs() < 1e-15 && simulation.time() > 0.0, "{error}");
    // The held end is where it must be at that time.
    let tip = *simulation.fine_displacement().unwrap().chunks_exact(3).nth(12).unwrap().first().unwrap();
    assert!((tip + 0.2 * simulation.time() / 0.5).abs() < 1e-12, "tip {tip} at {}", simulation.time());
}
