//! Bars along the axes of a lattice, crossing each other in a grid.

use super::Lattice;

/// A grid of bars along the axes, inside a box of cells.
///
/// With a, b, c counted from the low corner of the box, a cell of the box is in a bar if at least two of a mod p₀, b mod p₁ and c mod p₂
/// are less than the width: a bar along x is where b and c are. A period not larger than the width makes no gaps along that axis:
/// with periods \[4, 4, 1\] and width 1 the bars along x and y become ribs as high as the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bars {
    /// Distance from one bar to the next along x, y, z, in cells.
    pub period: [usize; 3],
    /// Thickness of a bar in cells.
    pub width: usize,
    /// First cell of the box, and the one after its last; all of the lattice if `None`.
    pub extent: Option<[[usize; 3]; 2]>,
}

impl Bars {
    /// The box on a lattice; `None` if it holds no cell or reaches beyond the lattice.
    pub(super) fn extent_on(&self, lattice: &Lattice) -> Option<[[usize; 3]; 2]> {
        let [low, high] = self.extent.unwrap_or([[0; 3], lattice.cells]);
        (0..3).all(|a| low[a] < high[a] && high[a] <= lattice.cells[a]).then_some([low, high])
    }

    /// Whether a cell of the lattice is in a bar of the box.
    pub(super) fn contain(&self, [low, high]: [[usize; 3]; 2], at: [usize; 3]) -> bool {
        let within = (0..3).all(|a| low[a] <= at[a] && at[a] < high[a]);
        within && (0..3).filter(|&a| (at[a] - low[a]) % self.period[a] < self.width).count() >= 2
    }
}
