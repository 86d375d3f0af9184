//! Energy, forces and tangents of the fine model under large deformation.
//!
//! Layers of cells are taken in two colours (even z, then odd z), which touch disjoint layers of nodes: forces have one order
//! of addition for any number of threads.

mod cell;
mod points;
mod single;
mod tangents;

use rayon::prelude::*;

use super::FineModel;
use crate::assembly::CellStiffness;
use crate::material::{Law, PointLaw, Projection};
use crate::mesh::{Cell, Lattice};
use points::CornerVectors;

pub(super) use cell::smallest_determinant;
pub(super) use points::{GaussPoints, corner_displacements, deformation_gradient, gradients_at};
pub(crate) use single::{CellVectors, SingleCell};
pub use tangents::CellTangents;

/// A cell that is turned inside out somewhere, where its material has no energy.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("cell ({}, {}, {}) is inverted: det F = {determinant:.3e} at a Gauss point, and its neo-Hookean material has no energy there; take smaller steps, or smaller loads", at[0], at[1], at[2])]
pub struct InvertedCell {
    /// The cell.
    pub cell: Cell,
    /// Its position (i, j, k) in the lattice.
    pub at: [usize; 3],
    /// Its smallest det F over the Gauss points.
    pub determinant: f64,
}

/// Elastic energy E(u) = ∫ ψ(I + ∂u/∂X) dV of a fine model with its derivatives, by 2×2×2 Gauss points per cell.
///
/// Displacements and forces are lattice vectors, three components per node. Cells of [`Law::Linear`] use their reference
/// stiffness as the static solver does. What is kept here belongs to the spacing and the materials, not to single cells:
/// a model that was [changed](FineModel::change) needs no new one.
#[derive(Clone, Debug)]
pub struct FineForces {
    points: GaussPoints,
    /// Volume that belongs to a Gauss point \[m³\].
    weight: f64,
    /// By index of the material; `None` for linear ones.
    laws: Vec<Option<PointLaw>>,
}

impl FineForces {
    /// The forces of a model.
    pub fn new(model: &FineModel) -> Self {
        let law = |material: &crate::material::Material| match material.law {
            Law::Linear => None,
            Law::Corotational | Law::NeoHookean => Some(PointLaw::of(material, 1.0)),
        };
        Self {
            points: GaussPoints::new(model.grid.spacing),
            weight: model.grid.cell_volume() / 8.0,
            laws: model.materials.iter().map(|(_, material)| law(material)).collect(),
        }
    }

    /// E(u) \[J\].
    ///
    /// # Errors
    /// The first cell in the order of the lattice that is inverted.
    ///
    /// # Panics
    /// If `u` has not three components per node.
    pub fn energy(&self, model: &FineModel, u: &[f64]) -> Result<f64, InvertedCell> {
        let lattice = model.grid.lattice;
        assert_eq!(u.len(), 3 * lattice.node_count());
        let layer = |k: usize| {
            let mut sum = 0.0;
            for cell in cells_of_layer(lattice, k) {
                sum += self.cell_energy(model, cell, u)?;
            }
            Ok(sum)
        };
        let energies: Vec<Result<f64, InvertedCell>> = (0..lattice.cells[2]).into_par_iter().map(layer).collect();
        energies.into_iter().sum()
    }

    /// Adds the internal forces ∂E/∂u \[N\] to `out` and returns E(u) \[J\].
    ///
    /// # Errors
    /// As for [`energy`](Self::energy); a part has been added to `out` then.
    ///
    /// # Panics
    /// If `u` or `out` has not three components per node.
    pub fn gradient(&self, model: &FineModel, u: &[f64], out: &mut [f64]) -> Result<f64, InvertedCell> {
        let lattice = model.grid.lattice;
        assert_eq!([u.len(), out.len()], [3 * lattice.node_count(); 2]);
        let plane = 3 * lattice.nodes()[0] * lattice.nodes()[1];
        let mut energies = vec![Ok(0.0); lattice.cells[2]];
        for colour in 0..energies.len().min(2) {
            let layers = energies[colour..].par_chunks_mut(2).zip(out[plane * colour..].par_chunks_mut(2 * plane));
            layers.enumerate().for_each(|(n, (energy, out))| {
                let k = 2 * n + colour;
                energy[0] = self.layer_gradient(model, k, u, (out, k * plane));
            });
        }
        energies.into_iter().sum()
    }

