//! The bodies of the paper: layers of a soft and a stiff material in beams and single cells.

use std::str::FromStr;

use grosgrain::fine::FineModel;
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Label, Pattern, VoxelGrid};

use crate::failure::Failure;
use crate::scene::nearest;

/// Coarse cells of the beam along x, y, z.
pub const BEAM: [usize; 3] = [16, 4, 4];
/// Young's modulus of the stiff phase over that of the soft one.
pub const RATIO: f64 = 50.0;
/// Poisson's ratio of both.
pub const POISSON: f64 = 0.45;
/// Labels of the soft and of the stiff phase; layers start with the soft one.
pub const PHASES: [Label; 2] = [Label(0), Label(1)];
/// Edge of a coarse cell \[m\]; errors in percent do not depend on it.
const COARSE_EDGE: f64 = 0.01;
const SOFT: f64 = 1e5;
const DENSITY: f64 = 1000.0;

/// A pattern of layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heterogeneity {
    /// Along i + j + k.
    Oblique,
    /// Along k, so that layers run along the beam.
    Horizontal,
    /// Along i, so that layers stand across the beam.
    Vertical,
}

/// Why a name is no pattern.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name:?} is no pattern{hint}; expected oblique, horizontal or vertical")]
pub struct UnknownPattern {
    name: String,
    hint: String,
}

impl Heterogeneity {
    /// All of them, in the paper's order.
    pub const ALL: [Self; 3] = [Self::Oblique, Self::Horizontal, Self::Vertical];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Oblique => "oblique",
            Self::Horizontal => "horizontal",
            Self::Vertical => "vertical",
        }
    }

    fn direction(self) -> [f64; 3] {
        match self {
            Self::Oblique => [1.0, 1.0, 1.0],
            Self::Horizontal => [0.0, 0.0, 1.0],
            Self::Vertical => [1.0, 0.0, 0.0],
        }
    }

    /// `coarse` cells of degree d in layers of `thickness` fine cells, soft first.
    fn layers(self, coarse: [usize; 3], degree: usize, thickness: usize) -> Result<VoxelGrid, Failure> {
        let spacing = COARSE_EDGE / degree as f64;
        let mut grid = VoxelGrid::uniform(coarse.map(|n| n * degree), [spacing; 3], PHASES[0]);
        let period = 2.0 * thickness as f64;
        let pattern = Pattern::Layers { direction: self.direction(), period, labels: PHASES.to_vec() };
        pattern.paint(&mut grid).map_err(|error| Failure::Failed(error.to_string()))?;
        Ok(grid)
    }

    /// The beam of Table 1: layers ⌈d/2⌉ fine cells thick.
    pub fn beam(self, degree: usize) -> Result<VoxelGrid, Failure> {
        self.layers(BEAM, degree, degree.div_ceil(2))
    }

    /// The single cell of Fig. 3: layers ⌈d/2⌉ fine cells thick.
    pub fn cell(self, degree: usize) -> Result<VoxelGrid, Failure> {
        self.layers([1; 3], degree, degree.div_ceil(2))
    }

    /// 3 × 3 × 3 coarse cells with layers two fine cells thick, on whose middle cell times are measured; the paper does not say what
    /// its cells were filled with.
    pub fn ring(self, degree: usize) -> Result<VoxelGrid, Failure> {
        self.layers([3; 3], degree, 2)
    }
}

impl FromStr for Heterogeneity {
    type Err = UnknownPattern;

    fn from_str(name: &str) -> Result<Self, UnknownPattern> {
        let known = Self::ALL.into_iter().find(|pattern| pattern.name() == name);
        known.ok_or_else(|| {
            let near = nearest(name, &Self::ALL.map(Self::name));
            let hint = near.map_or_else(String::new, |near| format!(" (did you mean {near:?}?)"));
            UnknownPattern { name: name.into(), hint }
        })
    }
}

/// The fine model of a body of the two phases, of equal density.
pub fn fine_model(grid: VoxelGrid) -> Result<FineModel, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::Failed(error.to_string());
    let mut table = MaterialTable::new();
    for (label, name, young) in [(PHASES[0], "soft", SOFT), (PHASES[1], "stiff", RATIO * SOFT)] {
        let isotropic = IsotropicMaterial::new(young, POISSON).map_err(|error| failed(&error))?;
        let elasticity = Elasticity::Isotropic(isotropic);
        table.insert(label, Material::linear(name, elasticity, DENSITY));
    }
    FineModel::new(grid, &table).map_err(|error| failed(&error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use grosgrain::mesh::Cell;

    #[test]
    fn layers_are_half_a_coarse_cell_thick_rounded_up_and_soft_first() {
        for (pattern, degree) in Heterogeneity::ALL.into_iter().flat_map(|p| (2..=7).map(move |d| (p, d))) {
            let grid = pattern.beam(degree).unwrap();
            assert_eq!(grid.lattice.cells, [16 * degree, 4 * degree, 4 * degree]);
            let thickness = degree.div_ceil(2);
            for (cell, label) in grid.labels.iter().enumerate() {
                let [i, j, k] = grid.lattice.cell_position(Cell(cell));
                let along = match pattern {
                    Heterogeneity::Oblique => i + j + k,
                    Heterogeneity::Horizontal => k,
                    Heterogeneity::Vertical => i,
                };
                assert_eq!(*label, PHASES[along / thickness % 2], "{pattern:?}, d = {degree}, ({i}, {j}, {k})");
            }
        }
    }
}
