//! Few colours that stand for many: the common palette of the frames of an animation.

use crate::{Image, colour::Rgb};

/// Bits per channel by which colours are told apart.
const BITS: u32 = 6;
/// Rounds of moving each palette colour to the mean of what it stands for.
const ROUNDS: usize = 4;

/// A palette, and the entry that stands for each colour.
pub(crate) struct Palette {
    pub(crate) colours: Vec<Rgb>,
    entry: Vec<u8>,
}

/// Colours of one cell of the colour cube, taken together.
#[derive(Clone, Copy)]
struct Bin {
    at: usize,
    mean: [f32; 3],
    weight: f32,
}

impl Palette {
    /// At most `most` colours (up to 256) for all pixels of the frames.
    ///
    /// The colour cube is cut where the weighted variance is largest, at the mean, until there are enough parts; then
    /// colours and parts are improved in turn (Lloyd's iteration). A colour's weight is the root of its number of pixels, so that
    /// a large background does not use up the palette.
    pub(crate) fn new(frames: &[Image], most: usize) -> Self {
        let bins = bins(frames);
        let mut parts = vec![bins.clone()];
        while parts.len() < most {
            let spread = |part: &[Bin]| variance(part).into_iter().fold(0.0, f32::max);
            let widest = (0..parts.len()).max_by(|a, b| spread(&parts[*a]).total_cmp(&spread(&parts[*b])));
            match widest.and_then(|at| Some((at, cut(&parts[at])?))) {
                Some((at, [low, high])) => {
                    parts[at] = low;
                    parts.push(high);
                }
                None => break,
            }
        }
        let mut centres: Vec<[f32; 3]> = parts.iter().map(|part| mean(part)).collect();
        for _ in 0..ROUNDS {
            improve(&bins, &mut centres);
        }
        let mut entry = vec![0; 1 << (3 * BITS)];
        bins.iter().for_each(|bin| entry[bin.at] = nearest(&centres, bin.mean) as u8);
        Self { colours: centres.iter().map(|c| c.map(|x| x.round() as u8)).collect(), entry }
    }

    /// The palette's entry for a colour that is in the frames.
    pub(crate) fn entry(&self, colour: Rgb) -> u8 {
        self.entry[bin_of(colour)]
    }
}

fn bin_of(colour: Rgb) -> usize {
    colour.iter().fold(0, |at, c| at << BITS | usize::from(c >> (8 - BITS)))
}

fn bins(frames: &[Image]) -> Vec<Bin> {
    let mut sums = vec![[0u64; 4]; 1 << (3 * BITS)];
    for pixel in frames.iter().flat_map(Image::pixels) {
        let sum = &mut sums[bin_of(*pixel)];
        (0..3).for_each(|c| sum[c] += u64::from(pixel[c]));
        sum[3] += 1;
    }
    let bin = |(at, [r, g, b, n]): (usize, &[u64; 4])| {
        let mean = [r, g, b].map(|s| (*s as f64 / *n as f64) as f32);
        (*n > 0).then_some(Bin { at, mean, weight: (*n as f32).sqrt() })
    };
    sums.iter().enumerate().filter_map(bin).collect()
}

fn mean(part: &[Bin]) -> [f32; 3] {
    let weight: f32 = part.iter().map(|b| b.weight).sum();
    std::array::from_fn(|c| part.iter().map(|b| b.weight * b.mean[c]).sum::<f32>() / weight)
}

/// Weighted sum of squares around the mean, per channel.
fn variance(part: &[Bin]) -> [f32; 3] {
    let mean = mean(part);
    std::array::from_fn(|c| part.iter().map(|b| b.weight * (b.mean[c] - mean[c]).powi(2)).sum())
}

fn cut(part: &[Bin]) -> Option<[Vec<Bin>; 2]> {
    let (spread, middle) = (variance(part), mean(part));
    let channel = (0..3).max_by(|a, b| spread[*a].total_cmp(&spread[*b]))?;
    let (low, high): (Vec<Bin>, Vec<Bin>) = part.iter().partition(|b| b.mean[channel] < middle[channel]);
    (!low.is_empty() && !high.is_empty()).then_some([low, high])
}

fn improve(bins: &[Bin], centres: &mut [[f32; 3]]) {
    let mut sums = vec![[0.0f64; 4]; centres.len()];
    for bin in bins {
        let sum = &mut sums[nearest(centres, bin.mean)];
        (0..3).for_each(|c| sum[c] += f64::from(bin.weight * bin.mean[c]));
        sum[3] += f64::from(bin.weight);
    }
    for (centre, sum) in centres.iter_mut().zip(&sums).filter(|(_, sum)| sum[3] > 0.0) {
        *centre = std::array::from_fn(|c| (sum[c] / sum[3]) as f32);
    }
}

/// The centre closest to a colour; the first of several. Green counts most, as for the eye.
fn nearest(centres: &[[f32; 3]], colour: [f32; 3]) -> usize {
    let distance = |c: &[f32; 3]| {
        let d: [f32; 3] = std::array::from_fn(|i| c[i] - colour[i]);
        2.0 * d[0] * d[0] + 4.0 * d[1] * d[1] + 3.0 * d[2] * d[2]
    };
    let mut best = (0, f32::INFINITY);
    for (at, centre) in centres.iter().enumerate() {
        let d = distance(centre);
        if d < best.1 {
            best = (at, d);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_and_many_become_few_near_ones() {
        let mut image = Image::new(64, 64, [255; 3]);
        let shades: Vec<Rgb> = (0..6).map(|i| [40 * i, 255 - 30 * i, 128]).collect();
        (0..600).for_each(|i| image.set(i % 64, i / 64, shades[i % 6]));
        let palette = Palette::new(std::slice::from_ref(&image), 255);
        for colour in shades.iter().chain(&[[255; 3]]) {
            assert_eq!(palette.colours[usize::from(palette.entry(*colour))], *colour);
        }
        let mut image = Image::new(256, 256, [0; 3]);
        (0..65536).for_each(|i| image.set(i % 256, i / 256, [(i % 256) as u8, (i / 256) as u8, 90]));
        let palette = Palette::new(std::slice::from_ref(&image), 255);
        assert_eq!(palette.colours.len(), 255);
        let error = |p: &Rgb| {
            let q = palette.colours[usize::from(palette.entry(*p))];
            (0..3).map(|c| (f64::from(p[c]) - f64::from(q[c])).powi(2)).sum::<f64>()
        };
        let rms = (image.pixels().map(error).sum::<f64>() / 65536.0).sqrt();
        // A square of 256 × 256 colours in 255 equal squares of 16 × 16 has an RMS error of 16/√6 = 6.5.
        assert!(rms < 7.5, "{rms}");
    }
}
