//! `report.json`: what a run did, in figures.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::failure::Failure;
use crate::tracks::Books;

/// The version of the report's layout; it grows when a field changes its meaning or goes.
pub const SCHEMA_VERSION: u32 = 1;

/// The report of one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Version of this layout.
    pub schema_version: u32,
    /// Version of the program.
    pub program_version: &'static str,
    /// The scene's title.
    pub title: String,
    /// The method's name.
    pub method: String,
    /// SHA-256 of the scene and the files it names.
    pub input_hash: String,
    /// Number of threads.
    pub threads: usize,
    /// The fine model.
    pub fine: ModelSize,
    /// The coarse model; absent for the method `fine`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coarse: Option<ModelSize>,
    /// Seconds spent in each stage.
    pub seconds: BTreeMap<String, f64>,
    /// How the equations of a linear equilibrium were solved; absent from other runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<Solver>,
    /// The steps of every model of a dynamic or nonlinear run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<Steps>,
    /// Why the run ended before its last step; the frames before are whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<String>,
    /// How the fine model's equations were solved; absent where it did not run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fine_solver: Option<Solver>,
    /// How the harmonic displacements of the whole body were solved; absent where training is local or there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub training_solver: Option<Solver>,
    /// What changed during the run.
    pub edits: Vec<Edit>,
    /// Every step.
    pub frames: Vec<Frame>,
    /// The difference from the fine model; absent where it did not run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<RunError>,
}

/// The size of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ModelSize {
    /// Cells that are not void.
    pub cells: usize,
    /// Nodes that touch one.
    pub nodes: usize,
    /// Displacement components, three per node and two or one for meshes in a plane or on a line, held ones included.
    pub unknowns: usize,
}

/// How the equations were solved.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Solver {
    /// The solver's name.
    pub kind: String,
    /// Why it was chosen.
    pub reason: String,
    /// Iterations; 0 for a direct solver.
    pub iterations: usize,
    /// ‖f − K u‖ / ‖f‖.
    pub relative_residual: f64,
}

/// A change during the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Edit {
    /// The step it happened in.
    pub step: usize,
    /// Coarse cells that hold a changed fine cell.
    pub changed_cells: usize,
    /// Fine cells that changed, parts left out among them.
    pub changed_fine_cells: usize,
    /// Coarse cells that were coarsened again.
    pub dirty_cells: usize,
    /// Parts that the edits cut loose.
    pub loose_parts: usize,
    /// Their fine cells.
    pub loose_cells: usize,
    /// What the user should know.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Seconds by stage: training, fitting, total.
    pub seconds: BTreeMap<String, f64>,
}

/// A step of the run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Frame {
    /// The step.
    pub step: usize,
    /// The time \[s\].
    pub time: f64,
    /// The elastic energy \[J\].
    pub energy: f64,
    /// RMS error against the fine model in percent; absent where that did not run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// The books of a dynamic run.
    #[serde(flatten)]
    pub motion: Option<Motion>,
}

/// Books of energy and momentum at a step of a dynamic run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Motion {
    /// The kinetic energy \[J\].
    pub kinetic: f64,
    /// Work of loads and of moved holds since the start \[J\].
    pub work: f64,
    /// Energy that edits have put in since the start, negative where they took some away \[J\].
    pub edited: f64,
    /// Energy that is gone since the start, to damping, friction and the integrator \[J\].
    pub dissipated: f64,
    /// Momentum \[N s\].
    pub momentum: [f64; 3],
    /// Angular momentum about the origin \[N m s\].
    pub angular_momentum: [f64; 3],
}

/// What the steps of a model cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Steps {
    /// Whose steps.
    pub method: String,
    /// Steps or equilibria made.
    pub steps: usize,
    /// Seconds per step.
    pub seconds_per_step: f64,
    /// Newton steps over all.
    pub newton_steps: usize,
    /// Iterations of linear solvers over all.
    pub linear_iterations: usize,
    /// Steps that failed at first and were made in several parts.
    pub divided_steps: usize,
    /// Worst relative residual.
    pub relative_residual: f64,
    /// Seconds per step of the fine model over this one's; absent where that did not run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_up: Option<f64>,
}

impl Steps {
    /// What a method's books say, beside those of the fine model where that is another one and ran too.
    pub fn of(method: &str, books: &Books, fine: Option<&Books>) -> Self {
        let seconds_per_step = books.seconds_per_step();
        let speed_up = fine.filter(|_| seconds_per_step > 0.0).map(|fine| fine.seconds_per_step() / seconds_per_step);
        Self {
            method: method.into(),
            steps: books.steps,
            seconds_per_step,
            newton_steps: books.newton,
            linear_iterations: books.linear,
            divided_steps: books.divided,
            relative_residual: books.residual,
            speed_up,
        }
    }
}

/// The difference from the fine model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RunError {
    /// 100 ‖u_coarse − u_fine‖ / ‖u_fine‖ over the fine nodes.
    pub rms_percent: f64,
    /// Elastic energy of the coarse model over that of the fine one.
    pub energy_ratio: f64,
}

impl RunError {
    /// An error in percent with the energies that two books hold.
    pub fn of(rms_percent: f64, books: &Books, fine: &Books) -> Self {
        Self { rms_percent, energy_ratio: if fine.elastic == 0.0 { 1.0 } else { books.elastic / fine.elastic } }
    }
}

/// SHA-256 over the contents of `files` in their order, each preceded by its length, as lower-case hexadecimal.
///
/// # Errors
/// A file that cannot be read.
pub fn input_hash(files: &[&Path]) -> Result<String, Failure> {
    let mut hash = Sha256::new();
    for file in files {
        let content = std::fs::read(file).map_err(|e| Failure::Failed(format!("{}: {e}", file.display())))?;
        hash.update((content.len() as u64).to_le_bytes());
        hash.update(&content);
    }
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_input_hash_is_sha256_over_lengths_and_contents() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a"), folder.path().join("b"));
        std::fs::write(&a, "abc").unwrap();
        std::fs::write(&b, "").unwrap();
        // printf '\x03\0\0\0\0\0\0\0abc\0\0\0\0\0\0\0\0' | sha256sum
        let expected = "3e2f8940c3a0e0fd6f6e07bbf07f015dd7c147431e5fa14bf3f225d782641540";
        assert_eq!(input_hash(&[&a, &b]).unwrap(), expected);
        assert_ne!(input_hash(&[&b, &a]).unwrap(), expected);
    }
}
