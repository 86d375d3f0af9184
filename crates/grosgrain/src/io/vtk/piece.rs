//! The file around one grid whose cells all have the same shape.

use super::data_array::check;
use super::encoding::{escape, write_compressed};
use super::{DataArray, Values, VtkError};
use std::io::Write;

/// What a `.vtu` file holds.
pub(super) struct Piece<'a> {
    pub points: &'a [[f64; 3]],
    pub cells: Cells,
    pub point_data: &'a [DataArray<'a>],
    pub cell_data: &'a [DataArray<'a>],
    pub time: Option<f64>,
}

/// Cells of one shape, corners in VTK's order; every corner must be a point.
pub(super) struct Cells {
    /// VTK's number for the shape.
    pub kind: u8,
    /// Corners of a cell.
    pub corners: usize,
    /// Number of cells.
    pub count: usize,
    /// Corners of all cells.
    pub connectivity: Vec<i64>,
}

impl Piece<'_> {
    fn validate(&self) -> Result<(), VtkError> {
        if self.cells.count == 0 {
            return Err(VtkError::Empty);
        }
        self.position_array().check_finite()?;
        if let Some(time) = self.time {
            DataArray { name: "TimeValue", values: Values::Scalar(&[time]) }.check_finite()?;
        }
        check(self.point_data, self.points.len(), "points")?;
        check(self.cell_data, self.cells.count, "cells")
    }

    fn position_array(&self) -> DataArray<'_> {
        DataArray { name: "Points", values: Values::Vector(self.points) }
    }

    /// Writes the file, or nothing if something is refused.
    pub fn write<W: Write>(&self, mut writer: W) -> Result<(), VtkError> {
        self.validate()?;
        let w = &mut writer;
        writeln!(w, "<?xml version=\"1.0\"?>")?;
        write!(w, "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" ")?;
        writeln!(w, "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">")?;
        self.write_component_orders(w)?;
        writeln!(w, "<UnstructuredGrid>")?;
        write_time(w, self.time)?;
        writeln!(w, "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">", self.points.len(), self.cells.count)?;
        write_arrays(w, "PointData", self.point_data)?;
        write_arrays(w, "CellData", self.cell_data)?;
        write_arrays(w, "Points", &[self.position_array()])?;
        self.cells.write(w)?;
        writeln!(w, "</Piece>\n</UnstructuredGrid>\n</VTKFile>")?;
        Ok(writer.flush()?)
    }

    /// A comment for each array whose components need one; a field array of text would stop meshio.
    fn write_component_orders<W: Write>(&self, writer: &mut W) -> Result<(), VtkError> {
        for array in self.point_data.iter().chain(self.cell_data) {
            if let Some(order) = array.values.component_order() {
                // XML forbids two hyphens in a comment.
                writeln!(writer, "<!-- {}: {order} -->", escape(array.name).replace('-', "_"))?;
            }
        }
        Ok(())
    }
}

impl Cells {
    fn write<W: Write>(&self, writer: &mut W) -> Result<(), VtkError> {
        let bytes = |numbers: &mut dyn Iterator<Item = i64>| numbers.flat_map(i64::to_le_bytes).collect::<Vec<u8>>();
        let offsets = bytes(&mut (1..=self.count).map(|cell| (self.corners * cell) as i64));
        writeln!(writer, "<Cells>")?;
        write_array(writer, "Name=\"connectivity\" type=\"Int64\"", &bytes(&mut self.connectivity.iter().copied()))?;
        write_array(writer, "Name=\"offsets\" type=\"Int64\"", &offsets)?;
        write_array(writer, "Name=\"types\" type=\"UInt8\"", &vec![self.kind; self.count])?;
        Ok(writeln!(writer, "</Cells>")?)
    }
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

fn write_array<W: Write>(writer: &mut W, attributes: &str, bytes: &[u8]) -> Result<(), VtkError> {
    write!(writer, "<DataArray {attributes} format=\"binary\">")?;
    write_compressed(writer, bytes)?;
    Ok(writeln!(writer, "</DataArray>")?)
}
