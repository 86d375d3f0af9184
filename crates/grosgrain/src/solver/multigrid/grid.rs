//! How lattices are halved, and where their vectors keep each node.

use crate::mesh::Lattice;

/// Number of nodes whose coefficients lie side by side.
pub(super) const LANES: usize = 8;

/// From a lattice to the next coarser one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coarsening {
    pub fine: Lattice,
    pub coarse: Lattice,
    /// Along which axes two cells become one; the others stay as they are.
    pub halved: [bool; 3],
}

impl Coarsening {
    /// Halves (rounding up) the axes that have more than one cell and whose edge is below 1.5 times the shortest
    /// of these, so that long thin cells become cubes first. Also returns the edges of the coarse cells.
    pub fn new(fine: Lattice, spacing: [f64; 3]) -> (Self, [f64; 3]) {
        let long: [bool; 3] = fine.cells.map(|n| n > 1);
        let shortest = (0..3).filter(|a| long[*a]).fold(f64::INFINITY, |m, a| m.min(spacing[a]));
        let halved = std::array::from_fn(|a| long[a] && spacing[a] < 1.5 * shortest);
        let cells = std::array::from_fn(|a| if halved[a] { fine.cells[a].div_ceil(2) } else { fine.cells[a] });
        let edges = std::array::from_fn(|a| if halved[a] { 2.0 * spacing[a] } else { spacing[a] });
        (Self { fine, coarse: Lattice::new(cells), halved }, edges)
    }

    /// Coarse nodes along an axis to which a fine one interpolates, with weights; the second may be absent.
    pub fn parents(&self, axis: usize, fine: usize) -> [(usize, f64); 2] {
        match self.halved[axis] {
            false => [(fine, 1.0), (fine, 0.0)],
            true if fine.is_multiple_of(2) => [(fine / 2, 1.0), (fine / 2, 0.0)],
            true => [(fine / 2, 0.5), (fine / 2 + 1, 0.5)],
        }
    }

    /// Fine nodes along an axis that a coarse one interpolates to, with weights; weight 0 where there is none.
    pub fn children(&self, axis: usize, coarse: usize) -> [(usize, f64); 3] {
        let last = self.fine.cells[axis];
        if !self.halved[axis] {
            return [(coarse, 1.0), (coarse, 0.0), (coarse, 0.0)];
        }
        let centre = 2 * coarse;
        let at = |n: usize, weight: f64| if n <= last { (n, weight) } else { (last, 0.0) };
        let left = if centre == 0 { (0, 0.0) } else { at(centre - 1, 0.5) };
        [left, at(centre, 1.0), at(centre + 1, 0.5)]
    }

    /// Trilinear weights p[f][c] from corner c of a coarse cell to corner f of its child at `octant` (x fastest bits).
    pub fn weights(&self, octant: usize) -> [[f64; 8]; 8] {
        let axis_weight = |axis: usize, f: usize, c: usize| {
            let (corner, far) = (f >> axis & 1, c >> axis & 1 == 1);
            let at = if self.halved[axis] { 0.5 * ((octant >> axis & 1) + corner) as f64 } else { corner as f64 };
            if far { at } else { 1.0 - at }
        };
        std::array::from_fn(|f| std::array::from_fn(|c| (0..3).map(|a| axis_weight(a, f, c)).product()))
    }

    /// The fine cells that make up a coarse cell, as (octant, fine cell index).
    pub fn child_cells(&self, coarse: [usize; 3]) -> impl Iterator<Item = (usize, usize)> + use<> {
        let Self { fine, halved, .. } = *self;
        (0..8).filter_map(move |octant: usize| {
            let at = std::array::from_fn(|a| {
                let bit = octant >> a & 1;
                if halved[a] { 2 * coarse[a] + bit } else { coarse[a] + bit * fine.cells[a] }
            });
            (0..3).all(|a| at[a] < fine.cells[a]).then(|| (octant, fine.cell(at).0))
        })
    }
}

/// Where a vector keeps component r of node (i, j, k): `origin + r·component + i·strides[0] + j·strides[1] +
/// (k + ghost)·strides[2]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    pub nodes: [usize; 3],
    pub origin: usize,
    pub component: usize,
    pub strides: [usize; 3],
    /// Layers of zeros before the first and after the last layer of nodes.
    pub ghost: usize,
}

impl Layout {
    /// Component fastest, no ghosts: the layout of vectors outside this module.
    pub fn interleaved(lattice: Lattice) -> Self {
        let nodes @ [nx, ny, _] = lattice.nodes();
        Self { nodes, origin: 0, component: 1, strides: [3, 3 * nx, 3 * nx * ny], ghost: 0 }
    }

    /// Nodes without an order in space, component fastest.
    pub fn list(nodes: usize) -> Self {
        Self { nodes: [nodes, 1, 1], origin: 0, component: 1, strides: [3, 3 * nodes, 3 * nodes], ghost: 0 }
    }

    /// A row of x, then of y, then of z components, with a frame of zeros, rows filled up to whole lanes.
    pub fn rows(lattice: Lattice) -> Self {
        let nodes @ [nx, ny, _] = lattice.nodes();
        let length = nx.next_multiple_of(LANES) + 2;
        let strides = [1, 3 * length, 3 * length * (ny + 2)];
        Self { nodes, origin: 1 + strides[1], component: length, strides, ghost: 1 }
    }

    /// Number of entries of a vector.
    pub fn length(&self) -> usize {
        self.strides[2] * (self.nodes[2] + 2 * self.ghost)
    }

    /// Index of component 0 of node (i, j, k).
    pub fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        self.origin + i * self.strides[0] + j * self.strides[1] + (k + self.ghost) * self.strides[2]
    }
}
