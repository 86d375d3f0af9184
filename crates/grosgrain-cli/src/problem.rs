//! From a scene to what is solved: model, degree, fixed nodes, loads.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use grosgrain::coarse::BuildOptions;
use grosgrain::contact::Ground;
use grosgrain::dynamics::{Holds, RigidVelocity, centre_of_mass};
use grosgrain::fine::FineModel;
use grosgrain::mesh::{Label, Volume, VoxelGrid, pad_to_multiple};
use grosgrain::partition::Partition;
use grosgrain::training::{RunTimeTraining, TrainingKind, run_time_training};

use crate::body::{build_body, loose_when_held};
use crate::failure::Failure;
use crate::held_parts::{check_held_parts, held_parts};
use crate::method::{AskedMethod, Method};
use crate::placed_loads::PlacedLoads;
use crate::placed_springs::PlacedSprings;
use crate::progress::Progress;
use crate::quantities::triple_count;
use crate::report::ModelSize;
use crate::scene::{Filling, Scene, Source, Start, VoxelModulus, read_scene};
use crate::schedule::EditSchedule;
use crate::tracks;

/// Label of the voids that fill the last coarse cells.
const PADDING: Label = Label(-1);
/// Larger forces on a node overflow when they are squared \[N\].
const LARGEST_FORCE: f64 = 1e100;
/// The time of a single equilibrium \[s\]: when all loads and motions have grown in full.
pub const END_OF_RAMPS: f64 = f64::INFINITY;

/// A scene with its fine model.
#[derive(Debug)]
pub struct Problem {
    /// The scene.
    pub scene: Scene,
    /// The fine model, padded to a multiple of the degree.
    pub model: FineModel,
    /// The volume that the body was read from, where there is one.
    pub volume: Option<Volume>,
    /// Which nodes of the lattice are held: at the beginning, and in a dynamic run after its last edit.
    pub fixed: Vec<bool>,
    /// What is held over time, and how it moves.
    pub holds: Holds,
    /// Loads \[N\] on the model as it is at the beginning, three per lattice node.
    pub loads: Vec<f64>,
    /// Where the scene's loads act, whatever becomes of the body.
    pub placed: PlacedLoads,
    /// The springs of the scene's loads.
    pub springs: Vec<PlacedSprings>,
    /// The ground that the body may land on.
    pub ground: Option<Ground>,
    /// What changes during the run.
    pub schedule: EditSchedule,
    /// Seconds per stage so far.
    pub seconds: BTreeMap<String, f64>,
}

impl Problem {
    /// Reads a scene and makes its fine model.
    ///
    /// # Errors
    /// Everything that is wrong with the scene or its files; a body that is a mesh.
    pub fn read(file: &Path, progress: &Progress) -> Result<Self, Failure> {
        Self::new(read_scene(file)?, progress)
    }

    /// The fine model of a scene of voxels.
    ///
    /// # Errors
    /// Everything that is wrong with its files; a body that is a mesh.
    pub fn new(scene: Scene, progress: &Progress) -> Result<Self, Failure> {
        let start = Instant::now();
        scene.warnings.iter().for_each(|warning| progress.warn(warning));
        let body = build_body(&scene)?;
        body.remarks.iter().for_each(|remark| progress.say(remark));
        require_degree(&scene, &body.grid)?;
        let schedule = EditSchedule::new(&scene, &body.grid);
        let grid = padded(&body.grid, scene.coarsening.degree, progress);
        let holds = held_parts(&scene, &grid)?;
        check_held_parts(&scene, &grid, &holds)?;
        let fixed = holds.fixed_at(0.0, grid.lattice.node_count());
        let unusable = |error: &dyn std::fmt::Display| Failure::Unusable(format!("{}: {error}", scene.file.display()));
        let model = FineModel::new(grid, &body.materials).map_err(|error| unusable(&error))?;
        let placed = PlacedLoads::new(&scene, &model)?;
        let loads = placed.assemble(&model, time_of(&scene, &schedule, 0));
        let springs = PlacedSprings::of(&scene, &model)?;
        let ground = tracks::ground(&scene, &model);
        let seconds = BTreeMap::from([("body".to_owned(), start.elapsed().as_secs_f64())]);
        Ok(Self { scene, model, volume: body.volume, fixed, holds, loads, placed, springs, ground, schedule, seconds })
    }

    /// The time \[s\] whose loads and motions hold at a step: the step's, or [`END_OF_RAMPS`] for a single equilibrium.
    pub fn time_of(&self, step: usize) -> f64 {
        time_of(&self.scene, &self.schedule, step)
    }

    /// How the body moves at time zero.
    pub fn initial_velocity(&self) -> RigidVelocity {
        let Start { velocity, spin } = self.scene.start;
        RigidVelocity { velocity, spin, centre: centre_of_mass(&self.model).unwrap_or_default() }
    }