    /// Writes ∂²E/∂u² \[N/m\] cell by cell into `out`, which follows the solid cells of the model. Sums over the Gauss points
    /// are projected point by point, so a projected tangent is semidefinite in each cell.
    ///
    /// # Errors
    /// As for [`energy`](Self::energy); `out` is then useless until it is filled again.
    ///
    /// # Panics
    /// If `u` has not three components per node.
    pub fn tangents(
        &self,
        model: &FineModel,
        u: &[f64],
        projection: Projection,
        out: &mut CellTangents,
    ) -> Result<(), InvertedCell> {
        let lattice = model.grid.lattice;
        assert_eq!(u.len(), 3 * lattice.node_count());
        out.follow(model);
        let inverted = out.cells_mut().filter_map(|(cell, matrix)| {
            let factor = model.factors[cell.0];
            match self.law(model, cell) {
                Some(law) => {
                    let local = corner_displacements(lattice, cell, u);
                    let tangent = cell::tangent(&self.points, self.weight * factor, (law, projection), &local, matrix);
                    tangent.is_none().then(|| self.inverted(lattice, cell, &local))
                }
                None => {
                    let reference = model.stiffness(cell.0)?.1;
                    matrix.iter_mut().zip(reference).for_each(|(to, from)| *to = factor * from);
                    None
                }
            }
        });
        inverted.min_by_key(|error| error.cell).map_or(Ok(()), Err)
    }

    /// The law of a cell, `None` for linear cells and voids.
    fn law(&self, model: &FineModel, cell: Cell) -> Option<&PointLaw> {
        self.laws.get(usize::from(model.material_of[cell.0]))?.as_ref()
    }

    fn cell_energy(&self, model: &FineModel, cell: Cell, u: &[f64]) -> Result<f64, InvertedCell> {
        let lattice = model.grid.lattice;
        let Some((factor, reference)) = model.stiffness(cell.0) else { return Ok(0.0) };
        let local = corner_displacements(lattice, cell, u);
        match self.law(model, cell) {
            None => Ok(cell::linear(factor, reference, &local).0),
            Some(law) => cell::energy(&self.points, self.weight * factor, law, &local)
                .ok_or_else(|| self.inverted(lattice, cell, &local)),
        }
    }

    /// Adds the forces of layer k to the two layers of nodes that it touches, of which the first number is `out.1`.
    fn layer_gradient(
        &self,
        model: &FineModel,
        k: usize,
        u: &[f64],
        out: (&mut [f64], usize),
    ) -> Result<f64, InvertedCell> {
        let lattice = model.grid.lattice;
        let (out, first) = out;
        let mut sum = 0.0;
        for cell in cells_of_layer(lattice, k) {
            let Some((factor, reference)) = model.stiffness(cell.0) else { continue };
            let local = corner_displacements(lattice, cell, u);
            let (energy, forces) = match self.law(model, cell) {
                None => cell::linear(factor, reference, &local),
                Some(law) => cell::forces(&self.points, self.weight * factor, law, &local)
                    .ok_or_else(|| self.inverted(lattice, cell, &local))?,
            };
            sum += energy;
            for (a, node) in lattice.corners(cell).iter().enumerate() {
                (0..3).for_each(|r| out[3 * node.0 - first + r] += forces[r][a]);
            }
        }
        Ok(sum)
    }

    fn inverted(&self, lattice: Lattice, cell: Cell, u: &CornerVectors) -> InvertedCell {
        InvertedCell { cell, at: lattice.cell_position(cell), determinant: smallest_determinant(&self.points, u) }
    }
}

fn cells_of_layer(lattice: Lattice, k: usize) -> impl Iterator<Item = Cell> {
    let count = lattice.cells[0] * lattice.cells[1];
    (k * count..(k + 1) * count).map(Cell)
}
