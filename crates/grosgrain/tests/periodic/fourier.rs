//! The discrete Fourier transform of a complex field on a box, for lengths with small prime factors.

use rayon::prelude::*;

/// Real and imaginary part.
pub type Complex = [f64; 2];

/// Lengths must have no prime factor above this.
const LARGEST_FACTOR: usize = 7;

/// The roots of unity of each axis.
pub struct Fourier {
    cells: [usize; 3],
    roots: [Vec<Complex>; 3],
}

fn product(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// Transform of `input[0], input[stride], …` (`out.len()` values) by decimation in time.
fn transform(input: &[Complex], stride: usize, out: &mut [Complex], roots: &[Complex]) {
    let n = out.len();
    if n == 1 {
        out[0] = input[0];
        return;
    }
    let factor = (2..=n).find(|p| n.is_multiple_of(*p)).unwrap_or(n);
    let m = n / factor;
    for (q, part) in out.chunks_exact_mut(m).enumerate() {
        transform(&input[q * stride..], stride * factor, part, roots);
    }
    let mut turn = [[[0.0; 2]; LARGEST_FACTOR]; LARGEST_FACTOR];
    for (r, q) in (0..factor * factor).map(|n| (n / factor, n % factor)) {
        turn[r][q] = roots[q * r % factor * m * stride];
    }
    let mut turned = [[0.0; 2]; LARGEST_FACTOR];
    for k in 0..m {
        (0..factor).for_each(|q| turned[q] = product(out[q * m + k], roots[q * k * stride]));
        for r in 0..factor {
            out[r * m + k] = (0..factor).fold([0.0; 2], |sum, q| {
                let term = product(turned[q], turn[r][q]);
                [sum[0] + term[0], sum[1] + term[1]]
            });
        }
    }
}

impl Fourier {
    pub fn new(cells: [usize; 3]) -> Self {
        let roots = cells.map(|n| {
            let angle = |k: usize| -std::f64::consts::TAU * k as f64 / n as f64;
            (0..n).map(|k| [angle(k).cos(), angle(k).sin()]).collect()
        });
        Self { cells, roots }
    }

    /// Σ_x f(x) exp(−2πi ξ·x / n) in place.
    pub fn forward(&self, field: &mut [Complex]) {
        let [nx, ny, _] = self.cells;
        field.par_chunks_mut(nx * ny).for_each(|plane| {
            let mut line = vec![[0.0; 2]; nx.max(ny)];
            for row in plane.chunks_exact_mut(nx) {
                transform(row, 1, &mut line[..nx], &self.roots[0]);
                row.copy_from_slice(&line[..nx]);
            }
            let mut column = vec![[0.0; 2]; ny];
            for i in 0..nx {
                (0..ny).for_each(|j| column[j] = plane[i + nx * j]);
                transform(&column, 1, &mut line[..ny], &self.roots[1]);
                (0..ny).for_each(|j| plane[i + nx * j] = line[j]);
            }
        });
        self.forward_along_z(field);
    }

    fn forward_along_z(&self, field: &mut [Complex]) {
        let [nx, ny, nz] = self.cells;
        let area = nx * ny;
        let source: &[Complex] = field;
        let mut lines = vec![[0.0; 2]; field.len()];
        lines.par_chunks_mut(nz).enumerate().for_each(|(at, line)| {
            let column: Vec<Complex> = (0..nz).map(|k| source[at + area * k]).collect();
            transform(&column, 1, line, &self.roots[2]);
        });
        field.par_chunks_mut(area).enumerate().for_each(|(k, plane)| {
            plane.iter_mut().enumerate().for_each(|(at, value)| *value = lines[nz * at + k]);
        });
    }

    /// The inverse of [`Fourier::forward`].
    pub fn inverse(&self, field: &mut [Complex]) {
        let scale = 1.0 / field.len() as f64;
        field.par_iter_mut().for_each(|v| v[1] = -v[1]);
        self.forward(field);
        field.par_iter_mut().for_each(|v| *v = [scale * v[0], -scale * v[1]]);
    }
}
