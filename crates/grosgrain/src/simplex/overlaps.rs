//! What cells of two meshes have in common.

use super::clipping::HalfSpaces;
use super::{BoundingBox, BoundingTree, Dimension, SimplexMesh};
use rayon::prelude::*;

/// Fine cells that one task works on.
const CHUNK: usize = 512;
/// Common parts below this share of both cells are rounding.
const NOTHING: f64 = 1e-14;

/// Why two meshes have no overlaps.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OverlapError {
    /// Their dimensions differ.
    #[error("the fine mesh consists of {fine}, the coarse one of {coarse}; take two meshes of the same kind")]
    Dimensions {
        /// Of the fine mesh.
        fine: Dimension,
        /// Of the coarse mesh.
        coarse: Dimension,
    },
    /// They have nothing in common.
    #[error(
        "the meshes do not overlap: the fine one lies between {:?} and {:?}, the coarse one between {:?} and {:?}; bring both into one frame and unit",
        fine.lower, fine.upper, coarse.lower, coarse.upper
    )]
    Apart {
        /// Around the fine mesh.
        fine: BoundingBox,
        /// Around the coarse mesh.
        coarse: BoundingBox,
    },
}

/// For each coarse cell T_q the fine cells T_p that it meets, with their common measures |T_p ∩ T_q| \[m, m² or m³\].
///
/// Where the coarse mesh covers a fine cell, Σ_q |T_p ∩ T_q| = |T_p| to rounding: neighbours clip with the same planes.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlaps {
    starts: Vec<usize>,
    entries: Vec<(u32, f64)>,
    fine: Vec<f64>,
    coarse: Vec<f64>,
    covered: Vec<f64>,
    filled: Vec<f64>,
}

impl Overlaps {
    /// Intersects all cells of two meshes, each of which must not overlap itself.
    ///
    /// # Errors
    /// Meshes of different dimensions, or that have nothing in common.
    pub fn new(fine: &SimplexMesh, coarse: &SimplexMesh) -> Result<Self, OverlapError> {
        if fine.dimension() != coarse.dimension() {
            return Err(OverlapError::Dimensions { fine: fine.dimension(), coarse: coarse.dimension() });
        }
        let measures = |mesh: &SimplexMesh| (0..mesh.cell_count()).map(|c| mesh.measure(c)).collect::<Vec<f64>>();
        let (fine_measures, coarse_measures) = (measures(fine), measures(coarse));
        let common = intersect((fine, &fine_measures), (coarse, &coarse_measures));
        let overlaps = Self::sorted(&common, fine_measures, coarse_measures);
        if overlaps.entries.is_empty() {
            let around = |mesh: &SimplexMesh| BoundingBox::of_points(mesh.nodes().iter().copied());
            return Err(OverlapError::Apart { fine: around(fine), coarse: around(coarse) });
        }
        Ok(overlaps)
    }

    /// Sorts what each chunk of fine cells found by coarse cells.
    fn sorted(common: &[Vec<Common>], fine: Vec<f64>, coarse: Vec<f64>) -> Self {
        let mut starts = vec![0; coarse.len() + 1];
        common.iter().flatten().for_each(|c| starts[c.coarse as usize + 1] += 1);
        (0..coarse.len()).for_each(|q| starts[q + 1] += starts[q]);
        let mut next = starts.clone();
        let mut entries = vec![(0, 0.0); starts[coarse.len()]];
        let (mut covered, mut filled) = (vec![0.0; fine.len()], vec![0.0; coarse.len()]);
        for Common { fine, coarse, measure } in common.iter().flatten() {
            let at = &mut next[*coarse as usize];
            entries[*at] = (*fine, *measure);
            *at += 1;
            covered[*fine as usize] += measure;
            filled[*coarse as usize] += measure;
        }
        Self { starts, entries, fine, coarse, covered, filled }
    }

    /// Number of coarse cells.
    pub fn coarse_count(&self) -> usize {
        self.coarse.len()
    }

    /// Number of fine cells.
    pub fn fine_count(&self) -> usize {
        self.fine.len()
    }

    /// Fine cells p that meet the coarse cell q, ascending, and |T_p ∩ T_q|.
    pub fn of_coarse(&self, q: usize) -> &[(u32, f64)] {
        &self.entries[self.starts[q]..self.starts[q + 1]]
    }

    /// |T_p| of each fine cell.
    pub fn fine_measures(&self) -> &[f64] {
        &self.fine
    }

    /// |T_q| of each coarse cell.
    pub fn coarse_measures(&self) -> &[f64] {
        &self.coarse
    }

    /// Σ_q |T_p ∩ T_q| / |T_p| of a fine cell: 1 inside of the coarse mesh, 0 outside.
    pub fn covered(&self, p: usize) -> f64 {
        self.covered[p] / self.fine[p]
    }

    /// Σ_p |T_p ∩ T_q| / |T_q| of a coarse cell: 1 inside of the fine mesh, 0 outside.
    pub fn filled(&self, q: usize) -> f64 {
        self.filled[q] / self.coarse[q]
    }

    /// The fine cell p with the greatest |Σ_q |T_p ∩ T_q| / |T_p| − 1|, and the difference with its sign: rounding where the coarse mesh covers the fine one, −1 where
    /// a cell lies outside, positive where coarse cells overlap each other.
    pub fn worst_covered(&self) -> (usize, f64) {
        let misfits = (0..self.fine.len()).map(|p| (p, self.covered(p) - 1.0));
        misfits.fold((0, 0.0), |worst, misfit| if misfit.1.abs() > worst.1.abs() { misfit } else { worst })
    }

    /// Coarse cells with no fine cell in them.
    pub fn empty_coarse(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.coarse.len()).filter(|q| self.starts[*q] == self.starts[q + 1])
    }

    /// Measure of the fine mesh, of the coarse mesh, and of what they have in common.
    pub fn totals(&self) -> [f64; 3] {
        [&self.fine, &self.coarse, &self.filled].map(|measures| measures.iter().sum())
    }
}

/// Part of a fine cell that lies in a coarse cell.
#[derive(Clone, Copy, Debug)]
struct Common {
    fine: u32,
    coarse: u32,
    measure: f64,
}

/// All common parts in the order of the fine cells, by chunks of these.
fn intersect(fine: (&SimplexMesh, &[f64]), coarse: (&SimplexMesh, &[f64])) -> Vec<Vec<Common>> {
    let tree = BoundingTree::of_cells(coarse.0);
    let half_spaces: Vec<HalfSpaces> =
        (0..coarse.0.cell_count()).into_par_iter().map(|q| HalfSpaces::of_cell(coarse.0, q)).collect();
    let chunk = |number: usize| {
        let mut found = Vec::new();
        for p in number * CHUNK..((number + 1) * CHUNK).min(fine.0.cell_count()) {
            let mut corners = [[0.0; 3]; 4];
            let count = fine.0.cell(p).len();
            (0..count).for_each(|n| corners[n] = fine.0.corner(p, n));
            let around = BoundingBox::of_points(corners[..count].iter().copied());
            tree.visit(&around, |q| {
                let share = half_spaces[q as usize].share_of(&corners[..count]);
                let measure = share * fine.1[p];
                if share > 0.0 && measure >= NOTHING * fine.1[p].min(coarse.1[q as usize]) {
                    found.push(Common { fine: p as u32, coarse: q, measure });
                }
            });
        }
        found
    };
    (0..fine.0.cell_count().div_ceil(CHUNK)).into_par_iter().map(chunk).collect()
}
