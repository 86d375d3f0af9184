//! Small dense matrices of substructures, row-major.

/// A pivot below this share of its diagonal is a motion without stiffness.
pub(super) const VANISHING: f64 = 1e-11;

/// Inverts a positive definite n×n matrix in place by Gauss–Jordan elimination; false where a pivot is below the share `dependent` of its diagonal.
pub(super) fn invert(n: usize, a: &mut [f64], row: &mut Vec<f64>, dependent: f64) -> bool {
    struct Invert<'a>(usize, &'a mut [f64], &'a mut Vec<f64>, f64);
    impl pulp::WithSimd for Invert<'_> {
        type Output = bool;
        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _: S) -> bool {
            let Self(n, a, pivot_row, dependent) = self;
            let scale: Vec<f64> = (0..n).map(|k| a[k * n + k]).collect();
            for (k, &scale) in scale.iter().enumerate() {
                let pivot = a[k * n + k];
                if pivot.is_nan() || pivot <= dependent * scale {
                    return false;
                }
                let inverse = 1.0 / pivot;
                a[k * n + k] = 1.0;
                pivot_row.clear();
                pivot_row.extend(a[k * n..][..n].iter().map(|x| x * inverse));
                for (i, target) in a.chunks_exact_mut(n).enumerate() {
                    if i == k {
                        target.copy_from_slice(pivot_row);
                        continue;
                    }
                    let factor = -target[k];
                    target[k] = 0.0;
                    target.iter_mut().zip(pivot_row.iter()).for_each(|(t, p)| *t = factor.mul_add(*p, *t));
                }
            }
            true
        }
    }
    n == 0 || pulp::Arch::new().dispatch(Invert(n, a, row, dependent))
}

/// Solves the positive semidefinite system A x = b of `columns` right-hand sides in place; x is zero where a pivot vanishes.
pub(super) fn solve_semidefinite(n: usize, a: &mut [f64], b: &mut [f64], columns: usize) {
    let mut inverse = vec![0.0; n];
    for k in 0..n {
        let scale = a[k * n + k];
        let (above, rest) = a.split_at_mut(k * n);
        let current = &mut rest[..n];
        for j in 0..k {
            let other = &above[j * n..][..j];
            let sum: f64 = current[..j].iter().zip(other).map(|(x, y)| x * y).sum();
            current[j] = (current[j] - sum) * inverse[j];
        }
        let pivot = scale - current[..k].iter().map(|x| x * x).sum::<f64>();
        inverse[k] = if pivot > VANISHING * scale { 1.0 / pivot.sqrt() } else { 0.0 };
    }
    for k in 0..n {
        for c in 0..columns {
            let sum: f64 = (0..k).map(|j| a[k * n + j] * b[columns * j + c]).sum();
            b[columns * k + c] = (b[columns * k + c] - sum) * inverse[k];
        }
    }
    for k in (0..n).rev() {
        for c in 0..columns {
            let sum: f64 = (k + 1..n).map(|j| a[j * n + k] * b[columns * j + c]).sum();
            b[columns * k + c] = (b[columns * k + c] - sum) * inverse[k];
        }
    }
}

/// Y_S Y_Sᵀ: entries i, j = Σ over the rows y of `rows` (`width` values each, a multiple of eight) of y_i y_j; the lower triangle of the
/// `width` × `width` result, in whole blocks of 4 × 8.
pub(super) fn gram(rows: &[f64], width: usize, out: &mut Vec<f64>) {
    struct Gram<'a>(&'a [f64], usize, &'a mut [f64]);
    impl pulp::WithSimd for Gram<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _: S) {
            let Self(rows, width, out) = self;
            for i in (0..width).step_by(4) {
                for j in (0..=i).step_by(8) {
                    let mut sums = [[0.0; 8]; 4];
                    for row in rows.chunks_exact(width) {
                        let mut right = [0.0; 8];
                        right.copy_from_slice(&row[j..j + 8]);
                        for (sum, left) in sums.iter_mut().zip(&row[i..i + 4]) {
                            (0..8).for_each(|k| sum[k] = left.mul_add(right[k], sum[k]));
                        }
                    }
                    for (r, sum) in sums.iter().enumerate() {
                        out[width * (i + r) + j..][..8].copy_from_slice(sum);
                    }
                }
            }
        }
    }
    out.clear();
    out.resize(width * width, 0.0);
    pulp::Arch::new().dispatch(Gram(rows, width, out));
}

