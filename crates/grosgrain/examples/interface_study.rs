//! What neighbouring coarse cells should share: errors of substructured training for several interface spaces.
//!
//! ```sh
//! cargo run --release -p grosgrain --example interface_study
//! ```
//!
//! A cantilever of 8 × 3 × 3 coarse cells, layers of two phases ⌈d/2⌉ fine cells thick, soft first, Young's moduli 1 : 50, ν = 0.45, clamped at x = 0, under
//! gravity along −z. Printed is ‖u_coarse − u_fine‖ / ‖u_fine‖ in percent. The interface forces come from the body itself, from the body
//! with its phases swapped, with a tenth of its fine cells flipped (the flipped cells are then set right), or from a homogeneous body.

use std::error::Error;
use std::sync::Arc;

use grosgrain::coarse::CoarseModel;
use grosgrain::coarsening::{BaseKind, Objective, ShapeFunctions};
use grosgrain::dynamics::{relative_error, solve_coarse, solve_fine};
use grosgrain::fine::{FineModel, gravity};
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Axis, Label, Pattern, PlaneAt, Selector, VoxelGrid};
use grosgrain::partition::{CoarseMesh, Partition};
use grosgrain::progress::silent;
use grosgrain::solver::SolverChoice;
use grosgrain::training::{
    HarmonicDisplacements, InterfaceForces, InterfaceSpace, LocalTrainer, Means, RingKind, Substructures, Training,
};

const COARSE: [usize; 3] = [8, 3, 3];

/// Where the interface forces come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// The body itself.
    Itself,
    /// Its phases swapped.
    Swapped,
    /// A tenth of its fine cells in the other phase.
    TenthFlipped,
    /// The soft phase only.
    Homogeneous,
}

/// A layered cantilever with what its errors are measured against.
pub struct Case {
    model: FineModel,
    partition: Partition,
    fixed: Vec<bool>,
    loads: Vec<f64>,
    fine: Vec<f64>,
}

/// The interface spaces that are compared.
pub fn spaces() -> [(&'static str, InterfaceSpace); 8] {
    let none = Means { translations: true, node_means: false, rotations: false, linear: false, harmonic: false };
    let means = |means| InterfaceSpace::Means(means);
    [
        ("3 translations", means(none)),
        ("+ 6 forces", means(Means { harmonic: true, ..none })),
        ("+ node means", means(Means { harmonic: true, node_means: true, ..none })),
        ("+ rotations", means(Means { harmonic: true, rotations: true, ..none })),
        ("+ first moments", means(Means { harmonic: true, linear: true, ..none })),
        ("+ node means, moments", means(Means { harmonic: true, node_means: true, linear: true, ..none })),
        ("moments, no forces", means(Means { linear: true, ..none })),
        ("all nodes", InterfaceSpace::Full),
    ]
}

/// A body of two phases; `phase` says of which a cell is.
fn body(degree: usize, phase: &dyn Fn(usize, i32) -> i32, direction: [f64; 3]) -> Result<FineModel, Box<dyn Error>> {
    let mut grid = VoxelGrid::uniform(COARSE.map(|n| n * degree), [0.01 / degree as f64; 3], Label(0));
    let period = 2.0 * degree.div_ceil(2) as f64;
    Pattern::Layers { direction, period, labels: vec![Label(0), Label(1)] }.paint(&mut grid)?;
    grid.labels.iter_mut().enumerate().for_each(|(c, label)| *label = Label(phase(c, label.0)));
    let mut materials = MaterialTable::new();
    for (label, young) in [(0, 1e5), (1, 5e6)] {
        let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45)?);
        materials.insert(Label(label), Material::linear(format!("phase {label}"), elasticity, 1000.0));
    }
    Ok(FineModel::new(grid, &materials)?)
}

impl Case {
    /// The layered body and its fine solution.
    pub fn new(degree: usize, direction: [f64; 3]) -> Result<Self, Box<dyn Error>> {
        let model = body(degree, &|_, phase| phase, direction)?;
        let fixed = Selector::Plane { axis: Axis::X, at: PlaneAt::Min }.nodes(model.grid())?.mask;
        let loads = gravity(&model, [0.0, 0.0, -9.81]);
        let fine = solve_fine(&model, &fixed, &loads, SolverChoice::Direct, &silent)?.displacement;
        let partition = Partition::new(model.grid().lattice, degree)?;
        Ok(Self { model, partition, fixed, loads, fine })
    }

