//! Elements as a file lists them, of all dimensions, and the choice of those that make the body.

use super::{MeshFile, MeshReadError};
use crate::simplex::Dimension;
use std::collections::BTreeMap;

/// All elements of a file; nodes are counted from 0.
#[derive(Clone, Debug, Default)]
pub(in crate::io) struct Contents {
    pub nodes: Vec<[f64; 3]>,
    /// Names of tags by the dimension of what they name.
    pub names: Vec<(usize, i32, String)>,
    /// Sentences for [`MeshFile::skipped`].
    pub notes: Vec<String>,
    cells: [Vec<[u32; 4]>; 3],
    /// Tag and entity of each cell.
    tags: [Vec<[i32; 2]>; 3],
    others: BTreeMap<(usize, &'static str), usize>,
}

/// The dimension with so many axes.
const fn dimension_of(axes: usize) -> Dimension {
    match axes {
        1 => Dimension::One,
        2 => Dimension::Two,
        _ => Dimension::Three,
    }
}

impl Contents {
    /// Adds a segment, triangle or tetrahedron, told by its number of corners (two to four).
    pub fn add(&mut self, corners: &[u32], tag: i32) {
        self.add_or(corners, tag, tag);
    }

    /// As `add`, with the number of a geometric entity that is the tag if those of all cells of the body are 0.
    pub fn add_or(&mut self, corners: &[u32], tag: i32, entity: i32) {
        let mut cell = [u32::MAX; 4];
        cell[..corners.len()].copy_from_slice(corners);
        self.cells[corners.len() - 2].push(cell);
        self.tags[corners.len() - 2].push([tag, entity]);
    }

    /// Counts elements (if there are any) that are no simplices of two to four corners, e.g. `(0, "points")` or `(3, "hexahedra")`.
    pub fn add_other(&mut self, dimension: usize, plural: &'static str, count: usize) {
        if count > 0 {
            *self.others.entry((dimension, plural)).or_default() += count;
        }
    }

    /// The elements of the highest dimension as a body: turned right side out, without copies, without nodes that none of them uses.
    pub fn into_file(mut self) -> Result<MeshFile, MeshReadError> {
        let axes = self.body_axes()?;
        let dimension = dimension_of(axes);
        let corners = dimension.corners();
        let cells = std::mem::take(&mut self.cells[axes - 1]);
        let tags = self.tags_of_body(axes);
        let nodes = self.nodes.len();
        for (cell, nodes_of_cell) in cells.iter().enumerate() {
            if let Some(node) = nodes_of_cell[..corners].iter().find(|n| **n as usize >= nodes) {
                return Err(crate::simplex::SimplexMeshError::NoSuchNode { cell, node: *node, nodes }.into());
            }
        }
        let mut skipped = std::mem::take(&mut self.notes);
        skipped.extend(self.left_out(axes));
        let names = self.names.into_iter().filter(|(d, ..)| *d == axes).map(|(_, tag, name)| (tag, name)).collect();
        let mut file = MeshFile { dimension, nodes: self.nodes, cells, tags, names, skipped };
        drop_copies(&mut file);
        drop_unused_nodes(&mut file);
        turn_inverted(&mut file);
        Ok(file)
    }

    /// Groups of the cells, or their entities where no cell is in a group.
    fn tags_of_body(&mut self, axes: usize) -> Vec<i32> {
        let tags = std::mem::take(&mut self.tags[axes - 1]);
        let by_entity = tags.iter().all(|[tag, _]| *tag == 0) && tags.iter().any(|[_, entity]| *entity != 0);
        if by_entity {
            self.names.clear();
            self.notes.push("no cell is in a physical group: tags are the numbers of geometric entities".into());
        }
        tags.iter().map(|pair| pair[usize::from(by_entity)]).collect()
    }

    /// Number of axes of the body; all elements of that dimension must be simplices.
    fn body_axes(&self) -> Result<usize, MeshReadError> {
        let simplices = (1..=3).rev().find(|axes| !self.cells[axes - 1].is_empty()).unwrap_or(0);
        match self.others.iter().next_back() {
            Some((&(axes, plural), &count)) if axes >= simplices.max(1) => {
                Err(MeshReadError::NotSimplices { kind: plural, count })
            }
            _ if simplices == 0 => Err(MeshReadError::NoCells { nodes: self.nodes.len() }),
            _ => Ok(simplices),
        }
    }

