//! Frames of meshes for ParaView: the fine mesh as it moves, and the coarse one.

use std::path::{Path, PathBuf};

use grosgrain::fine::von_mises;
use grosgrain::homogenization::SimplexModel;
use grosgrain::io::vtk::{DataArray, SimplexGrid, Values, VtkError, write_simplex_vtu};
use grosgrain::io::write_atomically;
use grosgrain::material::Elasticity;
use grosgrain::mesh::Label;
use grosgrain::simplex::{Locator, cauchy_stress};

use super::problem::MeshProblem;
use crate::failure::Failure;
use crate::frames::series;

/// What a frame of a mesh shows.
#[derive(Clone, Copy, Debug)]
pub struct ShownMesh<'a> {
    /// Number of its step.
    pub number: usize,
    /// Its time \[s\].
    pub time: f64,
    /// Displacement \[m\] and velocity \[m/s\] of the fine nodes.
    pub fine: [&'a [f64]; 2],
    /// The fine model's displacement \[m\], where the one that is shown is compared with it.
    pub reference: Option<&'a [f64]>,
    /// The coarse mesh, where there is one.
    pub coarse: Option<ShownCoarseMesh<'a>>,
}

/// The coarse mesh of a frame.
#[derive(Clone, Copy, Debug)]
pub struct ShownCoarseMesh<'a> {
    /// The mesh and its materials.
    pub model: &'a SimplexModel,
    /// Mass \[kg\] of its nodes.
    pub mass: &'a [f64],
    /// Displacement \[m\] and velocity \[m/s\] of its nodes.
    pub fields: [&'a [f64]; 2],
}

/// The frames of a run, which grow step by step.
#[derive(Debug)]
pub struct MeshFrames {
    folder: PathBuf,
    /// Young's modulus \[Pa\] of the fine cells, along x where they are anisotropic.
    young: Vec<f64>,
    /// The coarse cell at the centre of every fine cell; −1 without a coarse mesh, and outside of it.
    coarse_cell: Vec<i32>,
    body: Vec<(f64, String)>,
    coarse: Vec<(f64, String)>,
}

impl MeshFrames {
    /// No frames yet; they go into `folder`.
    pub fn new(problem: &MeshProblem, folder: &Path, is_coarse: bool) -> Self {
        let mesh = problem.fine.mesh();
        let young = |tag: &i32| problem.materials.get(Label(*tag)).map_or(0.0, |m| young_of(&m.elasticity));
        let locator = Locator::new(&problem.coarse);
        let coarse_cell = |cell: usize| {
            let place = locator.locate(mesh.centre(cell));
            if place.outside { -1 } else { place.cells()[0].cell as i32 }
        };
        let coarse_cell = match is_coarse {
            true => (0..mesh.cell_count()).map(coarse_cell).collect(),
            false => vec![-1; mesh.cell_count()],
        };
        let young = mesh.tags().iter().map(young).collect();
        Self { folder: folder.to_path_buf(), young, coarse_cell, body: Vec::new(), coarse: Vec::new() }
    }

    /// Writes the frame of a step: `body_NNNN.vtu`, and `coarse_NNNN.vtu` where there is a coarse mesh. The series `body.pvd` and `coarse.pvd` list all frames so far. Returns
    /// the number of cells that are inside out, for which `von_mises` is zero.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn add(&mut self, problem: &MeshProblem, shown: &ShownMesh<'_>) -> Result<usize, Failure> {
        let at = (shown.number, shown.time);
        let mises = stresses(problem, shown.fine[0]);
        let inverted = mises.iter().filter(|mises| mises.is_nan()).count();
        let mises: Vec<f64> = mises.into_iter().map(|mises| if mises.is_nan() { 0.0 } else { mises }).collect();
        let Self { folder, young, coarse_cell, body, coarse } = self;
        let write = |path: &Path| write_body(path, problem, shown, (young, coarse_cell, &mises));
        series(folder, "body", at, body, write)?;
        if let Some(shown_coarse) = &shown.coarse {
            series(folder, "coarse", at, coarse, |path: &Path| write_coarse(path, shown_coarse, shown.time))?;
        }
        Ok(inverted)
    }

    /// The series that were written.
    pub fn written(&self) -> Vec<PathBuf> {
        let series = [("body.pvd", &self.body), ("coarse.pvd", &self.coarse)];
        series.iter().filter(|(_, frames)| !frames.is_empty()).map(|(name, _)| self.folder.join(name)).collect()
    }
}

