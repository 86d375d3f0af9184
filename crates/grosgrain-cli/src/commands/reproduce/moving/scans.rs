//! The scan of a deformed body, volume-rendered and as files for viewers of scans.
//!
//! Everything is drawn after the run: only then is known how much room the motion takes. Until then the displacements are kept, in
//! single precision, and a model for each edit.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use grosgrain::fine::FineModel;
use grosgrain::mesh::Node;

use super::films::{COLUMNS, caption, track};
use super::{Example, Model};
use crate::commands::simulate::keep_or_warn;
use crate::deformed_volume::{DeformedScan, ScannedBody, write_scan_as};
use crate::failure::Failure;
use crate::film::{ScanFilm, ScanLook};
use crate::interruption;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::tracks::TrackStep;

/// The models whose scans are shown, as in the paper.
const ROWS: [Model; 2] = [Model::Fine, Model::WithUpdate];

/// Drawing a scan takes about as long as a step, so no more are drawn.
const MOST_FRAMES: usize = 31;

/// The steps of a body that comes from a scan.
pub struct ScanRecorder {
    body: ScannedBody,
    model: Arc<FineModel>,
    frames: Vec<Frame>,
}

/// A step.
struct Frame {
    time: f64,
    model: Arc<FineModel>,
    displacements: [Vec<f32>; 2],
    error: Option<f64>,
}

impl ScanRecorder {
    /// A recorder for the body of a problem before any edit; `None` if it does not come from a scan.
    pub fn new(problem: &Problem) -> Option<Self> {
        let body = ScannedBody::new(problem)?;
        Some(Self { body, model: Arc::new(problem.model.clone()), frames: Vec::new() })
    }

    /// Adds a step.
    pub fn add(&mut self, problem: &Problem, step: &TrackStep<'_>) {
        if problem.model.grid().void != self.model.grid().void {
            self.model = Arc::new(problem.model.clone());
        }
        let of = |model: Model| step.displacements[track(model)].iter().map(|u| *u as f32).collect();
        self.frames.push(Frame {
            time: step.time,
            model: Arc::clone(&self.model),
            displacements: ROWS.map(of),
            error: step.errors[track(Model::WithUpdate)].filter(|_| step.number > 0),
        });
    }

    /// Writes the strip, the animation, and the last step as NIfTI and NRRD; what cannot be made is told as a warning.
    ///
    /// # Errors
    /// An interruption.
    pub fn write(
        self,
        problem: &Problem,
        example: &Example,
        folder: &Path,
        progress: &Progress,
    ) -> Result<Vec<PathBuf>, Failure> {
        let look = ScanLook { view: example.view, ..ScanLook::default() };
        let names = ROWS.map(caption);
        let names = names.each_ref().map(String::as_str);
        let film = ScanFilm::new(&problem.scene.title, &names, look, self.room());
        let Some(mut film) = keep_or_warn(film, progress) else { return Ok(Vec::new()) };
        let mut written = Vec::new();
        let shown = self.shown();
        for (n, frame) in shown.iter().enumerate() {
            interruption::check()?;
            progress.report("drawing scans", n + 1, shown.len());
            let last = n + 1 == shown.len();
            for row in 0..ROWS.len() {
                let Some(scan) = keep_or_warn(self.scan(frame, row), progress) else { continue };
                if keep_or_warn(film.record(row, frame.time, &scan), progress).is_none() {
                    continue;
                }
                if let Some(error) = frame.error.filter(|_| ROWS[row] == Model::WithUpdate) {
                    film.set_note(row, format!("error {error:.1} %"));
                }
                if last {
                    let name = if ROWS[row] == Model::Fine { "fine" } else { "coarse" };
                    let files = write_scan_as(&scan, folder, &format!("{}-scan-{name}", example.name));
                    written.extend(keep_or_warn(files, progress).unwrap_or_default());
                }
            }
        }
        progress.close();
        let file = |ending: &str| folder.join(format!("{}-scan{ending}.png", example.name));
        written.extend(keep_or_warn(film.write_strip(&file(""), COLUMNS), progress));
        written.extend(keep_or_warn(film.write_animation(&file("-animated")), progress));
        Ok(written)
    }

    /// The frames that are drawn, evenly picked, the first and the last among them.
    fn shown(&self) -> Vec<&Frame> {
        let (count, last) = (self.frames.len().min(MOST_FRAMES), self.frames.len().saturating_sub(1));
        (0..count).map(|n| &self.frames[(n * last).checked_div(count - 1).unwrap_or(last)]).collect()
    }

    fn scan(&self, frame: &Frame, row: usize) -> Result<DeformedScan, Failure> {
        let displacement: Vec<f64> = frame.displacements[row].iter().map(|u| f64::from(*u)).collect();
        self.body.deformed(&frame.model, &displacement)
    }

    /// The box around all that is ever drawn \[m\].
    fn room(&self) -> [[f64; 3]; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for Frame { model, displacements, .. } in &self.frames {
            let active = model.active();
            for node in (0..active.len()).filter(|n| active[*n]) {
                let place = model.node_position(Node(node));
                for (displacement, a) in displacements.iter().flat_map(|u| (0..3).map(move |a| (u, a))) {
                    let x = place[a] + f64::from(displacement[3 * node + a]);
                    (low[a], high[a]) = (low[a].min(x), high[a].max(x));
                }
            }
        }
        [low, high]
    }
}
