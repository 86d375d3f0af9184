//! A fine body and coarse ones by every method: what they are made of, and how far they are from it at rest.

use grosgrain::dynamics::{
    Conditions, Hold, Holds, LoadPath, Schedule, SimplexBody, TimedLoad, relative_error, simplex_mass,
};
use grosgrain::homogenization::{
    Average, Downsampling, EffectiveOptions, HarmonicDisplacements, HarmonicOptions, SimplexEmbedding, SimplexModel,
    average_tensors, downsample, effective_tensors, fit_downsampled, harmonic_displacements, lumped_mass,
    sampled_tensors,
};
use grosgrain::material::IsotropicMaterial;
use grosgrain::simplex::{
    BoundingBox, BoxCut, Dimension, Locator, MandelTensor, Overlaps, SimplexLattice, SimplexLaw, SimplexMesh,
};

use super::super::Study;
use super::body;
use crate::failure::Failure;
use crate::interruption;
use crate::meshes::SimplexTrack;
use crate::outcome::failed;
use crate::scene::Time;

/// Standard gravity \[m/s²\].
pub const GRAVITY: f64 = 9.81;
/// Tags of the two materials.
pub const SOFT: i32 = 1;
/// See [`SOFT`].
pub const STIFF: i32 = 2;

/// Where the tensors of coarse cells come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Effective tensors by harmonic displacements of the free body.
    Tensor,
    /// The same with harmonic displacements fitted on the coarse mesh instead of taken at its nodes.
    TensorFitted,
    /// Effective tensors by harmonic displacements of the body held as in use (§3.8), taken at the coarse nodes.
    TensorHeld,
    /// The mean of Young's modulus and Poisson's ratio.
    Coefficients,
    /// The mean of the stiffness.
    Stiffness,
    /// The fine material at quadrature points.
    Sampled,
}

impl Way {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Tensor, Self::TensorFitted, Self::TensorHeld, Self::Coefficients, Self::Stiffness, Self::Sampled];

    /// What it is called.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tensor => "tensor",
            Self::TensorFitted => "fitted",
            Self::TensorHeld => "held",
            Self::Coefficients => "average",
            Self::Stiffness => "mean stiffness",
            Self::Sampled => "sampled",
        }
    }
}

/// Errors in percent by every way, in the order of [`Way::ALL`].
pub type Errors = [f64; Way::ALL.len()];

/// How many times the error of the tensors the lesser one of the two averages is.
pub fn gain(errors: &Errors) -> f64 {
    errors[Way::Coefficients as usize].min(errors[Way::Stiffness as usize]) / errors[Way::Tensor as usize]
}

/// How a body is held and pulled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// What it is called.
    pub name: &'static str,
    /// Nodes on this plane are held: the axis, and the coordinate \[m\] along it.
    pub plane: (usize, f64),
    /// Acceleration \[m/s²\] of every mass.
    pub acceleration: [f64; 3],
}

impl Task {
    /// Which nodes are held.
    pub fn held(&self, mesh: &SimplexMesh) -> Vec<bool> {
        let (axis, at) = self.plane;
        mesh.nodes().iter().map(|x| (x[axis] - at).abs() < 1e-9).collect()
    }

    /// The model under these conditions, with these masses \[kg\] of nodes.
    pub fn body(&self, model: &SimplexModel, mass: Vec<f64>, law: SimplexLaw) -> Result<SimplexBody, Failure> {
        let forces = mass.iter().flat_map(|mass| self.acceleration.map(|a| mass * a)).collect();
        let conditions = Conditions {
            holds: Holds(vec![Hold::still("hold", self.held(model.mesh()))]),
            loads: vec![TimedLoad { forces, schedule: Schedule::default() }],
            ..Conditions::default()
        };
        let body = SimplexBody::new(model, law, conditions).and_then(|body| body.with_mass(mass));
        body.map_err(|error| failed(&error))
    }

    /// Its equilibrium under small displacements \[m\].
    fn balance(&self, study: &Study, model: &SimplexModel, mass: Vec<f64>) -> Result<Vec<f64>, Failure> {
        let time = Time { tolerance: 1e-8, ..Time::default() };
        let mut track = SimplexTrack::new(self.name, self.body(model, mass, SimplexLaw::Linear)?, &time)?;
        let path = LoadPath { share: [0.0, 1.0], time: [0.0; 2], loads: [0.0; 2] };
        track.balance(&path, study.progress)?;
        Ok(track.state.displacement)
    }
}

/// Boxes from the origin, cut into cells, with a tag by the places of their centres.
pub fn lattice(
    dimension: Dimension,
    boxes: [usize; 3],
    size: [f64; 3],
    tag: impl Fn([f64; 3]) -> i32,
) -> Result<SimplexMesh, Failure> {
    let around = BoundingBox { lower: [0.0; 3], upper: size };
    let mesh = SimplexLattice { dimension, boxes, around, cut: BoxCut::Alternating }.mesh();
    Ok(mesh.map_err(|error| failed(&error))?.tagged(tag))
}

