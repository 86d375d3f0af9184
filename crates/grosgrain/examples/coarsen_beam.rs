//! Coarsen a beam of two materials and compare it with the fine model. The first example to read.
//!
//! ```sh
//! cargo run --release -p grosgrain --example coarsen_beam
//! ```
//!
//! Find the displacement u of a cantilever under its own weight,
//!
//! ```text
//!     −div(C(x) : ε(u)) = ρ g   in the beam,        u = 0 at x = 0,
//!
//!      z  clamped
//!      |  ▓▓░░▓▓░░▓▓░░▓▓░░▓▓░░▓▓░░      ▓ soft, ░ 50 times stiffer; layers across the beam,
//!      |  ▓▓░░▓▓░░▓▓░░▓▓░░▓▓░░▓▓░░        two fine cells thick
//!      +--------------------------- x
//! ```
//!
//! once with one trilinear hexahedron per fine cell, and once with coarse cells of 3 × 3 × 3 of them whose shape functions know
//! what lies inside.

use std::error::Error;

use grosgrain::coarse::{BuildOptions, build};
use grosgrain::dynamics::{relative_error, solve_coarse, solve_fine};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Axis, Label, Pattern, PlaneAt, Selector, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::solver::SolverChoice;

const SOFT: Label = Label(0);
const STIFF: Label = Label(1);
const DEGREE: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let error = run()?;
    println!("RMS error of the coarse displacement: {:.2} %", 100.0 * error);
    Ok(())
}

/// Runs the example; returns ‖u_coarse − u_fine‖ / ‖u_fine‖.
pub fn run() -> Result<f64, Box<dyn Error>> {
    // 1. The body: voxels with labels, painted in layers across x.
    let mut grid = VoxelGrid::uniform([48, 12, 12], [0.16 / 48.0; 3], SOFT);
    Pattern::Layers { direction: [1.0, 0.0, 0.0], period: 4.0, labels: vec![SOFT, STIFF] }.paint(&mut grid)?;

    // 2. What the labels stand for [Pa, –, kg/m³].
    let mut materials = MaterialTable::new();
    for (label, name, young) in [(SOFT, "soft", 1e5), (STIFF, "stiff", 5e6)] {
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45)?);
        materials.insert(label, Material::linear(name, elasticity, 1000.0));
    }

    // 3. The fine model, what holds it and what pulls.
    let fixed = Selector::Plane { axis: Axis::X, at: PlaneAt::Min }.nodes(&grid)?.mask;
    let model = FineModel::new(grid, &materials)?;
    let loads = gravity(&model, [0.0, 0.0, -9.81]);

    // 4. The coarse model: training on the one-ring of every coarse cell, shape functions in closed form.
    let built = build(&model, DEGREE, &BuildOptions::default(), &silent)?;

    // 5. Both under the same load.
    let fine = solve_fine(&model, &fixed, &loads, SolverChoice::Auto, &silent)?;
    let coarse = solve_coarse(&built.model, &fixed, &loads, &silent)?;
    println!("{} unknowns instead of {}", 3 * built.model.mesh().vertices().len(), fine.report.unknowns);
    Ok(relative_error(&coarse.displacement, &fine.displacement))
}
