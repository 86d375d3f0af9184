//! Cuts: voxels that a plane, or a straight blade swept through the body, takes away.

use super::VoxelGrid;

/// Nodes that are closer to a plane than this share of the smallest voxel edge count as lying on it.
const ON_PLANE: f64 = 1e-7;
/// A box and a blade overlap when they are closer than this share of the smallest voxel edge; above [`ON_PLANE`], so that
/// the voxel beside a plane of nodes is found although the blade lies a rounding away from it.
const OVERLAP: f64 = 2.0 * ON_PLANE;
/// By this share of the smallest voxel edge a blade is shortened at its ends; above [`OVERLAP`], so that a blade that ends on
/// a face between two voxels does not cut the one beyond.
const SHORTENED: f64 = 1e-6;

/// A cut along the plane through `point` with the unit normal n of `normal`.
///
/// With δ = n · (x − point) at a node x, a voxel is removed if and only if min δ ≤ 0 < max δ over its eight nodes, where
/// δ up to 1e-7 of the smallest voxel edge counts as zero. The test is half-open: a voxel that stays has all its nodes at
/// δ ≤ 0 or all at δ > 0, so the two sides share no node, and along a plane of nodes exactly the layer on the side of the
/// normal goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// A point of the plane \[m\].
    pub point: [f64; 3],
    /// The plane's normal, of any length.
    pub normal: [f64; 3],
    /// Where given, only voxels are removed whose centre lies within this distance \[m\] of the line through `point` along the
    /// normal.
    pub radius: Option<f64>,
}

/// A straight edge from `edge[0]` to `edge[1]` swept along `sweep`: the parallelogram e₀ + s (e₁ − e₀) + t `sweep` with s and t
/// from 0 to 1.
///
/// A voxel is cut if and only if the [`Cut`] along the parallelogram's plane (normal (e₁ − e₀) × `sweep`) removes it and its
/// closed box meets the parallelogram, both within 2e-7 of the smallest voxel edge. For this second test the parallelogram
/// is shortened by 1e-6 of the smallest voxel edge at its four sides: a blade that ends on a face between two voxels does not
/// cut the one beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct Blade {
    /// Ends of the edge where the sweep begins \[m\].
    pub edge: [[f64; 3]; 2],
    /// How far it moves \[m\].
    pub sweep: [f64; 3],
}

/// A plane with what the tests of a grid need.
struct Plane {
    point: [f64; 3],
    unit: [f64; 3],
    zero: f64,
}

impl Plane {
    fn new(point: [f64; 3], normal: [f64; 3], grid: &VoxelGrid) -> Self {
        let length = dot(normal, normal).sqrt();
        Self { point, unit: normal.map(|n| n / length), zero: ON_PLANE * smallest_edge(grid) }
    }

    /// Whether the node counts as lying on the side that the normal points to. A function of the node alone, so that all
    /// voxels around it agree.
    fn is_above(&self, grid: &VoxelGrid, node: [usize; 3]) -> bool {
        dot(self.unit, minus(grid.position(node), self.point)) > self.zero
    }

    fn removes(&self, grid: &VoxelGrid, at: [usize; 3]) -> bool {
        let node = |a: usize| [at[0] + (a & 1), at[1] + (a >> 1 & 1), at[2] + (a >> 2)];
        let first = self.is_above(grid, node(0));
        (1..8).any(|a| self.is_above(grid, node(a)) != first)
    }

    /// Largest |δ| of the centre of a voxel that the plane can remove \[m\].
    fn reach(&self, grid: &VoxelGrid) -> f64 {
        let half: f64 = (0..3).map(|a| 0.5 * grid.spacing[a] * self.unit[a].abs()).sum();
        half + 2.0 * self.zero
    }
}

impl Cut {
    /// Whether the voxel at (i, j, k) is removed.
    pub(super) fn removes(&self, grid: &VoxelGrid, at: [usize; 3]) -> bool {
        let plane = Plane::new(self.point, self.normal, grid);
        let near = |radius: f64| {
            let from = minus(grid.centre(at), self.point);
            let along = dot(from, plane.unit);
            dot(from, from) - along * along <= radius * radius
        };
        self.radius.is_none_or(near) && plane.removes(grid, at)
    }

    /// Smallest and largest x \[m\] of the centres that the cut can remove in the row of voxels at y and z \[m\].
    pub(super) fn row(&self, grid: &VoxelGrid, [y, z]: [f64; 2]) -> [f64; 2] {
        let plane = Plane::new(self.point, self.normal, grid);
        let reach = plane.reach(grid);
        let offset = plane.unit[1] * (y - self.point[1]) + plane.unit[2] * (z - self.point[2]);
        let ends = [-1.0, 1.0].map(|side| self.point[0] + (side * reach - offset) / plane.unit[0]);
        match ends[0].is_finite() && ends[1].is_finite() {
            true => [ends[0].min(ends[1]), ends[0].max(ends[1])],
            false if offset.abs() <= reach => [f64::NEG_INFINITY, f64::INFINITY],
            false => [f64::INFINITY, f64::NEG_INFINITY],
        }
    }

    /// Whether point and normal are numbers, the normal is not zero and the radius, where there is one, is positive.
    pub(super) fn is_usable(&self) -> bool {
        is_finite(self.point) && is_direction(self.normal) && self.radius.is_none_or(|r| r.is_finite() && r > 0.0)
    }

