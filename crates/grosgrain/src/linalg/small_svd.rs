//! Singular values of small dense matrices.

use faer::Mat;

/// M = U diag(s) Vᵀ of an n × n matrix, n ≤ 6, singular values in descending order; entries beyond n are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct SmallSvd {
    /// Left singular vectors, as columns.
    pub u: [[f64; 6]; 6],
    /// Singular values.
    pub s: [f64; 6],
    /// Right singular vectors, as columns.
    pub v: [[f64; 6]; 6],
}

impl SmallSvd {
    /// Decomposes the leading n × n part; `None` where an entry is not finite or the iteration does not end.
    pub fn new(n: usize, matrix: &[[f64; 6]; 6]) -> Option<Self> {
        if matrix.iter().flatten().any(|value| !value.is_finite()) {
            return None;
        }
        let svd = Mat::from_fn(n, n, |i, j| matrix[i][j]).svd().ok()?;
        let (mut u, mut s, mut v) = ([[0.0; 6]; 6], [0.0; 6], [[0.0; 6]; 6]);
        for j in 0..n {
            s[j] = svd.S()[j];
            for i in 0..n {
                u[i][j] = svd.U()[(i, j)];
                v[i][j] = svd.V()[(i, j)];
            }
        }
        Some(Self { u, s, v })
    }

    /// s₁ / sₙ, infinite for a singular matrix.
    pub fn condition(&self, n: usize) -> f64 {
        self.s[0] / self.s[n - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factors_are_orthogonal_and_give_the_matrix_back() {
        for n in [1, 3, 6] {
            let mut matrix = [[0.0; 6]; 6];
            (0..n * n)
                .for_each(|e| matrix[e / n][e % n] = (1.7 * e as f64).sin() + if e / n == e % n { 0.5 } else { 0.0 });
            let SmallSvd { u, s, v } = SmallSvd::new(n, &matrix).unwrap();
            let sum = |f: &dyn Fn(usize) -> f64| (0..n).map(f).sum::<f64>();
            for (i, j) in (0..n * n).map(|e| (e / n, e % n)) {
                let identity = if i == j { 1.0 } else { 0.0 };
                assert!((sum(&|k| u[i][k] * s[k] * v[j][k]) - matrix[i][j]).abs() < 1e-14, "{n}");
                assert!((sum(&|k| u[k][i] * u[k][j]) - identity).abs() < 1e-14);
                assert!((sum(&|k| v[k][i] * v[k][j]) - identity).abs() < 1e-14);
            }
            assert!(s[..n].windows(2).all(|pair| pair[0] >= pair[1]) && s[n..].iter().all(|s| *s == 0.0));
        }
        let mut singular = [[0.0; 6]; 6];
        singular[0][0] = 2.0;
        assert_eq!(SmallSvd::new(3, &singular).unwrap().condition(3), f64::INFINITY);
        singular[0][1] = f64::NAN;
        assert_eq!(SmallSvd::new(3, &singular), None);
    }
}
