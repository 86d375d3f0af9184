//! Sums over long vectors whose rounding does not depend on the number of threads.
//!
//! A range is halved at multiples of a fixed block length until one block is left; the tree of
//! additions is a function of the length alone, and its branches run in parallel.

/// Length of the blocks that are summed without branching.
const BLOCK: usize = 4096;

/// Σ xᵢ yᵢ.
///
/// The two slices must have the same length; what exceeds the shorter one is left out.
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    let [sum] = sum_of_blocks(x.len().min(y.len()), &|from, to| [dot_of_block(&x[from..to], &y[from..to])]);
    sum
}

/// √(Σ xᵢ²).
pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// Σ over the blocks of `0..length` of the N sums `block(from, to)`, added in a fixed order.
pub fn sum_of_blocks<const N: usize>(length: usize, block: &(dyn Fn(usize, usize) -> [f64; N] + Sync)) -> [f64; N] {
    branch(0, length, block)
}

fn branch<const N: usize>(from: usize, to: usize, block: &(dyn Fn(usize, usize) -> [f64; N] + Sync)) -> [f64; N] {
    let blocks = (to - from).div_ceil(BLOCK);
    if blocks <= 1 {
        return if from == to { [0.0; N] } else { block(from, to) };
    }
    let middle = from + blocks / 2 * BLOCK;
    let (left, right) = rayon::join(|| branch(from, middle, block), || branch(middle, to, block));
    std::array::from_fn(|i| left[i] + right[i])
}

/// x += α p and r −= α q in one pass; returns Σ rᵢ² of the new r.
pub fn step(alpha: f64, [p, q]: [&[f64]; 2], [x, r]: [&mut [f64]; 2]) -> f64 {
    let blocks = x.len().div_ceil(BLOCK);
    if blocks <= 1 {
        for i in 0..x.len() {
            x[i] += alpha * p[i];
            r[i] -= alpha * q[i];
        }
        return dot_of_block(r, r);
    }
    let middle = blocks / 2 * BLOCK;
    let (p0, p1) = p.split_at(middle);
    let (q0, q1) = q.split_at(middle);
    let (x0, x1) = x.split_at_mut(middle);
    let (r0, r1) = r.split_at_mut(middle);
    let (left, right) = rayon::join(|| step(alpha, [p0, q0], [x0, r0]), || step(alpha, [p1, q1], [x1, r1]));
    left + right
}

fn dot_of_block(x: &[f64], y: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (xs, x_rest) = x.as_chunks::<8>();
    let (ys, y_rest) = y.as_chunks::<8>();
    for (a, b) in xs.iter().zip(ys) {
        for l in 0..8 {
            lanes[l] += a[l] * b[l];
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(a, b)| a * b).sum();
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waves(n: usize, frequency: f64) -> Vec<f64> {
        (0..n).map(|i| (frequency * i as f64).sin()).collect()
    }

    fn in_pool<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
    }

    #[test]
    fn dot_products_have_the_same_bits_with_any_number_of_threads() {
        let (x, y) = (waves(100_003, 0.7), waves(100_003, 1.3));
        let bits = [1, 2, 5].map(|threads| in_pool(threads, || dot(&x, &y)).to_bits());
        assert_eq!(bits, [bits[0]; 3]);
    }

    #[test]
    fn a_dot_product_equals_the_plain_sum_to_rounding() {
        for n in [0, 1, 7, 8, 9, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 5] {
            let (x, y) = (waves(n, 0.7), waves(n, 1.3));
            let plain: f64 = x.iter().zip(&y).map(|(a, b)| a * b).sum();
            let bound = f64::EPSILON * (n * n) as f64;
            assert!((dot(&x, &y) - plain).abs() <= bound, "{n}: {} against {plain}", dot(&x, &y));
        }
    }

    #[test]
    fn a_step_updates_both_vectors_and_returns_the_square_of_the_second() {
        let n = 2 * BLOCK + 11;
        let (p, q, mut x, mut r) = (waves(n, 0.1), waves(n, 0.2), waves(n, 0.3), waves(n, 0.4));
        let expected: Vec<f64> = (0..n).map(|i| r[i] - 0.25 * q[i]).collect();
        let square = step(0.25, [&p, &q], [&mut x, &mut r]);
        assert_eq!(r, expected);
        let before = waves(n, 0.3);
        assert!((0..n).all(|i| x[i] == before[i] + 0.25 * p[i]));
        assert_eq!(square, dot(&r, &r));
    }
}
