//! One mesh of a problem in a run, and how the fine nodes move with it.

use grosgrain::dynamics::{Hold, Holds, SimplexBody, State, restrict_conditions, simplex_mass};
use grosgrain::homogenization::{Blending, HarmonicMap, SimplexModel};
use grosgrain::simplex::{BoundingBox, SimplexMesh};

use super::coarse::coarse_of;
use super::method::MeshMethod;
use super::problem::MeshProblem;
use super::support::Support;
use super::track::SimplexTrack;
use crate::failure::Failure;
use crate::interruption;
use crate::outcome::failed;
use crate::progress::Progress;
use crate::report::ModelSize;
use crate::scene::Time;

/// Residual of the equations of linear materials in equilibrium, which one step solves.
const LINEAR_TOLERANCE: f64 = 1e-10;

/// A fine or coarse mesh on its way through a run.
pub struct MeshRun {
    /// How it is modelled.
    pub method: MeshMethod,
    /// Its motion and books.
    pub track: SimplexTrack,
    /// What the coarse cells are made of; `None` for the fine mesh.
    pub coarse: Option<SimplexModel>,
    /// How the fine mesh follows, where it is not by the barycentric map.
    map: Option<(HarmonicMap, Blending)>,
}

/// Share of the body's size by which velocities move it, to see where they move the fine mesh.
const INSTANT: f64 = 1e-6;

impl MeshRun {
    /// The model of a method at the start of the run.
    ///
    /// # Errors
    /// Coarse materials that are not found, a static run of a coarse mesh that is not held, bodies that do not fit into memory, an interruption.
    pub fn new(problem: &MeshProblem, method: MeshMethod, progress: &Progress) -> Result<Self, Failure> {
        interruption::check()?;
        let (body, coarse, map, build) = match method {
            MeshMethod::Fine => (fine_body(problem)?, None, None, [0.0; 3]),
            _ => {
                progress.say(&format!("building the coarse model: {method}"));
                let made = coarse_of(problem, method, progress)?;
                let body = coarse_body(problem, &made.coarse.model, &made.coarse.mass, progress)?;
                (body, Some(made.coarse.model), made.map, made.seconds)
            }
        };
        let mut track = SimplexTrack::new(method.name(), body, &time_of(problem))?;
        track.books.build = build;
        if problem.scene.is_dynamic() && !problem.scene.start.is_at_rest() {
            let mesh = coarse.as_ref().map_or(problem.fine.mesh(), SimplexModel::mesh);
            let state = start(problem, mesh, &track);
            track.start_from(state)?;
        }
        Ok(Self { method, track, coarse, map })
    }

    /// Its mesh.
    pub fn mesh<'a>(&'a self, problem: &'a MeshProblem) -> &'a SimplexMesh {
        self.coarse.as_ref().map_or(problem.fine.mesh(), SimplexModel::mesh)
    }

    /// Its size.
    pub fn size(&self, problem: &MeshProblem) -> ModelSize {
        if self.coarse.is_some() { problem.coarse_size() } else { problem.fine_size() }
    }

    /// Displacement \[m\] of the fine nodes.
    pub fn displacement(&self, problem: &MeshProblem) -> Vec<f64> {
        self.on_fine(problem, &self.track.state.displacement)
    }

    /// Velocity \[m/s\] of the fine nodes: by the harmonic map the change of their displacement in a very short time.
    pub fn velocity(&self, problem: &MeshProblem) -> Vec<f64> {
        let State { displacement, velocity } = &self.track.state;
        let fastest = velocity.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        if self.map.is_none() || fastest == 0.0 {
            return self.barycentric(problem, velocity);
        }
        let instant =
            INSTANT * BoundingBox::of_points(problem.fine.mesh().nodes().iter().copied()).diagonal() / fastest;
        let at = |time: f64| -> Vec<f64> {
            let moved: Vec<f64> = displacement.iter().zip(velocity).map(|(u, v)| u + time * v).collect();
            self.on_fine(problem, &moved)
        };
        at(instant).iter().zip(at(-instant)).map(|(after, before)| (after - before) / (2.0 * instant)).collect()
    }

    fn on_fine(&self, problem: &MeshProblem, displacement: &[f64]) -> Vec<f64> {
        match &self.map {
            Some((map, blending)) => map.map(displacement, *blending).displacement,
            None => self.barycentric(problem, displacement),
        }
    }

