//! What a scene describes.

use grosgrain::material::Elasticity;
use grosgrain::mesh::{Components, Label, Neighbourhood, VoxelGrid, pad_to_multiple};
use grosgrain::partition::{CoarseMesh, Partition};
use serde::Serialize;

use super::row;
use super::volume::memory_row;
use crate::body::{Body, build_body, loose_from_largest, loose_when_held, solid_counts};
use crate::failure::Failure;
use crate::held_parts::{check_held_parts, held_parts};
use crate::memory;
use crate::progress::Progress;
use crate::quantities::{bytes, count, counted, number, triple, triple_count};
use crate::scene::{Coarsening, Scene};
use crate::schedule::EditSchedule;

/// What a scene describes.
#[derive(Debug, Serialize)]
pub struct SceneSummary {
    title: String,
    cells: [usize; 3],
    spacing_metres: [f64; 3],
    extent_metres: [f64; 3],
    solid_cells: usize,
    void_cells: usize,
    components: usize,
    materials: Vec<MaterialSummary>,
    fine_nodes: usize,
    fine_unknowns: usize,
    degree: usize,
    coarse_cells: usize,
    coarse_nodes: usize,
    coarse_unknowns: usize,
    fixes: usize,
    loads: usize,
    edits: usize,
    mode: &'static str,
    steps: usize,
    direct_bytes: f64,
    iterative_bytes: f64,
    /// Memory of the steps of the fine and of the coarse model; none where equations are linear.
    #[serde(skip_serializing_if = "Option::is_none")]
    steps_bytes: Option<[f64; 2]>,
}

#[derive(Debug, Serialize)]
pub(super) struct MaterialSummary {
    pub name: String,
    pub label: i32,
    pub cells: usize,
    pub young: Option<[f64; 2]>,
    pub poisson: Option<f64>,
    pub density: f64,
}

/// Builds the body of a scene of voxels and sums both up.
pub fn summarise(scene: &Scene, progress: &Progress) -> Result<SceneSummary, Failure> {
    scene.warnings.iter().for_each(|warning| progress.warn(warning));
    let body = build_body(scene)?;
    body.remarks.iter().for_each(|remark| progress.say(remark));
    check_held_parts(scene, &body.grid, &held_parts(scene, &body.grid)?)?;
    let loose = match scene.fixes.is_empty() {
        _ if scene.is_dynamic() => None,
        true => loose_from_largest(&body.grid),
        false => loose_when_held(scene, &body.grid)?,
    };
    loose.iter().for_each(|sentence| progress.warn(sentence));
    summary(scene, &body)
}

fn summary(scene: &Scene, body: &Body) -> Result<SceneSummary, Failure> {
    let grid = &body.grid;
    let fine_nodes = grid.active_nodes().into_iter().filter(|active| *active).count();
    let coarse = coarse_mesh(grid, &scene.coarsening)?;
    let coarse_nodes = coarse.vertices().len();
    Ok(SceneSummary {
        title: scene.title.clone(),
        cells: grid.lattice.cells,
        spacing_metres: grid.spacing,
        extent_metres: std::array::from_fn(|a| grid.spacing[a] * grid.lattice.cells[a] as f64),
        solid_cells: grid.solid_count(),
        void_cells: grid.lattice.cell_count() - grid.solid_count(),
        components: Components::new(&grid.void, &grid.lattice, Neighbourhood::Faces).count(),
        materials: materials(body),
        fine_nodes,
        fine_unknowns: 3 * fine_nodes,
        degree: scene.coarsening.degree,
        coarse_cells: coarse.elements().len(),
        coarse_nodes,
        coarse_unknowns: 3 * coarse_nodes,
        fixes: scene.fixes.len(),
        loads: scene.loads.len(),
        edits: scene.edits.len(),
        mode: if scene.is_dynamic() { "dynamic" } else { "static" },
        steps: EditSchedule::new(scene, grid).steps(),
        direct_bytes: memory::direct(3 * fine_nodes),
        iterative_bytes: memory::iterative(3 * fine_nodes),
        steps_bytes: (!scene.is_linear_static()).then(|| {
            let damped = scene.is_dynamic() && scene.time.damping.stiffness > 0.0;
            [
                memory::fine_steps(grid.solid_count(), fine_nodes, damped),
                memory::coarse_steps(coarse.elements().len(), coarse_nodes, scene.coarsening.degree, damped),
            ]
        }),
    })
}

