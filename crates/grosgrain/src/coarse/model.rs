//! A coarse model of a fine body.

use rayon::prelude::*;

use super::{CoarseLattice, galerkin_stiffness};
use crate::coarsening::ShapeFunctions;
use crate::element::{CellMatrix, Hex8, trilinear};
use crate::fine::FineModel;
use crate::material::ElasticityTensor;
use crate::mesh::Cell;
use crate::partition::{CellPart, CoarseMesh, Partition, PerElement};

/// A mesh of elements with shape functions and a stiffness each, and lumped masses at its vertices.
#[derive(Clone, Debug)]
pub struct CoarseModel {
    mesh: CoarseMesh,
    spacing: [f64; 3],
    functions: ShapeFunctions,
    stiffness: PerElement<Box<CellMatrix>>,
    /// What each element adds to the masses of its corners.
    corner_mass: PerElement<[f64; 8]>,
    mass: Vec<f64>,
}

impl CoarseModel {
    /// The Galerkin model of shape functions of all elements of `mesh`: K̄ = Σ_e W_eᵀ K_e W_e over the fine cells of each element.
    ///
    /// # Panics
    /// Panics when the functions are not those of the elements of `mesh`.
    pub fn galerkin(model: &FineModel, mesh: CoarseMesh, functions: ShapeFunctions) -> Self {
        let stiffness = galerkin(model, &mesh, &functions);
        Self::from_parts(model, mesh, functions, stiffness)
    }

    /// Coarse trilinear elements with the volume average of the fine elasticity tensors over the coarse cell; voids and other parts of the
    /// cell count as zero.
    ///
    /// # Panics
    /// Panics when the functions are not those of the elements of `mesh`.
    pub fn averaged(model: &FineModel, mesh: CoarseMesh, functions: ShapeFunctions) -> Self {
        let hexahedron = Hex8::new(coarse_spacing(model, &mesh));
        let stiffness = |element: &CellPart| Box::new(hexahedron.stiffness(&mean_tensor(model, &mesh, *element)));
        let stiffness = mesh.elements().iter().map(stiffness).collect();
        let stiffness = PerElement::new(mesh.elements().to_vec(), stiffness);
        Self::from_parts(model, mesh, functions, stiffness)
    }

    fn from_parts(
        model: &FineModel,
        mesh: CoarseMesh,
        functions: ShapeFunctions,
        stiffness: PerElement<Box<CellMatrix>>,
    ) -> Self {
        assert_eq!(mesh.elements(), functions.elements(), "functions of another mesh");
        let corner_mass = corner_masses(model, &mesh, mesh.elements());
        let mass = lumped_mass(&mesh, corner_mass.values());
        Self { spacing: coarse_spacing(model, &mesh), mesh, functions, stiffness, corner_mass, mass }
    }

    /// Takes over a changed body: `mesh` is its mesh, `renewed` holds the functions of all elements whose functions or fine cells have changed.
    /// Galerkin stiffness and masses are computed for these only; the result is that of [`CoarseModel::galerkin`] bit for bit.
    ///
    /// # Panics
    /// Panics when an element of `mesh` has no functions, old or renewed.
    pub fn replace(&mut self, model: &FineModel, mesh: CoarseMesh, renewed: ShapeFunctions) {
        let corner_mass = corner_masses(model, &mesh, renewed.elements());
        self.stiffness.replace(mesh.elements(), galerkin(model, &mesh, &renewed));
        self.corner_mass.replace(mesh.elements(), corner_mass);
        self.functions.replace(mesh.elements(), renewed);
        self.mass = lumped_mass(&mesh, self.corner_mass.values());
        self.mesh = mesh;
    }

    /// Elements and vertices.
    pub fn mesh(&self) -> &CoarseMesh {
        &self.mesh
    }

    /// The partition into coarse cells.
    pub fn partition(&self) -> &Partition {
        self.mesh.partition()
    }

    /// Edge lengths of a coarse cell \[m\].
    pub fn spacing(&self) -> [f64; 3] {
        self.spacing
    }

    /// The shape functions.
    pub fn functions(&self) -> &ShapeFunctions {
        &self.functions
    }

    /// The elements, ascending.
    pub fn elements(&self) -> &[CellPart] {
        self.mesh.elements()
    }

    /// Stiffness \[N/m\] of element number `index`.
    pub fn stiffness(&self, index: usize) -> &CellMatrix {
        &self.stiffness.values()[index]
    }

    /// Lumped mass \[kg\] of every vertex: Σ_e m_e N_i(x_e) over the fine cells of its elements with trilinear N_i at their centres, so that
    /// it is positive and adds up to the mass of the body.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// What element number `index` adds to the masses \[kg\] of its corners.
    pub fn corner_mass(&self, index: usize) -> &[f64; 8] {
        &self.corner_mass.values()[index]
    }

    /// The model as a lattice, where its mesh is one.
    pub fn as_lattice(&self) -> Option<CoarseLattice<'_>> {
        CoarseLattice::new(&self.mesh, self.stiffness.values().iter().map(AsRef::as_ref).collect())
    }
}

fn coarse_spacing(model: &FineModel, mesh: &CoarseMesh) -> [f64; 3] {
    model.grid().spacing.map(|h| h * mesh.partition().degree() as f64)
}

fn galerkin(model: &FineModel, mesh: &CoarseMesh, functions: &ShapeFunctions) -> PerElement<Box<CellMatrix>> {
    let elements = functions.elements();
    let stiffness = |index: usize| galerkin_stiffness(&mesh.window(model, elements[index]), functions.of(index));
    let stiffness = (0..elements.len()).into_par_iter().map(|index| Box::new(stiffness(index))).collect();
    PerElement::new(elements.to_vec(), stiffness)
}

fn mean_tensor(model: &FineModel, mesh: &CoarseMesh, element: CellPart) -> ElasticityTensor {
    let count = mesh.partition().degree().pow(3) as f64;
    let mut sum = [[0.0; 6]; 6];
    for tensor in mesh.fine_cells(element).filter_map(|(_, fine)| model.elasticity(fine)) {
        for (total, entry) in sum.iter_mut().flatten().zip(tensor.voigt().iter().flatten()) {
            *total += entry / count;
        }
    }
    ElasticityTensor::from_voigt_unchecked(sum)
}

fn corner_masses(model: &FineModel, mesh: &CoarseMesh, elements: &[CellPart]) -> PerElement<[f64; 8]> {
    let local = mesh.partition().cell_lattice();
    let d = mesh.partition().degree() as f64;
    let of_element = |element: &CellPart| {
        let mut masses = [0.0; 8];
        for (index, fine) in mesh.fine_cells(*element) {
            let share = model.cell_mass(fine);
            let centre = local.cell_position(Cell(index)).map(|x| (x as f64 + 0.5) / d);
            masses.iter_mut().zip(trilinear(centre)).for_each(|(mass, weight)| *mass += share * weight);
        }
        masses
    };
    PerElement::new(elements.to_vec(), elements.iter().map(of_element).collect())
}

fn lumped_mass(mesh: &CoarseMesh, corner_mass: &[[f64; 8]]) -> Vec<f64> {
    let mut mass = vec![0.0; mesh.vertices().len()];
    for (corners, shares) in mesh.corners().iter().zip(corner_mass) {
        corners.iter().zip(shares).for_each(|(vertex, share)| mass[*vertex as usize] += share);
    }
    mass
}
