//! Surface points by cells, so that those of cells far above the ground cost nothing.

use std::ops::Range;

use super::simplex_points::CellPotential;
use crate::contact::PointPotential;

/// What rounding may make of a height, relative to the heights that it comes from.
const ROUNDING: f64 = 1e-12;

/// Points next to each other in a list that move with one cell and may meet the ground, or springs, which always act.
#[derive(Clone, Debug)]
pub(super) struct PointGroup {
    pub points: Range<usize>,
    ground: Option<Bounds>,
    /// Whether friction holds one of the points.
    grips: bool,
}

/// Which weights the corners of a cell have at its points.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    height: f64,
    corners: [u32; 4],
    /// Least and greatest weight of each corner but the first.
    weights: [[f64; 2]; 3],
}

impl PointGroup {
    /// The groups of a list in which springs come first and then points on the ground, those of one cell together.
    pub fn of(points: &[CellPotential]) -> Vec<Self> {
        let key = |point: &CellPotential| Self::key(point);
        let mut groups = Vec::new();
        let mut first = 0;
        for points in points.chunk_by(|a, b| key(a) == key(b)) {
            groups.push(Self { points: first..first + points.len(), ground: Bounds::of(points), grips: false });
            first += points.len();
        }
        groups
    }

    /// By which points are sorted and grouped: `None` for springs, else the cell.
    pub fn key(point: &CellPotential) -> Option<u32> {
        matches!(point.potential, PointPotential::Ground { .. }).then_some(point.cell)
    }

    /// Whether a point may have energy: springs, what friction holds, and cells that reach into the ground. Others have none, and no derivatives either.
    pub fn may_act(&self, rest: &[[f64; 3]], displacement: &[f64]) -> bool {
        self.grips || self.ground.is_none_or(|bounds| bounds.reaches_ground(rest, displacement))
    }

    /// Takes note of what the potentials of its points hold.
    pub fn note(&mut self, potentials: &[PointPotential]) {
        let holds = |potential: &PointPotential| matches!(potential, PointPotential::Ground { grip, .. } if grip.anchor.is_some());
        self.grips = potentials[self.points.clone()].iter().any(holds);
    }
}

impl Bounds {
    fn of(points: &[CellPotential]) -> Option<Self> {
        let PointPotential::Ground { ground, .. } = points.first()?.potential else { return None };
        let range = |n: usize| {
            let weights = points.iter().map(|point| point.weights[n]);
            weights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], w| [low.min(w), high.max(w)])
        };
        Some(Self { height: ground.height, corners: points[0].corners, weights: [range(1), range(2), range(3)] })
    }

    /// z = z₀ + Σ_n w_n (z_n − z₀) is nowhere less than with the weight of each corner chosen for itself.
    fn reaches_ground(&self, rest: &[[f64; 3]], displacement: &[f64]) -> bool {
        let [first, others @ ..] =
            self.corners.map(|node| rest[node as usize][2] + displacement[3 * node as usize + 2]);
        let (mut least, mut size) = (first, first.abs() + self.height.abs());
        for (z, [low, high]) in others.iter().zip(self.weights) {
            let (a, b) = (low * (z - first), high * (z - first));
            least += a.min(b);
            size += a.abs().max(b.abs()) + z.abs();
        }
        let highest = self.height + ROUNDING * size;
        // Not-a-number counts as reaching.
        least <= highest || least.is_nan() || highest.is_nan()
    }
}
