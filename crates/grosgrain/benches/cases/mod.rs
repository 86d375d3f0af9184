//! What the benchmarks and the report measure: one type per case, made once, run often.

#![allow(dead_code, reason = "every benchmark uses its own part of the cases")]

pub mod coarse;
pub mod fitting;
pub mod forces;
pub mod harmonic;
pub mod lattice;
pub mod steps;
pub mod updates;

use std::time::Duration;

use criterion::Criterion;
use grosgrain::fine::FineModel;
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Label, Pattern, VoxelGrid};
use grosgrain::partition::CoarseCell;

/// A value, or why a case cannot be set up.
pub type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Edge lengths of a fine cell [m].
pub const SPACING: [f64; 3] = [0.01; 3];
/// Young's modulus of the stiff layers over that of the soft ones.
pub const RATIO: f64 = 50.0;
/// The cell in the middle of 3 × 3 × 3 coarse cells.
pub const CENTRE: CoarseCell = CoarseCell(13);

/// A body of oblique layers two cells thick, Poisson's ratio 0.45, whose moduli differ by `ratio`.
pub fn layered(cells: [usize; 3], ratio: f64) -> Outcome<FineModel> {
    let mut grid = VoxelGrid::uniform(cells, SPACING, Label(1));
    let labels = vec![Label(1), Label(2)];
    Pattern::Layers { direction: [1.0; 3], period: 4.0, labels }.paint(&mut grid)?;
    let mut table = MaterialTable::new();
    for (label, young) in [(1, 1e5), (2, 1e5 * ratio)] {
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45)?);
        table.insert(Label(label), Material::linear(format!("layer {label}"), elasticity, 1000.0));
    }
    Ok(FineModel::new(grid, &table)?)
}

/// Few samples and short runs, so that all benchmarks together take minutes.
pub fn criterion() -> Criterion {
    let short = Criterion::default().sample_size(10).warm_up_time(Duration::from_secs(1));
    short.measurement_time(Duration::from_secs(3)).configure_from_args()
}
