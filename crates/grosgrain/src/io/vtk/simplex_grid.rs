//! One mesh of simplices with its data: `.vtu`.

use super::piece::{Cells, Piece};
use super::{DataArray, Values, VtkError};
use crate::simplex::{Dimension, SimplexMesh};
use std::io::Write;

/// A mesh of segments, triangles or tetrahedra and the values on it.
#[derive(Clone, Debug, PartialEq)]
pub struct SimplexGrid<'a> {
    /// The mesh; its tags are written too, as cell data `tag`.
    pub mesh: &'a SimplexMesh,
    /// Values at the nodes.
    pub point_data: Vec<DataArray<'a>>,
    /// Values at the cells, besides the tags.
    pub cell_data: Vec<DataArray<'a>>,
    /// Time of the frame \[s\], written as `TimeValue`.
    pub time: Option<f64>,
}

impl<'a> SimplexGrid<'a> {
    /// A mesh with nothing on it but its tags.
    pub fn new(mesh: &'a SimplexMesh) -> Self {
        Self { mesh, point_data: Vec::new(), cell_data: Vec::new(), time: None }
    }
}

/// Writes a mesh of simplices as VTU. Nothing is written if something is refused.
///
/// # Errors
/// Arrays of the wrong length or with equal names (`tag` is taken), tensors of several dimensions in one array, numbers that are not finite, what the writer reports.
pub fn write_simplex_vtu<W: Write>(writer: W, grid: &SimplexGrid) -> Result<(), VtkError> {
    let mesh = grid.mesh;
    let count = mesh.cell_count();
    let connectivity = (0..count).flat_map(|cell| mesh.cell(cell)).map(|node| i64::from(*node)).collect();
    let mut cell_data = vec![DataArray { name: "tag", values: Values::Integer(mesh.tags()) }];
    cell_data.extend_from_slice(&grid.cell_data);
    let piece = Piece {
        points: mesh.nodes(),
        cells: Cells { kind: vtk_shape(mesh.dimension()), corners: mesh.dimension().corners(), count, connectivity },
        point_data: &grid.point_data,
        cell_data: &cell_data,
        time: grid.time,
    };
    piece.write(writer)
}

/// VTK's number for a simplex.
const fn vtk_shape(dimension: Dimension) -> u8 {
    match dimension {
        Dimension::One => 3,
        Dimension::Two => 5,
        Dimension::Three => 10,
    }
}