    fn mesh(&self) -> CoarseMesh {
        CoarseMesh::new(&self.model.grid().void, &self.partition)
    }

    /// The interface forces of a start.
    pub fn forces(&self, direction: [f64; 3], start: Start) -> Result<Arc<InterfaceForces>, Box<dyn Error>> {
        // Every tenth cell in the order of a multiplicative hash.
        let drawn = |c: usize| (c as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        let phase = |c: usize, phase: i32| match start {
            Start::Itself => phase,
            Start::Swapped => 1 - phase,
            Start::TenthFlipped => (phase + i32::from(drawn(c) % 10 == 0)) % 2,
            Start::Homogeneous => 0,
        };
        let model = body(self.partition.degree(), &phase, direction)?;
        let harmonic = HarmonicDisplacements::solve(&model, SolverChoice::Direct, &silent)?;
        Ok(Arc::new(InterfaceForces::new(&model, &self.partition, &harmonic)))
    }

    /// Error of the static solution with the given training data \[%\].
    pub fn error(&self, training: &Training) -> Result<f64, Box<dyn Error>> {
        let fit = (BaseKind::Harmonic, Objective::ClosedForm);
        let mesh = self.mesh();
        let functions = ShapeFunctions::fit(&self.model, &mesh, training, fit, &silent)?;
        let coarse = CoarseModel::galerkin(&self.model, mesh, functions);
        let solution = solve_coarse(&coarse, &self.fixed, &self.loads, &silent)?;
        Ok(100.0 * relative_error(&solution.displacement, &self.fine))
    }

    /// Error with the data of substructures.
    pub fn substructured(&self, forces: &Arc<InterfaceForces>, space: InterfaceSpace) -> Result<f64, Box<dyn Error>> {
        let substructures = Substructures::new(&self.model, forces.clone(), space);
        let mesh = self.mesh();
        self.error(&substructures.train(&self.model, &mesh, mesh.elements(), &silent)?)
    }

    /// Errors with global and with one-ring data.
    pub fn references(&self) -> Result<[f64; 2], Box<dyn Error>> {
        let mesh = self.mesh();
        let harmonic = HarmonicDisplacements::solve(&self.model, SolverChoice::Direct, &silent)?;
        let global = Training::from_harmonic(&self.model, &mesh, mesh.elements(), &harmonic);
        let ring = LocalTrainer::new(&self.partition, RingKind::OneRing);
        let ring = ring.train(&self.model, &mesh, mesh.elements(), &silent)?;
        Ok([self.error(&global)?, self.error(&ring)?])
    }
}

/// Directions across the layers.
pub const PATTERNS: [(&str, [f64; 3]); 3] =
    [("oblique", [1.0, 1.0, 1.0]), ("horizontal", [0.0, 0.0, 1.0]), ("vertical", [1.0, 0.0, 0.0])];

fn main() -> Result<(), Box<dyn Error>> {
    for degree in [2, 3] {
        let cases: Vec<Case> =
            PATTERNS.iter().map(|(_, direction)| Case::new(degree, *direction)).collect::<Result<_, _>>()?;
        let references: Vec<[f64; 2]> = cases.iter().map(Case::references).collect::<Result<_, _>>()?;
        println!("\nd = {degree}; error [%] for {}", PATTERNS.map(|(name, _)| name).join(", "));
        let line = |name: &str, errors: Vec<f64>| {
            let columns: Vec<String> = errors.iter().map(|e| format!("{e:8.1}")).collect();
            println!("{name:<40}{}", columns.join(" "));
        };
        line("global", references.iter().map(|r| r[0]).collect());
        line("one-ring", references.iter().map(|r| r[1]).collect());
        for start in [Start::Itself, Start::Swapped, Start::TenthFlipped, Start::Homogeneous] {
            let forces: Vec<Arc<InterfaceForces>> =
                cases.iter().zip(PATTERNS).map(|(c, (_, d))| c.forces(d, start)).collect::<Result<_, _>>()?;
            for (name, space) in spaces() {
                let errors = cases.iter().zip(&forces).map(|(c, f)| c.substructured(f, space));
                line(&format!("{start:?}: {name}"), errors.collect::<Result<_, _>>()?);
            }
        }
    }
    Ok(())
}