/// The mesh that a run would coarsen the body to.
fn coarse_mesh(grid: &VoxelGrid, coarsening: &Coarsening) -> Result<CoarseMesh, Failure> {
    let padded = pad_to_multiple(grid, coarsening.degree, Label(0)).grid;
    let partition =
        Partition::new(padded.lattice, coarsening.degree).map_err(|error| Failure::Unusable(error.to_string()))?;
    Ok(match coarsening.split {
        true => CoarseMesh::new(&padded.void, &partition),
        false => CoarseMesh::unsplit(&padded.void, &partition),
    })
}

fn materials(body: &Body) -> Vec<MaterialSummary> {
    let counts = solid_counts(&body.grid);
    let summarise = |(label, material): (grosgrain::mesh::Label, &grosgrain::material::Material)| {
        let (constant, poisson) = match material.elasticity {
            Elasticity::Isotropic(m) => (Some([m.young(), m.young()]), Some(m.poisson())),
            Elasticity::Anisotropic(_) => (None, None),
        };
        MaterialSummary {
            name: material.name.clone(),
            label: label.0,
            cells: counts.get(&label).copied().unwrap_or(0),
            young: young_range(&body.grid, label).or(constant),
            poisson,
            density: material.density,
        }
    };
    body.materials.iter().map(summarise).collect()
}

/// Smallest and largest modulus of the solid voxels of `label`, where moduli are given voxel by voxel.
fn young_range(grid: &VoxelGrid, label: grosgrain::mesh::Label) -> Option<[f64; 2]> {
    let young = grid.young.as_ref()?;
    let of_label = |c: &usize| grid.labels[*c] == label && !grid.void[*c];
    let range = (0..young.len())
        .filter(of_label)
        .fold([f64::INFINITY, 0.0f64], |[low, high], c| [low.min(young[c]), high.max(young[c])]);
    (range[1] > 0.0).then_some(range)
}

impl SceneSummary {
    /// The summary for people.
    pub fn rows(&self) -> Vec<(String, String)> {
        let mut rows = vec![
            row("scene", self.title.clone()),
            row(
                "body",
                format!("{} cells of {} mm", triple_count(self.cells), triple(self.spacing_metres.map(|h| 1e3 * h))),
            ),
            row("extent", format!("{} m", triple(self.extent_metres))),
            row("solid", format!("{}, {} void", counted(self.solid_cells, "cell"), count(self.void_cells))),
            row("parts", format!("{}, connected by faces", count(self.components))),
        ];
        rows.extend(self.materials.iter().map(MaterialSummary::row));
        rows.push(row("conditions", format!("{} fixed, {} loaded", count(self.fixes), count(self.loads))));
        let steps = if self.steps > 0 { format!(", {}", counted(self.steps, "step")) } else { String::new() };
        rows.push(row("run", format!("{}{steps}", self.mode)));
        if self.edits > 0 {
            rows.push(row("edits", count(self.edits)));
        }
        rows.push(row("fine model", model_size(self.solid_cells, self.fine_nodes, self.fine_unknowns)));
        let coarse = model_size(self.coarse_cells, self.coarse_nodes, self.coarse_unknowns);
        rows.push(row("coarse model", format!("{coarse}, at degree {}", self.degree)));
        rows.push(match self.steps_bytes {
            None => memory_row(self.direct_bytes, self.iterative_bytes),
            Some([fine, coarse]) => {
                let sentence =
                    format!("about {} for the fine model, {} for the coarse one", bytes(fine), bytes(coarse));
                row("memory", sentence)
            }
        });
        rows
    }
}

pub(super) fn model_size(cells: usize, nodes: usize, unknowns: usize) -> String {
    format!("{}, {}, {}", counted(cells, "cell"), counted(nodes, "node"), counted(unknowns, "unknown"))
}

impl MaterialSummary {
    pub fn row(&self) -> (String, String) {
        let elasticity = match (self.young, self.poisson) {
            (Some([low, high]), Some(poisson)) if low == high => format!("E {} Pa, ν {}", number(low), number(poisson)),
            (Some([low, high]), Some(poisson)) => {
                format!("E {} to {} Pa, ν {}", number(low), number(high), number(poisson))
            }
            _ => "21 constants".into(),
        };
        let name = format!("{} ({})", self.name, self.label);
        row(&name, format!("{}, {elasticity}, {} kg/m³", counted(self.cells, "cell"), number(self.density)))
    }
}
