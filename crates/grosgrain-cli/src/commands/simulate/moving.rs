//! `simulate` under large deformation: dynamic runs, and static ones of nonlinear materials or moved parts.

use std::path::{Path, PathBuf};
use std::time::Instant;

use grosgrain::fine::FineModel;
use grosgrain_picture::{Axis, Chart, Event, Series};

use super::{draw, keep_or_warn, write_volumes};
use crate::deformed_volume::ScannedBody;
use crate::failure::Failure;
use crate::film::{Film, FilmOptions};
use crate::frames::{Frames, Shown, ShownCoarse};
use crate::interruption;
use crate::method::Method;
use crate::outcome::warn_of_softness;
use crate::picture::{self, Drawn};
use crate::problem::Problem;
use crate::progress::Progress;
use crate::quantities::{count, number};
use crate::report::{self, ModelSize, Report, RunError, SCHEMA_VERSION, Steps};
use crate::results;
use crate::scene::Scene;
use crate::tracks::{self, Kind, Outcome, Track, TrackStep};

/// Times in the strip of a film.
pub(super) const COLUMNS: usize = 6;

/// Runs the scene and writes the results into `folder`.
///
/// # Errors
/// A model that cannot be built; a step that cannot be made, after what came before it has been written.
pub fn run(problem: &mut Problem, method: Method, folder: &Path, progress: &Progress) -> Result<(), Failure> {
    let start = Instant::now();
    let initial = problem.fine_size();
    let scanned = problem.scene.output.volume.then(|| ScannedBody::new(problem)).flatten();
    let mut tracks = tracks_of(problem, method, progress)?;
    let mut writer = Writer::new(problem, method, folder, &tracks, progress);
    let mut outcome = tracks::run(problem, &mut tracks, progress, |problem, step| writer.add(problem, &step))?;
    interruption::check()?;
    let mut written = writer.finish(problem, &outcome)?;
    if let Some(displacement) = writer.last.first().filter(|_| problem.scene.output.volume) {
        progress.say("resampling the deformed volume");
        written.extend(write_volumes(problem, scanned.as_ref(), displacement, folder, progress));
    }
    problem.seconds.insert("output".into(), writer.seconds);
    problem.seconds.insert("total".into(), problem.seconds.get("body").unwrap_or(&0.0) + start.elapsed().as_secs_f64());
    let report = make_report(problem, method, initial, &tracks, &mut outcome)?;
    let path = folder.join("report.json");
    results::write_json(&path, &report)?;
    written.push(path);
    results::print(&super::text(&report, &written))?;
    if let Some(fine) = tracks.iter().skip(1).find(|track| track.kind == Kind::Fine) {
        warn_of_softness(&report.method, tracks[0].books.ratio_of_peaks(&fine.books), progress);
    }
    outcome.stopped.map_or(Ok(()), Err)
}

/// The track of the method, and the fine one where it is compared with.
fn tracks_of(problem: &Problem, method: Method, progress: &Progress) -> Result<Vec<Track>, Failure> {
    let update = problem.scene.coarsening.update;
    let main = match method {
        Method::Fine => Kind::Fine,
        method => Kind::Coarse { method, update },
    };
    let mut kinds = vec![main];
    if problem.scene.output.compare_with_fine && main != Kind::Fine {
        kinds.push(Kind::Fine);
    }
    kinds.into_iter().map(|kind| Track::new(problem, kind, progress)).collect()
}

/// What of a run goes into files step by step.
struct Writer<'a> {
    folder: &'a Path,
    method: Method,
    frames: Frames,
    film: Option<Film>,
    /// Displacements of the last step.
    last: Vec<Vec<f64>>,
    worst: Option<Worst>,
    written: Vec<PathBuf>,
    unknowns: Option<usize>,
    /// The step whose frame was added last.
    framed: Option<usize>,
    /// Whether the user has been told of inverted cells.
    inverted: bool,
    seconds: f64,
    progress: &'a Progress,
}

/// The step of the largest error.
struct Worst {
    model: FineModel,
    displacements: Vec<Vec<f64>>,
    error: f64,
    time: f64,
}

impl<'a> Writer<'a> {
    fn new(problem: &Problem, method: Method, folder: &'a Path, tracks: &[Track], progress: &'a Progress) -> Self {
        let output = &problem.scene.output;
        let dynamic = problem.scene.is_dynamic();
        let film = (output.animation || output.picture && dynamic).then(|| {
            let names: Vec<String> = tracks.iter().map(|track| track.kind.to_string()).collect();
            let materials = problem.scene.materials.iter().map(|m| (m.label, m.name.clone(), None)).collect();
            let ground = problem.scene.contact.map(|ground| ground.z);
            let options = FilmOptions { ground, materials, ..FilmOptions::default() };
            Film::new(&problem.scene.title, &names.iter().map(String::as_str).collect::<Vec<_>>(), options)
        });
        let unknowns = tracks.first().filter(|t| t.coarse().is_some()).map(|t| t.size(problem).unknowns);
        Self {
            folder,
            method,
            frames: Frames::new(folder),
            film,
            last: Vec::new(),
            worst: None,
            written: Vec::new(),
            unknowns,
            framed: None,
            inverted: false,
            seconds: 0.0,
            progress,
        }
    }

