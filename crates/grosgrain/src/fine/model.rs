//! Voxels and materials become cell stiffnesses and masses.

use crate::assembly::{CellStiffness, active_nodes};
use crate::element::{CellMatrix, Hex8};
use crate::material::{Elasticity, Law, Material, MaterialTable};
use crate::mesh::{Cell, Label, Lattice, Node, VoxelGrid, VoxelGridError};

/// The index of the material of voids.
pub(super) const VOID: u16 = u16::MAX;

/// Why a body and its materials do not make a model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FineModelError {
    /// The grid is unusable.
    #[error(transparent)]
    Grid(#[from] VoxelGridError),
    /// A label has no material.
    #[error("label {label} of voxel ({}, {}, {}) has no material; add one with label = {label}, or declare the label void", at[0], at[1], at[2])]
    NoMaterial {
        /// The label.
        label: Label,
        /// The first voxel that has it.
        at: [usize; 3],
    },
    /// More materials than a cell's 16-bit index tells apart.
    #[error("there are {count} materials; at most 65534 can be told apart, merge labels of equal material")]
    TooManyMaterials {
        /// How many there are.
        count: usize,
    },
    /// A per-voxel modulus on a material that is not isotropic.
    #[error(
        "material \"{name}\" is given by a stiffness matrix, which a modulus per voxel cannot scale; give it young and poisson"
    )]
    AnisotropicModulus {
        /// The material's name.
        name: String,
    },
    /// A law of large deformation for a material that is not isotropic.
    #[error(
        "material \"{name}\" is given by a stiffness matrix, which the {law} law cannot follow; give it young and poisson, or make it linear"
    )]
    AnisotropicLaw {
        /// The material's name.
        name: String,
        /// Its law.
        law: Law,
    },
}

/// A voxel body with its materials: stiffness and mass of every fine cell.
///
/// Cells of one material share a reference stiffness; a modulus per voxel scales it. Single cells can be
/// [changed](Self::change); the model keeps all materials of its table for that.
#[derive(Clone, Debug)]
pub struct FineModel {
    pub(super) grid: VoxelGrid,
    pub(super) materials: Vec<(Label, Material)>,
    references: Vec<CellMatrix>,
    pub(super) material_of: Vec<u16>,
    pub(super) factors: Vec<f64>,
    pub(super) active: Vec<bool>,
    /// Number of cells that are not void.
    pub(super) solid: usize,
}

impl FineModel {
    /// A model of the body.
    ///
    /// # Errors
    /// Unusable grids, labels without a material, an anisotropic material with a per-voxel modulus or a law other than linear.
    pub fn new(grid: VoxelGrid, table: &MaterialTable) -> Result<Self, FineModelError> {
        grid.validate()?;
        let materials: Vec<(Label, Material)> = table.iter().map(|(label, m)| (label, m.clone())).collect();
        if materials.len() >= usize::from(VOID) {
            return Err(FineModelError::TooManyMaterials { count: materials.len() });
        }
        materials.iter().try_for_each(|(_, material)| check_law(material))?;
        let element = Hex8::new(grid.spacing);
        let references = materials.iter().map(|(_, m)| element.stiffness(&m.elasticity.tensor())).collect();
        let material_of = materials_of_cells(&grid, &materials)?;
        let factors = stiffness_factors(&grid, &materials, &material_of)?;
        let solid = grid.solid_count();
        let mut model = Self { grid, materials, references, material_of, factors, active: Vec::new(), solid };
        model.active = active_nodes(&model);
        Ok(model)
    }

    /// The voxel body.
    pub fn grid(&self) -> &VoxelGrid {
        &self.grid
    }

    /// Whether a cell is void.
    pub fn is_void(&self, cell: Cell) -> bool {
        self.material_of[cell.0] == VOID
    }

    /// Which lattice nodes touch a solid cell.
    pub fn active(&self) -> &[bool] {
        &self.active
    }

    /// Number of nodes that touch a solid cell.
    pub fn active_count(&self) -> usize {
        self.active.iter().filter(|a| **a).count()
    }

    /// Position of a lattice node \[m\].
    pub fn node_position(&self, node: Node) -> [f64; 3] {
        self.grid.position(self.grid.lattice.node_position(node))
    }

