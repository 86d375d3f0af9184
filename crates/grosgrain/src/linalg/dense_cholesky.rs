//! Cholesky factorisation of a small dense matrix, row by row, in a fixed order.

use super::reduction::dot;

/// A = L Lᵀ with L lower triangular, row-major.
#[derive(Clone, Debug, Default)]
pub struct DenseCholesky {
    n: usize,
    factor: Vec<f64>,
}

/// Why a dense matrix has no factor.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DenseCholeskyError {
    /// A pivot is zero, negative or not finite.
    #[error(
        "the {n}×{n} matrix is not positive definite: pivot {pivot:.2e} in row {row}; hold the body or shift the diagonal"
    )]
    Pivot {
        /// Number of rows.
        n: usize,
        /// Row of the pivot.
        row: usize,
        /// The pivot.
        pivot: f64,
    },
}

impl DenseCholesky {
    /// Factors the row-major n×n matrix `a`, of which the lower triangle is read.
    ///
    /// # Errors
    /// A pivot that is not a positive finite number.
    pub fn new(n: usize, mut a: Vec<f64>) -> Result<Self, DenseCholeskyError> {
        for row in 0..n {
            let (above, current) = a.split_at_mut(row * n);
            for column in 0..row {
                let other = &above[column * n..column * n + column + 1];
                let sum = dot(&current[..column], &other[..column]);
                current[column] = (current[column] - sum) / other[column];
            }
            let pivot = current[row] - dot(&current[..row], &current[..row]);
            if !(pivot.is_finite() && pivot > 0.0) {
                return Err(DenseCholeskyError::Pivot { n, row, pivot });
            }
            current[row] = pivot.sqrt();
        }
        Ok(Self { n, factor: a })
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.n
    }

    /// Replaces b by A⁻¹ b.
    pub fn solve_in_place(&self, b: &mut [f64]) {
        let row = |i: usize| &self.factor[i * self.n..i * self.n + i + 1];
        for i in 0..self.n {
            b[i] = (b[i] - dot(&row(i)[..i], &b[..i])) / row(i)[i];
        }
        for i in (0..self.n).rev() {
            let value = b[i] / row(i)[i];
            b[i] = value;
            b[..i].iter_mut().zip(row(i)).for_each(|(b, l)| *b -= value * l);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_of_a_diagonally_dominant_system_has_a_residual_at_rounding() {
        let n = 37;
        let entry =
            |i: usize, j: usize| if i == j { 2.0 * n as f64 } else { ((i * j) as f64).sin() + ((i + j) as f64).cos() };
        let a: Vec<f64> = (0..n * n).map(|m| entry(m / n, m % n)).collect();
        let b: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
        let mut x = b.clone();
        DenseCholesky::new(n, a.clone()).unwrap().solve_in_place(&mut x);
        for i in 0..n {
            let residual = dot(&a[i * n..(i + 1) * n], &x) - b[i];
            assert!(residual.abs() < 1e-13, "row {i}: {residual:e}");
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused_with_its_row_and_pivot() {
        let error = DenseCholesky::new(2, vec![1.0, 2.0, 2.0, 1.0]).unwrap_err();
        assert_eq!(error, DenseCholeskyError::Pivot { n: 2, row: 1, pivot: -3.0 });
    }
}
