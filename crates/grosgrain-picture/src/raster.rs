//! A buffer of samples with depth: triangles and hidden lines.

/// A projected corner of a triangle. Lengths are in samples, y downwards.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Corner {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// Larger is nearer to the eye.
    pub(crate) closeness: f64,
    /// Position in the colour table, 0 to 1.
    pub(crate) tone: f64,
    /// Light that falls on it, 0 to 1.
    pub(crate) light: f64,
}

impl Corner {
    pub(crate) fn mean(corners: &[Corner; 4]) -> Corner {
        let mean = |part: fn(&Corner) -> f64| 0.25 * corners.iter().map(part).sum::<f64>();
        Corner {
            x: mean(|c| c.x),
            y: mean(|c| c.y),
            closeness: mean(|c| c.closeness),
            tone: mean(|c| c.tone),
            light: mean(|c| c.light),
        }
    }
}

/// What the nearest surface is at every sample, and how much ink lies on it.
pub(crate) struct Raster {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Closeness of the surface, −∞ where there is none.
    pub(crate) closeness: Vec<f32>,
    pub(crate) quad: Vec<u32>,
    /// Tone and light in 1/65535.
    pub(crate) tone: Vec<[u16; 2]>,
    /// Opacity of faint and of dark lines in 1/255.
    pub(crate) ink: Vec<[u8; 2]>,
}

/// A pen for hidden lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pen {
    /// Index into [`Raster::ink`].
    pub(crate) layer: usize,
    /// Half the line's width in samples.
    pub(crate) radius: f64,
    /// Opacity, 0 to 1.
    pub(crate) opacity: f64,
    /// How far behind the surface a line is still drawn, in samples.
    pub(crate) bias: f64,
}

impl Raster {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let n = width * height;
        Self {
            width,
            height,
            closeness: vec![f32::NEG_INFINITY; n],
            quad: vec![0; n],
            tone: vec![[0; 2]; n],
            ink: vec![[0; 2]; n],
        }
    }

    /// Draws a triangle; of two surfaces at one sample the nearer stays, of equal ones the first.
    pub(crate) fn triangle(&mut self, quad: u32, [a, b, c]: [Corner; 3]) {
        let area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        if area == 0.0 {
            return;
        }
        let rows = span([a.y, b.y, c.y], self.height);
        let columns = span([a.x, b.x, c.x], self.width);
        for row in rows {
            let y = row as f64 + 0.5;
            for column in columns.clone() {
                let x = column as f64 + 0.5;
                let u = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
                let v = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
                if u < 0.0 || v < 0.0 || u + v > 1.0 {
                    continue;
                }
                let mix = |part: fn(&Corner) -> f64| part(&a) + u * (part(&b) - part(&a)) + v * (part(&c) - part(&a));
                let closeness = mix(|c| c.closeness) as f32;
                let at = row * self.width + column;
                if closeness > self.closeness[at] {
                    self.closeness[at] = closeness;
                    self.quad[at] = quad;
                    self.tone[at] = [mix(|c| c.tone), mix(|c| c.light)].map(|t| (t * 65535.0 + 0.5) as u16);
                }
            }
        }
    }

    /// Draws a segment where no surface hides it. Ends are x, y, closeness in samples.
    pub(crate) fn line(&mut self, a: [f64; 3], b: [f64; 3], pen: Pen) {
        let steps = (b[0] - a[0]).abs().max((b[1] - a[1]).abs()).ceil().clamp(1.0, 1e5);
        for i in 0..=steps as usize {
            let t = i as f64 / steps;
            let [x, y, closeness] = std::array::from_fn(|k| a[k] + t * (b[k] - a[k]));
            if self.visible(x, y, closeness + pen.bias) {
                self.dot(x, y, pen);
            }
        }
    }

    /// True if no surface lies in front of the point, or only the rim of one.
    fn visible(&self, x: f64, y: f64, closeness: f64) -> bool {
        let rows = span([y - 1.0, y + 1.0, y], self.height);
        let columns = span([x - 1.0, x + 1.0, x], self.width);
        let mut farthest = f32::INFINITY;
        for row in rows {
            for &found in &self.closeness[row * self.width..][columns.clone()] {
                if found != f32::NEG_INFINITY {
                    farthest = farthest.min(found);
                }
            }
        }
        farthest == f32::INFINITY || closeness >= f64::from(farthest)
    }

    fn dot(&mut self, x: f64, y: f64, pen: Pen) {
        let opacity = (pen.opacity * 255.0) as u8;
        let columns = span([x - pen.radius, x + pen.radius, x], self.width);
        for row in span([y - pen.radius, y + pen.radius, y], self.height) {
            for column in columns.clone() {
                if (column as f64 + 0.5 - x).hypot(row as f64 + 0.5 - y) <= pen.radius {
                    let ink = &mut self.ink[row * self.width + column][pen.layer];
                    *ink = opacity.max(*ink);
                }
            }
        }
    }
}

/// The samples whose centres lie between the smallest and largest of three coordinates.
fn span(x: [f64; 3], count: usize) -> std::ops::Range<usize> {
    let low = x[0].min(x[1]).min(x[2]);
    let high = x[0].max(x[1]).max(x[2]);
    let first = (low - 0.5).ceil().max(0.0) as usize;
    let end = ((high - 0.5).floor() + 1.0).max(0.0) as usize;
    first.min(count)..end.min(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64, closeness: f64, quad: u32, raster: &mut Raster) {
        let corner = |x, y| Corner { x, y, closeness, tone: 0.0, light: 1.0 };
        let [a, b, c, d] = [corner(low, low), corner(high, low), corner(high, high), corner(low, high)];
        raster.triangle(quad, [a, b, c]);
        raster.triangle(quad, [a, c, d]);
    }

    #[test]
    fn the_nearer_surface_stays_whatever_the_order() {
        let (mut one, mut other) = (Raster::new(8, 8), Raster::new(8, 8));
        square(1.0, 7.0, 1.0, 1, &mut one);
        square(2.0, 6.0, 2.0, 2, &mut one);
        square(2.0, 6.0, 2.0, 2, &mut other);
        square(1.0, 7.0, 1.0, 1, &mut other);
        assert_eq!(one.quad, other.quad);
        assert_eq!(one.quad.iter().filter(|q| **q == 2).count(), 16);
        assert_eq!(one.quad.iter().filter(|q| **q == 1).count(), 36 - 16);
    }

    #[test]
    fn a_line_behind_a_surface_is_hidden_and_one_on_it_is_drawn() {
        let mut raster = Raster::new(16, 16);
        square(4.0, 12.0, 10.0, 1, &mut raster);
        let pen = Pen { layer: 1, radius: 0.8, opacity: 1.0, bias: 0.5 };
        raster.line([0.0, 6.0, 0.0], [16.0, 6.0, 0.0], pen);
        assert_eq!((raster.ink[6 * 16 + 8][1], raster.ink[6 * 16 + 1][1]), (0, 255));
        raster.line([4.0, 9.0, 9.8], [12.0, 9.0, 9.8], pen);
        assert_eq!(raster.ink[9 * 16 + 8][1], 255);
    }
}
