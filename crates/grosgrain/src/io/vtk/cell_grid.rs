//! Points and cells as VTK's files list them, and how they become a body.

use crate::io::mesh::{Contents, MeshFile, MeshReadError, Place};

/// Cells of any shape.
#[derive(Debug, Default)]
pub(super) struct CellGrid {
    pub points: Vec<[f64; 3]>,
    /// VTK's number for the shape of each cell.
    pub shapes: Vec<u8>,
    /// Where in `corners` each cell ends.
    pub ends: Vec<usize>,
    /// Corners of all cells.
    pub corners: Vec<u32>,
    /// Arrays with one number per cell.
    pub cell_data: Vec<(String, Vec<f64>)>,
    /// Names of arrays that were not read.
    pub left_out: Vec<String>,
}

/// Names under which programs store the tags of cells, the most telling first; meshio writes those with a colon, VTK's segmentation tools `MaterialIds`, TetGen's
/// users `attribute`, DOLFINx `cell_tags`.
const TAG_NAMES: [&str; 23] = [
    "tag",
    "tags",
    "label",
    "labels",
    "material",
    "materials",
    "material_id",
    "materialid",
    "materialids",
    "gmsh:physical",
    "medit:ref",
    "tetgen:ref",
    "netgen:index",
    "cell_tags",
    "region",
    "region_id",
    "regionid",
    "attribute",
    "attributes",
    "subdomain",
    "part",
    "cellentityids",
    "gmsh:geometrical",
];

/// What VTK's number for a shape means: axes, corners if it is a simplex, name of several.
const fn shape(number: u8) -> (usize, Option<usize>, &'static str) {
    match number {
        0..=2 => (0, None, "points"),
        3 => (1, Some(2), "segments"),
        4 => (1, None, "polylines"),
        5 => (2, Some(3), "triangles"),
        6 | 7 => (2, None, "strips and polygons"),
        8 | 9 => (2, None, "quadrilaterals"),
        10 => (3, Some(4), "tetrahedra"),
        11 | 12 => (3, None, "hexahedra"),
        13 => (3, None, "wedges"),
        14 => (3, None, "pyramids"),
        21 | 35 | 68 => (1, None, "curved segments"),
        22 | 34 | 69 | 76 => (2, None, "triangles of higher order"),
        23 | 28 | 30 | 36 | 70 | 77 => (2, None, "quadrilaterals of higher order"),
        24 | 71 | 78 => (3, None, "tetrahedra of higher order"),
        _ => (3, None, "cells of other shapes"),
    }
}

impl CellGrid {
    /// The corners of a cell.
    fn corners_of(&self, cell: usize) -> &[u32] {
        let from = if cell == 0 { 0 } else { self.ends[cell - 1] };
        &self.corners[from..self.ends[cell]]
    }

    /// The simplices of the highest dimension; `ends` must not decrease and stay within `corners`, `place` is where the cells stand.
    pub fn into_file(mut self, place: Place) -> Result<MeshFile, MeshReadError> {
        let mut contents = Contents::default();
        contents.nodes = std::mem::take(&mut self.points);
        let tags = self.take_tags();
        for cell in 0..self.shapes.len() {
            let (axes, simplex, plural) = shape(self.shapes[cell]);
            match (simplex, self.corners_of(cell)) {
                (None, _) => contents.add_other(axes, plural, 1),
                (Some(count), corners) if count == corners.len() => {
                    if let Some(node) = corners.iter().find(|n| **n as usize >= contents.nodes.len()) {
                        return Err(MeshReadError::NoSuchNode { place, node: i64::from(*node) });
                    }
                    contents.add(corners, tags.get(cell).copied().unwrap_or(0));
                }
                (Some(_), corners) => {
                    let found = format!("cell {cell} with {} corners among {plural}", corners.len());
                    return Err(MeshReadError::Unexpected {
                        place,
                        found,
                        expected: "a cell with as many corners as its shape has",
                    });
                }
            }
        }
        if !self.left_out.is_empty() {
            contents.notes.push(format!("cell data left out: {}", self.left_out.join(", ")));
        }
        contents.into_file()
    }

    /// The array that holds the tags: the first of the usual names with whole numbers, else the only array that there is. The names of the others are kept.
    fn take_tags(&mut self) -> Vec<i32> {
        let place_of =
            |name: &str| self.cell_data.iter().position(|(n, v)| n.eq_ignore_ascii_case(name) && are_whole(v));
        let lone = match &self.cell_data[..] {
            [(_, values)] if self.left_out.is_empty() && are_whole(values) => Some(0),
            _ => None,
        };
        let found = TAG_NAMES.iter().find_map(|name| place_of(name)).or(lone);
        let tags = found.map_or_else(Vec::new, |at| self.cell_data.remove(at).1);
        self.left_out.extend(self.cell_data.drain(..).map(|(name, _)| name));
        tags.into_iter().map(|tag| tag as i32).collect()
    }
}

/// Whether all values are whole numbers of 32 bits.
fn are_whole(values: &[f64]) -> bool {
    values.iter().all(|x| f64::from(*x as i32) == *x)
}
