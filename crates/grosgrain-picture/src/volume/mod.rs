//! Volume rendering: a scalar field as a translucent body.

mod field;
mod march;
mod transfer;

pub use transfer::{TransferFunction, TransferNode};

use crate::{
    Camera, Image, PictureError, View,
    camera::Vec3,
    colour::{Rgb, SrgbTable, to_linear},
};
use field::{Blocks, Field};
use march::March;
use rayon::prelude::*;
use transfer::TransferTable;

/// A scalar volume, how it is coloured, and from where it is seen.
///
/// Light absorbed and emitted along each ray is C = ∫ κ c exp(−∫ κ) (`max1995optical`), taken front to back in steps. A step
/// with the mean extinction κ and the length h has the opacity 1 − exp(−κ h), so the picture does not depend on h but
/// for its error. Surfaces, where the value changes fast, are lit by a lamp beside the eye and a soft sky
/// (`levoy1988display`).
///
/// ```
/// use grosgrain_picture::{TransferFunction, VolumeScene};
/// let ball = |i: usize| {
///     let [x, y, z] = [i % 16, i / 16 % 16, i / 256].map(|n| n as f32 - 7.5);
///     if x * x + y * y + z * z < 36.0 { 300.0 } else { -1000.0 }
/// };
/// let samples: Vec<f32> = (0..4096).map(ball).collect();
/// let scene = VolumeScene { width: 200, height: 150, ..VolumeScene::new(&samples, [16; 3], [0.01; 3], TransferFunction::ct()) };
/// let image = scene.render()?;
/// assert_ne!(image.pixel(100, 75), image.pixel(2, 2));
/// # Ok::<(), grosgrain_picture::PictureError>(())
/// ```
#[derive(Clone, Debug)]
pub struct VolumeScene<'a> {
    /// Values at the voxels' centres, x fastest.
    pub samples: &'a [f32],
    /// Number of voxels along x, y, z.
    pub size: [usize; 3],
    /// Edges of a voxel \[m\].
    pub spacing: [f64; 3],
    /// Centre of the first voxel \[m\].
    pub origin: [f64; 3],
    /// The value around the volume, reached one voxel beyond the outermost centres.
    pub outside: f32,
    /// Value to colour and extinction.
    pub transfer: TransferFunction,
    /// The view; `None` chooses a three-quarter view, z up. Not used where there is a camera.
    pub view: Option<View>,
    /// A camera that several pictures share; `None` fits one to what is seen.
    pub camera: Option<Camera>,
    /// Only this box is drawn: its low and high corner \[m\].
    pub clip_box: Option<[[f64; 3]; 2]>,
    /// Only what lies behind all these planes is drawn.
    pub clip_planes: Vec<ClipPlane>,
    /// Faces that a clip cuts look like a layer of this thickness \[m\]: thick ones show the cross-section, 0 none.
    pub face: f64,
    /// Width in pixels, 16 to 4000.
    pub width: usize,
    /// Height in pixels, 16 to 4000.
    pub height: usize,
    /// Length of a step in voxels.
    pub step: f64,
    /// Rays along each axis of a pixel that differs from its neighbours; one ray for the others.
    pub rays: usize,
    /// Behind the body.
    pub background: Rgb,
    /// Leaps over blocks in which nothing is seen; the picture is the same.
    pub skip_empty: bool,
}

/// A plane that cuts away what lies in front of it, on the side of its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlane {
    /// A point on the plane \[m\].
    pub point: [f64; 3],
    /// Normal, pointing to what is cut away; any length.
    pub normal: [f64; 3],
}

impl<'a> VolumeScene<'a> {
    /// A scene with all options at their defaults; the first voxel's centre is half a voxel from the origin.
    ///
    /// The value outside is that of the transfer function's first node.
    pub fn new(samples: &'a [f32], size: [usize; 3], spacing: [f64; 3], transfer: TransferFunction) -> Self {
        Self {
            samples,
            size,
            spacing,
            origin: spacing.map(|h| 0.5 * h),
            outside: transfer.nodes.first().map_or(0.0, |n| n.value as f32),
            transfer,
            view: None,
            camera: None,
            clip_box: None,
            clip_planes: Vec::new(),
            face: 0.03,
            width: 900,
            height: 700,
            step: 1.0,
            rays: 2,
            background: [0xff; 3],
            skip_empty: true,
        }
    }

    /// The camera that [`VolumeScene::render`] uses: the scene's own, or one that sees everything visible.
    ///
    /// # Errors
    /// As [`VolumeScene::render`].
    pub fn fitted_camera(&self) -> Result<Camera, PictureError> {
        self.validate()?;
        match &self.camera {
            Some(camera) => Ok(camera.clone()),
            None => Camera::new(self.view, &self.corners()),
        }
    }

    /// Draws the volume. The same input gives the same pixels for any number of threads.
    ///
    /// Pixels at edges get more rays than one.
    ///
    /// # Errors
    /// Samples that do not fit the size, a spacing or a step that is not positive, an unusable transfer function, view or
    /// picture size.
    pub fn render(&self) -> Result<Image, PictureError> {
        let camera = self.fitted_camera()?;
        let frame = PictureFrame { march: March::new(self, &camera), scene: self, table: SrgbTable::new() };
        let once = frame.pixels(|_| true, 1, &[]);
        let uneven = uneven(&once, [self.width, self.height]);
        let pixels = match self.rays {
            1 => once,
            rays => frame.pixels(|at| uneven[at], rays, &once),
        };
        let mut image = Image::new(self.width, self.height, self.background);
        for (at, colour) in pixels.iter().enumerate() {
            image.set(at % self.width, at / self.width, *colour);
        }
        Ok(image)
    }

