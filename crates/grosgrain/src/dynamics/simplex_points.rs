//! Points that move with the cells of a mesh of simplices, and what they rest on.

use super::Schedule;
use crate::contact::{PointPotential, simplex_surface_areas};
use crate::simplex::{BoundaryError, Locator, SimplexMesh};

/// A point of a surface: it moves with a cell, at Σ_n w_n x_n of its corners, and stands for a piece of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The cell.
    pub cell: u32,
    /// w, one weight per corner, sum 1; those beyond d + 1 are zero.
    pub weights: [f64; 4],
    /// The area \[m²\] it stands for.
    pub area: f64,
}

impl SurfacePoint {
    /// The boundary nodes of a mesh with their areas, nodes ascending.
    ///
    /// # Errors
    /// A mesh with faces that do not divide inside from outside.
    pub fn of_boundary(mesh: &SimplexMesh) -> Result<Vec<Self>, BoundaryError> {
        let homes = homes(mesh);
        let areas = simplex_surface_areas(mesh)?;
        let on_boundary = areas.iter().zip(&homes).filter(|(area, _)| **area > 0.0);
        Ok(on_boundary.filter_map(|(area, home)| home.map(|home| Self { area: *area, ..home })).collect())
    }

    /// The boundary nodes of `fine` as points that move with `coarse`, so that a coarse body meets the ground with the surface of the fine one. A node outside
    /// of all coarse cells follows up to three of them by extrapolation, each for its share of the node's area (`kharevych2009numerical`, §4.2).
    ///
    /// # Errors
    /// A fine mesh with faces that do not divide inside from outside.
    pub fn embedded(fine: &SimplexMesh, coarse: &SimplexMesh) -> Result<Vec<Self>, BoundaryError> {
        let locator = Locator::new(coarse);
        let areas = simplex_surface_areas(fine)?;
        let on_boundary = fine.nodes().iter().zip(areas).filter(|(_, area)| *area > 0.0);
        let points = on_boundary.flat_map(|(at, area)| {
            let place = locator.locate(*at);
            let point = |n: usize| {
                let home = place.cells()[n];
                Self { cell: home.cell, weights: home.weights, area: home.share * area }
            };
            (0..place.cells().len()).map(point).collect::<Vec<_>>()
        });
        Ok(points.collect())
    }
}

/// A spring between a point that moves with a cell, at Σ_n w_n x_n of its corners, and a fixed place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmbeddedSpring {
    /// The cell.
    pub cell: u32,
    /// w, one weight per corner, sum 1; those beyond d + 1 are zero.
    pub weights: [f64; 4],
    /// Stiffness \[N/m\].
    pub stiffness: f64,
    /// The place \[m\].
    pub target: [f64; 3],
    /// When it acts; its stiffness grows along the ramp.
    pub schedule: Schedule,
}

/// For each node the last of its cells, with weight one at the node; `None` where no cell uses it.
pub(super) fn homes(mesh: &SimplexMesh) -> Vec<Option<SurfacePoint>> {
    let mut homes = vec![None; mesh.nodes().len()];
    for cell in 0..mesh.cell_count() {
        for (corner, node) in mesh.cell(cell).iter().enumerate() {
            let mut weights = [0.0; 4];
            weights[corner] = 1.0;
            homes[*node as usize] = Some(SurfacePoint { cell: cell as u32, weights, area: 0.0 });
        }
    }
    homes
}

/// A potential on a point of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CellPotential {
    pub cell: u32,
    pub corners: [u32; 4],
    pub weights: [f64; 4],
    /// The potential at full share.
    pub potential: PointPotential,
    pub schedule: Schedule,
}

impl CellPotential {
    /// Where the point is \[m\].
    pub fn position(&self, rest: &[[f64; 3]], displacement: &[f64]) -> [f64; 3] {
        let mut at = [0.0; 3];
        for (node, weight) in self.corners.iter().zip(self.weights).filter(|(_, weight)| *weight != 0.0) {
            let node = *node as usize;
            (0..3).for_each(|r| at[r] += weight * (rest[node][r] + displacement[3 * node + r]));
        }
        at
    }

    /// Adds a gradient at the point to that of the nodes.
    pub fn spread(&self, gradient: &[f64; 3], of_nodes: &mut [f64]) {
        for (node, weight) in self.corners.iter().zip(self.weights).filter(|(_, weight)| *weight != 0.0) {
            (0..3).for_each(|r| of_nodes[3 * *node as usize + r] += weight * gradient[r]);
        }
    }

    /// Adds second derivatives by the place of the point, w_n w_m D, to the row-major matrix of the cell.
    pub fn add_hessian(&self, hessian: &[[f64; 3]; 3], matrix: &mut [f64; 144]) {
        for (n, m) in (0..16).map(|e| (e / 4, e % 4)) {
            let weight = self.weights[n] * self.weights[m];
            for (r, s) in (0..9).map(|e| (e / 3, e % 3)) {
                matrix[12 * (3 * n + r) + 3 * m + s] += weight * hessian[r][s];
            }
        }
    }
}
