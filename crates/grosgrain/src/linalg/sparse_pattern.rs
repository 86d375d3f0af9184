//! Where a symmetric sparse matrix has entries.

/// The lower triangle (diagonal included) of a symmetric matrix, by columns.
///
/// Column j holds rows `rows[column_starts[j]..column_starts[j + 1]]`, the diagonal first, then ascending.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SparsePattern {
    /// Start of each column in `rows`; one more entry than columns.
    pub column_starts: Vec<u32>,
    /// Row indices.
    pub rows: Vec<u32>,
}

impl SparsePattern {
    /// Number of rows and columns.
    pub fn order(&self) -> usize {
        self.column_starts.len() - 1
    }

    /// Number of stored entries.
    pub fn entry_count(&self) -> usize {
        self.rows.len()
    }

    /// Range of column `j` in `rows` and in the values.
    pub fn column(&self, j: usize) -> std::ops::Range<usize> {
        self.column_starts[j] as usize..self.column_starts[j + 1] as usize
    }

    /// The same entries seen from the other side: the upper triangle by columns, rows ascending.
    pub(super) fn transposed(&self) -> Self {
        let n = self.order();
        let mut column_starts = vec![0u32; n + 1];
        self.rows.iter().for_each(|r| column_starts[*r as usize + 1] += 1);
        (0..n).for_each(|j| column_starts[j + 1] += column_starts[j]);
        let mut next = column_starts.clone();
        let mut rows = vec![0u32; self.rows.len()];
        for j in 0..n {
            for &row in &self.rows[self.column(j)] {
                let slot = &mut next[row as usize];
                rows[*slot as usize] = j as u32;
                *slot += 1;
            }
        }
        Self { column_starts, rows }
    }

    /// y = A x for the symmetric matrix with these `values`.
    pub fn multiply_into(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for j in 0..self.order() {
            let range = self.column(j);
            let mut sum = values[range.start] * x[j];
            for e in range.start + 1..range.end {
                let i = self.rows[e] as usize;
                y[i] += values[e] * x[j];
                sum += values[e] * x[i];
            }
            y[j] += sum;
        }
    }
}
