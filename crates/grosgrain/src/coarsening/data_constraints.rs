//! The part of the constraints that the training data of a cell add to the geometric ones.

use super::{COLUMNS, FIELDS};

/// Training fields whose corner values depend on the others', relative to their own size, up to this are dropped.
pub const RANK_TOLERANCE: f64 = 1e-9;

/// Data constraints of one cell, made orthogonal to the rigid motions of its corners.
///
/// With D (6×24) the corner values of the training fields and Q (6×24) orthonormal rigid motions of the corners, the
/// rows D' = D − (D Qᵀ) Q have the pseudo-inverse P, D' Pᵀ = I; fields that depend on others are dropped (P row zero).
#[derive(Clone, Debug, PartialEq)]
pub struct DataConstraints {
    /// D', one row per field.
    pub corners: [[f64; COLUMNS]; FIELDS],
    /// Rows of the pseudo-inverse: Pᵀ = D'⁺.
    pub inverse: [[f64; COLUMNS]; FIELDS],
    /// Translation and rotation (about the cell's centre) of each field: what D − D' is at the corners.
    pub rigid: [[f64; 6]; FIELDS],
    /// Number of fields kept.
    pub rank: usize,
    /// Ratio of the largest to the smallest pivot kept, the rows scaled to unit length.
    pub condition: f64,
}

impl DataConstraints {
    /// Constraints of the corner values `corners` (one row per field) of a cell with corner offsets `offsets` from its centre.
    pub fn new(mut corners: [[f64; COLUMNS]; FIELDS], offsets: &[[f64; 3]; 8]) -> Self {
        let rigid = corners.each_mut().map(|row| remove_rigid(row, offsets));
        let mut this = Self { corners, inverse: [[0.0; COLUMNS]; FIELDS], rigid, rank: 0, condition: 1.0 };
        this.invert();
        this
    }

    /// Pivoted Gram–Schmidt on the rows (each orthogonalised twice), then back substitution P = L⁻ᵀ Q̂ with D' = L Q̂.
    fn invert(&mut self) {
        let scale = self.corners.map(|row| dot(&row, &row).sqrt());
        let mut rows: [[f64; COLUMNS]; FIELDS] = std::array::from_fn(|k| match scale[k] {
            0.0 => [0.0; COLUMNS],
            s => self.corners[k].map(|v| v / s),
        });
        let mut lower = [[0.0; FIELDS]; FIELDS];
        let mut order: [usize; FIELDS] = std::array::from_fn(|k| k);
        let mut pivots = [0.0f64; FIELDS];
        for m in 0..FIELDS {
            let (best, pivot) = largest_row(&rows, &order, m);
            if pivot <= RANK_TOLERANCE {
                break;
            }
            order.swap(m, best);
            rows[order[m]].iter_mut().for_each(|v| *v /= pivot);
            lower[order[m]][m] = pivot;
            pivots[m] = pivot;
            self.rank = m + 1;
            let unit = rows[order[m]];
            for &k in &order[m + 1..] {
                for _ in 0..2 {
                    let overlap = dot(&rows[k], &unit);
                    lower[k][m] += overlap;
                    (0..COLUMNS).for_each(|c| rows[k][c] -= overlap * unit[c]);
                }
            }
        }
        if self.rank > 0 {
            self.condition = pivots[0] / pivots[self.rank - 1];
        }
        for m in (0..self.rank).rev() {
            let mut row = rows[order[m]];
            for n in m + 1..self.rank {
                let factor = lower[order[n]][m];
                (0..COLUMNS).for_each(|c| row[c] -= factor * self.inverse[order[n]][c]);
            }
            self.inverse[order[m]] = row.map(|v| v / lower[order[m]][m]);
        }
        (0..FIELDS).filter(|&k| scale[k] > 0.0).for_each(|k| self.inverse[k].iter_mut().for_each(|v| *v /= scale[k]));
    }
}

fn largest_row(rows: &[[f64; COLUMNS]; FIELDS], order: &[usize; FIELDS], from: usize) -> (usize, f64) {
    let mut best = (from, 0.0);
    for (position, &k) in order.iter().enumerate().skip(from) {
        let length = dot(&rows[k], &rows[k]).sqrt();
        if length > best.1 {
            best = (position, length);
        }
    }
    best
}

fn dot(a: &[f64; COLUMNS], b: &[f64; COLUMNS]) -> f64 {
    (0..COLUMNS).map(|c| a[c] * b[c]).sum()
}

/// Removes translation t and rotation ω × r from corner values; returns (t, ω). On a box the six motions are orthogonal.
fn remove_rigid(row: &mut [f64; COLUMNS], offsets: &[[f64; 3]; 8]) -> [f64; 6] {
    let mut motion = [0.0; 6];
    let mut inertia = [0.0; 3];
    for (i, r) in offsets.iter().enumerate() {
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            motion[a] += row[3 * i + a] / 8.0;
            motion[3 + a] += r[b] * row[3 * i + c] - r[c] * row[3 * i + b];
            inertia[a] += r[b] * r[b] + r[c] * r[c];
        }
    }
    (0..3).for_each(|a| motion[3 + a] /= inertia[a]);
    for (i, r) in offsets.iter().enumerate() {
        let rigid = rigid_displacement(&motion, r);
        (0..3).for_each(|a| row[3 * i + a] -= rigid[a]);
    }
    motion
}

/// t + ω × r.
pub(super) fn rigid_displacement(motion: &[f64; 6], r: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        motion[a] + motion[3 + b] * r[c] - motion[3 + c] * r[b]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offsets() -> [[f64; 3]; 8] {
        std::array::from_fn(|i| [(i & 1) as f64 - 0.5, 2.0 * (i >> 1 & 1) as f64 - 1.0, 0.5 * (i >> 2) as f64 - 0.25])
    }

    fn sample(k: usize, c: usize) -> f64 {
        ((7 * k + 3) as f64 * (c + 1) as f64 * 0.37).sin() * 10f64.powi(k as i32 - 3)
    }

    #[test]
    fn the_inverse_inverts_and_is_orthogonal_to_rigid_motions() {
        let rows = std::array::from_fn(|k| std::array::from_fn(|c| sample(k, c)));
        let data = DataConstraints::new(rows, &offsets());
        assert_eq!(data.rank, FIELDS);
        for (k, m) in (0..36).map(|n| (n / 6, n % 6)) {
            let product = dot(&data.corners[k], &data.inverse[m]);
            let scale = (dot(&data.corners[k], &data.corners[k]) * dot(&data.inverse[m], &data.inverse[m])).sqrt();
            let exact = f64::from(u8::from(k == m));
            assert!((product - exact).abs() < 1e-14 * scale.max(1.0), "({k}, {m}): {product}");
        }
        for motion in 0..6 {
            let unit = std::array::from_fn(|m| f64::from(u8::from(m == motion)));
            let rigid: [f64; COLUMNS] = std::array::from_fn(|c| rigid_displacement(&unit, &offsets()[c / 3])[c % 3]);
            for k in 0..FIELDS {
                let size = dot(&data.inverse[k], &data.inverse[k]).sqrt();
                assert!(dot(&data.inverse[k], &rigid).abs() < 1e-13 * size);
            }
        }
    }

    #[test]
    fn dependent_fields_are_dropped_and_nothing_becomes_nan() {
        let rows = std::array::from_fn(|k| std::array::from_fn(|c| if k == 5 { 0.0 } else { sample(k % 3, c) }));
        let data = DataConstraints::new(rows, &offsets());
        assert_eq!(data.rank, 3);
        assert!(data.inverse.iter().flatten().all(|v| v.is_finite()));
    }
}
