//! The deformed body as voxels again.

use super::{Cell, VoxelGrid};
use crate::mesh::Lattice;

/// Newton steps for the material point at a voxel's centre; the map of a cell is nearly affine.
const NEWTON_STEPS: usize = 12;
/// A centre counts as inside a deformed cell up to this in its unit coordinates.
const MARGIN: f64 = 1e-9;
/// Voxels of the result may be at most this many times those of the body.
const LARGEST_GROWTH: usize = 64;

/// Which cell of the body lies at each voxel of a lattice that holds the deformed body.
#[derive(Clone, Debug, PartialEq)]
pub struct WarpedBody {
    /// The lattice of the result, with the body's spacing.
    pub lattice: Lattice,
    /// Position of its first cell in cells of the body's lattice; negative where the body has moved out of its box.
    pub offset: [isize; 3],
    /// The cell whose deformed shape holds the voxel's centre, x fastest; the first where cells overlap.
    pub cells: Vec<Option<Cell>>,
}

/// Resamples the body deformed by `displacement` (3 entries per lattice node \[m\]) on voxels of the same spacing.
///
/// A voxel belongs to the solid cell whose trilinear image X + u(X) holds its centre. `None` when the deformed body would need
/// more than 64 times the body's voxels.
pub fn warp(grid: &VoxelGrid, displacement: &[f64]) -> Option<WarpedBody> {
    let (low, high) = bounds(grid, displacement)?;
    let count = (0..3).try_fold(1usize, |n, a| n.checked_mul(usize::try_from(high[a] - low[a]).ok()?))?;
    if count > LARGEST_GROWTH.checked_mul(grid.lattice.cell_count())? {
        return None;
    }
    let lattice = Lattice::new(std::array::from_fn(|a| (high[a] - low[a]) as usize));
    let mut result = WarpedBody { lattice, offset: low, cells: vec![None; count] };
    for cell in (0..grid.lattice.cell_count()).map(Cell).filter(|c| !grid.void[c.0]) {
        result.fill(cell, &corner_positions(grid, cell, displacement));
    }
    Some(result)
}

/// Corners of a deformed cell in cells of the body's lattice.
fn corner_positions(grid: &VoxelGrid, cell: Cell, displacement: &[f64]) -> [[f64; 3]; 8] {
    grid.lattice.corners(cell).map(|node| {
        let at = grid.lattice.node_position(node);
        std::array::from_fn(|a| at[a] as f64 + displacement[3 * node.0 + a] / grid.spacing[a])
    })
}

fn bounds(grid: &VoxelGrid, displacement: &[f64]) -> Option<([isize; 3], [isize; 3])> {
    let (mut low, mut high) = ([isize::MAX; 3], [isize::MIN; 3]);
    for cell in (0..grid.lattice.cell_count()).map(Cell).filter(|c| !grid.void[c.0]) {
        for corner in corner_positions(grid, cell, displacement) {
            for a in 0..3 {
                if corner[a].is_nan() || corner[a].abs() >= 1e9 {
                    return None;
                }
                low[a] = low[a].min(corner[a].floor() as isize);
                high[a] = high[a].max(corner[a].ceil() as isize);
            }
        }
    }
    (low[0] < high[0]).then_some((low, high))
}

impl WarpedBody {
    fn fill(&mut self, cell: Cell, corners: &[[f64; 3]; 8]) {
        let extent = |a: usize| {
            let (low, high) = corners.iter().fold((f64::MAX, f64::MIN), |(l, h), c| (l.min(c[a]), h.max(c[a])));
            let first = (low - 0.5).ceil() as isize - self.offset[a];
            let last = (high - 0.5).floor() as isize - self.offset[a];
            first.max(0) as usize..(last + 1).clamp(0, self.lattice.cells[a] as isize) as usize
        };
        let (x, y, z) = (extent(0), extent(1), extent(2));
        for (k, j) in z.flat_map(|k| y.clone().map(move |j| (k, j))) {
            for i in x.clone() {
                let at = [i, j, k];
                let centre = std::array::from_fn(|a| (at[a] as isize + self.offset[a]) as f64 + 0.5);
                let voxel = self.lattice.cell(at).0;
                if self.cells[voxel].is_none() && holds(corners, centre) {
                    self.cells[voxel] = Some(cell);
                }
            }
        }
    }
}

