//! What a scene describes whose body is a mesh.

use grosgrain::material::Elasticity;
use grosgrain::simplex::{BoundingBox, SimplexLaw, components};
use serde::Serialize;

use super::row;
use super::scene::{MaterialSummary, model_size};
use crate::failure::Failure;
use crate::memory;
use crate::meshes::MeshProblem;
use crate::progress::Progress;
use crate::quantities::{bytes, count, counted, triple};
use crate::report::ModelSize;
use crate::scene::Scene;

/// What a scene describes whose body is a mesh.
#[derive(Debug, Serialize)]
pub struct MeshSceneSummary {
    title: String,
    cells_are: String,
    extent_metres: [f64; 3],
    parts: usize,
    materials: Vec<MaterialSummary>,
    fine: ModelSize,
    coarse: ModelSize,
    outside_nodes: usize,
    fixes: usize,
    loads: usize,
    mode: &'static str,
    law: &'static str,
    steps: usize,
    /// Memory of the steps of the fine and of the coarse mesh.
    steps_bytes: [f64; 2],
}

/// Reads the meshes of a scene and sums them up.
pub fn summarise(scene: Scene, progress: &Progress) -> Result<MeshSceneSummary, Failure> {
    let problem = MeshProblem::new(scene, progress)?;
    let (scene, mesh) = (&problem.scene, problem.fine.mesh());
    // A scene without conditions can be inspected and coarsened.
    if !scene.fixes.is_empty()
        && let Err(failure) = problem.require_support()
    {
        progress.warn(&failure.to_string());
    }
    let around = BoundingBox::of_points(mesh.nodes().iter().copied());
    let damped = scene.is_dynamic() && scene.time.damping.stiffness > 0.0;
    let memory = |size: ModelSize| memory::simplex_steps(size.cells, size.nodes, mesh.dimension().axes(), damped);
    let (fine, coarse) = (problem.fine_size(), problem.coarse_size());
    Ok(MeshSceneSummary {
        title: scene.title.clone(),
        cells_are: mesh.dimension().to_string(),
        extent_metres: std::array::from_fn(|r| around.upper[r] - around.lower[r]),
        parts: components(mesh).1,
        materials: materials(&problem),
        fine,
        coarse,
        outside_nodes: problem.embedding.outside().count(),
        fixes: scene.fixes.len(),
        loads: scene.loads.len(),
        mode: if scene.is_dynamic() { "dynamic" } else { "static" },
        law: if problem.law == SimplexLaw::Linear { "linear" } else { "corotational" },
        steps: problem.steps(),
        steps_bytes: [memory(fine), memory(coarse)],
    })
}

fn materials(problem: &MeshProblem) -> Vec<MaterialSummary> {
    let tags = problem.fine.mesh().tags();
    let summarise = |(label, material): (grosgrain::mesh::Label, &grosgrain::material::Material)| {
        let (young, poisson) = match material.elasticity {
            Elasticity::Isotropic(m) => (Some([m.young(); 2]), Some(m.poisson())),
            Elasticity::Anisotropic(_) => (None, None),
        };
        let cells = tags.iter().filter(|tag| **tag == label.0).count();
        MaterialSummary {
            name: material.name.clone(),
            label: label.0,
            cells,
            young,
            poisson,
            density: material.density,
        }
    };
    problem.materials.iter().map(summarise).collect()
}

impl MeshSceneSummary {
    /// The summary for people.
    pub fn rows(&self) -> Vec<(String, String)> {
        let mut rows = vec![
            row("scene", self.title.clone()),
            row("body", format!("{} {}, {}", count(self.fine.cells), self.cells_are, self.law)),
            row("extent", format!("{} m", triple(self.extent_metres))),
            row("parts", format!("{}, connected by nodes", count(self.parts))),
        ];
        rows.extend(self.materials.iter().map(MaterialSummary::row));
        rows.push(row("conditions", format!("{} fixed, {} loaded", count(self.fixes), count(self.loads))));
        let steps = if self.steps > 0 { format!(", {}", counted(self.steps, "step")) } else { String::new() };
        rows.push(row("run", format!("{}{steps}", self.mode)));
        let size = |size: ModelSize| model_size(size.cells, size.nodes, size.unknowns);
        rows.push(row("fine model", size(self.fine)));
        let outside = format!("{} outside", counted(self.outside_nodes, "fine node"));
        rows.push(row("coarse model", format!("{}, {outside}", size(self.coarse))));
        let [fine, coarse] = self.steps_bytes.map(bytes);
        rows.push(row("memory", format!("about {fine} for the fine model, {coarse} for the coarse one")));
        rows
    }
}
