//! Reading `.vtu`: text, inline base64, appended raw or base64, plain or by zlib, either byte order.

mod outline;
mod stream;

use super::cell_grid::CellGrid;
use crate::io::excerpt::excerpt;
use crate::io::mesh::{MeshFile, MeshReadError, Place};
use outline::{ArrayOutline, Outline, PieceOutline, Section, Store};
use stream::Stream;

/// Reads the body in a VTU file: its simplices of the highest dimension, with tags from the cell data of a usual name (`tag`, `label`, `material`, `gmsh:physical`,
/// `medit:ref`, …) or, if it is the only array of the cells, of any name. Several pieces are joined; their common nodes stay apart.
///
/// # Errors
/// Damaged files, other data sets than unstructured grids, compressors other than zlib, bodies of other cells than simplices.
pub fn read_vtu(bytes: &[u8]) -> Result<MeshFile, MeshReadError> {
    let outline = Outline::read(bytes)?;
    let file = File { bytes, outline: &outline };
    let mut grid = CellGrid::default();
    for piece in &outline.pieces {
        file.add(piece, &mut grid)?;
    }
    let place = outline.pieces.iter().flat_map(|p| &p.arrays).find(|a| a.name == "connectivity").map(|a| a.place);
    grid.into_file(place.unwrap_or(Place::Byte(0)))
}

/// A file whose mark-up is read.
struct File<'a> {
    bytes: &'a [u8],
    outline: &'a Outline,
}

