//! From a scene whose body is a mesh to what is solved: the fine model, the coarse mesh, and what acts on them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use grosgrain::dynamics::{LoadPath, RigidVelocity};
use grosgrain::homogenization::{SimplexEmbedding, SimplexModel};
use grosgrain::material::{Law, MaterialTable};
use grosgrain::simplex::{Locator, Overlaps, SimplexLaw, SimplexMesh};

use super::conditions::MeshConditions;
use super::input::{lattice_around, material_table, read_checked, tell_unused};
use super::support::{Support, require_support};
use crate::failure::Failure;
use crate::problem::END_OF_RAMPS;
use crate::progress::Progress;
use crate::quantities::{count, counted};
use crate::report::ModelSize;
use crate::scene::{CoarseMeshSource, MeshSource, Scene, Source, Start};

/// Fine cells for each cell of a lattice that nobody asked for.
const CELLS_PER_COARSE_CELL: usize = 100;
/// Cells that such a lattice has at least.
const LEAST_CELLS: usize = 5;

/// A scene with its fine and its coarse mesh.
#[derive(Debug)]
pub struct MeshProblem {
    /// The scene.
    pub scene: Scene,
    /// The fine mesh with its materials.
    pub fine: SimplexModel,
    /// The materials by tag.
    pub materials: MaterialTable,
    /// The law of all cells, fine and coarse: cells turn where any material is corotational.
    pub law: SimplexLaw,
    /// The coarse mesh.
    pub coarse: SimplexMesh,
    /// Where the fine nodes lie in it.
    pub embedding: SimplexEmbedding,
    /// What acts on the fine mesh.
    pub conditions: MeshConditions,
    /// Seconds per stage so far.
    pub seconds: BTreeMap<String, f64>,
}

impl MeshProblem {
    /// Reads the meshes of a scene and places its conditions.
    ///
    /// # Errors
    /// Everything that is wrong with the scene's files, or does not fit them.
    pub fn new(scene: Scene, progress: &Progress) -> Result<Self, Failure> {
        let start = Instant::now();
        scene.warnings.iter().for_each(|warning| progress.warn(warning));
        let Source::Mesh(source) = &scene.body.source else {
            return Err(scene
                .unusable("body", "the body consists of voxels where a mesh is needed; expected body.mesh")
                .into());
        };
        let (mesh, names) = read_checked(&source.file, source.scale, progress)
            .map_err(|sentence| Failure::from(scene.unusable("body.mesh", sentence)))?;
        let materials = material_table(&scene.materials);
        let fine =
            SimplexModel::new(mesh, &materials).map_err(|error| Failure::from(scene.unusable("materials", error)))?;
        tell_unused(&materials, &fine, &names, progress);
        let conditions = MeshConditions::new(&scene, &fine, &materials)?;
        let coarse = coarse_mesh(&scene, source, fine.mesh(), progress)?;
        let embedding = SimplexEmbedding::new(fine.mesh(), &Locator::new(&coarse));
        tell_outside(&embedding, progress);
        let turns = scene.materials.iter().any(|material| material.law == Law::Corotational);
        let law = if turns { SimplexLaw::Corotational } else { SimplexLaw::Linear };
        let seconds = BTreeMap::from([("body".to_owned(), start.elapsed().as_secs_f64())]);
        Ok(Self { scene, fine, materials, law, coarse, embedding, conditions, seconds })
    }

    /// Number of steps after the start; none in a static run.
    pub fn steps(&self) -> usize {
        if self.scene.is_dynamic() { self.scene.time.steps.unwrap_or(0) } else { 0 }
    }

    /// The time of a step \[s\].
    pub fn time(&self, step: usize) -> f64 {
        step as f64 * self.scene.time.step.unwrap_or(1.0)
    }

    /// The way to the equilibrium of a static run: all loads and motions in full.
    pub fn path(&self) -> LoadPath {
        let end = self.conditions.nodal.holds.end_of_motion();
        LoadPath { share: [0.0, 1.0], time: [0.0, end], loads: [END_OF_RAMPS; 2] }
    }

    /// How the body moves at time zero, about the centre of the fine mesh's masses.
    pub fn initial_velocity(&self) -> RigidVelocity {
        let Start { velocity, spin } = self.scene.start;
        let (mesh, mut mass, mut moment) = (self.fine.mesh(), 0.0, [0.0; 3]);
        for cell in 0..mesh.cell_count() {
            let (own, centre) = (self.fine.density(cell) * mesh.measure(cell), mesh.centre(cell));
            mass += own;
            (0..3).for_each(|r| moment[r] += own * centre[r]);
        }
        let centre = if mass > 0.0 { moment.map(|m| m / mass) } else { [0.0; 3] };
        RigidVelocity { velocity, spin, centre }
    }

