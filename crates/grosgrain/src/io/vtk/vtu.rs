//! One grid of hexahedra with its data: `.vtu`.

use super::piece::{Cells, Piece};
use super::{DataArray, VtkError};
use std::io::Write;

/// Position in our corner order (x fastest) of each corner in VTK's order (around the bottom, around the top).
const VTK_CORNERS: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];
/// VTK's number for a trilinear hexahedron.
const VTK_HEXAHEDRON: u8 = 12;

/// A mesh of hexahedra and the values on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UnstructuredGrid<'a> {
    /// Undeformed positions \[m\].
    pub points: &'a [[f64; 3]],
    /// Eight points per cell, x fastest (000, 100, 010, 110, 001, …).
    pub hexahedra: &'a [[usize; 8]],
    /// Values at the points.
    pub point_data: Vec<DataArray<'a>>,
    /// Values at the cells.
    pub cell_data: Vec<DataArray<'a>>,
    /// Time of the frame \[s\], written as `TimeValue`.
    pub time: Option<f64>,
}

impl UnstructuredGrid<'_> {
    fn check_corners(&self) -> Result<(), VtkError> {
        let points = self.points.len();
        for (cell, corners) in self.hexahedra.iter().enumerate() {
            if let Some(&point) = corners.iter().find(|p| **p >= points) {
                return Err(VtkError::Corner { cell, point, points });
            }
        }
        Ok(())
    }
}

/// Writes a grid as VTU. Nothing is written if the grid is refused.
///
/// # Errors
/// No cells, a corner that is not a point, arrays of the wrong length or with equal names, numbers that are not
/// finite, what the writer reports.
pub fn write_vtu<W: Write>(writer: W, grid: &UnstructuredGrid) -> Result<(), VtkError> {
    grid.check_corners()?;
    let corners = grid.hexahedra.iter().flat_map(|cell| VTK_CORNERS.map(|corner| cell[corner] as i64));
    let piece = Piece {
        points: grid.points,
        cells: Cells { kind: VTK_HEXAHEDRON, corners: 8, count: grid.hexahedra.len(), connectivity: corners.collect() },
        point_data: &grid.point_data,
        cell_data: &grid.cell_data,
        time: grid.time,
    };
    piece.write(writer)
}