/// Von Mises stress \[Pa\] of the fine cells under a displacement \[m\] of the fine nodes; not a number in cells that are inside out.
pub fn stresses(problem: &MeshProblem, displacement: &[f64]) -> Vec<f64> {
    let mesh = problem.fine.mesh();
    let stress = |cell: usize| {
        let material = problem.materials.get(Label(mesh.tags()[cell]));
        material.map_or(0.0, |material| {
            von_mises(&cauchy_stress((mesh, cell), problem.law, &material.elasticity.tensor(), displacement))
        })
    };
    (0..mesh.cell_count()).map(stress).collect()
}

fn young_of(elasticity: &Elasticity) -> f64 {
    match elasticity {
        Elasticity::Isotropic(material) => material.young(),
        Elasticity::Anisotropic(tensor) => tensor.young_along_x(),
    }
}

fn write_body(
    path: &Path,
    problem: &MeshProblem,
    shown: &ShownMesh<'_>,
    (young, coarse_cell, mises): (&[f64], &[i32], &[f64]),
) -> Result<(), VtkError> {
    let mesh = problem.fine.mesh();
    let [displacement, velocity] = shown.fine.map(vectors);
    let error = shown.reference.map(|reference| {
        let difference: Vec<f64> = shown.fine[0].iter().zip(reference).map(|(u, v)| u - v).collect();
        vectors(&difference)
    });
    let mut point_data =
        vec![array("displacement", Values::Vector(&displacement)), array("velocity", Values::Vector(&velocity))];
    point_data.extend(error.as_ref().map(|error| array("error", Values::Vector(error))));
    let cell_data = vec![
        array("label", Values::Integer(mesh.tags())),
        array("young", Values::Scalar(young)),
        array("coarse_cell", Values::Integer(coarse_cell)),
        array("von_mises", Values::Scalar(mises)),
    ];
    let grid = SimplexGrid { mesh, point_data, cell_data, time: Some(shown.time) };
    write_atomically(path, |writer| write_simplex_vtu(writer, &grid))
}

fn write_coarse(path: &Path, shown: &ShownCoarseMesh<'_>, time: f64) -> Result<(), VtkError> {
    let &ShownCoarseMesh { model, mass, fields } = shown;
    let mesh = model.mesh();
    let [displacement, velocity] = fields.map(vectors);
    let cells = 0..mesh.cell_count();
    let number: Vec<i32> = cells.clone().map(|cell| cell as i32).collect();
    let tensors: Vec<_> = cells.clone().map(|cell| *model.tensor(cell)).collect();
    let density: Vec<f64> = cells.map(|cell| model.density(cell)).collect();
    let grid = SimplexGrid {
        mesh,
        point_data: vec![
            array("displacement", Values::Vector(&displacement)),
            array("velocity", Values::Vector(&velocity)),
            array("mass", Values::Scalar(mass)),
        ],
        cell_data: vec![
            array("coarse_cell", Values::Integer(&number)),
            array("stiffness", Values::Stiffness(&tensors)),
            array("density", Values::Scalar(&density)),
        ],
        time: Some(time),
    };
    write_atomically(path, |writer| write_simplex_vtu(writer, &grid))
}

fn vectors(field: &[f64]) -> Vec<[f64; 3]> {
    field.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect()
}

const fn array<'a>(name: &'a str, values: Values<'a>) -> DataArray<'a> {
    DataArray { name, values }
}
