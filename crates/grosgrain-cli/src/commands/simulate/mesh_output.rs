//! What of a run of meshes goes into files: frames, pictures, films and charts.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::keep_or_warn;
use super::moving::{COLUMNS, charts};
use crate::failure::Failure;
use crate::film::{FilmOptions, SimplexFilm};
use crate::meshes::{
    DrawnMeshes, MeshFrames, MeshMethod, MeshProblem, MeshRun, MeshStep, Posed, ShownCoarseMesh, ShownMesh, Skins,
    legend,
};
use crate::progress::Progress;
use crate::quantities::{counted, number};
use crate::tracks::Outcome;

/// Writes step by step.
pub struct MeshWriter<'a> {
    folder: &'a Path,
    frames: MeshFrames,
    skins: Option<Skins>,
    film: Option<SimplexFilm>,
    /// The last step, and that of the largest error.
    last: Option<Seen>,
    worst: Option<Seen>,
    written: Vec<PathBuf>,
    /// The step whose frame was added last.
    framed: Option<usize>,
    /// Whether the user has been told of inverted cells.
    inverted: bool,
    /// Seconds so far.
    pub seconds: f64,
    progress: &'a Progress,
}

/// What pictures need of a step.
#[derive(Clone, Debug)]
struct Seen {
    time: f64,
    error: Option<f64>,
    method: MeshMethod,
    /// Displacements of the fine nodes by every model.
    displacements: Vec<Vec<f64>>,
    /// Displacement of the first model's own nodes.
    own: Vec<f64>,
}

impl Seen {
    fn of(step: &MeshStep<'_>) -> Self {
        Self {
            time: step.time,
            error: step.errors[0],
            method: step.tracks[0].method,
            displacements: step.displacements.to_vec(),
            own: step.tracks[0].track.state.displacement.clone(),
        }
    }

    fn drawn<'s>(&'s self, remark: &'s str) -> DrawnMeshes<'s> {
        let at = |n: usize| self.displacements.get(n).map(Vec::as_slice);
        match (self.method, at(0)) {
            (MeshMethod::Fine, first) => DrawnMeshes { fine: first, coarse: None, error: None, remark },
            (method, first) => {
                let coarse = first.map(|u| (method, [u, self.own.as_slice()]));
                DrawnMeshes { fine: at(1), coarse, error: self.error, remark }
            }
        }
    }
}

impl<'a> MeshWriter<'a> {
    /// Nothing is written yet.
    pub fn new(problem: &MeshProblem, folder: &'a Path, runs: &[MeshRun], progress: &'a Progress) -> Self {
        let scene = &problem.scene;
        let is_coarse = runs.iter().any(|run| run.coarse.is_some());
        let films = scene.is_dynamic() && (scene.output.animation || scene.output.picture);
        let draws = scene.output.picture || films;
        let skins = draws.then(|| Skins::new(problem)).and_then(|skins| keep_or_warn(skins, progress));
        let film = skins.as_ref().filter(|_| films).map(|_| {
            let names: Vec<&str> = runs.iter().map(|run| run.method.label()).collect();
            let ground = scene.contact.map(|ground| ground.z);
            let options = FilmOptions { ground, materials: legend(problem), ..FilmOptions::default() };
            SimplexFilm::new(&scene.title, &names, options)
        });
        Self {
            folder,
            frames: MeshFrames::new(problem, folder, is_coarse),
            skins,
            film,
            last: None,
            worst: None,
            written: Vec::new(),
            framed: None,
            inverted: false,
            seconds: 0.0,
            progress,
        }
    }

