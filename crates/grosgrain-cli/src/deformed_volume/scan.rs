//! The scan of a deformed body: every voxel shows what has moved there.

use grosgrain::fine::FineModel;
use grosgrain::mesh::{Cell, MaterialPoint, Neighbourhood, Node, Volume, VoxelGrid, WarpTarget, warp_onto};

use super::{moved_world_by, too_large};
use crate::failure::Failure;
use crate::problem::Problem;

/// A scan and the body that was made from it, before it was cut.
///
/// The scan may have other voxels than the body. Around the body a layer of cells is taken along: the scan's voxels at
/// the skin are partly air, and without them the skin would have the steps of the body's cells.
#[derive(Clone, Debug)]
pub struct ScannedBody {
    scan: Volume,
    /// Edges of the scan's voxels \[m\].
    spacing: [f64; 3],
    /// What is shown where there is no body.
    void_value: f32,
    /// The cells of the uncut body.
    solid: Vec<bool>,
    /// Void cells around them, in which the scan may hold some of the body.
    skin: Vec<bool>,
}

/// A scan of the deformed body.
#[derive(Clone, Debug, PartialEq)]
pub struct DeformedScan {
    /// One value per voxel, x fastest.
    pub samples: Vec<f32>,
    /// Number of voxels along x, y, z.
    pub size: [usize; 3],
    /// Edges of a voxel \[m\].
    pub spacing: [f64; 3],
    /// Centre of the first voxel in the body's coordinates \[m\].
    pub origin: [f64; 3],
    /// What voxels without body hold: the lowest value of the scan.
    pub void_value: f32,
    /// Voxel index (i, j, k, 1) to world coordinates \[mm\], RAS.
    pub voxel_to_world: Option<[[f64; 4]; 4]>,
    /// Whether the scan's own values are whole numbers.
    pub integral: bool,
}

impl ScannedBody {
    /// The scan of a problem whose body has not been cut yet; `None` where there is none.
    pub fn new(problem: &Problem) -> Option<Self> {
        Self::from_scan(problem.volume.as_ref()?, problem.model.grid(), cells_before_padding(problem))
    }

    /// A scan whose box was `cells` cells of the body's lattice, which may have been padded beyond.
    ///
    /// `None` for an empty scan.
    pub fn from_scan(scan: &Volume, grid: &VoxelGrid, cells: [usize; 3]) -> Option<Self> {
        let (lowest, _) = scan.range()?;
        let spacing = std::array::from_fn(|a| grid.spacing[a] * cells[a] as f64 / scan.cells[a] as f64);
        let mut skin = vec![false; grid.void.len()];
        for cell in (0..grid.void.len()).map(Cell).filter(|c| !grid.void[c.0]) {
            Neighbourhood::Nodes.for_each(&grid.lattice, cell, |near| skin[near.0] |= grid.void[near.0]);
        }
        let solid = grid.void.iter().map(|void| !void).collect();
        Some(Self { scan: scan.clone(), spacing, void_value: lowest as f32, solid, skin })
    }

    /// The scan of the body as it is now, displaced (3 entries per lattice node \[m\]).
    ///
    /// Cells that the model has lost since show nothing, the lowest value of the scan.
    ///
    /// # Errors
    /// A deformation too large for voxels.
    pub fn deformed(&self, model: &FineModel, displacement: &[f64]) -> Result<DeformedScan, Failure> {
        let grid = model.grid();
        let included = self.included(grid);
        let displacement = self.extended(model, &included, displacement);
        let target = WarpTarget { spacing: self.spacing, included: &included };
        let sample = |point: MaterialPoint| Some(self.sample(point.position));
        let warped = warp_onto(grid, &displacement, &target, sample).ok_or_else(too_large)?;
        let origin = |a: usize| grid.origin[a] + (warped.offset[a] as f64 + 0.5) * self.spacing[a];
        Ok(DeformedScan {
            samples: warped.values.iter().map(|value| value.unwrap_or(self.void_value)).collect(),
            size: warped.lattice.cells,
            spacing: self.spacing,
            origin: std::array::from_fn(origin),
            void_value: self.void_value,
            integral: self.scan.integral,
            voxel_to_world: self
                .scan
                .voxel_to_world
                .map(|old| moved_world_by(old, [1.0; 3], warped.offset, self.spacing)),
        })
    }