impl File<'_> {
    fn add(&self, piece: &PieceOutline, grid: &mut CellGrid) -> Result<(), MeshReadError> {
        let (first_point, first_corner) = (grid.points.len(), grid.corners.len());
        if piece.points > 0 {
            let points = find(piece, Section::Points, None, "array of points")?;
            grid.points.extend_from_slice(self.numbers(points, piece.points, 3)?.as_chunks().0);
        }
        if piece.cells > 0 {
            let ends = find(piece, Section::Cells, Some("offsets"), "array offsets of cells")?;
            let ends = increasing(&self.numbers(ends, piece.cells, 1)?, ends.place)?;
            let corners = find(piece, Section::Cells, Some("connectivity"), "array connectivity of cells")?;
            let count = ends.last().copied().unwrap_or(0);
            let node = |x: f64| {
                whole(x, corners.place)?
                    .checked_add(first_point)
                    .and_then(|n| u32::try_from(n).ok())
                    .ok_or(MeshReadError::TooManyNodes { nodes: grid.points.len() })
            };
            let found = self.numbers(corners, count, 1)?;
            grid.corners.extend(found.into_iter().map(node).collect::<Result<Vec<u32>, _>>()?);
            grid.ends.extend(ends.into_iter().map(|end| first_corner + end));
            let shapes = find(piece, Section::Cells, Some("types"), "array types of cells")?;
            grid.shapes.extend(self.numbers(shapes, piece.cells, 1)?.into_iter().map(|x| x as u8));
        }
        self.add_cell_data(piece, grid)
    }

    /// Arrays with one number per cell that all pieces have.
    fn add_cell_data(&self, piece: &PieceOutline, grid: &mut CellGrid) -> Result<(), MeshReadError> {
        let before = grid.shapes.len() - piece.cells;
        let arrays = piece.arrays.iter().filter(|a| a.section == Section::CellData && piece.cells > 0);
        for array in arrays {
            let name = &array.name;
            match grid.cell_data.iter_mut().find(|(n, values)| n == name && values.len() == before) {
                _ if array.components != 1 || array.kind.is_none() => grid.left_out.push(name.clone()),
                None if before == 0 => grid.cell_data.push((name.clone(), self.numbers(array, piece.cells, 1)?)),
                None => grid.left_out.push(name.clone()),
                Some((_, values)) => values.extend(self.numbers(array, piece.cells, 1)?),
            }
        }
        let count = grid.shapes.len();
        let (whole, partial) = grid.cell_data.drain(..).partition(|(_, values)| values.len() == count);
        grid.cell_data = whole;
        let partial: Vec<(String, Vec<f64>)> = partial;
        grid.left_out.extend(partial.into_iter().map(|(name, _)| name));
        grid.left_out.sort();
        grid.left_out.dedup();
        Ok(())
    }

    /// The numbers of an array of `entries` with so many components.
    fn numbers(&self, array: &ArrayOutline, entries: usize, components: usize) -> Result<Vec<f64>, MeshReadError> {
        let place = array.place;
        let unexpected = |found: String, expected| MeshReadError::Unexpected { place, found, expected };
        if array.components != components {
            let found = format!("{} components of the array {}", array.components, array.name);
            return Err(unexpected(found, "three components of points, one of cells"));
        }
        let Some(kind) = array.kind else {
            return Err(unexpected(array.name.clone(), "an array of numbers"));
        };
        let too_many = |claimed: usize| MeshReadError::Claim {
            place,
            claimed: claimed as u64,
            what: "entries of an array",
            left: self.bytes.len(),
        };
        let count = entries.checked_mul(components).ok_or_else(|| too_many(entries))?;
        let needed = count.checked_mul(kind.size()).ok_or_else(|| too_many(entries))?;
        let encoding = self.outline.encoding;
        let bytes = match (array.store, &self.outline.appended) {
            (Store::Text(start), _) => return self.text_numbers(start, count, place),
            (Store::Base64(start), _) => Stream::new(&self.bytes[start..], true, place).array(needed, encoding)?,
            (Store::Appended(offset), Some(appended)) => {
                let rest = appended.start.checked_add(offset).and_then(|start| self.bytes.get(start..));
                let rest = rest.ok_or_else(|| unexpected(format!("offset {offset}"), "an offset within the file"))?;
                Stream::new(rest, appended.is_base64, place).array(needed, encoding)?
            }
            (Store::Appended(_), None) => {
                return Err(MeshReadError::Missing {
                    section: "element AppendedData",
                    remedy: "it holds the arrays; fetch or write the file again",
                });
            }
        };
        Ok(kind.numbers(&bytes, encoding.little_endian))
    }

    fn text_numbers(&self, start: usize, count: usize, place: Place) -> Result<Vec<f64>, MeshReadError> {
        let rest = &self.bytes[start..];
        let text = &rest[..rest.iter().position(|b| *b == b'<').unwrap_or(rest.len())];
        let mut numbers = Vec::new();
        for word in text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
            let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
            let found = || excerpt(&String::from_utf8_lossy(word));
            let unexpected = || MeshReadError::Unexpected { place, found: found(), expected: "a number in the array" };
            numbers.push(number.ok_or_else(unexpected)?);
        }
        match numbers.len() == count {
            true => Ok(numbers),
            false => {
                let found = format!("an array of {} numbers where {count} are needed", numbers.len());
                Err(MeshReadError::Unexpected {
                    place,
                    found,
                    expected: "an array with an entry for each point or cell",
                })
            }
        }
    }
}

fn find<'a>(
    piece: &'a PieceOutline,
    section: Section,
    name: Option<&str>,
    what: &'static str,
) -> Result<&'a ArrayOutline, MeshReadError> {
    let fits = |array: &&ArrayOutline| array.section == section && name.is_none_or(|name| array.name == name);
    let remedy = "fetch or write the file again";
    piece.arrays.iter().find(fits).ok_or(MeshReadError::Missing { section: what, remedy })
}

/// A number as a position.
pub(super) fn whole(x: f64, place: Place) -> Result<usize, MeshReadError> {
    match x >= 0.0 && x.fract() == 0.0 && x < (1u64 << 53) as f64 {
        true => Ok(x as usize),
        false => Err(MeshReadError::Unexpected { place, found: x.to_string(), expected: "a whole number from 0" }),
    }
}

/// Positions that do not decrease.
pub(super) fn increasing(numbers: &[f64], place: Place) -> Result<Vec<usize>, MeshReadError> {
    let positions = numbers.iter().map(|x| whole(*x, place)).collect::<Result<Vec<usize>, _>>()?;
    match positions.windows(2).find(|pair| pair[1] < pair[0]) {
        None => Ok(positions),
        Some(pair) => {
            let found = format!("{} after {}", pair[1], pair[0]);
            Err(MeshReadError::Unexpected { place, found, expected: "an offset that is not below the one before" })
        }
    }
}