    /// The box \[m\] that holds the centres of all voxels that the cut can remove.
    pub(super) fn bounds(&self, grid: &VoxelGrid) -> [[f64; 3]; 2] {
        let Some(radius) = self.radius else { return [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]] };
        let far = radius + Plane::new(self.point, self.normal, grid).reach(grid);
        [self.point.map(|x| x - far), self.point.map(|x| x + far)]
    }
}

impl Blade {
    fn along(&self) -> [f64; 3] {
        minus(self.edge[1], self.edge[0])
    }

    /// Normal of the parallelogram, as long as its area \[m²\].
    pub fn normal(&self) -> [f64; 3] {
        cross(self.along(), self.sweep)
    }

    /// Whether the voxel at (i, j, k) is cut.
    pub(super) fn cuts(&self, grid: &VoxelGrid, at: [usize; 3]) -> bool {
        Plane::new(self.edge[0], self.normal(), grid).removes(grid, at) && self.meets(grid, at)
    }

    /// Separating axes of a box and a parallelogram: the box's three normals, the parallelogram's, and the products of their
    /// edges.
    fn meets(&self, grid: &VoxelGrid, at: [usize; 3]) -> bool {
        let smallest = smallest_edge(grid);
        let (along, sweep) = (self.along(), self.sweep);
        let half = |side: [f64; 3]| shortened(side, SHORTENED * smallest);
        let (u, v) = (half(along), half(sweep));
        let middle: [f64; 3] = std::array::from_fn(|a| self.edge[0][a] + 0.5 * (along[a] + sweep[a]));
        let between = minus(middle, grid.centre(at));
        let separates = |axis: [f64; 3]| {
            let size = dot(axis, axis).sqrt();
            let box_reach: f64 = (0..3).map(|a| 0.5 * grid.spacing[a] * axis[a].abs()).sum();
            let blade_reach = dot(axis, u).abs() + dot(axis, v).abs();
            dot(axis, between).abs() > box_reach + blade_reach + OVERLAP * smallest * size
        };
        let unit = |a: usize| std::array::from_fn(|b| f64::from(u8::from(a == b)));
        let crossed = (0..3).flat_map(|a| [cross(unit(a), along), cross(unit(a), sweep)]);
        !(0..3).map(unit).chain([self.normal()]).chain(crossed).any(separates)
    }

    /// Whether the edge and the sweep are numbers and span an area.
    pub(super) fn is_usable(&self) -> bool {
        let (along, normal) = (self.along(), self.normal());
        let spanned = dot(normal, normal).sqrt();
        let sides = (dot(along, along) * dot(self.sweep, self.sweep)).sqrt();
        self.edge.iter().all(|x| is_finite(*x))
            && is_direction(self.sweep)
            && spanned > 1e-9 * sides
            && sides.is_finite()
    }

    /// The box \[m\] that holds the centres of all voxels that the blade can cut.
    pub(super) fn bounds(&self, grid: &VoxelGrid) -> [[f64; 3]; 2] {
        let [a, b] = self.edge;
        let corners = [a, b, plus(a, self.sweep), plus(b, self.sweep)];
        let grown = |axis: usize| 0.5 * grid.spacing[axis] + 2.0 * OVERLAP * smallest_edge(grid);
        let end = |axis: usize, pick: fn(f64, f64) -> f64| corners.iter().map(|c| c[axis]).fold(corners[0][axis], pick);
        [
            std::array::from_fn(|axis| end(axis, f64::min) - grown(axis)),
            std::array::from_fn(|axis| end(axis, f64::max) + grown(axis)),
        ]
    }

    /// The blades of an edge that is swept along one vector after the other.
    pub fn path(edge: [[f64; 3]; 2], sweeps: &[[f64; 3]]) -> Vec<Self> {
        let mut edge = edge;
        let step = |sweep: &[f64; 3]| {
            let blade = Self { edge, sweep: *sweep };
            edge = edge.map(|end| plus(end, *sweep));
            blade
        };
        sweeps.iter().map(step).collect()
    }
}

/// Half of `side`, `by` shorter; zero where nothing is left.
fn shortened(side: [f64; 3], by: f64) -> [f64; 3] {
    let length = dot(side, side).sqrt();
    side.map(|x| 0.5 * x * (1.0 - 2.0 * by / length).max(0.0))
}

fn smallest_edge(grid: &VoxelGrid) -> f64 {
    grid.spacing.into_iter().fold(f64::INFINITY, f64::min)
}

pub(super) fn is_finite(x: [f64; 3]) -> bool {
    x.iter().all(|v| v.is_finite())
}

/// Whether a vector has a direction that arithmetic finds.
fn is_direction(x: [f64; 3]) -> bool {
    let square = dot(x, x);
    square.is_finite() && square > f64::MIN_POSITIVE
}

pub(super) fn plus(x: [f64; 3], y: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| x[a] + y[a])
}

pub(super) fn minus(x: [f64; 3], y: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| x[a] - y[a])
}

pub(super) fn dot(x: [f64; 3], y: [f64; 3]) -> f64 {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

fn cross(x: [f64; 3], y: [f64; 3]) -> [f64; 3] {
    [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
}

#[cfg(test)]
mod tests;
