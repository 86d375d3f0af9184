//! The deformed body as voxels again.

use super::{Cell, VoxelGrid};
use crate::mesh::Lattice;
use rayon::prelude::*;
use std::ops::Range;

/// Newton steps for the material point at a voxel's centre; the map of a cell is nearly affine.
const NEWTON_STEPS: usize = 12;
/// A centre counts as inside a deformed cell up to this in its unit coordinates.
const MARGIN: f64 = 1e-9;
/// The box of the result may be at most this many times that of the body.
const LARGEST_GROWTH: f64 = 64.0;
/// Corners this close to a face between voxels lie on it; no centre is lost.
const ROUNDING: f64 = 1e-6;
/// Layers of voxels that are worked on together.
const SLAB: usize = 8;

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
///
/// ```
/// use grosgrain::mesh::{Label, VoxelGrid, warp};
/// let grid = VoxelGrid::uniform([3, 2, 2], [0.1; 3], Label(1));
/// let moved: Vec<f64> = (0..3 * grid.lattice.node_count()).map(|i| if i % 3 == 0 { 0.2 } else { 0.0 }).collect();
/// assert_eq!(warp(&grid, &moved).map(|warped| warped.offset), Some([2, 0, 0]));
/// ```
pub fn warp(grid: &VoxelGrid, displacement: &[f64]) -> Option<WarpedBody> {
    let included: Vec<bool> = grid.void.iter().map(|void| !void).collect();
    let target = WarpTarget { spacing: grid.spacing, included: &included };
    let Warped { lattice, offset, values } = warp_onto(grid, displacement, &target, |point| Some(point.cell))?;
    Some(WarpedBody { lattice, offset, cells: values })
}

/// The voxels that a deformed body is resampled on, and what of it.
#[derive(Clone, Copy, Debug)]
pub struct WarpTarget<'a> {
    /// Edges of a voxel \[m\]; voxel (i, j, k) of the undeformed frame has its centre at the origin + (i + ½) times these.
    pub spacing: [f64; 3],
    /// Which cells count, one entry per cell of the body's lattice.
    pub included: &'a [bool],
}

/// A point of the undeformed body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialPoint {
    /// The cell it is in.
    pub cell: Cell,
    /// Its position from the lattice's first node \[m\].
    pub position: [f64; 3],
}

/// A value per voxel of the deformed body.
#[derive(Clone, Debug, PartialEq)]
pub struct Warped<T> {
    /// The voxels.
    pub lattice: Lattice,
    /// Position of the first voxel in voxels from the body's first node; negative where the body has moved out of its box.
    pub offset: [isize; 3],
    /// One value per voxel, x fastest; the default where there is no body.
    pub values: Vec<T>,
}

/// What `value` says of the material point at each voxel's centre, x = X + u(X) with u trilinear in each cell.
///
/// Where cells overlap the first of them counts. Layers of voxels are worked on at the same time; the result does not
/// depend on the number of threads. `None` when the deformed body would need more than 64 times the voxels of the
/// undeformed one, or a displacement is not finite.
pub fn warp_onto<T: Clone + Default + Send + Sync>(
    grid: &VoxelGrid,
    displacement: &[f64],
    target: &WarpTarget,
    value: impl Fn(MaterialPoint) -> T + Sync,
) -> Option<Warped<T>> {
    let body = DeformedCells { grid, displacement, target };
    let rows = body.row_bounds()?;
    let (low, high) = bounds(&rows)?;
    let count = (0..3).try_fold(1usize, |n, a| n.checked_mul(usize::try_from(high[a] - low[a]).ok()?))?;
    let ratio: f64 = (0..3).map(|a| grid.spacing[a] / target.spacing[a]).product();
    if count as f64 > LARGEST_GROWTH * ratio * grid.lattice.cell_count() as f64 {
        return None;
    }
    let lattice = Lattice::new(std::array::from_fn(|a| (high[a] - low[a]) as usize));
    let mut values = vec![T::default(); count];
    let slab = lattice.cells[0] * lattice.cells[1] * SLAB;
    values.par_chunks_mut(slab).enumerate().for_each(|(number, values)| {
        let layer = lattice.cells[0] * lattice.cells[1];
        let size = [lattice.cells[0], lattice.cells[1], values.len() / layer];
        let low = [low[0], low[1], low[2] + (number * SLAB) as isize];
        Slab { low, size, taken: vec![false; values.len()], values }.fill(&body, &rows, &value);
    });
    Some(Warped { lattice, offset: low, values })
}

