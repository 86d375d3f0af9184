//! A coarse model of a fine body.

use rayon::prelude::*;

use super::galerkin_stiffness;
use crate::assembly::{CellStiffness, Window};
use crate::coarsening::ShapeFunctions;
use crate::element::{CellMatrix, Hex8, trilinear};
use crate::fine::FineModel;
use crate::material::ElasticityTensor;
use crate::mesh::{Cell, Lattice};
use crate::partition::{CoarseCell, CoarseNode, Partition};

/// Coarse cells with shape functions, a stiffness each, and lumped masses at the coarse nodes.
#[derive(Clone, Debug)]
pub struct CoarseModel {
    partition: Partition,
    functions: ShapeFunctions,
    index_of: Vec<Option<u32>>,
    stiffness: Vec<CellMatrix>,
    mass: Vec<f64>,
}

impl CoarseModel {
    /// The Galerkin model of shape functions: K̄ = Σ_e W_eᵀ K_e W_e in every cell.
    pub fn galerkin(model: &FineModel, partition: &Partition, functions: ShapeFunctions) -> Self {
        let stiffness = (0..functions.cells().len())
            .into_par_iter()
            .map(|index| {
                let cells = partition.cell_box(functions.cells()[index]);
                galerkin_stiffness(&Window::new(model, cells.start, cells.cells), functions.of(index))
            })
            .collect();
        Self::from_parts(model, partition, functions, stiffness)
    }

    /// Coarse trilinear elements with the volume average of the fine elasticity tensors; voids count as zero.
    pub fn averaged(model: &FineModel, partition: &Partition, functions: ShapeFunctions) -> Self {
        let element = Hex8::new(model.grid().spacing.map(|h| h * partition.degree() as f64));
        let stiffness =
            functions.cells().iter().map(|&cell| element.stiffness(&mean_tensor(model, partition, cell))).collect();
        Self::from_parts(model, partition, functions, stiffness)
    }

    fn from_parts(
        model: &FineModel,
        partition: &Partition,
        functions: ShapeFunctions,
        stiffness: Vec<CellMatrix>,
    ) -> Self {
        let mut index_of = vec![None; partition.coarse().cell_count()];
        functions.cells().iter().enumerate().for_each(|(i, cell)| index_of[cell.0] = Some(i as u32));
        let mass = lumped_mass(model, partition);
        Self { partition: *partition, functions, index_of, stiffness, mass }
    }

    /// The partition into coarse cells.
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// The shape functions.
    pub fn functions(&self) -> &ShapeFunctions {
        &self.functions
    }

    /// The coarse cells that hold solid fine cells, in the order of their functions.
    pub fn cells(&self) -> &[CoarseCell] {
        self.functions.cells()
    }

    /// Number of a coarse cell in [`CoarseModel::cells`], `None` where it is void.
    pub fn index_of(&self, cell: CoarseCell) -> Option<usize> {
        self.index_of[cell.0].map(|i| i as usize)
    }

    /// Stiffness \[N/m\] of cell number `index`.
    pub fn cell_stiffness(&self, index: usize) -> &CellMatrix {
        &self.stiffness[index]
    }

    /// Lumped mass \[kg\] of every node of the coarse lattice: Σ_e m_e N_i(x_e) with trilinear N_i at the fine cells' centres, so that
    /// it is positive and adds up to the mass of the body.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// Coarse nodes that belong to a cell with solid material, ascending.
    pub fn nodes(&self) -> Vec<CoarseNode> {
        let active = crate::assembly::active_nodes(self);
        (0..active.len()).filter(|&n| active[n]).map(CoarseNode).collect()
    }
}

impl CellStiffness for CoarseModel {
    fn lattice(&self) -> Lattice {
        self.partition.coarse()
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        self.index_of[cell].map(|i| (1.0, &self.stiffness[i as usize]))
    }
}

fn mean_tensor(model: &FineModel, partition: &Partition, cell: CoarseCell) -> ElasticityTensor {
    let count = partition.degree().pow(3) as f64;
    let mut sum = [[0.0; 6]; 6];
    for tensor in partition.fine_cells(cell).filter_map(|c| model.elasticity(c)) {
        for (total, entry) in sum.iter_mut().flatten().zip(tensor.voigt().iter().flatten()) {
            *total += entry / count;
        }
    }
    ElasticityTensor::from_voigt_unchecked(sum)
}

fn lumped_mass(model: &FineModel, partition: &Partition) -> Vec<f64> {
    let coarse = partition.coarse();
    let d = partition.degree() as f64;
    let mut mass = vec![0.0; coarse.node_count()];
    for cell in (0..coarse.cell_count()).map(CoarseCell) {
        let local = partition.cell_lattice();
        for (index, fine) in partition.fine_cells(cell).enumerate() {
            let share = model.cell_mass(fine);
            let centre = local.cell_position(Cell(index)).map(|x| (x as f64 + 0.5) / d);
            for (node, weight) in partition.corners(cell).iter().zip(trilinear(centre)) {
                mass[node.0] += share * weight;
            }
        }
    }
    mass
}
