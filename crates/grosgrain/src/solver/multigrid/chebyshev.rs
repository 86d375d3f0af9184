//! The smoother: Chebyshev polynomials of the fourth kind in D⁻¹A, D the 3×3 block diagonal.
//!
//! Lottes, Optimal polynomial smoothers for multigrid V-cycles, 2023: needs the largest eigenvalue only.

use super::level::Level;
use crate::linalg::norm;

/// Steps of the power iteration; it is stopped early, and [`SAFETY`] covers what is missing.
const POWER_STEPS: usize = 12;
const SAFETY: f64 = 1.1;

/// A polynomial smoother of one level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chebyshev {
    /// An upper estimate of the largest eigenvalue of D⁻¹A.
    pub eigenvalue: f64,
    /// Degree of the polynomial: applications of D⁻¹.
    pub steps: usize,
}

impl Chebyshev {
    /// Estimates the eigenvalue by power iteration; the vectors are scratch.
    pub fn new(level: &dyn Level, steps: usize, [x, y, d]: [&mut [f64]; 3]) -> Self {
        fill_with_noise(level, x);
        let mut estimate = 1.0;
        for _ in 0..POWER_STEPS {
            let before = norm(x);
            if before == 0.0 {
                return Self { eigenvalue: 1.0, steps };
            }
            x.iter_mut().for_each(|v| *v /= before);
            level.apply(x, y);
            level.relax([0.0, 1.0], y, None, [d, x]);
            estimate = norm(x);
        }
        Self { eigenvalue: SAFETY * estimate, steps }
    }

    /// Smooths A x = b; with `from_zero`, what `x` held before is overwritten. `d` and `ax` are scratch.
    pub fn smooth(&self, level: &dyn Level, b: &[f64], [x, d, ax]: [&mut [f64]; 3], from_zero: bool) {
        for step in 1..=self.steps {
            let k = step as f64;
            let alpha = if step == 1 { 0.0 } else { (2.0 * k - 3.0) / (2.0 * k + 1.0) };
            let beta = (8.0 * k - 4.0) / ((2.0 * k + 1.0) * self.eigenvalue);
            if step == 1 && from_zero {
                level.relax([0.0, beta], b, None, [d, x]);
            } else {
                level.apply(x, ax);
                level.relax([alpha, beta], b, Some(ax), [d, x]);
            }
        }
    }
}

/// A fixed rough start vector: the fractional parts of multiples of the golden ratio, at the nodes only.
fn fill_with_noise(level: &dyn Level, x: &mut [f64]) {
    let layout = level.layout();
    x.fill(0.0);
    let [nx, ny, nz] = layout.nodes;
    for n in 0..nx * ny * nz {
        let index = layout.index([n % nx, n / nx % ny, n / (nx * ny)]);
        for r in 0..3 {
            x[index + r * layout.component] = ((3 * n + r) as f64 * 0.618_033_988_749_895).fract() - 0.5;
        }
    }
}
