//! Films of deformed scans, as volume renderings.

use std::path::{Path, PathBuf};

use grosgrain::io::write_atomically;
use grosgrain_picture::{
    Animation, Camera, ClipPlane, Image, PictureError, Sheet, SheetPicture, TransferFunction, View, VolumeScene,
};

use super::reel::{Reel, delay, note, time_labels};
use crate::deformed_volume::DeformedScan;
use crate::failure::Failure;
use crate::picture::save;

/// How a film of scans looks.
#[derive(Clone, Debug)]
pub struct ScanLook {
    /// Value to colour and extinction.
    pub transfer: TransferFunction,
    /// The view; `None` chooses a three-quarter view, z up.
    pub view: Option<View>,
    /// What lies before one of these planes is not drawn.
    pub clip_planes: Vec<ClipPlane>,
    /// Width and height of a picture in pixels.
    pub picture: [usize; 2],
    /// The animation shows at most so many frames.
    pub most_frames: usize,
    /// How many times slower than in truth the animation plays.
    pub slowdown: f64,
    /// Small lines under the pictures.
    pub footer: Vec<String>,
}

impl Default for ScanLook {
    fn default() -> Self {
        Self {
            transfer: TransferFunction::ct(),
            view: None,
            clip_planes: Vec::new(),
            picture: [400, 360],
            most_frames: 90,
            slowdown: 1.0,
            footer: Vec::new(),
        }
    }
}

/// A film of one or more runs of a scanned body. It keeps the pictures, not the volumes.
#[derive(Debug)]
pub struct ScanFilm {
    title: String,
    look: ScanLook,
    camera: Camera,
    reel: Reel<Image>,
}

impl ScanFilm {
    /// A film without frames that shows the box `room` \[m\], in which the body moves.
    ///
    /// # Errors
    /// A box or a view that is none.
    pub fn new(title: &str, runs: &[&str], look: ScanLook, room: [[f64; 3]; 2]) -> Result<Self, Failure> {
        let corner = |c: usize| std::array::from_fn(|a| room[c >> a & 1][a]);
        let corners: Vec<[f64; 3]> = (0..8).map(corner).collect();
        let camera = Camera::new(look.view, &corners).map_err(failure)?;
        Ok(Self { title: title.into(), look, camera, reel: Reel::new(runs) })
    }

    /// Draws what a run looks like at a time \[s\].
    ///
    /// # Errors
    /// A volume that cannot be drawn.
    ///
    /// # Panics
    /// `run` is not one of the film's.
    pub fn record(&mut self, run: usize, time: f64, scan: &DeformedScan) -> Result<(), Failure> {
        let [width, height] = self.look.picture;
        let scene = VolumeScene {
            origin: scan.origin,
            camera: Some(self.camera.clone()),
            clip_planes: self.look.clip_planes.clone(),
            outside: scan.void_value,
            width,
            height,
            ..VolumeScene::new(&scan.samples, scan.size, scan.spacing, self.look.transfer.clone())
        };
        let image = scene.render().map_err(failure)?;
        self.reel.push(run, time, image);
        Ok(())
    }

    /// Sets the line under the frame of a run that was recorded last, such as `error 12.3 %`.
    pub fn set_note(&mut self, run: usize, text: impl Into<String>) {
        if let Some(frame) = self.reel.last_mut(run) {
            frame.note = text.into();
        }
    }

    /// Writes the strip as PNG: a row per run, and at most `columns` times.
    ///
    /// # Errors
    /// No frames, a file that cannot be written.
    pub fn write_strip(&self, path: &Path, columns: usize) -> Result<PathBuf, Failure> {
        let times = self.reel.times(columns);
        let runs = 0..self.reel.runs.len();
        let sheet = Sheet {
            title: self.title.clone(),
            rows: self.reel.runs.clone(),
            columns: time_labels(&times),
            pictures: runs.flat_map(|run| times.iter().map(move |t| self.picture(run, *t))).collect(),
            footer: self.look.footer.clone(),
            letters: self.letters(),
            ..Sheet::default()
        };
        save(sheet.render(), path)
    }

    /// Writes the animation as animated PNG: the runs side by side, closest to true speed.
    ///
    /// # Errors
    /// As [`ScanFilm::write_strip`].
    pub fn write_animation(&self, path: &Path) -> Result<PathBuf, Failure> {
        let failed = |error: PictureError| Failure::Failed(format!("{}: {error}", path.display()));
        let times = self.reel.times(self.look.most_frames);
        let frame = |(time, label): (&f64, String)| {
            let sheet = Sheet {
                title: self.title.clone(),
                rows: vec![String::new()],
                columns: self.reel.runs.clone(),
                pictures: (0..self.reel.runs.len()).map(|run| self.picture(run, *time)).collect(),
                footer: [&[label][..], &self.look.footer].concat(),
                letters: self.letters(),
                ..Sheet::default()
            };
            sheet.render()
        };
        let frames: Vec<Image> =
            times.iter().zip(time_labels(&times)).map(frame).collect::<Result<_, _>>().map_err(failed)?;
        let delay = (self.look.slowdown * delay(&times)).clamp(0.02, 1.0);
        let animation = Animation { frames: &frames, delay, hold: 1.0 };
        write_atomically(path, |writer| animation.write_apng(writer)).map_err(failed)?;
        Ok(path.into())
    }

    fn letters(&self) -> f32 {
        (self.look.picture[0] as f32 / 20.0).clamp(14.0, 40.0)
    }

    fn picture(&self, run: usize, time: f64) -> SheetPicture {
        let frame = self.reel.at(run, time);
        SheetPicture { image: frame.map(|f| f.frame.clone()), note: note(frame, self.reel.has_notes()) }
    }
}

fn failure(error: PictureError) -> Failure {
    Failure::Failed(error.to_string())
}
