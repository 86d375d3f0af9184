//! Values and gradients between voxel centres, and the blocks in which nothing is seen.

use super::transfer::TransferTable;
use rayon::prelude::*;

/// Voxels along an edge of a block.
const BLOCK: usize = 8;

/// A scalar field: trilinear between voxel centres, `outside` one voxel beyond them.
pub(crate) struct Field<'a> {
    pub(crate) samples: &'a [f32],
    pub(crate) size: [usize; 3],
    pub(crate) outside: f32,
}

impl Field<'_> {
    fn at(&self, i: [i64; 3]) -> f32 {
        match (0..3).all(|a| i[a] >= 0 && i[a] < self.size[a] as i64) {
            true => self.samples[(i[0] + self.size[0] as i64 * (i[1] + self.size[1] as i64 * i[2])) as usize],
            false => self.outside,
        }
    }

    /// The value at a position in voxels, 0 being the first voxel's centre.
    pub(crate) fn value(&self, p: [f64; 3]) -> f32 {
        let (base, f) = split(p);
        let inner = (0..3).all(|a| base[a] >= 0 && base[a] + 1 < self.size[a] as i64);
        let c: [f32; 8] = if inner {
            let [nx, ny] = [self.size[0], self.size[0] * self.size[1]];
            let first = base[0] as usize + nx * base[1] as usize + ny * base[2] as usize;
            let s = self.samples;
            let rows = [first, first + nx, first + ny, first + nx + ny];
            [
                s[rows[0]],
                s[rows[0] + 1],
                s[rows[1]],
                s[rows[1] + 1],
                s[rows[2]],
                s[rows[2] + 1],
                s[rows[3]],
                s[rows[3] + 1],
            ]
        } else {
            std::array::from_fn(|n| self.at(std::array::from_fn(|a| base[a] + (n >> a & 1) as i64)))
        };
        let x: [f32; 4] = std::array::from_fn(|r| mix(c[2 * r], c[2 * r + 1], f[0]));
        mix(mix(x[0], x[1], f[1]), mix(x[2], x[3], f[1]), f[2])
    }
}

/// Gradients at the voxels' centres by central differences, interpolated trilinearly; eight bits per component.
pub(crate) struct Gradients {
    size: [usize; 3],
    of_voxel: Vec<[i8; 4]>,
}

/// Gradients longer than this many times `edge` are shortened to it, which keeps their direction.
const STEEPEST: f32 = 4.0;

impl Gradients {
    /// Gradients of a field with these voxel edges, in units of `edge` \[value/m\].
    pub(crate) fn new(field: &Field, spacing: [f64; 3], edge: f64) -> Self {
        let size = field.size;
        let per_voxel = spacing.map(|h| (0.5 / (h * edge)) as f32);
        let layer = |k: usize| {
            let mut found = Vec::with_capacity(size[0] * size[1]);
            for (j, i) in (0..size[1]).flat_map(|j| (0..size[0]).map(move |i| (j, i))) {
                found.push(quantised(difference(field, [i, j, k], per_voxel)));
            }
            found
        };
        let layers: Vec<Vec<[i8; 4]>> = (0..size[2]).into_par_iter().map(layer).collect();
        Self { size, of_voxel: layers.concat() }
    }

    /// The gradient at a position in voxels, in units of `edge`.
    pub(crate) fn at(&self, p: [f64; 3]) -> [f32; 3] {
        let (base, f) = split(p);
        let ends: [[usize; 2]; 3] =
            std::array::from_fn(|a| [base[a], base[a] + 1].map(|i| i.clamp(0, self.size[a] as i64 - 1) as usize));
        let corner = |n: usize| {
            let [i, j, k] = [ends[0][n & 1], ends[1][n >> 1 & 1], ends[2][n >> 2]];
            self.of_voxel[i + self.size[0] * (j + self.size[1] * k)].map(f32::from)
        };
        let along = |a: [f32; 4], b: [f32; 4], t: f32| -> [f32; 4] { std::array::from_fn(|c| mix(a[c], b[c], t)) };
        let row = |n: usize| along(corner(n), corner(n + 1), f[0]);
        let [x, y, z, _] = along(along(row(0), row(2), f[1]), along(row(4), row(6), f[1]), f[2]);
        [x, y, z].map(|v| v * STEEPEST / 127.0)
    }
}

fn difference(field: &Field, at: [usize; 3], per_voxel: [f32; 3]) -> [f32; 3] {
    let stride = [1, field.size[0], field.size[0] * field.size[1]];
    let here = at[0] + stride[1] * at[1] + stride[2] * at[2];
    std::array::from_fn(|a| {
        let before = if at[a] > 0 { field.samples[here - stride[a]] } else { field.outside };
        let after = if at[a] + 1 < field.size[a] { field.samples[here + stride[a]] } else { field.outside };
        (after - before) * per_voxel[a]
    })
}

fn quantised(g: [f32; 3]) -> [i8; 4] {
    let length = (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]).sqrt();
    let scale = 127.0 / STEEPEST * (STEEPEST / length).min(1.0);
    let [x, y, z] = g.map(|v| (v * scale).round() as i8);
    [x, y, z, 0]
}

