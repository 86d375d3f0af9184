//! The elastic energy of all cells of a mesh.

use rayon::prelude::*;

use super::cell::{Corners, ElasticCell};
use crate::linalg::sum_of_blocks;
use crate::material::Projection;
use crate::simplex::{Dimension, MandelTensor, SimplexMesh};

/// Cells of a task; fewer are done at once than it takes to wake a thread, and coarse meshes have no more.
const FORCES_AT_ONCE: usize = 256;
/// The same for second derivatives.
const TANGENTS_AT_ONCE: usize = 128;

/// The row-major 12×12 matrix of a cell with four corners, three components each; rows and columns of corners and axes that a dimension does not have are zero.
pub type SimplexMatrix = [f64; 144];

/// How the energy of a cell depends on the displacements of its corners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SimplexLaw {
    /// ½ ε : C : ε with ε = sym ∇u: small displacements.
    Linear,
    /// The same in a frame that rotates with the cell, ε = sym(Rᵀ F) − I, where R is the rotation that leaves the least displacement of the corners,
    /// Σ_i |Rᵀ (x_i − b) − (X_i − b₀)|² (`kharevych2009numerical`, §4.4). The gradient and the Hessian know that R depends on the corners.
    #[default]
    Corotational,
}

/// Why a mesh and its tensors have no energy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplexElasticityError {
    /// A tensor belongs to another dimension.
    #[error("the tensor of cell {cell} is one for {tensor}, but the mesh has {mesh}; make it for these")]
    Dimension {
        /// The cell, from 0.
        cell: usize,
        /// What the tensor is made for.
        tensor: Dimension,
        /// What the mesh is made of.
        mesh: Dimension,
    },
    /// A tensor has entries that are not finite.
    #[error("the tensor of cell {cell} has an entry {value}; all must be finite")]
    NotFinite {
        /// The cell, from 0.
        cell: usize,
        /// The entry.
        value: f64,
    },
}

/// Linear simplices (P1), each with its own elasticity tensor: energy, gradient and tangents of a displacement, three entries per node.
///
/// Energies are finite for any finite displacement, inverted cells included. In two dimensions they are those of a layer one metre thick, in one of a bar of a
/// square metre. Memory: 0.5 kB per cell.
#[derive(Clone, Debug)]
pub struct SimplexElasticity {
    cells: Vec<ElasticCell>,
    corners: Vec<[u32; 4]>,
    nodes: usize,
}

impl SimplexElasticity {
    /// The energy of `mesh`, `tensor` being that of a cell by its number.
    ///
    /// # Errors
    /// Tensors of another dimension or with entries that are not finite.
    pub fn new<'t>(
        mesh: &SimplexMesh,
        tensor: impl Fn(usize) -> &'t MandelTensor,
        law: SimplexLaw,
    ) -> Result<Self, SimplexElasticityError> {
        let rotates = law == SimplexLaw::Corotational;
        let elastic = |cell: usize| {
            let tensor = tensor(cell);
            if tensor.dimension != mesh.dimension() {
                let (tensor, mesh) = (tensor.dimension, mesh.dimension());
                return Err(SimplexElasticityError::Dimension { cell, tensor, mesh });
            }
            match tensor.matrix.iter().flatten().find(|value| !value.is_finite()) {
                Some(value) => Err(SimplexElasticityError::NotFinite { cell, value: *value }),
                None => Ok(ElasticCell::new(mesh, cell, tensor, rotates)),
            }
        };
        // Corners that a dimension does not have repeat the first one and contribute nothing.
        let corners = |cell: usize| std::array::from_fn(|n| *mesh.cell(cell).get(n).unwrap_or(&mesh.cell(cell)[0]));
        Ok(Self {
            cells: (0..mesh.cell_count()).map(elastic).collect::<Result<_, _>>()?,
            corners: (0..mesh.cell_count()).map(corners).collect(),
            nodes: mesh.nodes().len(),
        })
    }

    /// Corners of the cells, the first one again in place of those that a dimension does not have.
    pub fn corners(&self) -> &[[u32; 4]] {
        &self.corners
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodes
    }

    fn at_corners(&self, cell: usize, displacement: &[f64]) -> Corners {
        self.corners[cell].map(|v| std::array::from_fn(|r| displacement[3 * v as usize + r]))
    }

    /// The energy \[J\] of a displacement \[m\]; `None` where it is not finite.
    ///
    /// # Panics
    /// Panics when `displacement` has not three entries per node.
    pub fn energy(&self, displacement: &[f64]) -> Option<f64> {
        assert_eq!(displacement.len(), 3 * self.nodes, "three entries per node");
        let energy = |cell: usize| self.cells[cell].energy(&self.at_corners(cell, displacement)).unwrap_or(f64::NAN);
        let [sum] = sum_of_blocks(self.cells.len(), &|from, to| [(from..to).map(energy).sum()]);
        sum.is_finite().then_some(sum)
    }

    /// Adds the gradient \[N\] of the energy to `gradient` and returns the energy \[J\]; `None` where it is not finite.
    ///
    /// # Panics
    /// Panics when the vectors have not three entries per node.
    pub fn gradient(&self, displacement: &[f64], gradient: &mut [f64]) -> Option<f64> {
        assert_eq!([displacement.len(), gradient.len()], [3 * self.nodes; 2], "three entries per node");
        let of_cell = |cell: usize| self.cells[cell].gradient(&self.at_corners(cell, displacement));
        let forces: Vec<(f64, Corners)> =
            (0..self.cells.len()).into_par_iter().with_min_len(FORCES_AT_ONCE).map(of_cell).collect::<Option<_>>()?;
        for (corners, (_, forces)) in self.corners.iter().zip(&forces) {
            for (v, force) in corners.iter().zip(forces) {
                (0..3).for_each(|r| gradient[3 * *v as usize + r] += force[r]);
            }
        }
        let [sum] = sum_of_blocks(forces.len(), &|from, to| [forces[from..to].iter().map(|(energy, _)| energy).sum()]);
        sum.is_finite().then_some(sum)
    }

    /// Sets `tangents` to the second derivatives \[N/m\] of the cells' energies: exact ones, or with [`Projection::PositiveSemidefinite`] without what the
    /// stresses do as the frames turn, which is as definite as the tensors. `None` where the displacement is not finite.
    ///
    /// # Panics
    /// Panics when the displacement has not three entries per node, or there is not one matrix per cell.
    pub fn tangents(&self, displacement: &[f64], projection: Projection, tangents: &mut [SimplexMatrix]) -> Option<()> {
        assert_eq!(displacement.len(), 3 * self.nodes, "three entries per node");
        assert_eq!(tangents.len(), self.cells.len(), "one matrix per cell");
        tangents.par_iter_mut().with_min_len(TANGENTS_AT_ONCE).enumerate().try_for_each(|(cell, tangent)| {
            *tangent = self.cells[cell].hessian(&self.at_corners(cell, displacement), projection)?;
            Some(())
        })
    }
}
