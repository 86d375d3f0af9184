//! Ambient occlusion in the picture plane: hollows and inner corners receive less light from the sky.

use crate::camera::Vec3;

/// The nearest surface at each pixel.
pub(crate) struct Relief {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Closeness in pixels, `None` where there is no surface.
    pub(crate) closeness: Vec<Option<f32>>,
    /// Unit normal of the surface, to the right, up, to the eye.
    pub(crate) normal: Vec<Vec3>,
}

/// Probes per pixel.
const TAPS: usize = 20;
/// How dark a hollow gets; above one, since the fade keeps even a deep one from hiding the whole sky.
const STRENGTH: f64 = 3.5;

/// Share of the sky that each pixel sees, 0 to 1, probed within `radius` pixels.
///
/// With v from a pixel's surface point to a neighbour's, the neighbour hides max(0, n·v/|v|)(1 − |v|²/r²)² of the sky.
/// The probes turn from pixel to pixel in a 4 × 4 pattern, which a mean over 4 × 4 pixels of similar depth smooths out.
pub(crate) fn sky_seen(relief: &Relief, radius: f64) -> Vec<f32> {
    let probes = probes(radius);
    let turn = |at: usize| (at % relief.width % 4) * 4 + (at / relief.width) % 4;
    let raw: Vec<f32> =
        (0..relief.closeness.len()).map(|at| open_share(relief, at, radius, &probes[turn(at)])).collect();
    (0..raw.len()).map(|at| smoothed(relief, &raw, at, radius)).collect()
}

/// Offsets in pixels on a sunflower spiral that fills a disc, in sixteen turns.
fn probes(radius: f64) -> Vec<[[f64; 2]; TAPS]> {
    let probe = |turn: usize, tap: usize| {
        let r = radius * ((tap as f64 + 0.5) / TAPS as f64).sqrt();
        let (sine, cosine) = (tap as f64 * 2.399_963 + turn as f64 * 0.9).sin_cos();
        [(r * cosine).round(), (r * sine).round()]
    };
    (0..16).map(|turn| std::array::from_fn(|tap| probe(turn, tap))).collect()
}

fn open_share(relief: &Relief, at: usize, radius: f64, probes: &[[f64; 2]; TAPS]) -> f32 {
    let Some(z) = relief.closeness[at] else { return 1.0 };
    let (x, y) = ((at % relief.width) as f64, (at / relief.width) as f64);
    let n = relief.normal[at];
    let mut hidden = 0.0;
    for [dx, dy] in probes {
        let (px, py) = (x + dx, y + dy);
        if px < 0.0 || py < 0.0 || px >= relief.width as f64 || py >= relief.height as f64 {
            continue;
        }
        let Some(near) = relief.closeness[py as usize * relief.width + px as usize] else { continue };
        let v = [*dx, -dy, f64::from(near - z)];
        let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let fade = (1.0 - square / (radius * radius)).max(0.0);
        let slant = (n[0] * v[0] + n[1] * v[1] + n[2] * v[2]) / square.sqrt().max(1e-9);
        hidden += (slant - 0.08).max(0.0) * fade * fade;
    }
    (1.0 - STRENGTH * hidden / TAPS as f64).clamp(0.0, 1.0) as f32
}

fn smoothed(relief: &Relief, raw: &[f32], at: usize, radius: f64) -> f32 {
    let Some(z) = relief.closeness[at] else { return 1.0 };
    let (x, y) = (at % relief.width, at / relief.width);
    let (mut sum, mut weight) = (0.0, 0.0);
    for row in y.saturating_sub(2)..(y + 2).min(relief.height) {
        for column in x.saturating_sub(2)..(x + 2).min(relief.width) {
            let other = row * relief.width + column;
            if relief.closeness[other].is_some_and(|near| f64::from((near - z).abs()) < 0.5 * radius + 3.0) {
                sum += raw[other];
                weight += 1.0;
            }
        }
    }
    sum / f32::max(weight, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_sees_the_whole_sky_and_the_foot_of_a_step_does_not() {
        let (width, height) = (60, 20);
        let step = |at: usize| at % width >= 30;
        let relief = Relief {
            width,
            height,
            closeness: (0..width * height).map(|at| Some(if step(at) { 5.0 } else { 0.0 })).collect(),
            normal: vec![[0.0, 0.0, 1.0]; width * height],
        };
        let seen = sky_seen(&relief, 12.0);
        let row = 10 * width;
        assert_eq!((seen[row + 5], seen[row + 45]), (1.0, 1.0));
        assert!(seen[row + 27] < 0.95, "{}", seen[row + 27]);
    }
}
