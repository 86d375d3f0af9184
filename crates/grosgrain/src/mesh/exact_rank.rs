//! Ranks and null spaces of integer matrices without a tolerance.

/// Arithmetic modulo the Mersenne prime 2⁶¹ − 1.
const P: u64 = (1 << 61) - 1;

fn multiply(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    reduce((product as u64 & P) + (product >> 61) as u64)
}

fn reduce(a: u64) -> u64 {
    if a >= P { a - P } else { a }
}

pub(super) fn negate(a: u64) -> u64 {
    reduce(P - a)
}

/// a⁻¹ = a^(P−2) for a ≠ 0.
fn invert(a: u64) -> u64 {
    (0..61).rev().fold(1, |power, bit| {
        let square = multiply(power, power);
        if (P - 2) >> bit & 1 == 1 { multiply(square, a) } else { square }
    })
}

/// The span of rows of whole numbers, in reduced echelon form modulo 2⁶¹ − 1.
///
/// The rank modulo a prime is at most the true one and equal to it unless the prime divides every minor of that
/// order. For the three translations and three rotations of a rigid part on a lattice of up to 10⁵ cells an axis
/// every minor is smaller than the prime, so there the rank is exact.
#[derive(Clone, Debug)]
pub(super) struct RowSpan {
    columns: usize,
    /// For every column the row that has its leading 1 there.
    rows: Vec<Option<Vec<u64>>>,
    rank: usize,
}

impl RowSpan {
    pub(super) fn new(columns: usize) -> Self {
        Self { columns, rows: vec![None; columns], rank: 0 }
    }

    pub(super) fn rank(&self) -> usize {
        self.rank
    }

    /// Basis of the span: rows modulo the prime, to be inserted into another span.
    pub(super) fn basis(&self) -> impl Iterator<Item = &[u64]> {
        self.rows.iter().flatten().map(Vec::as_slice)
    }

    /// Adds a row of whole numbers.
    pub(super) fn insert_whole(&mut self, row: &[i64]) {
        self.insert(row.iter().map(|v| v.rem_euclid(P as i64) as u64).collect());
    }

    /// Adds a row given modulo the prime.
    pub(super) fn insert(&mut self, mut row: Vec<u64>) {
        for (column, pivot) in self.rows.iter().enumerate() {
            if let Some(pivot) = pivot {
                eliminate(&mut row, pivot, column);
            }
        }
        let Some(lead) = row.iter().position(|v| *v != 0) else { return };
        let scale = invert(row[lead]);
        row.iter_mut().for_each(|v| *v = multiply(*v, scale));
        self.rows.iter_mut().flatten().for_each(|other| eliminate(other, &row, lead));
        self.rows[lead] = Some(row);
        self.rank += 1;
    }

    /// Basis of the vectors that every row annihilates, modulo the prime.
    pub(super) fn null_space(&self) -> Vec<Vec<u64>> {
        let free = (0..self.columns).filter(|c| self.rows[*c].is_none());
        let vector = |f: usize| {
            let entry = |c: usize| self.rows[c].as_ref().map_or(u64::from(c == f), |row| negate(row[f]));
            (0..self.columns).map(entry).collect()
        };
        free.map(vector).collect()
    }
}

/// Takes the multiple of `pivot`, which leads with 1 at `column`, from `row` that makes it vanish there.
fn eliminate(row: &mut [u64], pivot: &[u64], column: usize) {
    if row[column] == 0 {
        return;
    }
    let factor = negate(row[column]);
    for (v, p) in row[column..].iter_mut().zip(&pivot[column..]).filter(|(_, p)| **p != 0) {
        *v = reduce(*v + multiply(factor, *p));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn inverses_invert(a in 1..P) {
            prop_assert_eq!(multiply(a, invert(a)), 1);
            prop_assert_eq!(reduce(a + negate(a)), 0);
        }

        #[test]
        fn a_product_of_random_factors_has_the_rank_of_the_narrow_one_and_a_null_space(
            left in prop::collection::vec(-9..10i64, 30), right in prop::collection::vec(-9..10i64, 21)
        ) {
            // 10 × 3 times 3 × 7.
            let product = |i: usize, j: usize| (0..3).map(|k| left[3 * i + k] * right[7 * k + j]).sum::<i64>();
            let span = |rows: Vec<Vec<i64>>, columns| {
                let mut span = RowSpan::new(columns);
                rows.iter().for_each(|row| span.insert_whole(row));
                span
            };
            let all = span((0..10).map(|i| (0..7).map(|j| product(i, j)).collect()).collect(), 7);
            let narrow = span((0..10).map(|i| left[3 * i..3 * i + 3].to_vec()).collect(), 3);
            let wide = span((0..3).map(|k| right[7 * k..7 * k + 7].to_vec()).collect(), 7);
            prop_assert!(all.rank() <= narrow.rank().min(wide.rank()));
            prop_assert!(all.rank() + 3 >= narrow.rank() + wide.rank(), "Sylvester's inequality");
            let null = all.null_space();
            prop_assert_eq!(null.len(), 7 - all.rank());
            for row in all.basis() {
                for vector in &null {
                    let dot = row.iter().zip(vector).fold(0, |sum, (a, b)| reduce(sum + multiply(*a, *b)));
                    prop_assert_eq!(dot, 0);
                }
            }
        }
    }
}
