//! A mesh of simplices with the material of each cell.

use std::collections::BTreeMap;

use crate::linalg::sum_of_blocks;
use crate::material::MaterialTable;
use crate::mesh::Label;
use crate::simplex::{Dimension, MandelTensor, SimplexMesh};

/// Entries of a tensor may differ from its transpose by this share of the largest entry.
const ASYMMETRY: f64 = 1e-9;

/// Why a mesh and its materials do not make a model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplexModelError {
    /// Tags that no material stands for.
    #[error("{}; add a material with that label", listed(.missing))]
    NoMaterial {
        /// Each such tag with the number of its cells, ascending.
        missing: Vec<(i32, usize)>,
    },
    /// As many tensors or densities as cells are needed.
    #[error("{cells} cells but {tensors} tensors and {densities} densities; give one of each per cell")]
    Count {
        /// Number of cells.
        cells: usize,
        /// Number of tensors.
        tensors: usize,
        /// Number of densities.
        densities: usize,
    },
    /// A tensor is one of another space.
    #[error("the tensor of cell {cell} has {rows} rows, but {cells} need {expected}")]
    Dimension {
        /// The cell, from 0.
        cell: usize,
        /// Rows of its tensor.
        rows: usize,
        /// Of what the mesh is made.
        cells: Dimension,
        /// Rows that a tensor needs there.
        expected: usize,
    },
    /// An entry of a tensor is not a number, or differs from that across the diagonal.
    #[error(
        "entries ({row}, {column}) and ({column}, {row}) of the tensor of cell {cell} are {value:e} and {mirrored:e}; a stiffness is symmetric and finite"
    )]
    Tensor {
        /// The cell, from 0.
        cell: usize,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// The entry \[Pa\].
        value: f64,
        /// The one across the diagonal \[Pa\].
        mirrored: f64,
    },
    /// A density is negative or not a number.
    #[error("the density of cell {cell} is {density}; it must be zero or more")]
    Density {
        /// The cell, from 0.
        cell: usize,
        /// Its density \[kg/m³\].
        density: f64,
    },
}

fn listed(missing: &[(i32, usize)]) -> String {
    let tags: Vec<String> = missing.iter().map(|(tag, cells)| format!("tag {tag} ({cells} cells)")).collect();
    format!("{} {} no material", tags.join(", "), if tags.len() == 1 { "has" } else { "have" })
}

/// A body of simplices: a mesh, and the elasticity tensor and density of each of its cells.
///
/// A body of triangles is a slice of one metre in plane strain, one of segments a bar of one square metre, so that masses are in kilograms and densities in kg/m³ in
/// every dimension.
#[derive(Clone, Debug)]
pub struct SimplexModel {
    mesh: SimplexMesh,
    tensors: Vec<MandelTensor>,
    densities: Vec<f64>,
    /// Index of each cell in `tensors` and `densities`.
    material_of: Vec<u32>,
}

impl SimplexModel {
    /// A model in which a cell is made of the material whose label is its tag; triangles in plane strain, segments with Young's modulus along x.
    ///
    /// # Errors
    /// Tags without a material, all of them with their numbers of cells; densities that are negative or not finite.
    pub fn new(mesh: SimplexMesh, materials: &MaterialTable) -> Result<Self, SimplexModelError> {
        let mut counts = BTreeMap::new();
        mesh.tags().iter().for_each(|tag| *counts.entry(*tag).or_insert(0usize) += 1);
        let missing: Vec<(i32, usize)> =
            counts.iter().filter(|(tag, _)| materials.get(Label(**tag)).is_none()).map(|(t, n)| (*t, *n)).collect();
        if !missing.is_empty() {
            return Err(SimplexModelError::NoMaterial { missing });
        }
        let (mut tensors, mut densities, mut index) = (Vec::new(), Vec::new(), BTreeMap::new());
        for (label, material) in materials.iter().filter(|(label, _)| counts.contains_key(&label.0)) {
            index.insert(label.0, tensors.len() as u32);
            tensors.push(MandelTensor::of_material(mesh.dimension(), &material.elasticity.tensor()));
            densities.push(material.density);
        }
        let material_of = mesh.tags().iter().map(|tag| index[tag]).collect();
        Self { mesh, tensors, densities, material_of }.checked()
    }

    /// A model with a tensor \[Pa\] and a density \[kg/m³\] per cell, whatever the tags.
    ///
    /// Tensors need not be definite: what a computation needs, it checks itself.
    ///
    /// # Errors
    /// Tensors or densities that are not one per cell, tensors of another dimension than the mesh, tensors that are not symmetric and finite, densities that are negative or not
    /// finite.
    pub fn with_tensors(
        mesh: SimplexMesh,
        tensors: Vec<MandelTensor>,
        densities: Vec<f64>,
    ) -> Result<Self, SimplexModelError> {
        let cells = mesh.cell_count();
        if tensors.len() != cells || densities.len() != cells {
            return Err(SimplexModelError::Count { cells, tensors: tensors.len(), densities: densities.len() });
        }
        Self { mesh, tensors, densities, material_of: (0..cells as u32).collect() }.checked()
    }