    /// Refuses loads beyond arithmetic, and in a static run a body that has no equilibrium: nothing held, nothing loaded, or parts that can
    /// still move.
    ///
    /// # Errors
    /// A sentence with the parts and what to do.
    pub fn require_support(&self) -> Result<(), Failure> {
        self.scene.require_conditions()?;
        let loads = self.placed.in_full(&self.model);
        if let Some(force) = loads.iter().find(|force| !force.is_finite() || force.abs() > LARGEST_FORCE) {
            let sentence =
                format!("a node bears a force of {force:.1e} N, which no arithmetic survives; check its unit");
            return Err(self.scene.unusable("load", sentence).into());
        }
        if self.scene.is_dynamic() {
            return Ok(());
        }
        let moves = |node: &usize| !self.fixed[*node] && self.model.active()[*node];
        let loaded = |node: usize| loads[3 * node..3 * node + 3].iter().any(|force| *force != 0.0);
        let driven = !self.springs.is_empty() || self.scene.fixes.iter().any(|fix| fix.motion.is_some());
        if !driven && !(0..self.fixed.len()).filter(moves).any(loaded) {
            let sentence = "the loads are zero wherever the body can move; \
                            expected a load, and a density where it is gravity";
            return Err(self.scene.unusable("load", sentence).into());
        }
        match loose_when_held(&self.scene, self.model.grid())? {
            None => Ok(()),
            Some(sentence) => {
                let key = if self.scene.fixes.is_empty() { "load" } else { "fix" };
                Err(self.scene.unusable(key, sentence).into())
            }
        }
    }

    /// The method asked for on the command line, or the scene's.
    ///
    /// # Errors
    /// A method of meshes.
    pub fn method(&self, asked: Option<&AskedMethod>) -> Result<Method, Failure> {
        match asked {
            Some(asked) => Ok(asked.for_voxels()?),
            None => Ok(self.own_method()),
        }
    }

    /// The scene's method.
    pub fn own_method(&self) -> Method {
        Method::of_training(self.scene.coarsening.training)
    }

    /// Says that only `simulate` makes edits.
    pub fn tell_idle_edits(&self, progress: &Progress) {
        if !self.scene.edits.is_empty() {
            progress.say("the scene's edits are made by simulate only; this is the body before them");
        }
    }

    /// How the library builds the coarse model of a method; `None` for the fine one.
    pub fn build_options(&self, method: Method) -> Option<BuildOptions> {
        let method = match method {
            Method::Fine => return None,
            Method::Trilinear => grosgrain::coarse::Method::Trilinear,
            Method::Average => grosgrain::coarse::Method::Average,
            Method::Coarsened(_) | Method::Auto => grosgrain::coarse::Method::Trained(self.run_time_training(method)?),
        };
        let coarsening = &self.scene.coarsening;
        Some(BuildOptions { method, base: coarsening.base, objective: coarsening.objective, split: coarsening.split })
    }

    /// The training of a coarsened method, of which `auto` is one; `None` for the others.
    pub fn run_time_training(&self, method: Method) -> Option<TrainingKind> {
        let training = match method {
            Method::Fine | Method::Trilinear | Method::Average => return None,
            Method::Coarsened(kind) => RunTimeTraining::Fixed(kind),
            Method::Auto => RunTimeTraining::default(),
        };
        // The lattice was padded to a multiple of the degree.
        let partition = Partition::new(self.model.grid().lattice, self.scene.coarsening.degree).ok()?;
        Some(run_time_training(&partition, training))
    }

    /// Size of the fine model.
    pub fn fine_size(&self) -> ModelSize {
        let nodes = self.model.active_count();
        ModelSize { cells: self.model.grid().solid_count(), nodes, unknowns: 3 * nodes }
    }

    /// The files that decide the result, the scene first.
    pub fn input_files(&self) -> Vec<PathBuf> {
        let mut files = vec![self.scene.file.clone()];
        match &self.scene.body.source {
            Source::Volume(file) | Source::Moduli(file) => files.push(file.clone()),
            Source::Mesh(mesh) => files.push(mesh.file.clone()),
            Source::Grid(_, Filling::File(file)) => files.push(file.clone()),
            Source::Grid(_, Filling::Pattern(_)) => {}
        }
        if let Some(VoxelModulus::File(file)) = &self.scene.body.modulus {
            files.push(file.clone());
        }
        files.into_iter().flat_map(files_of).collect()
    }
}

fn time_of(scene: &Scene, schedule: &EditSchedule, step: usize) -> f64 {
    match scene.is_dynamic() || !scene.edits.is_empty() {
        true => schedule.time(step),
        false => END_OF_RAMPS,
    }
}

/// The file itself, or the files in a folder of slices, in the order of their names.
fn files_of(path: PathBuf) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(&path) else { return vec![path] };
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.is_file());
    files.sort();
    files
}

/// Refuses coarse cells larger than the body, which would be mostly void.
fn require_degree(scene: &Scene, grid: &VoxelGrid) -> Result<(), Failure> {
    let largest = grid.lattice.cells.into_iter().max().unwrap_or_default();
    let degree = scene.coarsening.degree;
    match degree <= largest {
        true => Ok(()),
        false => {
            let cells = triple_count(grid.lattice.cells);
            let sentence = format!("is {degree}, larger than the body of {cells} cells; expected at most {largest}");
            Err(scene.unusable("coarsening.degree", sentence).into())
        }
    }
}

fn padded(grid: &VoxelGrid, degree: usize, progress: &Progress) -> VoxelGrid {
    let padding = pad_to_multiple(grid, degree, PADDING);
    if padding.added != [0; 3] {
        let (old, new) = (grid.lattice.cells, padding.grid.lattice.cells);
        let sentence = format!(
            "degree {degree} does not divide {} cells; padded with voids to {}",
            triple_count(old),
            triple_count(new)
        );
        progress.say(&sentence);
    }
    padding.grid
}