/// The included cells of a body in their deformed places.
struct DeformedCells<'a> {
    grid: &'a VoxelGrid,
    displacement: &'a [f64],
    target: &'a WarpTarget<'a>,
}

/// A box in voxels.
type Bounds = ([f64; 3], [f64; 3]);

impl DeformedCells<'_> {
    /// Corners of a deformed cell in voxels of the target.
    fn corners(&self, cell: Cell) -> [[f64; 3]; 8] {
        self.grid.lattice.corners(cell).map(|node| {
            let at = self.grid.lattice.node_position(node);
            let place = |a: usize| at[a] as f64 * self.grid.spacing[a] + self.displacement[3 * node.0 + a];
            std::array::from_fn(|a| place(a) / self.target.spacing[a])
        })
    }

    /// Included cells of a row along x.
    fn row(&self, row: usize) -> impl Iterator<Item = Cell> {
        let length = self.grid.lattice.cells[0];
        (row * length..(row + 1) * length).map(Cell).filter(|cell| self.target.included[cell.0])
    }

    /// The box around each row of cells along x; `None` if a corner has no place.
    fn row_bounds(&self) -> Option<Vec<Bounds>> {
        let [_, ny, nz] = self.grid.lattice.cells;
        let of_row = |row: usize| {
            let mut bounds = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
            for corner in self.row(row).flat_map(|cell| self.corners(cell)) {
                if corner.iter().any(|x| x.is_nan() || x.abs() >= 1e9) {
                    return None;
                }
                (0..3).for_each(|a| bounds.0[a] = bounds.0[a].min(corner[a]));
                (0..3).for_each(|a| bounds.1[a] = bounds.1[a].max(corner[a]));
            }
            Some(bounds)
        };
        (0..ny * nz).into_par_iter().map(of_row).collect()
    }
}

/// Whole voxels around all rows.
fn bounds(rows: &[Bounds]) -> Option<([isize; 3], [isize; 3])> {
    let mut found = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (low, high) in rows {
        (0..3).for_each(|a| found.0[a] = found.0[a].min(low[a]));
        (0..3).for_each(|a| found.1[a] = found.1[a].max(high[a]));
    }
    let (low, high) =
        (found.0.map(|x| (x + ROUNDING).floor() as isize), found.1.map(|x| (x - ROUNDING).ceil() as isize));
    (0..3).all(|a| low[a] < high[a]).then_some((low, high))
}

/// Layers of voxels that one thread fills.
struct Slab<'a, T> {
    low: [isize; 3],
    size: [usize; 3],
    taken: Vec<bool>,
    values: &'a mut [T],
}

impl<T> Slab<'_, T> {
    fn fill(&mut self, body: &DeformedCells, rows: &[Bounds], value: &impl Fn(MaterialPoint) -> T) {
        let (bottom, top) = (self.low[2] as f64, (self.low[2] + self.size[2] as isize) as f64);
        for (row, (low, high)) in rows.iter().enumerate() {
            // The bounds of an empty row are infinities the wrong way round.
            if low[2] <= top && high[2] >= bottom {
                for cell in body.row(row) {
                    self.fill_cell(body, cell, value);
                }
            }
        }
    }

    fn fill_cell(&mut self, body: &DeformedCells, cell: Cell, value: &impl Fn(MaterialPoint) -> T) {
        let corners = body.corners(cell);
        let [x, y, z]: [Range<usize>; 3] = std::array::from_fn(|a| self.centres_within(&corners, a));
        let first = body.grid.lattice.cell_position(cell);
        for (k, j) in z.flat_map(|k| y.clone().map(move |j| (k, j))) {
            for i in x.clone() {
                let at = [i, j, k];
                let voxel = i + self.size[0] * (j + self.size[1] * k);
                if self.taken[voxel] {
                    continue;
                }
                let centre = std::array::from_fn(|a| (at[a] as isize + self.low[a]) as f64 + 0.5);
                if let Some(xi) = place_within(&corners, centre) {
                    let position = std::array::from_fn(|a| (first[a] as f64 + xi[a]) * body.grid.spacing[a]);
                    self.taken[voxel] = true;
                    self.values[voxel] = value(MaterialPoint { cell, position });
                }
            }
        }
    }

    /// The voxels along an axis whose centres lie between the corners.
    fn centres_within(&self, corners: &[[f64; 3]; 8], a: usize) -> Range<usize> {
        let (low, high) = corners.iter().fold((f64::MAX, f64::MIN), |(l, h), c| (l.min(c[a]), h.max(c[a])));
        let first = (low - 0.5).ceil() as isize - self.low[a];
        let last = (high - 0.5).floor() as isize - self.low[a];
        first.max(0) as usize..(last + 1).clamp(0, self.size[a] as isize) as usize
    }
}

