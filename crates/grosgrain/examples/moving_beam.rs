//! A beam that swings, and is cut while it does.
//!
//! Sample run:
//!
//! ```text
//! cargo run --release -p grosgrain --example moving_beam
//! ```
//!
//! The beam of `coarsen_beam.rs` (see that first) is held at x = 0 and falls under its weight:
//!
//! ```text
//!   |#|==================
//!   |#|==================   ->   |#|===\\
//!                                        \\
//! ```
//!
//! 1. Materials with a law for large deformation.
//! 2. What acts on the body, as a function of the body: its weight changes with every cut.
//! 3. A simulation: body, coarse model and motion together.
//! 4. Steps of a thirtieth of a second; half-way an edit.

use grosgrain::coarse::Integration;
use grosgrain::dynamics::{Conditions, Damping, Hold, Holds, Schedule, TimedLoad};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::{Elasticity, IsotropicMaterial, Law, Material, MaterialTable};
use grosgrain::mesh::{Label, Node, Pattern, Selector, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::update::{Change, Edit, Region, Simulation, SimulationOptions};

const CELLS: [usize; 3] = [32, 8, 8];
const EDGE: f64 = 0.01;
const STEP: f64 = 1.0 / 30.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run().map(drop)
}

/// How far the tip hangs down \[m\] after every tenth step.
pub fn run() -> Result<Vec<f64>, Box<dyn std::error::Error>> {
    // 1.
    let mut materials = MaterialTable::new();
    for (label, name, young) in [(0, "soft", 1e5), (1, "stiff", 5e6)] {
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45)?);
        let material = Material { law: Law::NeoHookean, ..Material::linear(name, elasticity, 1000.0) };
        materials.insert(Label(label), material);
    }
    let mut grid = VoxelGrid::uniform(CELLS, [EDGE; 3], Label(0));
    let layers = Pattern::Layers { direction: [0.0, 0.0, 1.0], period: 8.0, labels: vec![Label(0), Label(1)] };
    layers.paint(&mut grid)?;
    let body = FineModel::new(grid, &materials)?;

    // 2.
    let acting = |body: &FineModel| {
        let lattice = body.grid().lattice;
        let wall = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 0).collect();
        let weight = TimedLoad { forces: gravity(body, [0.0, 0.0, -9.81]), schedule: Schedule::default() };
        Conditions { holds: Holds(vec![Hold::still("wall", wall)]), loads: vec![weight], ..Conditions::default() }
    };

    // 3.
    let mut options = SimulationOptions { integration: Integration::Stiffness, ..SimulationOptions::default() };
    options.steps.damping = Damping { mass: 2.0, stiffness: 0.0 };
    let mut simulation = Simulation::new(body, 4, &options, Box::new(acting), &silent)?;
    let unknowns = 3 * simulation.coarse().mesh().vertices().len();
    println!("{} fine cells, {unknowns} coarse unknowns", CELLS.iter().product::<usize>());

    // 4.
    let mut sags = Vec::new();
    let slot = Selector::Box { low: [0.12, -1.0, 0.04], high: [0.13, 1.0, 1.0] };
    let cut = Edit { region: Region::Selector(slot), change: Change::Remove };
    for step in 1..=60 {
        if step == 31 {
            let report = simulation.apply(&cut)?;
            println!("cut: {} cells, {} coarse cells renewed", report.changed_fine, report.dirty);
        }
        let report = simulation.step(STEP)?;
        if step % 10 == 0 {
            let tip = CELLS[0] + (CELLS[0] + 1) * (CELLS[1] / 2);
            let sag = -simulation.fine_displacement()?[3 * tip + 2];
            sags.push(sag);
            let energy = report.energies.elastic;
            println!("{:.2} s: tip {:.1} mm down, elastic energy {energy:.3} J", simulation.time(), 1e3 * sag);
        }
    }
    Ok(sags)
}
