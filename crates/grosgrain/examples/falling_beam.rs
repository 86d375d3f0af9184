//! A beam that falls askew on the ground and slides to rest: 10,000 steps of the coarse model by its stiffness.
//!
//! ```sh
//! cargo run --release -p grosgrain --example falling_beam -- 10000
//! ```
//!
//! Prints energies, memory, and time per step, and checks that no step of backward Euler adds mechanical energy, that of the weight and of the
//! ground included. In flight this follows where the energy is convex along the step. On the ground nothing guarantees it: the limit of friction is the normal
//! force of the last iterate, so that a step may begin with another friction energy than the last one ended with. It holds here, because the beam
//! loses far more by the impact.

use std::error::Error;
use std::time::Instant;

use grosgrain::coarse::Integration;
use grosgrain::contact::Ground;
use grosgrain::dynamics::{Conditions, NewtonOptions, RigidVelocity, Schedule, StepOptions, TimedLoad, centre_of_mass};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::{Elasticity, IsotropicMaterial, Law, Material, MaterialTable};
use grosgrain::mesh::{Label, Node, Pattern, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::update::{Simulation, SimulationOptions};

const SOFT: Label = Label(0);
const STIFF: Label = Label(1);
const VOXEL: f64 = 0.01;
const DEGREE: usize = 4;
const STEP: f64 = 0.005;
/// Height of the fall [m].
const FALL: f64 = 0.1;
/// Gain of a step over the energy of the fall that counts as rounding.
const SLACK: f64 = 1e-9;

/// What came out of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// The first step that touches the ground.
    pub landing: Option<usize>,
    /// Largest gain of mechanical energy in a step of the fall, and in one on the ground, over the energy of the fall.
    pub gains: [f64; 2],
    /// Kinetic energy at the end over the energy of the fall.
    pub motion_left: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let steps = std::env::args().nth(1).map_or(Ok(10_000), |a| a.parse())?;
    let outcome = run(steps, true)?;
    println!("{outcome:?}");
    if outcome.gains.iter().any(|gain| *gain > SLACK) {
        return Err("the beam has gained energy".into());
    }
    Ok(())
}

/// The beam above the ground, in flight.
pub fn falling_beam() -> Result<Simulation, Box<dyn Error>> {
    let mut grid = VoxelGrid::uniform([24, 8, 8], [VOXEL; 3], SOFT);
    Pattern::Layers { direction: [1.0; 3], period: 4.0, labels: vec![SOFT, STIFF] }.paint(&mut grid)?;
    let mut materials = MaterialTable::new();
    for (label, name, young) in [(SOFT, "soft", 1e5), (STIFF, "stiff", 5e6)] {
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45)?);
        let material = Material::linear(name, elasticity, 1000.0);
        materials.insert(label, Material { law: Law::NeoHookean, ..material });
    }
    let acting = |body: &FineModel| Conditions {
        loads: vec![TimedLoad { forces: gravity(body, [0.0, 0.0, -9.81]), schedule: Schedule::default() }],
        ground: Some(Ground { height: -FALL, friction: 0.5, stiffness: 1e5 / VOXEL }),
        ..Conditions::default()
    };
    let newton = NewtonOptions { tolerance: 1e-7, ..NewtonOptions::default() };
    let options = SimulationOptions {
        integration: Integration::Stiffness,
        steps: StepOptions { newton, ..StepOptions::default() },
        ..SimulationOptions::default()
    };
    let body = FineModel::new(grid, &materials)?;
    let centre = centre_of_mass(&body).ok_or("the beam has no mass")?;
    let mut simulation = Simulation::new(body, DEGREE, &options, Box::new(acting), &silent)?;
    let push = RigidVelocity { velocity: [0.5, 0.2, 0.0], spin: [0.0, 3.0, 0.0], centre };
    let coarse = simulation.coarse();
    let nodes: Vec<Node> =
        coarse.mesh().vertices().iter().map(|v| coarse.partition().coincident_node(v.node)).collect();
    let velocity = nodes.iter().flat_map(|node| push.at(simulation.fine().node_position(*node))).collect();
    simulation.state_mut().velocity = velocity;
    Ok(simulation)
}

/// Makes the steps.
pub fn run(steps: usize, talk: bool) -> Result<Outcome, Box<dyn Error>> {
    let mut simulation = falling_beam()?;
    let fall = simulation.fine().mass() * 9.81 * FALL;
    let start = simulation.state().kinetic_energy(simulation.coarse().mass());
    let (mut before, mut outcome) = (start, Outcome::default());
    let clock = Instant::now();
    for step in 1..=steps {
        let report = simulation.step(STEP)?;
        let now = report.kinetic + report.energies.total();
        if report.energies.points != 0.0 && outcome.landing.is_none() {
            outcome.landing = Some(step);
        }
        let gain = (now - before) / fall;
        let on_ground = outcome.landing.is_some();
        let worst = &mut outcome.gains[usize::from(on_ground)];
        *worst = worst.max(gain);
        outcome.motion_left = report.kinetic / fall;
        before = now;
        if talk && [1, 10, 100, 1_000, 2_000, 5_000, 10_000].contains(&step) {
            let memory = resident().map_or("-".to_owned(), |bytes| format!("{:.1}", bytes as f64 / 1e6));
            println!(
                "step {step:>6}: kinetic {:.3e} J, elastic {:.3e} J, weight {:.3e} J, ground {:.3e} J; {memory} MB; {:.3} ms per step",
                report.kinetic,
                report.energies.elastic,
                report.energies.loads,
                report.energies.points,
                1e3 * clock.elapsed().as_secs_f64() / step as f64
            );
        }
    }
    Ok(outcome)
}

/// Resident memory of the process [B], where the system tells it.
pub fn resident() -> Option<usize> {
    let pages = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(pages.split_whitespace().nth(1)?.parse::<usize>().ok()? * 4096)
}