    /// The cells of the body, and the skin of those that are left.
    fn included(&self, grid: &VoxelGrid) -> Vec<bool> {
        let mut near = vec![false; grid.void.len()];
        for cell in (0..grid.void.len()).map(Cell).filter(|c| !grid.void[c.0]) {
            Neighbourhood::Nodes.for_each(&grid.lattice, cell, |other| near[other.0] = true);
        }
        for cell in (0..grid.void.len()).map(Cell).filter(|c| grid.void[c.0] && self.solid[c.0]) {
            // What lies on a cell that was cut away goes with it.
            Neighbourhood::Faces.for_each(&grid.lattice, cell, |other| near[other.0] = false);
        }
        (0..grid.void.len()).map(|c| !grid.void[c] || self.skin[c] && near[c]).collect()
    }

    /// The displacement, and at the nodes of the skin that nothing moves the mean of those around them that move.
    fn extended(&self, model: &FineModel, included: &[bool], displacement: &[f64]) -> Vec<f64> {
        let lattice = model.grid().lattice;
        let (mut sum, mut count) = (vec![[0.0; 3]; lattice.node_count()], vec![0.0; lattice.node_count()]);
        for cell in (0..included.len()).map(Cell).filter(|c| included[c.0] && model.is_void(*c)) {
            let corners = lattice.corners(cell);
            let moved = |node: &&Node| model.active()[node.0];
            let moving: Vec<Node> = corners.iter().filter(moved).copied().collect();
            for node in corners.iter().filter(|node| !model.active()[node.0]) {
                for other in &moving {
                    (0..3).for_each(|a| sum[node.0][a] += displacement[3 * other.0 + a]);
                    count[node.0] += 1.0;
                }
            }
        }
        let mut extended = displacement.to_vec();
        for node in (0..count.len()).filter(|n| count[*n] > 0.0) {
            (0..3).for_each(|a| extended[3 * node + a] = sum[node][a] / count[node]);
        }
        extended
    }

    /// The scan's value at a position from its corner \[m\], trilinear between the centres of its voxels.
    fn sample(&self, position: [f64; 3]) -> f32 {
        let cells = self.scan.cells;
        let place: [f64; 3] = std::array::from_fn(|a| position[a] / self.spacing[a] - 0.5);
        // Half a voxel beyond the outermost centres they still count; padding lies further out.
        if (0..3).any(|a| place[a] < -0.5 - 1e-6 || place[a] > cells[a] as f64 - 0.5 + 1e-6) {
            return self.void_value;
        }
        let place: [f64; 3] = std::array::from_fn(|a| place[a].clamp(0.0, (cells[a] - 1) as f64));
        let base: [usize; 3] = std::array::from_fn(|a| (place[a] as usize).min(cells[a].saturating_sub(2)));
        let mut sum = 0.0;
        for corner in 0..8 {
            let (mut weight, mut index, mut stride) = (1.0, 0, 1);
            for a in 0..3 {
                let upper = corner >> a & 1;
                let share = place[a] - base[a] as f64;
                weight *= if upper == 1 { share } else { 1.0 - share };
                index += (base[a] + upper).min(cells[a] - 1) * stride;
                stride *= cells[a];
            }
            sum += weight * self.scan.values[index];
        }
        sum as f32
    }
}

impl DeformedScan {
    /// The scan as a volume that can be written.
    pub fn volume(&self) -> Volume {
        // Whole numbers take a quarter of the room in files.
        let value = |v: &f32| f64::from(if self.integral { v.round() } else { *v });
        let values = self.samples.iter().map(value).collect();
        Volume {
            cells: self.size,
            spacing: Some(self.spacing),
            voxel_to_world: self.voxel_to_world,
            integral: self.integral,
            values,
        }
    }
}

/// Cells of the body before it was padded to a multiple of the degree.
fn cells_before_padding(problem: &Problem) -> [usize; 3] {
    let cells = problem.volume.as_ref().map(|volume| volume.cells);
    problem.scene.body.resample.or(cells).unwrap_or(problem.model.grid().lattice.cells)
}
