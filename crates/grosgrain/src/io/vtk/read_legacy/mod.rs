//! Reading legacy `.vtk`: unstructured grids as text or binary, versions up to 5.1.

mod cursor;

use super::cell_grid::CellGrid;
use super::numbers::NumberType;
use super::read_vtu::{increasing, whole};
use crate::io::excerpt::excerpt;
use crate::io::mesh::{MeshFile, MeshReadError, Place};
use cursor::Cursor;

/// Reads the body in a legacy VTK file, as [`read_vtu`](super::read_vtu()) does in an XML file.
///
/// # Errors
/// Damaged files, other data sets than unstructured grids, bodies of other cells than simplices.
pub fn read_vtk_legacy(bytes: &[u8]) -> Result<MeshFile, MeshReadError> {
    let mut file = Legacy { cursor: Cursor::new(bytes), grid: CellGrid::default(), cells_at: Place::Line(1), cells: 0 };
    file.header()?;
    let mut section = Section::Other;
    while let Some(line) = file.cursor.full_line() {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        file.entry(&words, &mut section)?;
    }
    if file.grid.shapes.len() != file.grid.ends.len() {
        let found = format!("{} cells with {} types", file.grid.ends.len(), file.grid.shapes.len());
        return Err(file.cursor.unexpected(&found, "a type for each cell"));
    }
    file.grid.into_file(file.cells_at)
}

/// To what the next arrays belong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Cells(usize),
    Other,
    Points(usize),
}

struct Legacy<'a> {
    cursor: Cursor<'a>,
    grid: CellGrid,
    cells_at: Place,
    cells: usize,
}