    fn field(&self) -> Field<'_> {
        Field { samples: self.samples, size: self.size, outside: self.outside }
    }

    /// Corners of the box around what is seen, of the whole volume if that is nothing.
    fn corners(&self) -> Vec<Vec3> {
        let all = [[-0.5; 3], self.size.map(|n| n as f64 - 0.5)];
        let seen = Blocks::new(&self.field(), &TransferTable::new(&self.transfer)).visible_box();
        let ends = seen.unwrap_or(all);
        let world = |c: usize, a: usize| {
            let low = ends[0][a].max(all[0][a]);
            let high = ends[1][a].min(all[1][a]);
            let x = self.origin[a] + self.spacing[a] * if c >> a & 1 == 1 { high } else { low };
            self.clip_box.map_or(x, |[low, high]| x.clamp(low[a].min(high[a]), high[a].max(low[a])))
        };
        (0..8).map(|c| std::array::from_fn(|a| world(c, a))).collect()
    }

    fn validate(&self) -> Result<(), PictureError> {
        let product = |n: usize, e: &usize| n.checked_mul(*e);
        let expected = self.size.iter().try_fold(1, product).filter(|n| *n > 0 && *n == self.samples.len());
        if expected.is_none() {
            return Err(PictureError::VolumeSize { found: self.samples.len(), size: self.size });
        }
        if let Some(index) = self.samples.iter().position(|v| !v.is_finite()) {
            return Err(PictureError::VolumeSample { index, value: self.samples[index] });
        }
        let positive = |x: f64| x > 0.0 && x < 1e100;
        let lengths = [self.spacing[0], self.spacing[1], self.spacing[2], self.step];
        let usable = self.origin.iter().all(|x| x.abs() < 1e100) && self.outside.is_finite() && self.face >= 0.0;
        if !usable || !lengths.into_iter().all(positive) || !(1..=8).contains(&self.rays) {
            let (spacing, step, rays) = (self.spacing, self.step, self.rays);
            return Err(PictureError::VolumeSteps { spacing, step, rays });
        }
        if ![self.width, self.height].iter().all(|n| (16..=4000).contains(n)) {
            return Err(PictureError::VolumePicture { width: self.width, height: self.height });
        }
        self.transfer.validate()
    }
}

/// A picture being taken.
struct PictureFrame<'a> {
    march: March<'a>,
    scene: &'a VolumeScene<'a>,
    table: SrgbTable,
}

impl PictureFrame<'_> {
    /// The pixels that `which` picks with `rays`² rays each, the others as they were `before`.
    fn pixels(&self, which: impl Fn(usize) -> bool + Sync, rays: usize, before: &[Rgb]) -> Vec<Rgb> {
        let (width, height) = (self.scene.width, self.scene.height);
        let scale = self.march.camera.scale([width, height]);
        let [[left, bottom], [right, top]] = self.march.camera.bounds;
        let corner = [0.5 * (left + right - width as f64 / scale), 0.5 * (bottom + top + height as f64 / scale)];
        let pixel = |at: usize| match which(at) {
            true => self.pixel(at, rays, corner, scale),
            false => before[at],
        };
        (0..width * height).into_par_iter().with_min_len(width).map(pixel).collect()
    }

    fn pixel(&self, at: usize, rays: usize, corner: [f64; 2], scale: f64) -> Rgb {
        let background = to_linear(self.scene.background).map(f64::from);
        let (column, row) = ((at % self.scene.width) as f64, (at / self.scene.width) as f64);
        let count = (rays * rays) as f64;
        let mut sum = [0.0; 3];
        for ray in 0..rays * rays {
            let [i, j] = [ray % rays, ray / rays].map(|n| (n as f64 + 0.5) / rays as f64);
            let (x, y) = (corner[0] + (column + i) / scale, corner[1] - (row + j) / scale);
            // Rays of a pixel step out of phase, which averages out what steps leave of a pattern.
            let gathered = self.march.gather(x, y, (ray as f64 + 0.5) / count);
            (0..3).for_each(|c| sum[c] += gathered.light[c] + gathered.left * background[c]);
        }
        self.table.encode(sum.map(|c| (c / count) as f32))
    }
}

/// Difference of neighbouring pixels from which on both get more rays.
const UNEVEN: u8 = 10;

/// Which pixels differ visibly from a neighbour.
fn uneven(pixels: &[Rgb], [width, height]: [usize; 2]) -> Vec<bool> {
    let mut found = vec![false; pixels.len()];
    for at in 0..pixels.len() {
        let right = (at % width + 1 < width).then_some(at + 1);
        let below = (at / width + 1 < height).then_some(at + width);
        for other in right.into_iter().chain(below) {
            if (0..3).any(|c| pixels[at][c].abs_diff(pixels[other][c]) > UNEVEN) {
                (found[at], found[other]) = (true, true);
            }
        }
    }
    found
}