    fn checked(self) -> Result<Self, SimplexModelError> {
        let first_of = |material: usize| self.material_of.iter().position(|m| *m as usize == material);
        for (material, tensor) in self.tensors.iter().enumerate() {
            check_tensor(self.mesh.dimension(), tensor, || first_of(material).unwrap_or_default())?;
        }
        match self.densities.iter().position(|d| !d.is_finite() || *d < 0.0) {
            Some(material) => Err(SimplexModelError::Density {
                cell: first_of(material).unwrap_or_default(),
                density: self.densities[material],
            }),
            None => Ok(self),
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &SimplexMesh {
        &self.mesh
    }

    /// The elasticity tensor \[Pa\] of a cell.
    pub fn tensor(&self, cell: usize) -> &MandelTensor {
        &self.tensors[self.material_of[cell] as usize]
    }

    /// The density \[kg/m³\] of a cell.
    pub fn density(&self, cell: usize) -> f64 {
        self.densities[self.material_of[cell] as usize]
    }

    /// The mass \[kg\] of the body.
    pub fn mass(&self) -> f64 {
        let mass = |cell: usize| self.density(cell) * self.mesh.measure(cell);
        sum_of_blocks(self.mesh.cell_count(), &|from, to| [(from..to).map(mass).sum()])[0]
    }
}

fn check_tensor(
    dimension: Dimension,
    tensor: &MandelTensor,
    cell: impl Fn() -> usize,
) -> Result<(), SimplexModelError> {
    let (rows, expected) = (tensor.rows(), dimension.strains());
    if tensor.dimension != dimension {
        return Err(SimplexModelError::Dimension { cell: cell(), rows, cells: dimension, expected });
    }
    let entries = || tensor.matrix.iter().flatten().map(|value| value.abs());
    let scale = entries().fold(0.0, f64::max);
    for (row, column) in (0..6).flat_map(|row| (0..=row).map(move |column| (row, column))) {
        let (value, mirrored) = (tensor.matrix[row][column], tensor.matrix[column][row]);
        let is_alike = (value - mirrored).abs() <= ASYMMETRY * scale;
        if !(value.is_finite() && mirrored.is_finite() && is_alike) {
            return Err(SimplexModelError::Tensor { cell: cell(), row, column, value, mirrored });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Elasticity, IsotropicMaterial, Material};

    fn mesh(tags: [i32; 3]) -> SimplexMesh {
        let nodes = [0.0, 1.0, 1.5, 3.5].map(|x| [x, 0.0, 0.0]).to_vec();
        let cells = [0, 1, 2].map(|n| [n, n + 1, 0, 0]).to_vec();
        SimplexMesh::new(Dimension::One, nodes, cells, tags.to_vec()).unwrap()
    }

    fn table(entries: &[(i32, f64, f64)]) -> MaterialTable {
        let mut table = MaterialTable::new();
        for (label, young, density) in entries {
            let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(*young, 0.3).unwrap());
            table.insert(Label(*label), Material::linear("gel", elasticity, *density));
        }
        table
    }

    #[test]
    fn cells_have_the_material_of_their_tag() {
        let model = SimplexModel::new(mesh([5, -2, 5]), &table(&[(-2, 7.0, 100.0), (3, 1.0, 1.0), (5, 2.0, 10.0)]));
        let model = model.unwrap();
        let young: Vec<f64> = (0..3).map(|cell| model.tensor(cell).matrix[0][0]).collect();
        assert!(young.iter().zip([2.0, 7.0, 2.0]).all(|(found, given)| (found - given).abs() < 1e-12), "{young:?}");
        assert_eq!([0, 1, 2].map(|cell| model.density(cell)), [10.0, 100.0, 10.0]);
        assert!((model.mass() - (10.0 * 1.0 + 100.0 * 0.5 + 10.0 * 2.0)).abs() < 1e-12);
    }

    #[test]
    fn all_tags_without_material_are_named_with_their_cells() {
        let error = SimplexModel::new(mesh([5, -2, 5]), &table(&[(3, 1.0, 1.0)])).unwrap_err();
        let text = "tag -2 (1 cells), tag 5 (2 cells) have no material; add a material with that label";
        assert_eq!(error.to_string(), text);
    }

    #[test]
    fn unusable_tensors_and_densities_are_refused_with_their_cell() {
        let good = MandelTensor::of_material(Dimension::One, &IsotropicMaterial::new(4.0, 0.0).unwrap().tensor());
        let make = |tensors: Vec<MandelTensor>, densities| {
            SimplexModel::with_tensors(mesh([0; 3]), tensors, densities).map(|model| model.mass())
        };
        assert!((make(vec![good; 3], vec![1.0, 0.0, 2.0]).unwrap() - 5.0).abs() < 1e-14);
        let few = make(vec![good; 2], vec![1.0; 3]).unwrap_err();
        assert_eq!(few, SimplexModelError::Count { cells: 3, tensors: 2, densities: 3 });
        let flat = MandelTensor { dimension: Dimension::Two, ..good };
        let wrong = make(vec![good, flat, good], vec![1.0; 3]).unwrap_err();
        assert!(matches!(wrong, SimplexModelError::Dimension { cell: 1, rows: 3, expected: 1, .. }), "{wrong}");
        let odd = make(vec![good, good, good.scaled(f64::NAN)], vec![1.0; 3]).unwrap_err();
        assert!(matches!(odd, SimplexModelError::Tensor { cell: 2, .. }), "{odd}");
        let mut skew = good;
        skew.matrix[4][1] = 1.0;
        let skew = make(vec![good, good, skew], vec![1.0; 3]).unwrap_err();
        assert!(matches!(skew, SimplexModelError::Tensor { cell: 2, row: 4, column: 1, .. }), "{skew}");
        let light = make(vec![good; 3], vec![1.0, -1.0, 1.0]).unwrap_err();
        assert_eq!(light, SimplexModelError::Density { cell: 1, density: -1.0 });
    }
}