/// Σ_j row_j weights_j for every row of `width` values.
pub(super) fn combine(rows: &[f64], width: usize, weights: &[[f64; 8]], out: &mut [[f64; 8]]) {
    struct Combine<'a>(&'a [f64], usize, &'a [[f64; 8]], &'a mut [[f64; 8]]);
    impl pulp::WithSimd for Combine<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _: S) {
            let Self(rows, width, weights, out) = self;
            for (row, out) in rows.chunks_exact(width).zip(out) {
                let mut sums = [[0.0; 8]; 4];
                for (values, weights) in row.chunks(4).zip(weights.chunks(4)) {
                    for ((value, weight), sum) in values.iter().zip(weights).zip(&mut sums) {
                        (0..8).for_each(|k| sum[k] = value.mul_add(weight[k], sum[k]));
                    }
                }
                *out = std::array::from_fn(|k| sums[0][k] + sums[1][k] + (sums[2][k] + sums[3][k]));
            }
        }
    }
    pulp::Arch::new().dispatch(Combine(rows, width, weights, out));
}

/// Adds `factor` times the product of n × m and m × n matrices to an n × n matrix.
pub(super) fn add_product(n: usize, (left, right): (&[f64], &[f64]), stride: usize, factor: f64, out: &mut [f64]) {
    struct Product<'a>(usize, &'a [f64], &'a [f64], usize, f64, &'a mut [f64]);
    impl pulp::WithSimd for Product<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _: S) {
            let Self(n, left, right, stride, factor, out) = self;
            let inner = left.len() / n;
            for (row, left) in out.chunks_exact_mut(n).zip(left.chunks_exact(inner)) {
                for (left, right) in left.iter().zip(right.chunks_exact(stride)) {
                    let share = factor * left;
                    row.iter_mut().zip(&right[..n]).for_each(|(o, r)| *o = share.mul_add(*r, *o));
                }
            }
        }
    }
    if n > 0 && !left.is_empty() {
        pulp::Arch::new().dispatch(Product(n, left, right, stride, factor, out));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverses_grams_and_semidefinite_solutions_are_those_of_their_definitions() {
        let (n, width) = (13, 16);
        let rows: Vec<f64> = (0..40 * width).map(|i| ((i * i) as f64 * 0.37).sin()).collect();
        let mut all = Vec::new();
        gram(&rows, width, &mut all);
        for i in 0..width {
            for j in 0..=i {
                let sum: f64 = rows.chunks_exact(width).map(|r| r[i] * r[j]).sum();
                assert!((all[width * i + j] - sum).abs() < 1e-12);
            }
        }
        let entry = |i: usize, j: usize| all[width * i.max(j) + i.min(j)];
        let a: Vec<f64> = (0..n * n).map(|m| entry(m / n, m % n)).collect();
        let mut inverse = a.clone();
        assert!(invert(n, &mut inverse, &mut Vec::new(), 1e-6));
        for (i, j) in (0..n * n).map(|m| (m / n, m % n)) {
            let sum: f64 = (0..n).map(|k| a[n * i + k] * inverse[n * k + j]).sum();
            assert!((sum - f64::from(u8::from(i == j))).abs() < 1e-12);
        }
        let (mut product, mut sums) = (vec![1.0; 9], vec![[0.0; 8]; 2]);
        add_product(3, (&rows[..6], &rows[6..14]), 4, 2.0, &mut product);
        let weights: Vec<[f64; 8]> = (0..13).map(|j| std::array::from_fn(|k| (j * k) as f64)).collect();
        combine(&rows[..32], 16, &weights, &mut sums);
        for i in 0..3 {
            for j in 0..3 {
                let sum: f64 = (0..2).map(|m| rows[2 * i + m] * rows[6 + 4 * m + j]).sum();
                assert!((product[3 * i + j] - 1.0 - 2.0 * sum).abs() < 1e-14);
            }
        }
        for (r, sum) in sums.iter().enumerate() {
            for (k, sum) in sum.iter().enumerate() {
                let exact: f64 = (0..13).map(|j| rows[16 * r + j] * (j * k) as f64).sum();
                assert!((sum - exact).abs() < 1e-11);
            }
        }
        // B Bᵀ of rank three.
        let b: Vec<[f64; 3]> = (0..n).map(|i| [1.0, i as f64, (i as f64).cos()]).collect();
        let dot = |i: usize, j: usize| (0..3).map(|k| b[i][k] * b[j][k]).sum::<f64>();
        let low: Vec<f64> = (0..n * n).map(|m| dot(m / n, m % n)).collect();
        assert!(!invert(n, &mut low.clone(), &mut Vec::new(), 1e-6));
        let load: Vec<f64> = (0..2 * n).map(|m| dot(m / 2, m % 2)).collect();
        let mut x = load.clone();
        solve_semidefinite(n, &mut low.clone(), &mut x, 2);
        for (i, k) in (0..2 * n).map(|m| (m / 2, m % 2)) {
            let sum: f64 = (0..n).map(|j| low[n * i + j] * x[2 * j + k]).sum();
            assert!((sum - load[2 * i + k]).abs() < 1e-9 * dot(n - 1, n - 1));
        }
    }
}
