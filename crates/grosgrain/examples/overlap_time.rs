//! Prints how long it takes to intersect two meshes of tetrahedra, and how well the parts add up.
//!
//! ```sh
//! cargo run --release -p grosgrain --example overlap_time
//! ```

use std::error::Error;
use std::time::Instant;

use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, Overlaps, SimplexLattice, SimplexMesh};

/// A lattice of the unit cube whose inner nodes are pushed about, so that no faces of two of them coincide.
fn bent(boxes: usize, cut: BoxCut) -> Result<SimplexMesh, Box<dyn Error>> {
    let around = BoundingBox { lower: [0.0; 3], upper: [1.0; 3] };
    let mesh = SimplexLattice { dimension: Dimension::Three, boxes: [boxes; 3], around, cut }.mesh()?;
    let nodes = mesh.nodes().iter().map(|x| {
        let wave = x.map(|x| (std::f64::consts::PI * x).sin());
        let push = 0.1 * wave[0] * wave[1] * wave[2] / boxes as f64;
        [x[0] + push, x[1] - push, x[2] + 0.5 * push]
    });
    let cells = (0..mesh.cell_count()).map(|c| std::array::from_fn(|n| mesh.cell(c)[n])).collect();
    Ok(SimplexMesh::new(Dimension::Three, nodes.collect(), cells, mesh.tags().to_vec())?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let (fine, coarse) = (bent(33, BoxCut::Alike)?, bent(6, BoxCut::Alternating)?);
    let start = Instant::now();
    let overlaps = Overlaps::new(&fine, &coarse)?;
    let seconds = start.elapsed().as_secs_f64();
    let parts: usize = (0..overlaps.coarse_count()).map(|q| overlaps.of_coarse(q).len()).sum();
    println!(
        "{} fine and {} coarse tetrahedra, {parts} common parts: {seconds:.3} s with {} threads, greatest misfit {:.1e}",
        fine.cell_count(),
        coarse.cell_count(),
        rayon::current_num_threads(),
        overlaps.worst_covered().1.abs()
    );
    Ok(())
}