    fn left_out(&self, axes: usize) -> Vec<String> {
        let simplices = (1..axes).map(|a| (dimension_of(a).to_string(), self.cells[a - 1].len()));
        let others = self.others.iter().map(|((_, plural), count)| ((*plural).to_owned(), *count));
        let all = others.chain(simplices).filter(|(_, count)| *count > 0);
        all.map(|(plural, count)| format!("{plural} left out: {count}")).collect()
    }
}

/// Keeps the first of cells with the same nodes: some programs write a cell once per group it is in.
fn drop_copies(file: &mut MeshFile) {
    let mut keys: Vec<([u32; 4], usize)> = file.cells.iter().copied().zip(0..).collect();
    keys.iter_mut().for_each(|(key, _)| key.sort_unstable());
    keys.sort_unstable();
    let mut is_copy = vec![false; keys.len()];
    keys.windows(2).filter(|pair| pair[0].0 == pair[1].0).for_each(|pair| is_copy[pair[1].1] = true);
    let copies = is_copy.iter().filter(|copy| **copy).count();
    if copies > 0 {
        let mut flags = is_copy.iter();
        file.cells.retain(|_| !flags.next().is_some_and(|copy| *copy));
        let mut flags = is_copy.iter();
        file.tags.retain(|_| !flags.next().is_some_and(|copy| *copy));
        file.skipped.push(format!("{} left out that were listed before: {copies}", file.dimension));
    }
}

/// Keeps the nodes that cells name, in their order.
fn drop_unused_nodes(file: &mut MeshFile) {
    let corners = file.dimension.corners();
    let mut place = vec![u32::MAX; file.nodes.len()];
    file.cells.iter().flat_map(|cell| &cell[..corners]).for_each(|node| place[*node as usize] = 0);
    let mut next = 0;
    for new in place.iter_mut().filter(|p| **p == 0) {
        *new = next;
        next += 1;
    }
    let unused = file.nodes.len() - next as usize;
    if unused > 0 {
        let mut places = place.iter();
        file.nodes.retain(|_| places.next().is_some_and(|p| *p != u32::MAX));
        file.cells.iter_mut().flat_map(|cell| &mut cell[..corners]).for_each(|node| *node = place[*node as usize]);
        file.skipped.push(format!("nodes left out that no cell uses: {unused}"));
    }
}

/// Swaps two corners of every cell of negative measure.
fn turn_inverted(file: &mut MeshFile) {
    let axes = file.dimension.axes();
    let mut turned = 0;
    for cell in &mut file.cells {
        let first = file.nodes[cell[0] as usize];
        let mut edges = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for n in 0..axes {
            let other = file.nodes[cell[n + 1] as usize];
            (0..3).for_each(|r| edges[r][n] = other[r] - first[r]);
        }
        if crate::linalg::matrix3::determinant(&edges) < 0.0 {
            cell.swap(axes - 1, axes);
            turned += 1;
        }
    }
    if turned > 0 {
        file.skipped.push(format!("{} that were inside out and have been turned: {turned}", file.dimension));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 3]; 5] =
        [[9.0, 9.0, 9.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    fn contents() -> Contents {
        Contents { nodes: CORNERS.to_vec(), ..Contents::default() }
    }

    #[test]
    fn the_highest_dimension_is_the_body_and_everything_else_is_named() {
        let mut all = contents();
        all.add(&[1, 2, 3, 4], 5);
        all.add(&[1, 3, 2], 6);
        all.add(&[1, 2], 6);
        all.add_other(0, "points", 3);
        all.names = vec![(2, 6, "skin".into()), (3, 5, "liver".into())];
        let file = all.into_file().unwrap();
        assert_eq!(
            (file.dimension, &file.tags[..], &file.cells[..]),
            (Dimension::Three, &[5][..], &[[0, 1, 2, 3]][..])
        );
        assert_eq!(file.nodes, CORNERS[1..]);
        assert_eq!(file.names, [(5, "liver".to_owned())]);
        let left = [
            "points left out: 3",
            "segments left out: 1",
            "triangles left out: 1",
            "nodes left out that no cell uses: 1",
        ];
        assert_eq!(file.skipped, left);
        assert!((file.into_mesh().unwrap().total_measure() - 1.0 / 6.0).abs() < 1e-16);
    }

    #[test]
    fn inverted_cells_are_turned_and_copies_go() {
        let mut all = contents();
        all.add(&[2, 1, 3, 4], 5);
        all.add(&[1, 2, 3, 4], 6);
        let file = all.into_file().unwrap();
        assert_eq!(file.tags, [5]);
        assert!(file.skipped.iter().any(|s| s == "tetrahedra that were inside out and have been turned: 1"));
        assert!(file.skipped.iter().any(|s| s == "tetrahedra left out that were listed before: 1"));
        assert!((file.into_mesh().unwrap().measure(0) - 1.0 / 6.0).abs() < 1e-16);
        let mut line = contents();
        line.add(&[2, 1], 0);
        assert_eq!(line.into_file().unwrap().into_mesh().unwrap().measure(0), 1.0);
        let mut plane = contents();
        plane.add(&[1, 3, 2], 0);
        assert_eq!(plane.into_file().unwrap().scaled(2.0).into_mesh().unwrap().measure(0), 2.0);
    }

    #[test]
    fn what_is_no_body_of_simplices_is_refused() {
        let mut mixed = contents();
        mixed.add(&[1, 2, 3, 4], 5);
        mixed.add_other(3, "hexahedra", 12);
        assert!(mixed.into_file().unwrap_err().to_string().contains("12 hexahedra"));
        assert!(matches!(contents().into_file().unwrap_err(), MeshReadError::NoCells { nodes: 5 }));
        let mut surface = contents();
        surface.add(&[2, 3, 4], 0);
        let error = surface.into_file().unwrap().into_mesh().unwrap_err();
        assert!(matches!(error, MeshReadError::Surface { node: 2, .. }), "{error}");
        let mut missing = contents();
        missing.add(&[1, 2, 3, 5], 0);
        assert!(missing.into_file().unwrap_err().to_string().contains("names node 5"));
    }
}