    /// Young's modulus of a cell \[Pa\]; for an anisotropic material 1 / S₁₁ of its compliance S; zero for a void.
    pub fn young(&self, cell: Cell) -> f64 {
        let Some((_, material)) = self.materials.get(usize::from(self.material_of[cell.0])) else { return 0.0 };
        match &material.elasticity {
            Elasticity::Isotropic(m) => m.young() * self.factors[cell.0],
            Elasticity::Anisotropic(_) => own_young(material),
        }
    }

    /// The elasticity tensor of a cell \[Pa\], `None` for a void.
    pub fn elasticity(&self, cell: Cell) -> Option<crate::material::ElasticityTensor> {
        let (_, material) = self.materials.get(usize::from(self.material_of[cell.0]))?;
        Some(material.elasticity.tensor().scaled(self.factors[cell.0]))
    }

    /// Index of a cell's material in [`materials`](Self::materials) and the factor of its moduli, `None` for a void.
    pub fn material_of(&self, cell: Cell) -> Option<(usize, f64)> {
        let material = self.material_of[cell.0];
        (material != VOID).then(|| (usize::from(material), self.factors[cell.0]))
    }

    /// Density of a cell \[kg/m³\], zero for a void.
    pub fn density(&self, cell: Cell) -> f64 {
        let Some((_, material)) = self.materials.get(usize::from(self.material_of[cell.0])) else { return 0.0 };
        self.grid.density.as_ref().map_or(material.density, |density| density[cell.0])
    }

    /// Mass of a cell \[kg\].
    pub fn cell_mass(&self, cell: Cell) -> f64 {
        self.density(cell) * self.grid.cell_volume()
    }

    /// Mass of the body \[kg\].
    pub fn mass(&self) -> f64 {
        (0..self.grid.lattice.cell_count()).map(|c| self.cell_mass(Cell(c))).sum()
    }
}

impl CellStiffness for FineModel {
    fn lattice(&self) -> Lattice {
        self.grid.lattice
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        let reference = self.references.get(usize::from(self.material_of[cell]))?;
        Some((self.factors[cell], reference))
    }
}

/// Laws of large deformation exist for isotropic materials only.
fn check_law(material: &Material) -> Result<(), FineModelError> {
    match (&material.elasticity, material.law) {
        (Elasticity::Isotropic(_), _) | (_, Law::Linear) => Ok(()),
        (_, law) => Err(FineModelError::AnisotropicLaw { name: material.name.clone(), law }),
    }
}

fn materials_of_cells(grid: &VoxelGrid, materials: &[(Label, Material)]) -> Result<Vec<u16>, FineModelError> {
    let find = |label: Label| materials.binary_search_by_key(&label, |(l, _)| *l).ok();
    let material_of = |cell: usize| {
        if grid.void[cell] {
            return Ok(VOID);
        }
        let label = grid.labels[cell];
        let at = grid.lattice.cell_position(Cell(cell));
        find(label).map(|m| m as u16).ok_or(FineModelError::NoMaterial { label, at })
    };
    (0..grid.lattice.cell_count()).map(material_of).collect()
}

fn stiffness_factors(
    grid: &VoxelGrid,
    materials: &[(Label, Material)],
    material_of: &[u16],
) -> Result<Vec<f64>, FineModelError> {
    let Some(young) = &grid.young else { return Ok(vec![1.0; material_of.len()]) };
    let factor = |cell: usize| match materials.get(usize::from(material_of[cell])).map(|(_, m)| m) {
        None => Ok(0.0),
        Some(material) => factor_of(material, young[cell])
            .ok_or_else(|| FineModelError::AnisotropicModulus { name: material.name.clone() }),
    };
    (0..material_of.len()).map(factor).collect()
}

/// Young's modulus of a material \[Pa\]; for an anisotropic one 1 / S₁₁ of its compliance S.
pub(super) fn own_young(material: &Material) -> f64 {
    match &material.elasticity {
        Elasticity::Isotropic(m) => m.young(),
        Elasticity::Anisotropic(tensor) => tensor.young_along_x(),
    }
}

/// By what the reference stiffness of a material is scaled for a modulus; `None` if it cannot be scaled. An anisotropic material
/// takes its own modulus only, so that cells of it can stand in a body with moduli per voxel.
pub(super) fn factor_of(material: &Material, young: f64) -> Option<f64> {
    match &material.elasticity {
        Elasticity::Isotropic(m) => Some(young / m.young()),
        Elasticity::Anisotropic(_) => (young == own_young(material)).then_some(1.0),
    }
}