impl Legacy<'_> {
    fn header(&mut self) -> Result<(), MeshReadError> {
        let first = self.cursor.line().unwrap_or_default();
        if !first.to_ascii_lowercase().starts_with("# vtk datafile") {
            return Err(self.cursor.unexpected(&first, "`# vtk DataFile Version` on the first line"));
        }
        let _title = self.cursor.line();
        let encoding = self.cursor.line().unwrap_or_default();
        self.cursor.is_binary = match encoding.to_ascii_uppercase().as_str() {
            "ASCII" => false,
            "BINARY" => true,
            _ => return Err(self.cursor.unexpected(&encoding, "ASCII or BINARY on the third line")),
        };
        Ok(())
    }

    /// One keyword with its numbers.
    fn entry(&mut self, words: &[&str], section: &mut Section) -> Result<(), MeshReadError> {
        match words[0].to_ascii_uppercase().as_str() {
            "DATASET" if words.get(1).is_some_and(|w| w.eq_ignore_ascii_case("UNSTRUCTURED_GRID")) => Ok(()),
            "DATASET" => Err(MeshReadError::Unsupported {
                what: format!("the VTK data set {}", excerpt(words.get(1).unwrap_or(&"without a name"))),
                remedy: "save the mesh as an unstructured grid",
            }),
            "POINTS" => {
                let numbers = self.array(self.count(words, 1)?.saturating_mul(3), words.get(2))?;
                self.grid.points = numbers.as_chunks().0.to_vec();
                Ok(())
            }
            "CELLS" => self.read_cells(words),
            "CELL_TYPES" => {
                let count = self.count(words, 1)?;
                self.grid.shapes = self.cursor.numbers(count, NumberType::I32)?.into_iter().map(|x| x as u8).collect();
                Ok(())
            }
            "CELL_DATA" => self.count(words, 1).map(|count| *section = Section::Cells(count)),
            "POINT_DATA" => self.count(words, 1).map(|count| *section = Section::Points(count)),
            "METADATA" => {
                while self.cursor.line().is_some_and(|line| !line.is_empty()) {}
                Ok(())
            }
            "FIELD" => self.read_field(words, *section),
            _ => self.read_attribute(words, *section),
        }
    }

    /// The number at a place of a keyword line.
    fn count(&self, words: &[&str], at: usize) -> Result<usize, MeshReadError> {
        let word = words.get(at).copied().unwrap_or("nothing");
        word.parse().map_err(|_| self.cursor.unexpected(word, "a count"))
    }

    fn array(&mut self, count: usize, kind: Option<&&str>) -> Result<Vec<f64>, MeshReadError> {
        let name = kind.copied().unwrap_or("nothing");
        let kind =
            NumberType::of_name(name).ok_or_else(|| self.cursor.unexpected(name, "a type of numbers, e.g. float"))?;
        self.cursor.numbers(count, kind)
    }

    /// `CELLS n size` with the number of corners before each cell, or with lists of offsets and corners since version 5.
    fn read_cells(&mut self, words: &[&str]) -> Result<(), MeshReadError> {
        let (first, second) = (self.count(words, 1)?, self.count(words, 2)?);
        self.cells_at = self.cursor.place();
        let place = self.cells_at;
        let node = |x: f64| {
            let node = whole(x, place)?;
            u32::try_from(node).map_err(|_| MeshReadError::TooManyNodes { nodes: node })
        };
        if self.cursor.peek().is_some_and(|line| line.to_ascii_uppercase().starts_with("OFFSETS")) {
            let offsets = self.list("OFFSETS", first)?;
            let mut ends = increasing(&offsets, place)?;
            let corners = self.list("CONNECTIVITY", second)?;
            if !ends.is_empty() {
                ends.remove(0);
            }
            if ends.last().is_some_and(|end| *end > corners.len()) {
                return Err(self
                    .cursor
                    .unexpected(&format!("{} corners", corners.len()), "as many corners as the last offset says"));
            }
            self.grid.corners = corners.into_iter().map(node).collect::<Result<_, _>>()?;
            self.grid.ends = ends;
        } else {
            let numbers = self.cursor.numbers(second, NumberType::I32)?;
            let mut rest = &numbers[..];
            while let Some((&count, after)) = rest.split_first() {
                let Some((corners, after)) = after.split_at_checked(whole(count, place)?) else {
                    return Err(self
                        .cursor
                        .unexpected(&format!("a cell of {count} corners"), "as many corners as follow"));
                };
                self.grid.corners.extend(corners.iter().map(|x| node(*x)).collect::<Result<Vec<u32>, _>>()?);
                self.grid.ends.push(self.grid.corners.len());
                rest = after;
            }
            if self.grid.ends.len() != first {
                let found = format!("a list of {} cells", self.grid.ends.len());
                return Err(self.cursor.unexpected(&found, "as many cells as announced"));
            }
        }
        self.cells = self.grid.ends.len();
        Ok(())
    }

    fn list(&mut self, name: &'static str, count: usize) -> Result<Vec<f64>, MeshReadError> {
        let line = self.cursor.full_line().unwrap_or_default();
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words.first().is_some_and(|word| word.eq_ignore_ascii_case(name)) {
            true => self.array(count, words.get(1)),
            false => Err(self.cursor.unexpected(&line, name)),
        }
    }

    /// `FIELD name n`, then n arrays, each after a line `name components entries type`.
    fn read_field(&mut self, words: &[&str], section: Section) -> Result<(), MeshReadError> {
        for _ in 0..self.count(words, 2)? {
            let mut line = self.cursor.full_line();
            while line.as_ref().is_some_and(|line| line == "METADATA") {
                while self.cursor.line().is_some_and(|line| !line.is_empty()) {}
                line = self.cursor.full_line();
            }
            let Some(line) = line else {
                return Err(MeshReadError::CutOff { place: self.cursor.place(), expected: "an array of the field" });
            };
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let (components, entries) = (self.count(&words, 1)?, self.count(&words, 2)?);
            let numbers = self.array(components.saturating_mul(entries), words.get(3))?;
            self.keep(words[0], numbers, components, section);
        }
        Ok(())
    }

    /// An array of values at points or cells.
    fn read_attribute(&mut self, words: &[&str], section: Section) -> Result<(), MeshReadError> {
        let (Section::Cells(entries) | Section::Points(entries)) = section else {
            return Err(self.cursor.unexpected(words[0], "a keyword of an unstructured grid"));
        };
        let keyword = words[0].to_ascii_uppercase();
        let table_type = if self.cursor.is_binary { "unsigned_char" } else { "float" };
        let (components, kind) = match keyword.as_str() {
            "SCALARS" => (if words.len() > 3 { self.count(words, 3)? } else { 1 }, words.get(2).copied()),
            "COLOR_SCALARS" => (self.count(words, 2)?, Some(table_type)),
            "VECTORS" | "NORMALS" => (3, words.get(2).copied()),
            "TENSORS" => (9, words.get(2).copied()),
            "TENSORS6" => (6, words.get(2).copied()),
            "TEXTURE_COORDINATES" => (self.count(words, 2)?, words.get(3).copied()),
            "GLOBAL_IDS" | "PEDIGREE_IDS" => (1, words.get(2).copied()),
            "LOOKUP_TABLE" => {
                let colours = self.count(words, 2)?.saturating_mul(4);
                return self.array(colours, Some(&table_type)).map(|_| ());
            }
            _ => return Err(self.cursor.unexpected(words[0], "a keyword of cell or point data")),
        };
        if keyword == "SCALARS" && self.cursor.peek().is_some_and(|line| line.starts_with("LOOKUP_TABLE")) {
            self.cursor.full_line();
        }
        let numbers = self.array(entries.saturating_mul(components), kind.as_ref())?;
        self.keep(words.get(1).copied().unwrap_or_default(), numbers, components, section);
        Ok(())
    }

    fn keep(&mut self, name: &str, numbers: Vec<f64>, components: usize, section: Section) {
        if !matches!(section, Section::Cells(_)) {
            return;
        }
        match components == 1 && numbers.len() == self.cells {
            true => self.grid.cell_data.push((name.to_owned(), numbers)),
            false => self.grid.left_out.push(name.to_owned()),
        }
    }
}
