//! Pictures that move: animated PNG.

use crate::{Image, PictureError, palette::Palette};
use std::io::Write;

/// Index of the transparent entry, with which a frame leaves a pixel as it was.
const UNCHANGED: u8 = 255;

/// Frames of equal size that are shown one after the other, for ever; viewers without animation show the first.
///
/// ```
/// use grosgrain_picture::{Animation, Axis, Chart, Series};
/// let chart = |x: f64| Chart {
///     x: Axis { label: "t [s]".into(), ..Axis::default() },
///     series: vec![Series { name: "a".into(), points: vec![[0.0, 0.0], [1.0, x]] }],
///     width: 400,
///     ..Chart::default()
/// };
/// let frames = vec![chart(0.5).render()?, chart(1.0).render()?];
/// let mut apng = Vec::new();
/// Animation { frames: &frames, delay: 0.04, hold: 1.0 }.write_apng(&mut apng)?;
/// assert!(apng.starts_with(b"\x89PNG"));
/// # Ok::<(), grosgrain_picture::PictureError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Animation<'a> {
    /// The frames.
    pub frames: &'a [Image],
    /// Time that each frame stands \[s\], 0.01 to 60.
    pub delay: f64,
    /// Time that the last frame stands before it begins anew \[s\], 0.01 to 60.
    pub hold: f64,
}

impl Animation<'_> {
    /// Writes an animated PNG of at most 255 colours, common to all frames; each frame holds what has changed since the one before.
    ///
    /// # Errors
    /// No frames, frames of different sizes, times out of bounds, what the writer reports.
    pub fn write_apng<W: Write>(&self, writer: W) -> Result<(), PictureError> {
        let [width, height] = self.size()?;
        let palette = Palette::new(self.frames, usize::from(UNCHANGED));
        let mut encoder = png::Encoder::new(writer, width as u32, height as u32);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut colours = palette.colours.clone();
        colours.resize(usize::from(UNCHANGED) + 1, [0; 3]);
        encoder.set_palette(colours.concat());
        encoder.set_trns([vec![255; usize::from(UNCHANGED)], vec![0]].concat());
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::NoFilter);
        if self.frames.len() > 1 {
            encoder.set_animated(self.frames.len() as u32, 0)?;
            encoder.set_frame_delay(milliseconds(self.delay), 1000)?;
        }
        let mut writer = encoder.write_header()?;
        let mut shown: Vec<u8> = Vec::new();
        for (at, frame) in self.frames.iter().enumerate() {
            let next: Vec<u8> = frame.pixels().map(|p| palette.entry(*p)).collect();
            if at == 0 {
                writer.write_image_data(&next)?;
            } else {
                let patch = Patch::between(&shown, &next, width);
                let last = at + 1 == self.frames.len();
                writer.set_frame_delay(milliseconds(if last { self.hold } else { self.delay }), 1000)?;
                // The rectangle moves only while it fits: first the origin, so that no size is ever out of bounds.
                writer.reset_frame_position()?;
                writer.set_frame_dimension(patch.size[0] as u32, patch.size[1] as u32)?;
                writer.set_frame_position(patch.corner[0] as u32, patch.corner[1] as u32)?;
                writer.set_blend_op(png::BlendOp::Over)?;
                writer.write_image_data(&patch.entries)?;
            }
            shown = next;
        }
        Ok(writer.finish()?)
    }

    fn size(&self) -> Result<[usize; 2], PictureError> {
        let mut sizes = self.frames.iter().map(|f| [f.width(), f.height()]);
        let first = sizes.next().ok_or(PictureError::NoFrames)?;
        if let Some(other) = sizes.find(|size| *size != first) {
            return Err(PictureError::PictureSizes { first, other });
        }
        match [self.delay, self.hold].into_iter().find(|t| !(0.01..=60.0).contains(t)) {
            Some(seconds) => Err(PictureError::Delay(seconds)),
            None => Ok(first),
        }
    }
}

fn milliseconds(seconds: f64) -> u16 {
    (1000.0 * seconds).round() as u16
}

/// The rectangle in which two frames differ.
#[derive(Debug, PartialEq, Eq)]
struct Patch {
    corner: [usize; 2],
    size: [usize; 2],
    /// New entries, [`UNCHANGED`] where there is nothing new.
    entries: Vec<u8>,
}

impl Patch {
    fn between(old: &[u8], new: &[u8], width: usize) -> Self {
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        for at in (0..new.len()).filter(|at| old[*at] != new[*at]) {
            let place = [at % width, at / width];
            low = std::array::from_fn(|a| low[a].min(place[a]));
            high = std::array::from_fn(|a| high[a].max(place[a] + 1));
        }
        if low[0] >= high[0] {
            // A frame cannot be empty.
            return Self { corner: [0; 2], size: [1; 2], entries: vec![UNCHANGED] };
        }
        let size: [usize; 2] = std::array::from_fn(|a| high[a] - low[a]);
        let at = |i: usize| (low[1] + i / size[0]) * width + low[0] + i % size[0];
        let entry = |i: usize| if old[at(i)] == new[at(i)] { UNCHANGED } else { new[at(i)] };
        Self { corner: low, size, entries: (0..size[0] * size[1]).map(entry).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_is_the_smallest_rectangle_of_what_changed() {
        let old = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
        let mut new = old;
        (new[5], new[10]) = (50, 100);
        let patch = Patch::between(&old, &new, 4);
        assert_eq!((patch.corner, patch.size), ([1, 1], [2, 2]));
        assert_eq!(patch.entries, [50, UNCHANGED, UNCHANGED, 100]);
        assert_eq!(Patch::between(&old, &old, 4), Patch { corner: [0; 2], size: [1; 2], entries: vec![UNCHANGED] });
    }
}