/// A body of two materials, [`SOFT`] and [`STIFF`] with their Young's moduli \[Pa\] and Poisson's ratios.
pub fn two_phases(mesh: SimplexMesh, soft: (f64, f64), stiff: (f64, f64)) -> Result<SimplexModel, Failure> {
    let tensor = |(young, poisson): (f64, f64)| {
        let material = IsotropicMaterial::new(young, poisson).map_err(|error| failed(&error))?;
        Ok::<_, Failure>(MandelTensor::of_material(mesh.dimension(), &material.tensor()))
    };
    let (soft, stiff) = (tensor(soft)?, tensor(stiff)?);
    let tensors = mesh.tags().iter().map(|tag| if *tag == SOFT { soft } else { stiff }).collect();
    body(mesh, tensors)
}

/// A fine body with the harmonic displacements that its coarse models share.
pub struct Fine {
    /// The body.
    pub model: SimplexModel,
    /// Its harmonic displacements when nothing holds it.
    pub free: HarmonicDisplacements,
}

impl Fine {
    /// Finds the harmonic displacements of a body.
    pub fn new(study: &Study, model: SimplexModel) -> Result<Self, Failure> {
        let free = harmonic(study, &model, Vec::new())?;
        Ok(Self { model, free })
    }

    /// Those of the body held as in `task`.
    pub fn held(&self, study: &Study, task: &Task) -> Result<HarmonicDisplacements, Failure> {
        harmonic(study, &self.model, task.held(self.model.mesh()))
    }
}

fn harmonic(study: &Study, model: &SimplexModel, held: Vec<bool>) -> Result<HarmonicDisplacements, Failure> {
    let options = HarmonicOptions { held, ..HarmonicOptions::default() };
    let report = |name, done, total| study.progress.report(name, done, total);
    let found = harmonic_displacements(model, &options, &report).map_err(|error| failed(&error))?;
    study.progress.close();
    Ok(found.0)
}

/// A coarse mesh of a fine body.
pub struct Coarse {
    /// The mesh.
    pub mesh: SimplexMesh,
    /// How the fine mesh moves with it.
    pub embedding: SimplexEmbedding,
    /// Masses \[kg\] of its nodes.
    pub mass: Vec<f64>,
    overlaps: Overlaps,
}

impl Coarse {
    /// Intersects the meshes.
    pub fn new(fine: &SimplexModel, mesh: SimplexMesh) -> Result<Self, Failure> {
        let overlaps = Overlaps::new(fine.mesh(), &mesh).map_err(|error| failed(&error))?;
        let locator = Locator::new(&mesh);
        let mass = lumped_mass(fine, &locator, &overlaps);
        let embedding = SimplexEmbedding::new(fine.mesh(), &locator);
        Ok(Self { embedding, mass, overlaps, mesh })
    }

    /// Effective tensors of its cells by these harmonic displacements.
    pub fn effective(
        &self,
        fine: &SimplexModel,
        fields: &HarmonicDisplacements,
        downsampling: Downsampling,
    ) -> Result<Vec<MandelTensor>, Failure> {
        let mut coarse = downsample(&Locator::new(fine.mesh()), fields, &self.mesh);
        if downsampling == Downsampling::Fitted {
            let fitted = fit_downsampled((fine.mesh(), fields), (&self.mesh, &self.embedding), &coarse);
            coarse = fitted.map_err(|error| failed(&error))?;
        }
        let options = EffectiveOptions::default();
        let found = effective_tensors((fine, fields), (&self.mesh, &coarse.fields), &self.overlaps, &options);
        Ok(found.map_err(|error| failed(&error))?.tensors)
    }

    /// The models by every way, in the order of [`Way::ALL`].
    pub fn models(&self, fine: &Fine, held: &HarmonicDisplacements) -> Result<Vec<SimplexModel>, Failure> {
        let tensors = |way: Way| match way {
            Way::Tensor => self.effective(&fine.model, &fine.free, Downsampling::AtNodes),
            Way::TensorFitted => self.effective(&fine.model, &fine.free, Downsampling::Fitted),
            Way::TensorHeld => self.effective(&fine.model, held, Downsampling::AtNodes),
            Way::Coefficients => Ok(average_tensors(&fine.model, &self.mesh, &self.overlaps, Average::Coefficients)),
            Way::Stiffness => Ok(average_tensors(&fine.model, &self.mesh, &self.overlaps, Average::Stiffness)),
            Way::Sampled => Ok(sampled_tensors(&fine.model, &self.mesh).0),
        };
        Way::ALL.into_iter().map(|way| body(self.mesh.clone(), tensors(way)?)).collect()
    }
}

/// RMS errors in percent of the equilibria of coarse bodies under small displacements, at the fine nodes: one entry per coarse mesh.
pub fn static_errors(study: &Study, fine: &Fine, coarse: &[Coarse], task: &Task) -> Result<Vec<Errors>, Failure> {
    interruption::check()?;
    let reference = task.balance(study, &fine.model, simplex_mass(&fine.model))?;
    let held = fine.held(study, task)?;
    let errors = |coarse: &Coarse| {
        let mut errors = [0.0; Way::ALL.len()];
        for (error, model) in errors.iter_mut().zip(coarse.models(fine, &held)?) {
            let own = task.balance(study, &model, coarse.mass.clone())?;
            *error = 100.0 * relative_error(&coarse.embedding.prolong(&own), &reference);
        }
        Ok(errors)
    };
    coarse.iter().map(errors).collect()
}