    /// Refuses loads beyond arithmetic, and in a static run a body that has no equilibrium.
    ///
    /// # Errors
    /// Nothing held, nothing loaded, parts of the mesh that can still move.
    pub fn require_support(&self) -> Result<(), Failure> {
        self.scene.require_conditions()?;
        require_support(self)
    }

    /// Refuses a static run of a coarse mesh that its holds and springs leave free to move.
    ///
    /// # Errors
    /// A sentence with the part that can move.
    pub fn require_coarse_support(&self, coarse: &Support<'_>) -> Result<(), Failure> {
        match coarse.loose().filter(|_| !self.scene.is_dynamic()) {
            None => Ok(()),
            Some(loose) => {
                let sentence = format!("{loose} of the coarse mesh; take more coarse cells, or hold more of the body");
                Err(self.scene.unusable("coarsening", sentence).into())
            }
        }
    }

    /// Size of the fine mesh.
    pub fn fine_size(&self) -> ModelSize {
        size_of(self.fine.mesh())
    }

    /// Size of the coarse mesh.
    pub fn coarse_size(&self) -> ModelSize {
        size_of(&self.coarse)
    }

    /// The files that decide the result, the scene first.
    pub fn input_files(&self) -> Vec<PathBuf> {
        let mut files = vec![self.scene.file.clone()];
        if let Source::Mesh(source) = &self.scene.body.source {
            files.extend(files_of(&source.file));
        }
        if let CoarseMeshSource::File(file) = &self.scene.mesh_coarsening.mesh {
            files.extend(files_of(file));
        }
        files
    }

    /// The name of a tag: that of its material.
    pub fn name_of(&self, tag: i32) -> String {
        let material = self.scene.materials.iter().find(|material| material.label.0 == tag);
        material.map_or_else(|| format!("label {tag}"), |material| material.name.clone())
    }
}

/// The file, and the elements of TetGen beside its nodes.
fn files_of(file: &Path) -> Vec<PathBuf> {
    let elements = file.with_extension("ele");
    let has_elements = file.extension().is_some_and(|ending| ending == "node") && elements.exists();
    std::iter::once(file.to_path_buf()).chain(has_elements.then_some(elements)).collect()
}

fn size_of(mesh: &SimplexMesh) -> ModelSize {
    let nodes = mesh.nodes().len();
    ModelSize { cells: mesh.cell_count(), nodes, unknowns: mesh.dimension().axes() * nodes }
}

/// The coarse mesh, from its file or as a lattice; it must meet the fine one, and every cell of it some of the body.
fn coarse_mesh(
    scene: &Scene,
    source: &MeshSource,
    fine: &SimplexMesh,
    progress: &Progress,
) -> Result<SimplexMesh, Failure> {
    let lattice = |cells: usize| {
        lattice_around(fine, cells).map_err(|sentence| Failure::from(scene.unusable("coarsening.cells", sentence)))
    };
    let (key, mesh) = match &scene.mesh_coarsening.mesh {
        CoarseMeshSource::File(file) => {
            let read = read_checked(file, source.scale, progress);
            let unusable = |sentence| Failure::from(scene.unusable("coarsening.mesh", sentence));
            ("coarsening.mesh", read.map_err(unusable)?.0)
        }
        CoarseMeshSource::Lattice(cells) => ("coarsening.cells", lattice(*cells)?),
        CoarseMeshSource::Default => {
            let mesh = lattice((fine.cell_count() / CELLS_PER_COARSE_CELL).max(LEAST_CELLS))?;
            progress.say(&format!(
                "no coarse mesh is given: took a lattice of {} around the body; coarsening.mesh or coarsening.cells chooses another",
                counted(mesh.cell_count(), "cell")
            ));
            ("coarsening", mesh)
        }
    };
    let overlaps = Overlaps::new(fine, &mesh).map_err(|error| Failure::from(scene.unusable(key, error)))?;
    if let Some(cell) = overlaps.empty_coarse().next() {
        let others = overlaps.empty_coarse().count() - 1;
        let more = if others > 0 { format!(", and so do {} more", count(others)) } else { String::new() };
        let sentence = format!(
            "coarse cell {cell} lies wholly outside the body{more}; remove it from the coarse mesh, or move the meshes onto each other"
        );
        return Err(scene.unusable(key, sentence).into());
    }
    Ok(mesh)
}

fn tell_outside(embedding: &SimplexEmbedding, progress: &Progress) {
    let outside = embedding.outside().count();
    if outside > 0 {
        progress.say(&format!(
            "{} of {} fine nodes lie outside the coarse mesh; displacements are extrapolated to them",
            count(outside),
            count(embedding.fine_nodes())
        ));
    }
}
