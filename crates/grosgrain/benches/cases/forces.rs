//! Energy, forces and tangents of a body under large deformation, for each law.

use grosgrain::fine::{CellTangents, FineForces, FineModel, InvertedCell};
use grosgrain::material::{Elasticity, IsotropicMaterial, Law, Material, MaterialTable, Projection};
use grosgrain::mesh::{Label, Node, VoxelGrid};

use super::{Outcome, SPACING};

/// A bent and twisted block of one law; every Gauss point has another deformation.
pub struct ForcesCase {
    model: FineModel,
    forces: FineForces,
    displacement: Vec<f64>,
    gradient: Vec<f64>,
    tangents: CellTangents,
}

impl ForcesCase {
    pub fn new(cells: [usize; 3], law: Law) -> Outcome<Self> {
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(1e5, 0.45)?);
        let mut table = MaterialTable::new();
        table.insert(Label(0), Material { law, ..Material::linear("gel", elasticity, 1000.0) });
        let model = FineModel::new(VoxelGrid::uniform(cells, SPACING, Label(0)), &table)?;
        let displacement = (0..model.grid().lattice.node_count()).flat_map(|n| bent(&model, Node(n))).collect();
        Ok(Self {
            forces: FineForces::new(&model),
            gradient: vec![0.0; 3 * model.grid().lattice.node_count()],
            tangents: CellTangents::new(&model),
            model,
            displacement,
        })
    }

    pub fn energy(&self) -> Result<f64, InvertedCell> {
        self.forces.energy(&self.model, &self.displacement)
    }

    pub fn gradient(&mut self) -> Result<f64, InvertedCell> {
        self.gradient.fill(0.0);
        self.forces.gradient(&self.model, &self.displacement, &mut self.gradient)
    }

    pub fn tangents(&mut self, projection: Projection) -> Result<(), InvertedCell> {
        self.forces.tangents(&self.model, &self.displacement, projection, &mut self.tangents)
    }
}

/// Turned about x by up to a radian, stretched by a fifth at nearly constant volume, with waves of the length of a few cells.
fn bent(model: &FineModel, node: Node) -> [f64; 3] {
    let [x, y, z] = model.node_position(node);
    let length = SPACING[0] * model.grid().lattice.cells[0] as f64;
    let (sine, cosine) = (x / length).sin_cos();
    let wave = 0.03 * SPACING[0] * (1.7 * (x + 2.0 * y + 3.0 * z) / SPACING[0]).sin();
    let lateral = 1.2f64.sqrt().recip();
    [0.2 * x + wave, lateral * (cosine * y - sine * z) - y - wave, lateral * (sine * y + cosine * z) - z]
}
