//! The picture being drawn: pixels, rectangles, strokes, and the PNG it becomes.

use crate::{PictureError, colour::Rgb};
use std::io::Write;

/// An sRGB picture, rows from top to bottom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

/// A rectangle in pixels; x to the right, y downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub(crate) x: f32,
    pub(crate) y: f32,
    pub(crate) width: f32,
    pub(crate) height: f32,
}

impl Rect {
    /// The rectangle without a border of `by` pixels.
    pub(crate) fn inset(self, by: f32) -> Self {
        Self { x: self.x + by, y: self.y + by, width: self.width - 2.0 * by, height: self.height - 2.0 * by }
    }
}

impl Image {
    /// A picture of one colour.
    pub(crate) fn new(width: usize, height: usize, colour: Rgb) -> Self {
        Self { width, height, pixels: colour.repeat(width * height) }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The colour of a pixel, `None` outside the picture.
    pub fn pixel(&self, x: usize, y: usize) -> Option<Rgb> {
        let at = 3 * (y * self.width + x);
        (x < self.width && y < self.height).then(|| [self.pixels[at], self.pixels[at + 1], self.pixels[at + 2]])
    }

    /// Writes the picture as an 8-bit RGB PNG.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write_png<W: Write>(&self, writer: W) -> Result<(), PictureError> {
        let mut encoder = png::Encoder::new(writer, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        Ok(writer.finish()?)
    }

    /// The pixels in reading order.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = &Rgb> + '_ {
        self.pixels.as_chunks::<3>().0.iter()
    }

    /// Copies another picture into this one with its upper left corner at `[x, y]`; what does not fit is left out.
    pub(crate) fn paste(&mut self, other: &Self, [x, y]: [usize; 2]) {
        let width = other.width.min(self.width.saturating_sub(x));
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let (from, to) = (3 * row * other.width, 3 * ((y + row) * self.width + x));
            self.pixels[to..to + 3 * width].copy_from_slice(&other.pixels[from..from + 3 * width]);
        }
    }

    pub(crate) fn set(&mut self, x: usize, y: usize, colour: Rgb) {
        if x < self.width && y < self.height {
            let at = 3 * (y * self.width + x);
            self.pixels[at..at + 3].copy_from_slice(&colour);
        }
    }

    /// Mixes `colour` into a pixel; outside the picture nothing happens.
    pub(crate) fn blend(&mut self, x: i64, y: i64, colour: Rgb, alpha: f32) {
        if x < 0 || y < 0 || x >= self.width as i64 || y >= self.height as i64 {
            return;
        }
        let at = 3 * (y as usize * self.width + x as usize);
        for (old, new) in self.pixels[at..at + 3].iter_mut().zip(colour) {
            *old = (f32::from(*old) + alpha.clamp(0.0, 1.0) * (f32::from(new) - f32::from(*old))).round() as u8;
        }
    }

    /// Fills a rectangle with rounded corners, anti-aliased; the colour may depend on the pixel.
    pub(crate) fn fill(&mut self, rect: Rect, radius: f32, colour: impl Fn(f32, f32) -> Rgb) {
        let (cx, cy) = (rect.x + 0.5 * rect.width, rect.y + 0.5 * rect.height);
        let radius = radius.min(0.5 * rect.width).min(0.5 * rect.height);
        for y in rect.y.floor() as i64..(rect.y + rect.height).ceil() as i64 {
            for x in rect.x.floor() as i64..(rect.x + rect.width).ceil() as i64 {
                let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
                let dx = (px - cx).abs() - (0.5 * rect.width - radius);
                let dy = (py - cy).abs() - (0.5 * rect.height - radius);
                let outside = dx.max(0.0).hypot(dy.max(0.0)) + dx.max(dy).min(0.0) - radius;
                self.blend(x, y, colour(px, py), 0.5 - outside);
            }
        }
    }

    /// Strokes a segment with round ends, anti-aliased.
    pub(crate) fn stroke(&mut self, a: [f32; 2], b: [f32; 2], width: f32, colour: Rgb) {
        let reach = 0.5 * width + 1.0;
        let along = [b[0] - a[0], b[1] - a[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        for y in (a[1].min(b[1]) - reach).floor() as i64..=(a[1].max(b[1]) + reach) as i64 {
            for x in (a[0].min(b[0]) - reach).floor() as i64..=(a[0].max(b[0]) + reach) as i64 {
                let from = [x as f32 + 0.5 - a[0], y as f32 + 0.5 - a[1]];
                let t = ((from[0] * along[0] + from[1] * along[1]) / square.max(1e-12)).clamp(0.0, 1.0);
                let distance = (from[0] - t * along[0]).hypot(from[1] - t * along[1]);
                self.blend(x, y, colour, 0.5 * width + 0.5 - distance);
            }
        }
    }
}
