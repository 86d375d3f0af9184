//! One grid of hexahedra with its data: `.vtu`.

use super::{
    DataArray, Values, VtkError,
    data_array::check,
    encoding::{escape, write_compressed},
};
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
    fn validate(&self) -> Result<(), VtkError> {
        if self.hexahedra.is_empty() {
            return Err(VtkError::Empty);
        }
        let points = self.points.len();
        for (cell, corners) in self.hexahedra.iter().enumerate() {
            if let Some(&point) = corners.iter().find(|p| **p >= points) {
                return Err(VtkError::Corner { cell, point, points });
            }
        }
        self.position_array().check_finite()?;
        if let Some(time) = self.time {
            DataArray { name: "TimeValue", values: Values::Scalar(&[time]) }.check_finite()?;
        }
        check(&self.point_data, points, "points")?;
        check(&self.cell_data, self.hexahedra.len(), "cells")
    }

    fn position_array(&self) -> DataArray<'_> {
        DataArray { name: "Points", values: Values::Vector(self.points) }
    }
}

/// Writes a grid as VTU. Nothing is written if the grid is refused.
///
/// # Errors
/// No cells, a corner that is not a point, arrays of the wrong length or with equal names, numbers that are not
/// finite, what the writer reports.
pub fn write_vtu<W: Write>(mut writer: W, grid: &UnstructuredGrid) -> Result<(), VtkError> {
    grid.validate()?;
    let w = &mut writer;
    writeln!(w, "<?xml version=\"1.0\"?>")?;
    write!(w, "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" ")?;
    writeln!(w, "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">")?;
    writeln!(w, "<UnstructuredGrid>")?;
    write_time(w, grid.time)?;
    writeln!(w, "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">", grid.points.len(), grid.hexahedra.len())?;
    write_arrays(w, "PointData", &grid.point_data)?;
    write_arrays(w, "CellData", &grid.cell_data)?;
    write_arrays(w, "Points", &[grid.position_array()])?;
    write_cells(w, grid.hexahedra)?;
    writeln!(w, "</Piece>\n</UnstructuredGrid>\n</VTKFile>")?;
    Ok(writer.flush()?)
}

fn write_time<W: Write>(writer: &mut W, time: Option<f64>) -> Result<(), VtkError> {
    let Some(time) = time else { return Ok(()) };
    writeln!(writer, "<FieldData>")?;
    write_array(writer, "type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\"", &time.to_le_bytes())?;
    Ok(writeln!(writer, "</FieldData>")?)
}

fn write_arrays<W: Write>(writer: &mut W, element: &str, arrays: &[DataArray]) -> Result<(), VtkError> {
    writeln!(writer, "<{element}>")?;
    for array in arrays {
        let attributes = format!("Name=\"{}\" {}", escape(array.name), array.values.attributes());
        write_array(writer, &attributes, &array.values.bytes())?;
    }
    Ok(writeln!(writer, "</{element}>")?)
}

fn write_cells<W: Write>(writer: &mut W, hexahedra: &[[usize; 8]]) -> Result<(), VtkError> {
    let corners = hexahedra.iter().flat_map(|cell| VTK_CORNERS.map(|corner| cell[corner] as i64));
    let offsets = (1..=hexahedra.len()).map(|cell| 8 * cell as i64);
    let bytes = |numbers: &mut dyn Iterator<Item = i64>| numbers.flat_map(i64::to_le_bytes).collect::<Vec<u8>>();
    writeln!(writer, "<Cells>")?;
    write_array(writer, "Name=\"connectivity\" type=\"Int64\"", &bytes(&mut corners.into_iter()))?;
    write_array(writer, "Name=\"offsets\" type=\"Int64\"", &bytes(&mut offsets.into_iter()))?;
    write_array(writer, "Name=\"types\" type=\"UInt8\"", &vec![VTK_HEXAHEDRON; hexahedra.len()])?;
    Ok(writeln!(writer, "</Cells>")?)
}

fn write_array<W: Write>(writer: &mut W, attributes: &str, bytes: &[u8]) -> Result<(), VtkError> {
    write!(writer, "<DataArray {attributes} format=\"binary\">")?;
    write_compressed(writer, bytes)?;
    Ok(writeln!(writer, "</DataArray>")?)
}