    /// Takes a step.
    ///
    /// # Errors
    /// Frames that cannot be written.
    pub fn add(&mut self, problem: &MeshProblem, step: &MeshStep<'_>) -> Result<(), Failure> {
        let start = Instant::now();
        // A run that ends early shows its last step again.
        if (step.number.is_multiple_of(problem.scene.output.frames) || step.last) && self.framed != Some(step.number) {
            self.framed = Some(step.number);
            self.add_frame(problem, step)?;
            self.record(step);
        }
        if problem.scene.output.picture && self.skins.is_some() {
            let seen = Seen::of(step);
            if step.number == 0 && !step.last && self.last.is_none() {
                self.draw(problem, &seen, "picture_0000.png", "");
            }
            let known = self.worst.as_ref().and_then(|worst| worst.error).unwrap_or(0.0);
            if seen.error.is_some_and(|error| error > known) {
                self.worst = Some(seen.clone());
            }
            self.last = Some(seen);
        }
        self.seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    fn add_frame(&mut self, problem: &MeshProblem, step: &MeshStep<'_>) -> Result<(), Failure> {
        let main = &step.tracks[0];
        let (velocity, state) = (main.velocity(problem), &main.track.state);
        let shown = ShownMesh {
            number: step.number,
            time: step.time,
            fine: [&step.displacements[0], &velocity],
            reference: step.displacements.get(1).map(Vec::as_slice),
            coarse: main.coarse.as_ref().map(|model| ShownCoarseMesh {
                model,
                mass: main.track.mass(),
                fields: [&state.displacement, &state.velocity],
            }),
        };
        let inverted = self.frames.add(problem, &shown)?;
        if inverted > 0 && !self.inverted {
            self.inverted = true;
            let cells =
                if inverted == 1 { "1 cell is".to_owned() } else { format!("{} are", counted(inverted, "cell")) };
            self.progress.warn(&format!(
                "step {}: {cells} inside out, where von_mises is written as zero; use smaller steps, or load it less",
                step.number
            ));
        }
        Ok(())
    }

    fn record(&mut self, step: &MeshStep<'_>) {
        let (Some(film), Some(skins)) = (&mut self.film, &self.skins) else { return };
        for (n, (run, displacement)) in step.tracks.iter().zip(step.displacements).enumerate() {
            let own = &run.track.state.displacement;
            let wires = run.coarse.as_ref().map(|_| Posed { skin: &skins.coarse, displacement: own });
            film.record(n, step.time, Posed { skin: &skins.fine, displacement }, wires);
            if let Some(error) = step.errors[n].filter(|_| step.number > 0) {
                film.set_note(n, format!("error {error:.1} %"));
            }
        }
    }

    fn draw(&mut self, problem: &MeshProblem, seen: &Seen, file: &str, remark: &str) {
        let Some(skins) = &self.skins else { return };
        self.progress.say("drawing the picture");
        let drawn = skins.write(problem, &seen.drawn(remark), &self.folder.join(file));
        self.written.extend(keep_or_warn(drawn, self.progress));
    }

    /// Writes pictures, films and charts; all files that were written.
    pub fn finish(&mut self, problem: &MeshProblem, outcome: &Outcome) -> Vec<PathBuf> {
        let start = Instant::now();
        let (progress, folder) = (self.progress, self.folder);
        if let Some(last) = self.last.take() {
            self.draw(problem, &last, "picture.png", "");
            if let Some(worst) = self.worst.take().filter(|worst| worst.error != last.error) {
                let remark = format!(": largest error, at {} s", number(worst.time));
                self.draw(problem, &worst, "picture_worst.png", &remark);
            }
        }
        let mut written = self.frames.written();
        written.append(&mut self.written);
        if problem.scene.output.picture {
            written.extend(charts(&problem.scene, &[], outcome, folder, progress));
        }
        if let Some(film) = self.film.as_ref().filter(|_| self.framed.is_some()) {
            progress.say("drawing the film");
            if problem.scene.output.picture {
                written.extend(keep_or_warn(film.write_strip(&folder.join("film.png"), COLUMNS), progress));
            }
            if problem.scene.output.animation {
                written.extend(keep_or_warn(film.write_animation(&folder.join("film-animated.png")), progress));
            }
        }
        self.seconds += start.elapsed().as_secs_f64();
        written
    }
}
