//! Edit a body inside a loop, as a game or a surgery simulator does: a blade goes through a beam while the beam hangs under its own
//! weight, and the coarse model stays true at every frame.
//!
//! ```sh
//! cargo run --release -p grosgrain --example edit_in_a_loop
//! ```
//!
//! ```text
//!           blade, one frame further down each time
//!             |
//!      z  ▓▓░░|▓▓░░▓▓░░▓▓░░▓▓░░      ▓ soft, ░ 50 times stiffer
//!      |  ░░▓▓|░░▓▓░░▓▓░░▓▓░░▓▓
//!      +---------------------- x     clamped at x = 0
//! ```

use std::error::Error;

use grosgrain::dynamics::solve_coarse;
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Axis, Blade, Label, Pattern, PlaneAt, Selector, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::update::{Change, Edit, LiveModel, LiveOptions, Region};

const SOFT: Label = Label(0);
const STIFF: Label = Label(1);
const DEGREE: usize = 2;
const VOXEL: f64 = 0.0025;
const FRAMES: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let tip = run(true)?;
    println!("the tip has sunk from {:.2} mm to {:.2} mm", -1e3 * tip[0], -1e3 * tip[FRAMES]);
    Ok(())
}

/// Runs the loop; returns the vertical displacement of the tip \[m\] before the first and after each edit.
pub fn run(talk: bool) -> Result<Vec<f64>, Box<dyn Error>> {
    // 1. A body, and what holds it.
    let mut grid = VoxelGrid::uniform([24, 8, 8], [VOXEL; 3], SOFT);
    Pattern::Layers { direction: [1.0, 0.0, 1.0], period: 4.0, labels: vec![SOFT, STIFF] }.paint(&mut grid)?;
    let mut materials = MaterialTable::new();
    for (label, name, young) in [(SOFT, "soft", 1e5), (STIFF, "stiff", 5e6)] {
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45)?);
        materials.insert(label, Material::linear(name, elasticity, 1000.0));
    }
    let held = Selector::Plane { axis: Axis::X, at: PlaneAt::Min }.nodes(&grid)?.mask;
    let tip = Selector::Plane { axis: Axis::X, at: PlaneAt::Max }.nodes(&grid)?.mask;
    let body = FineModel::new(grid, &materials)?;

    // 2. Its coarse model, ready to be edited. The default training is exact and chosen by cost.
    let mut model = LiveModel::new(body, DEGREE, &LiveOptions::default(), held.clone(), &silent)?;
    let mut sunk = vec![equilibrium(&mut model, &held, &tip)?];

    // 3. The loop: the blade cuts one voxel deeper, the model follows, the frame is solved.
    for frame in 1..=FRAMES {
        let top = 8.0 * VOXEL;
        let edge = [[9.5 * VOXEL, -VOXEL, top], [9.5 * VOXEL, 9.0 * VOXEL, top]];
        let blade = Blade { edge, sweep: [0.0, 0.0, -VOXEL * (frame as f64 - 0.5)] };
        let cut = Edit { region: Region::Selector(Selector::Blade(blade)), change: Change::Remove };
        let report = model.apply(&cut)?;
        sunk.push(equilibrium(&mut model, &held, &tip)?);
        if talk {
            println!(
                "frame {frame}: {} voxels gone from {} coarse cells, {} renewed in {:.1} ms; tip at {:.2} mm",
                report.changed_fine,
                report.changed,
                report.dirty,
                1e3 * report.seconds.total,
                1e3 * sunk[frame]
            );
        }
    }
    Ok(sunk)
}

/// Solves for the equilibrium under gravity, which becomes the model's motion; returns the mean vertical displacement of the tip.
fn equilibrium(model: &mut LiveModel, held: &[bool], tip: &[bool]) -> Result<f64, Box<dyn Error>> {
    let loads = gravity(model.fine(), [0.0, 0.0, -9.81]);
    let solution = solve_coarse(model.coarse(), held, &loads, &silent)?;
    model.state.displacement = solution.coarse_displacement;
    let of_tip: Vec<f64> = (0..tip.len()).filter(|n| tip[*n]).map(|n| solution.displacement[3 * n + 2]).collect();
    Ok(of_tip.iter().sum::<f64>() / of_tip.len() as f64)
}