fn split(p: [f64; 3]) -> ([i64; 3], [f32; 3]) {
    let base = p.map(|x| x.floor() as i64);
    (base, std::array::from_fn(|a| (p[a] - base[a] as f64) as f32))
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

/// Which blocks of the field hold something that is seen, and how dense it is there.
pub(crate) struct Blocks {
    count: [usize; 3],
    visible: Vec<bool>,
}

impl Blocks {
    /// Smallest and largest value per block decide; a block holds the interpolation cells whose first voxel is in it.
    pub(crate) fn new(field: &Field, table: &TransferTable) -> Self {
        // Cells begin one voxel before the field, where it falls to `outside`.
        let count = field.size.map(|n| (n + 1).div_ceil(BLOCK));
        let visible = (0..count[0] * count[1] * count[2]).into_par_iter().map(|b| {
            let at = [b % count[0], b / count[0] % count[1], b / (count[0] * count[1])];
            let (low, high) = range(field, at);
            table.is_visible(low, high)
        });
        Self { count, visible: visible.collect() }
    }

    /// The empty block around a position in voxels, as its low and high end; `None` where something may be seen.
    pub(crate) fn empty_around(&self, p: [f64; 3]) -> Option<[[f64; 3]; 2]> {
        let at: [i64; 3] = std::array::from_fn(|a| ((p[a] + 1.0) / BLOCK as f64).floor() as i64);
        if (0..3).any(|a| at[a] < 0 || at[a] >= self.count[a] as i64) {
            return None;
        }
        let [i, j, k] = at.map(|x| x as usize);
        let low: [f64; 3] = std::array::from_fn(|a| at[a] as f64 * BLOCK as f64 - 1.0);
        (!self.visible[i + self.count[0] * (j + self.count[1] * k)]).then(|| [low, low.map(|x| x + BLOCK as f64)])
    }

    /// Box around everything that may be seen, in voxels; `None` if nothing is.
    pub(crate) fn visible_box(&self) -> Option<[[f64; 3]; 2]> {
        let (mut low, mut high) = ([usize::MAX; 3], [0; 3]);
        for b in (0..self.visible.len()).filter(|b| self.visible[*b]) {
            let at = [b % self.count[0], b / self.count[0] % self.count[1], b / (self.count[0] * self.count[1])];
            for a in 0..3 {
                (low[a], high[a]) = (low[a].min(at[a]), high[a].max(at[a] + 1));
            }
        }
        (low[0] < high[0]).then(|| [low, high].map(|end| end.map(|x| (x * BLOCK) as f64 - 1.0)))
    }
}

fn range(field: &Field, block: [usize; 3]) -> (f32, f32) {
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    let ends = |a: usize| {
        let first = (block[a] * BLOCK) as i64 - 1;
        first..=first + BLOCK as i64
    };
    for k in ends(2) {
        for j in ends(1) {
            for i in ends(0) {
                let v = field.at([i, j, k]);
                (low, high) = (low.min(v), high.max(v));
            }
        }
    }
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trilinear_field_is_met_exactly_and_its_gradient_to_eight_bits() {
        let size = [7, 6, 5];
        let f = |x: f64, y: f64, z: f64| 1.0 + 2.0 * x - 3.0 * y + 0.5 * z + 0.25 * x * y - 0.125 * x * y * z;
        let sample = |n: usize| f((n % 7) as f64, (n / 7 % 6) as f64, (n / 42) as f64) as f32;
        let samples: Vec<f32> = (0..210).map(sample).collect();
        let field = Field { samples: &samples, size, outside: 0.0 };
        let (spacing, edge) = ([0.5, 1.0, 2.0], 2.0);
        let gradients = Gradients::new(&field, spacing, edge);
        for p in [[1.5, 1.25, 1.75], [3.9, 2.0, 2.5], [4.2, 3.8, 1.1]] {
            let [x, y, z] = p;
            assert!((f64::from(field.value(p)) - f(x, y, z)).abs() < 1e-4, "{p:?}");
            let exact = [2.0 + 0.25 * y - 0.125 * y * z, -3.0 + 0.25 * x - 0.125 * x * z, 0.5 - 0.125 * x * y];
            let found = gradients.at(p);
            for a in 0..3 {
                let exact = exact[a] / spacing[a] / edge;
                // Half a unit of eight bits.
                assert!((f64::from(found[a]) - exact).abs() < 0.51 * 4.0 / 127.0, "{p:?} {a}: {found:?}, {exact}");
            }
        }
    }

    #[test]
    fn a_steep_gradient_keeps_its_direction() {
        let [x, y, z, _] = quantised([300.0, -400.0, 0.0]);
        assert_eq!((x, y, z), (76, -102, 0));
        assert_eq!(quantised([0.0; 3]), [0; 4]);
    }

    #[test]
    fn beyond_the_last_centre_the_field_falls_to_the_outside() {
        let samples = [8.0f32; 8];
        let field = Field { samples: &samples, size: [2; 3], outside: 0.0 };
        assert_eq!(field.value([0.5; 3]), 8.0);
        assert_eq!(field.value([1.25, 0.5, 0.5]), 6.0);
        assert_eq!(field.value([-0.75, 0.5, 0.5]), 2.0);
        assert_eq!(field.value([5.0, 0.5, 0.5]), 0.0);
        let gradients = Gradients::new(&field, [1.0; 3], 8.0);
        assert!(gradients.at([0.0, 0.5, 0.5])[0] > 0.4 && gradients.at([1.0, 0.5, 0.5])[0] < -0.4);
    }
}
