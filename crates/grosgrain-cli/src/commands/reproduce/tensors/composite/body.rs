//! The hanging triangle of two materials.

use grosgrain::dynamics::{
    Body, Conditions, EquilibriumOptions, Hold, Holds, LoadPath, Schedule, SimplexBody, TimedLoad, find_equilibrium,
    simplex_mass,
};
use grosgrain::homogenization::SimplexModel;
use grosgrain::material::IsotropicMaterial;
use grosgrain::mesh::{Axis, PlaneAt, Selector};
use grosgrain::simplex::{Dimension, MandelTensor, SimplexLaw, SimplexMesh, select_nodes};

use super::super::super::Study;
use super::super::body;
use crate::failure::Failure;
use crate::outcome::failed;

/// Width of the top and height \[m\].
pub const SIZE: f64 = 0.3;
/// Bands of alternating material, of equal height; the first and the last are stiff.
const BANDS: usize = 7;
/// Rows of fine triangles.
const ROWS: usize = 56;
/// Young's modulus \[Pa\] and Poisson's ratio of the soft and of the stiff material.
const MATERIALS: [(f64, f64); 2] = [(1e3, 0.45), (1e5, 0.3)];
const GRAVITY: f64 = 9.81;

/// An isosceles triangle that stands on its tip, cut into rows² triangles alike; the tag of the stiff bands is 1.
pub fn triangle(rows: usize) -> Result<SimplexMesh, Failure> {
    let place = |row: usize, column: usize| {
        let share = |n: f64| SIZE * n / rows as f64;
        [share(column as f64 - 0.5 * row as f64), share(row as f64 - rows as f64), 0.0]
    };
    let nodes = (0..=rows).flat_map(|row| (0..=row).map(move |column| place(row, column))).collect();
    // A row from the tip has one node more than the one below.
    let number = |row: usize, column: usize| (row * (row + 1) / 2 + column) as u32;
    let mut cells = Vec::with_capacity(rows * rows);
    for (row, column) in (0..rows).flat_map(|row| (0..=row).map(move |column| (row, column))) {
        cells.push([number(row, column), number(row + 1, column + 1), number(row + 1, column), 0]);
        if column < row {
            cells.push([number(row, column), number(row, column + 1), number(row + 1, column + 1), 0]);
        }
    }
    let tags = vec![0; cells.len()];
    let mesh = SimplexMesh::new(Dimension::Two, nodes, cells, tags).map_err(|error| failed(&error))?;
    let band = |y: f64| (-y / SIZE * BANDS as f64) as i32;
    Ok(mesh.tagged(|x| 1 - band(x[1]) % 2))
}

/// The fine model.
pub fn composite() -> Result<SimplexModel, Failure> {
    let mesh = triangle(ROWS)?;
    let tensor = |(young, poisson): (f64, f64)| -> Result<MandelTensor, Failure> {
        let material = IsotropicMaterial::new(young, poisson).map_err(|error| failed(&error))?;
        Ok(MandelTensor::of_material(mesh.dimension(), &material.tensor()))
    };
    let [soft, stiff] = MATERIALS.map(tensor);
    let (soft, stiff) = (soft?, stiff?);
    let tensors = mesh.tags().iter().map(|tag| if *tag == 1 { stiff } else { soft }).collect();
    body(mesh, tensors)
}

/// The top is held, gravity pulls.
pub fn conditions(model: &SimplexModel) -> Result<Conditions, Failure> {
    let top = Selector::Plane { axis: Axis::Y, at: PlaneAt::Max };
    let held = select_nodes(model.mesh(), &top).map_err(|error| failed(&error))?;
    let forces = simplex_mass(model).iter().flat_map(|mass| [0.0, -GRAVITY * mass, 0.0]).collect();
    let load = TimedLoad { forces, schedule: Schedule::default() };
    Ok(Conditions { holds: Holds(vec![Hold::still("the top", held)]), loads: vec![load], ..Conditions::default() })
}

/// A body in equilibrium.
pub struct Hanging {
    /// The body.
    pub body: SimplexBody,
    /// Displacement \[m\] of its nodes.
    pub displacement: Vec<f64>,
}

impl Hanging {
    /// The equilibrium of a corotated body under its conditions.
    pub fn new(study: &Study, model: &SimplexModel, conditions: Conditions) -> Result<Self, Failure> {
        let body = SimplexBody::new(model, SimplexLaw::Corotational, conditions);
        let mut body = body.map_err(|error| failed(&error))?;
        let mut displacement = body.rest().displacement;
        let path = LoadPath { share: [0.0, 1.0], time: [0.0; 2], loads: [0.0; 2] };
        let told = |share: f64| study.progress.report("loading", (100.0 * share) as usize, 100);
        let options = EquilibriumOptions::default();
        let found = find_equilibrium(&mut body, &mut displacement, &path, &options, &told);
        study.progress.close();
        found.map_err(|error| failed(&error))?;
        Ok(Self { body, displacement })
    }

    /// Elastic energy \[J\] of a displacement.
    pub fn elastic_energy(&self, displacement: &[f64]) -> f64 {
        self.body.energies(displacement).map_or(f64::NAN, |energies| energies.elastic)
    }

    /// √(Σ m |v − u|² / Σ m |u|²) of a displacement v beside that in equilibrium u.
    pub fn difference(&self, displacement: &[f64]) -> f64 {
        let own = &self.displacement;
        let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
            self.body
                .mass()
                .iter()
                .enumerate()
                .map(|(n, m)| m * (0..3).map(|r| of(3 * n + r).powi(2)).sum::<f64>())
                .sum()
        };
        (sum(&|i| displacement[i] - own[i]) / sum(&|i| own[i])).sqrt()
    }
}