/// Whether the trilinear image of the unit cube with these corners holds a point: Newton's method for ξ.
fn holds(corners: &[[f64; 3]; 8], point: [f64; 3]) -> bool {
    let mut xi = [0.5; 3];
    for _ in 0..NEWTON_STEPS {
        let (position, jacobian) = image(corners, xi);
        let residual: [f64; 3] = std::array::from_fn(|a| point[a] - position[a]);
        let Some(step) = solve(&jacobian, residual) else { return false };
        (0..3).for_each(|a| xi[a] = (xi[a] + step[a]).clamp(-1.0, 2.0));
        if step.iter().all(|s| s.abs() < 1e-12) {
            break;
        }
    }
    let (position, _) = image(corners, xi);
    let found = (0..3).all(|a| (position[a] - point[a]).abs() < 1e-6);
    found && xi.iter().all(|x| (-MARGIN..=1.0 + MARGIN).contains(x))
}

/// Position and its derivatives by ξ: `jacobian[a][b]` = ∂x_a/∂ξ_b.
fn image(corners: &[[f64; 3]; 8], xi: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let weight = |corner: usize, axis: usize| if corner >> axis & 1 == 1 { xi[axis] } else { 1.0 - xi[axis] };
    let (mut position, mut jacobian) = ([0.0; 3], [[0.0; 3]; 3]);
    for (i, corner) in corners.iter().enumerate() {
        let w: [f64; 3] = std::array::from_fn(|a| weight(i, a));
        for a in 0..3 {
            position[a] += w[0] * w[1] * w[2] * corner[a];
            for b in 0..3 {
                let sign = if i >> b & 1 == 1 { 1.0 } else { -1.0 };
                jacobian[a][b] += sign * w[(b + 1) % 3] * w[(b + 2) % 3] * corner[a];
            }
        }
    }
    (position, jacobian)
}

/// Cramer's rule.
fn solve(m: &[[f64; 3]; 3], b: [f64; 3]) -> Option<[f64; 3]> {
    let determinant = |m: &[[f64; 3]; 3]| -> f64 {
        (0..3).map(|i| m[0][i] * (m[1][(i + 1) % 3] * m[2][(i + 2) % 3] - m[1][(i + 2) % 3] * m[2][(i + 1) % 3])).sum()
    };
    let whole = determinant(m);
    (whole.abs() > 1e-12).then(|| {
        std::array::from_fn(|column| {
            let replaced =
                std::array::from_fn(|row| std::array::from_fn(|c| if c == column { b[row] } else { m[row][c] }));
            determinant(&replaced) / whole
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Label, Node};

    fn body() -> VoxelGrid {
        let mut grid = VoxelGrid::uniform([4, 3, 2], [0.1, 0.2, 0.3], Label(1));
        grid.void[5] = true;
        grid
    }

    #[test]
    fn no_displacement_gives_the_body_back() {
        let grid = body();
        let warped = warp(&grid, &vec![0.0; 3 * grid.lattice.node_count()]).unwrap();
        assert_eq!((warped.offset, warped.lattice), ([0; 3], grid.lattice));
        for (c, found) in warped.cells.iter().enumerate() {
            assert_eq!(*found, (!grid.void[c]).then_some(Cell(c)));
        }
    }

    #[test]
    fn a_shift_by_whole_cells_shifts_the_voxels() {
        let grid = body();
        let u: Vec<f64> = (0..3 * grid.lattice.node_count()).map(|i| [-0.2, 0.4, 0.0][i % 3]).collect();
        let warped = warp(&grid, &u).unwrap();
        assert_eq!((warped.offset, warped.lattice), ([-2, 2, 0], grid.lattice));
        assert_eq!(warped.cells.iter().filter(|c| c.is_some()).count(), grid.solid_count());
    }

    #[test]
    fn a_stretched_body_keeps_its_stretched_volume() {
        let grid = VoxelGrid::uniform([4; 3], [1.0; 3], Label(1));
        let stretch = |n: usize| grid.lattice.node_position(Node(n))[0] as f64;
        let u: Vec<f64> =
            (0..3 * grid.lattice.node_count()).map(|i| if i % 3 == 0 { stretch(i / 3) } else { 0.0 }).collect();
        let warped = warp(&grid, &u).unwrap();
        assert_eq!(warped.lattice.cells, [8, 4, 4]);
        assert!(warped.cells.iter().all(|c| c.is_some()));
    }

    #[test]
    fn a_displacement_that_is_not_finite_or_too_large_is_refused() {
        let grid = body();
        let mut u = vec![0.0; 3 * grid.lattice.node_count()];
        u[0] = f64::NAN;
        assert_eq!(warp(&grid, &u), None);
        u[0] = 1e6;
        assert_eq!(warp(&grid, &u), None);
    }
}
