//! Prints how long it takes to homogenize about 200,000 tetrahedra of two materials onto about 1,000, and the memory it takes.
//!
//! ```sh
//! cargo run --release -p grosgrain --example homogenize_time
//! ```

use std::error::Error;

use grosgrain::homogenization::{Downsampling, HomogenizeOptions, SimplexModel, homogenize};
use grosgrain::material::IsotropicMaterial;
use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, MandelTensor, SimplexLattice, SimplexMesh};

fn cube(boxes: usize, cut: BoxCut) -> Result<SimplexMesh, Box<dyn Error>> {
    let around = BoundingBox { lower: [0.0; 3], upper: [0.1; 3] };
    Ok(SimplexLattice { dimension: Dimension::Three, boxes: [boxes; 3], around, cut }.mesh()?)
}

/// Peak memory of the process \[GB\], where the system tells it.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1e6)
}

fn main() -> Result<(), Box<dyn Error>> {
    let (fine, coarse) = (cube(32, BoxCut::Alike)?, cube(6, BoxCut::Alternating)?);
    let tensor = |young: f64| -> Result<_, Box<dyn Error>> {
        Ok(MandelTensor::of_material(Dimension::Three, &IsotropicMaterial::new(young, 0.45)?.tensor()))
    };
    let phases = [tensor(1e4)?, tensor(1e7)?];
    // Rods along a diagonal, a thousand times stiffer than what they lie in.
    let is_rod = |x: [f64; 3]| ((x[0] - x[1]) * 150.0).sin() * ((x[1] - x[2]) * 170.0).sin() > 0.3;
    let tensors = (0..fine.cell_count()).map(|cell| phases[usize::from(is_rod(fine.centre(cell)))]).collect();
    let densities = vec![1000.0; fine.cell_count()];
    let model = SimplexModel::with_tensors(fine, tensors, densities)?;
    println!(
        "{} fine and {} coarse tetrahedra, {} threads",
        model.mesh().cell_count(),
        coarse.cell_count(),
        rayon::current_num_threads()
    );
    for downsampling in [Downsampling::AtNodes, Downsampling::Fitted] {
        let options = HomogenizeOptions { downsampling, ..HomogenizeOptions::default() };
        let found = homogenize(&model, &coarse, &options, &|_, _, _| true)?;
        let [harmonic, intersections, rest] = found.seconds;
        println!(
            "{downsampling:?}: harmonic displacements {harmonic:.2} s (factor {:.0} MB, {:.1} Gflop, residual {:.1e}), intersections {intersections:.2} s, \
             tensors and masses {rest:.2} s; peak memory {}",
            8e-6 * found.report.factor_entries as f64,
            1e-9 * found.report.factor_flops,
            found.report.residual,
            peak_memory().map_or_else(|| "unknown".into(), |memory| format!("{memory:.2} GB")),
        );
    }
    Ok(())
}
