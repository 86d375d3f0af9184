//! One dense symmetric matrix of which the leading unknowns are eliminated.

use super::front::Elimination;
use super::plan::{STRIP, TILE};

/// The Schur complement of a dense symmetric matrix and what elimination makes of its right-hand sides; buffers are used again.
///
/// With K = [A Bᵀ; B C], A positive semidefinite, and loads [f g] the columns of the boundary become C − B A⁺ Bᵀ, and the extra rows
/// g − f A⁺ Bᵀ. C need not be definite.
#[derive(Debug, Default)]
pub struct DenseFront {
    front: Vec<f64>,
    panel: Vec<f64>,
    inverse: Vec<f64>,
    scale: Vec<f64>,
    pivots: usize,
    boundary: usize,
    extra: usize,
}

impl DenseFront {
    /// An empty front.
    pub fn new() -> Self {
        Self::default()
    }

    /// Starts a matrix of zeros with so many pivots, boundary unknowns and extra rows.
    pub fn reset(&mut self, pivots: usize, boundary: usize, extra: usize) {
        (self.pivots, self.boundary, self.extra) = (pivots, boundary, extra);
        let columns = (self.padded() + boundary).next_multiple_of(STRIP);
        let stride = self.stride();
        self.front.clear();
        self.front.resize(stride * columns, 0.0);
        self.panel.resize(self.panel.len().max(stride * self.padded()), 0.0);
        self.inverse.clear();
        self.inverse.resize(self.padded(), 0.0);
    }

    fn padded(&self) -> usize {
        self.pivots.next_multiple_of(STRIP)
    }

    fn stride(&self) -> usize {
        (self.padded() + self.boundary + self.extra).next_multiple_of(TILE)
    }

    /// The lower part of pivot column `c`: pivots from `c` on, boundary, extra rows.
    pub fn pivot_column(&mut self, c: usize) -> (&mut [f64], &mut [f64], &mut [f64]) {
        let (stride, padded, end) = (self.stride(), self.padded(), self.padded() + self.boundary);
        let column = &mut self.front[stride * c..][..end + self.extra];
        let (column, extra) = column.split_at_mut(end);
        let (pivots, boundary) = column.split_at_mut(padded);
        (&mut pivots[c..self.pivots], boundary, extra)
    }

    /// The lower part of boundary column `c`: boundary unknowns from `c` on, extra rows.
    pub fn boundary_column(&mut self, c: usize) -> (&mut [f64], &mut [f64]) {
        let (stride, padded, boundary) = (self.stride(), self.padded(), self.boundary);
        let column = &mut self.front[stride * (padded + c) + padded..][..boundary + self.extra];
        let (column, extra) = column.split_at_mut(boundary);
        (&mut column[c..], extra)
    }

    /// Eliminates the pivots; returns how many were below `vanishing` of their diagonal and therefore skipped.
    pub fn eliminate(&mut self, vanishing: f64) -> usize {
        let (stride, padded, pivots) = (self.stride(), self.padded(), self.pivots);
        self.scale.clear();
        // The kernel measures against its own threshold, relative to the scale.
        let share = vanishing / super::front::VANISHING;
        self.scale.extend((0..pivots).map(|c| share * self.front[stride * c + c].abs()));
        let mut skipped = 0;
        pulp::Arch::new().dispatch(Elimination {
            front: &mut self.front,
            panel: &mut self.panel,
            stride,
            rows: padded + self.boundary + self.extra,
            pivots,
            padded,
            padded_columns: (padded + self.boundary).next_multiple_of(STRIP),
            scale: &self.scale,
            inverse: &mut self.inverse,
            skipped: &mut skipped,
        });
        skipped
    }
}
