//! A body in a fine mesh and in the coarse models that stand for it.

use grosgrain::contact::Ground;
use grosgrain::dynamics::{
    Conditions, Integrator, Schedule, SimplexBody, State, SurfacePoint, TimedLoad, simplex_mass,
};
use grosgrain::homogenization::{Average, Homogenized, SimplexEmbedding, SimplexModel, average_tensors};
use grosgrain::simplex::{Locator, MandelTensor, Overlaps, SimplexLaw, SimplexMesh};

use super::super::super::Study;
use super::super::homogenized;
use super::Model;
use crate::failure::Failure;
use crate::meshes::SimplexTrack;
use crate::outcome::failed;
use crate::scene::Time;

/// Acceleration of falling \[m/s²\].
const GRAVITY: f64 = 9.81;

/// How a body falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fall {
    /// Seconds per step.
    pub step: f64,
    /// Number of steps.
    pub steps: usize,
    /// Speed downwards at the start \[m/s\].
    pub speed: f64,
    /// Distance to the ground at the start \[m\].
    pub clearance: f64,
    /// Of the ground: pressure per depth \[Pa/m\].
    pub stiffness: f64,
}

/// A body in a fine mesh and in the coarse models that stand for it.
pub struct Pair {
    pub fine: SimplexModel,
    /// In the order of [`Model::COARSE`].
    pub coarse: [SimplexModel; 3],
    pub found: Homogenized,
    /// Seconds that coarsening took.
    pub seconds: f64,
    pub embedding: SimplexEmbedding,
    /// The boundary nodes of the fine mesh as points that move with the coarse one.
    surface: Vec<SurfacePoint>,
}

impl Pair {
    /// Coarsens a body in three ways.
    pub fn new(study: &Study, fine: SimplexModel, coarse: &SimplexMesh) -> Result<Self, Failure> {
        study.progress.say("coarsening");
        let start = std::time::Instant::now();
        let found = homogenized(study, &fine, coarse)?;
        let seconds = start.elapsed().as_secs_f64();
        study.progress.close();
        let overlaps = Overlaps::new(fine.mesh(), coarse).map_err(|error| failed(&error))?;
        let model = |tensors: Vec<MandelTensor>| {
            SimplexModel::with_tensors(coarse.clone(), tensors, found.density.clone()).map_err(|error| failed(&error))
        };
        let averaged = |average| model(average_tensors(&fine, coarse, &overlaps, average));
        Ok(Self {
            coarse: [
                model(found.effective.tensors.clone())?,
                averaged(Average::Coefficients)?,
                averaged(Average::Stiffness)?,
            ],
            embedding: SimplexEmbedding::new(fine.mesh(), &Locator::new(coarse)),
            surface: SurfacePoint::embedded(fine.mesh(), coarse).map_err(|error| failed(&error))?,
            fine,
            found,
            seconds,
        })
    }

    /// The coarse mesh.
    pub fn coarse_mesh(&self) -> &SimplexMesh {
        self.coarse[0].mesh()
    }

    /// Points with which the coarse body meets the ground.
    pub fn surface_points(&self) -> usize {
        self.surface.len()
    }

    /// z of the ground \[m\].
    pub fn ground(&self, fall: &Fall) -> f64 {
        self.fine.mesh().nodes().iter().map(|at| at[2]).fold(f64::INFINITY, f64::min) - fall.clearance
    }

    /// The models on their way down, in the order of [`Model::ALL`].
    pub fn tracks(&self, fall: &Fall) -> Result<Vec<SimplexTrack>, Failure> {
        Model::ALL.into_iter().map(|model| self.track(model, fall)).collect()
    }

    fn track(&self, model: Model, fall: &Fall) -> Result<SimplexTrack, Failure> {
        let coarse = Model::COARSE.into_iter().position(|coarse| coarse == model);
        let of = coarse.map_or(&self.fine, |n| &self.coarse[n]);
        let mass = coarse.map_or_else(|| simplex_mass(&self.fine), |_| self.found.mass.clone());
        let forces = mass.iter().flat_map(|mass| [0.0, 0.0, -GRAVITY * mass]).collect();
        let conditions = Conditions {
            loads: vec![TimedLoad { forces, schedule: Schedule::default() }],
            ground: Some(Ground { height: self.ground(fall), friction: 0.0, stiffness: fall.stiffness }),
            ..Conditions::default()
        };
        let body = SimplexBody::new(of, SimplexLaw::Corotational, conditions).map_err(|error| failed(&error))?;
        let body = match coarse {
            None => Ok(body),
            Some(_) => body.with_mass(mass).and_then(|body| body.with_surface(&self.surface)),
        };
        let body = body.map_err(|error| failed(&error))?;
        let time = Time { integrator: Integrator::Midpoint, ..Time::default() };
        let nodes = of.mesh().nodes().len();
        let velocity = (0..3 * nodes).map(|i| if i % 3 == 2 { -fall.speed } else { 0.0 }).collect();
        let mut track = SimplexTrack::new(model.name(), body, &time)?;
        track.start_from(State { displacement: vec![0.0; 3 * nodes], velocity })?;
        Ok(track)
    }
}