/// The ξ in the unit cube whose trilinear image is `point`, by Newton's method; `None` if there is none.
fn place_within(corners: &[[f64; 3]; 8], point: [f64; 3]) -> Option<[f64; 3]> {
    let mut xi = [0.5; 3];
    for _ in 0..NEWTON_STEPS {
        let (position, jacobian) = image(corners, xi);
        let residual: [f64; 3] = std::array::from_fn(|a| point[a] - position[a]);
        let step = solve(&jacobian, residual)?;
        (0..3).for_each(|a| xi[a] = (xi[a] + step[a]).clamp(-1.0, 2.0));
        // Convergence is quadratic: after such a step the rest is of the order of its square.
        if step.iter().all(|s| s.abs() < 1e-6) {
            break;
        }
    }
    let (position, _) = image(corners, xi);
    let found = (0..3).all(|a| (position[a] - point[a]).abs() < 1e-6);
    (found && xi.iter().all(|x| (-MARGIN..=1.0 + MARGIN).contains(x))).then_some(xi)
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
    fn material_points_are_those_that_were_moved_there() {
        let grid = VoxelGrid::uniform([6, 5, 7], [0.1, 0.2, 0.15], Label(1));
        // A shear and a bend: x = X + u(X) with u nodal, so trilinear in each cell.
        let at = |n: usize| grid.position(grid.lattice.node_position(Node(n)));
        let u = |[x, y, z]: [f64; 3]| [0.3 * z + 0.1 * y * z, 0.05 * x, -0.2 * x * y];
        let displacement: Vec<f64> = (0..grid.lattice.node_count()).flat_map(|n| u(at(n))).collect();
        let included = vec![true; grid.lattice.cell_count()];
        let target = WarpTarget { spacing: [0.05, 0.07, 0.06], included: &included };
        let warped = warp_onto(&grid, &displacement, &target, Some).unwrap();
        let mut found = 0;
        for (voxel, point) in warped.values.iter().enumerate() {
            let Some(MaterialPoint { cell, position }) = point else { continue };
            let at = warped.lattice.cell_position(Cell(voxel));
            let centre: [f64; 3] =
                std::array::from_fn(|a| (at[a] as f64 + warped.offset[a] as f64 + 0.5) * target.spacing[a]);
            // The field is trilinear in the whole body, so that its interpolation is exact.
            let moved = u(*position);
            assert!((0..3).all(|a| (position[a] + moved[a] - centre[a]).abs() < 1e-9), "{position:?} to {centre:?}");
            let corner = grid.lattice.cell_position(*cell);
            assert!((0..3).all(|a| {
                let share = position[a] / grid.spacing[a] - corner[a] as f64;
                (-1e-6..=1.0 + 1e-6).contains(&share)
            }));
            found += 1;
        }
        // The volume of the deformed body, ∫ det(I + ∇u), by the midpoint rule on a fine grid.
        let body: f64 = 0.6 * 1.0 * 1.05;
        let parts = 40;
        let mut mean = 0.0;
        for i in 0..parts * parts * parts {
            let cell = [i % parts, i / parts % parts, i / (parts * parts)];
            let size = [0.6, 1.0, 1.05];
            let [x, y, z]: [f64; 3] = std::array::from_fn(|a| (cell[a] as f64 + 0.5) / parts as f64 * size[a]);
            let f = [[1.0, 0.1 * z, 0.3 + 0.1 * y], [0.05, 1.0, 0.0], [-0.2 * y, -0.2 * x, 1.0]];
            mean += crate::linalg::matrix3::determinant(&f) / f64::from((parts * parts * parts) as u32);
        }
        let volume = found as f64 * target.spacing.iter().product::<f64>();
        assert!((volume / (body * mean) - 1.0).abs() < 0.01, "{volume} of {}", body * mean);
    }

    #[test]
    fn the_voxels_do_not_depend_on_the_number_of_threads() {
        let grid = body();
        let u: Vec<f64> = (0..3 * grid.lattice.node_count()).map(|i| 0.07 * (i as f64).sin()).collect();
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| warp(&grid, &u).unwrap())
        };
        assert_eq!(with(1), with(3));
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