    fn barycentric(&self, problem: &MeshProblem, field: &[f64]) -> Vec<f64> {
        match self.coarse {
            Some(_) => problem.embedding.prolong(field),
            None => field.to_vec(),
        }
    }

    /// Momentum \[N s\] and angular momentum about the origin \[N m s\].
    pub fn momenta(&self, problem: &MeshProblem) -> ([f64; 3], [f64; 3]) {
        let nodes = self.mesh(problem).nodes();
        self.track.state.momenta(self.track.mass(), |n| nodes[n])
    }
}

fn fine_body(problem: &MeshProblem) -> Result<SimplexBody, Failure> {
    let conditions = &problem.conditions;
    let acting = conditions.with_gravity(conditions.nodal.clone(), &simplex_mass(&problem.fine));
    SimplexBody::new(&problem.fine, problem.law, acting).map_err(|error| failed(&error))
}

fn coarse_body(
    problem: &MeshProblem,
    model: &SimplexModel,
    mass: &[f64],
    progress: &Progress,
) -> Result<SimplexBody, Failure> {
    let (fine, conditions) = (problem.fine.mesh(), &problem.conditions);
    let restricted = restrict_conditions(&conditions.nodal, fine, &problem.embedding, model.mesh());
    let restricted = restricted.map_err(|error| failed(&error))?;
    tell_shared(&conditions.nodal.holds, &restricted.conditions.holds, progress);
    let held = restricted.conditions.holds.fixed_at(0.0, model.mesh().nodes().len());
    let springs =
        restricted.springs.iter().map(|spring| (spring.cell, place(model.mesh(), spring.cell, &spring.weights)));
    problem.require_coarse_support(&Support::new(model.mesh(), |node| held[node], springs.collect()))?;
    let acting = conditions.with_gravity(restricted.conditions, mass);
    SimplexBody::new(model, problem.law, acting)
        .and_then(|body| body.with_mass(mass.to_vec()))
        .and_then(|body| body.with_springs(&restricted.springs))
        .and_then(|body| body.with_surface(&restricted.surface))
        .map_err(|error| failed(&format!("the coarse mesh: {error}")))
}

/// Warns of parts that hold nodes of their own on the fine mesh, but move a coarse node in different ways.
fn tell_shared(fine: &Holds, coarse: &Holds, progress: &Progress) {
    let meet = |a: &Hold, b: &Hold| a.nodes.iter().zip(&b.nodes).any(|(a, b)| *a && *b);
    for (n, m) in (0..coarse.0.len()).flat_map(|m| (0..m).map(move |n| (n, m))) {
        let [a, b] = [&coarse.0[n], &coarse.0[m]];
        let alike = a.motion == b.motion && a.ramp == b.ramp && a.until == b.until;
        if !alike && meet(a, b) && !meet(&fine.0[n], &fine.0[m]) {
            progress.warn(&format!(
                "{} and {} hold different parts of the body, but the same node of the coarse mesh, which follows the first; take more coarse cells",
                a.name, b.name
            ));
        }
    }
}

fn place(mesh: &SimplexMesh, cell: u32, weights: &[f64; 4]) -> [f64; 3] {
    let corners = mesh.cell(cell as usize).iter().zip(weights);
    corners.fold([0.0; 3], |sum, (node, weight)| {
        let at = mesh.nodes()[*node as usize];
        [0, 1, 2].map(|r| sum[r] + weight * at[r])
    })
}

/// The scene's `[time]`; equations of linear materials in equilibrium are solved as far as rounding lets them.
fn time_of(problem: &MeshProblem) -> Time {
    let time = problem.scene.time.clone();
    match problem.scene.is_dynamic() || problem.scene.is_nonlinear() {
        true => time,
        false => Time { tolerance: LINEAR_TOLERANCE, ..time },
    }
}

/// The velocity of `[start]` at all nodes that have a mass.
fn start(problem: &MeshProblem, mesh: &SimplexMesh, track: &SimplexTrack) -> State {
    let motion = problem.initial_velocity();
    let mut state = State::rest(mesh.nodes().len());
    for (n, position) in mesh.nodes().iter().enumerate().filter(|(n, _)| track.mass()[*n] > 0.0) {
        state.velocity[3 * n..3 * n + 3].copy_from_slice(&motion.at(*position));
    }
    state
}