    fn add(&mut self, problem: &Problem, step: &TrackStep<'_>) -> Result<(), Failure> {
        let start = Instant::now();
        let output = &problem.scene.output;
        // A run that ends early shows its last step again.
        if (step.number.is_multiple_of(output.frames) || step.last) && self.framed != Some(step.number) {
            self.framed = Some(step.number);
            self.add_frame(problem, step)?;
            if let Some(film) = &mut self.film {
                for (n, displacement) in step.displacements.iter().enumerate() {
                    film.record(n, step.time, &problem.model, displacement);
                    if let Some(error) = step.errors[n].filter(|_| step.number > 0) {
                        film.set_note(n, format!("error {error:.1} %"));
                    }
                }
            }
        }
        if output.picture && step.number == 0 && self.last.is_empty() {
            let path = self.folder.join("picture_0000.png");
            self.written.extend(draw(
                problem,
                self.method,
                &self.drawn(step.displacements, None, ""),
                path,
                self.progress,
            ));
        }
        if let Some(error) = step.errors[0].filter(|error| output.picture && *error > self.worst_error()) {
            self.worst = Some(Worst {
                model: problem.model.clone(),
                displacements: step.displacements.to_vec(),
                error,
                time: step.time,
            });
        }
        self.last = step.displacements.to_vec();
        self.seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    fn worst_error(&self) -> f64 {
        self.worst.as_ref().map_or(0.0, |worst| worst.error)
    }

    fn add_frame(&mut self, problem: &Problem, step: &TrackStep<'_>) -> Result<(), Failure> {
        let main = &step.tracks[0];
        let velocity = main.velocity(problem)?;
        let coarse = main.coarse().map(|model| ShownCoarse {
            model,
            displacement: &main.state.displacement,
            velocity: Some(&main.state.velocity),
        });
        let shown = Shown {
            number: step.number,
            time: step.time,
            displacement: &step.displacements[0],
            velocity: Some(&velocity),
            reference: step.displacements.get(1).map(Vec::as_slice),
            coarse,
        };
        let inverted = self.frames.add(problem, &shown)?;
        if inverted > 0 && !self.inverted {
            self.inverted = true;
            self.progress.warn(&format!(
                "step {}: {} inside out, where von_mises is written as zero; use smaller steps, a smaller degree or integration = \"gauss\", \
                 or model = \"neo-hookean\", which never lets a cell invert",
                step.number,
                match inverted {
                    1 => "1 cell is".to_owned(),
                    many => format!("{} cells are", count(many)),
                }
            ));
        }
        Ok(())
    }

    fn drawn<'d>(&self, displacements: &'d [Vec<f64>], error: Option<f64>, remark: &'d str) -> Drawn<'d> {
        let first = displacements.first().map(Vec::as_slice);
        match self.unknowns {
            None => Drawn { fine: first, remark, ..Drawn::default() },
            Some(unknowns) => {
                let fine = displacements.get(1).map(Vec::as_slice);
                Drawn { coarse: first.map(|u| (unknowns, u)), fine, error, remark }
            }
        }
    }

    /// Writes pictures, films and charts; all files that were written.
    fn finish(&mut self, problem: &mut Problem, outcome: &Outcome) -> Result<Vec<PathBuf>, Failure> {
        let start = Instant::now();
        let mut written = self.frames.written();
        written.append(&mut self.written);
        let progress = self.progress;
        if problem.scene.output.picture && !self.last.is_empty() {
            let error = outcome.errors.last().and_then(|errors| errors[0]);
            let drawn = self.drawn(&self.last, error, "");
            written.extend(draw(problem, self.method, &drawn, self.folder.join("picture.png"), progress));
            if let Some(worst) = self.worst.take().filter(|worst| Some(worst.error) != error) {
                let now = std::mem::replace(&mut problem.model, worst.model);
                let remark = format!(": largest error, at {} s", number(worst.time));
                let drawn = self.drawn(&worst.displacements, Some(worst.error), &remark);
                written.extend(draw(problem, self.method, &drawn, self.folder.join("picture_worst.png"), progress));
                problem.model = now;
            }
            written.extend(charts(&problem.scene, &edits_of(problem, outcome), outcome, self.folder, progress));
        }
        if let Some(film) = self.film.as_ref().filter(|_| !self.last.is_empty()) {
            progress.say("drawing the film");
            if problem.scene.output.picture {
                written.extend(keep_or_warn(film.write_strip(&self.folder.join("film.png"), COLUMNS), progress));
            }
            if problem.scene.output.animation {
                let path = self.folder.join("film-animated.png");
                written.extend(keep_or_warn(film.write_animation(&path), progress));
            }
        }
        self.seconds += start.elapsed().as_secs_f64();
        Ok(written)
    }
}

/// The first edits of a run as events of its charts.
fn edits_of(problem: &Problem, outcome: &Outcome) -> Vec<Event> {
    let edits = outcome.edits.iter().take(8).enumerate();
    edits.map(|(n, edit)| Event { at: problem.schedule.time(edit.step), label: format!("edit {}", n + 1) }).collect()
}

/// Charts over time: the error where there is one, and the energies of a dynamic run.
pub(super) fn charts(
    scene: &Scene,
    events: &[Event],
    outcome: &Outcome,
    folder: &Path,
    progress: &Progress,
) -> Vec<PathBuf> {
    let frames = &outcome.frames;
    if frames.len() < 3 {
        return Vec::new();
    }
    let x = Axis { label: "time [s]".into(), ..Axis::default() };
    let chart = |title: &str, unit: &str, series: Vec<Series>, file: &str| {
        let chart = Chart {
            title: format!("{}: {title}", scene.title),
            x: x.clone(),
            y: Axis { label: unit.into(), ..Axis::default() },
            series,
            events: events.to_vec(),
            ..Chart::default()
        };
        keep_or_warn(picture::save(chart.render(), &folder.join(file)), progress)
    };
    let errors: Vec<[f64; 2]> =
        frames.iter().skip(1).filter_map(|frame| frame.error.map(|error| [frame.time, error])).collect();
    let mut written = Vec::new();
    if errors.len() > 1 {
        let series = vec![Series { name: "coarse".into(), points: errors }];
        written.extend(chart("error", "RMS error against the fine model [%]", series, "error.png"));
    }
    if scene.is_dynamic() {
        let curve = |name: &str, pick: fn(&report::Frame, &report::Motion) -> f64| {
            let point = |frame: &report::Frame| Some([frame.time, pick(frame, frame.motion.as_ref()?)]);
            Series { name: name.into(), points: frames.iter().filter_map(point).collect() }
        };
        let series = vec![
            curve("elastic", |frame, _| frame.energy),
            curve("kinetic", |_, motion| motion.kinetic),
            curve("work put in", |_, motion| motion.work),
            curve("dissipated", |_, motion| motion.dissipated),
        ];
        written.extend(chart("energies", "energy [J]", series, "energy.png"));
    }
    written
}

/// The steps of all tracks, with how much faster than the fine one each is.
pub fn steps_of(tracks: &[Track]) -> Vec<Steps> {
    let fine = tracks.iter().find(|track| track.kind == Kind::Fine).map(|track| &track.books);
    let steps = |track: &Track| match track.kind {
        Kind::Fine => Steps::of("fine", &track.books, None),
        Kind::Coarse { method, .. } => Steps::of(method.name(), &track.books, fine),
    };
    tracks.iter().map(steps).collect()
}

fn make_report(
    problem: &Problem,
    method: Method,
    initial: ModelSize,
    tracks: &[Track],
    outcome: &mut Outcome,
) -> Result<Report, Failure> {
    let files = problem.input_files();
    let main = &tracks[0];
    let books = &main.books;
    let mut seconds = problem.seconds.clone();
    if main.coarse().is_some() {
        let names = ["training", "fitting", "assembly"].map(String::from);
        seconds.extend(names.into_iter().zip(books.build));
        seconds.insert("updates".into(), books.updates[2]);
    }
    seconds.insert("solve".into(), books.solving);
    if let Some(fine) = tracks.iter().skip(1).find(|track| track.kind == Kind::Fine) {
        seconds.insert("fine".into(), fine.books.solving);
    }
    let fine = tracks.iter().find(|track| track.kind == Kind::Fine);
    let error = outcome.errors.last().and_then(|errors| errors[0]).zip(fine);
    let error = error.map(|(rms_percent, fine)| RunError::of(rms_percent, books, &fine.books));
    Ok(Report {
        schema_version: SCHEMA_VERSION,
        program_version: env!("CARGO_PKG_VERSION"),
        title: problem.scene.title.clone(),
        method: method.name().into(),
        input_hash: report::input_hash(&files.iter().map(PathBuf::as_path).collect::<Vec<_>>())?,
        threads: rayon::current_num_threads(),
        fine: initial,
        coarse: main.coarse().map(|_| main.size(problem)),
        seconds,
        solver: None,
        fine_solver: None,
        training_solver: None,
        steps: steps_of(tracks),
        stopped: outcome.stopped.as_ref().map(ToString::to_string),
        edits: std::mem::take(&mut outcome.edits),
        frames: std::mem::take(&mut outcome.frames),
        error,
    })
}
