//! Elements and vertices of the coarse model: the connected parts of coarse cells, and the copies of coarse nodes they need.

use super::copies::CopyFinder;
use super::parts::{PartFinder, VOID};
use super::{CellPart, CoarseCell, CoarseNode, Partition};
use crate::assembly::{CellStiffness, Window};
use crate::linalg::{nested_dissection, postordered};
use crate::mesh::{Cell, Node};

/// A copy of a coarse node; ordered by node, then copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Vertex {
    /// The coarse node at whose place it stands.
    pub node: CoarseNode,
    /// Number of the copy.
    pub copy: u32,
}

/// The mesh of a coarse model that keeps the topology of the fine one (`nesme2009preserving`).
///
/// Elements are the connected parts of coarse cells ([`CellPart`]). At a coarse node two parts around it use the same vertex when they share a
/// fine node, directly or through other parts around that node; the copies are numbered by their smallest part. Elements are ascending, vertices too.
/// Everything at a coarse node follows from the eight cells around it, which is what makes updates local.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CoarseMesh {
    partition: Partition,
    split: bool,
    /// Part number of every fine cell.
    part_of: Vec<u32>,
    /// Number of parts of every coarse cell.
    counts: Vec<u32>,
    elements: Vec<CellPart>,
    /// First element of every coarse cell, and the number of elements.
    first_element: Vec<u32>,
    /// The copy that each element uses at its corners.
    copies: Vec<[u32; 8]>,
    /// Number of copies of every coarse node.
    copy_counts: Vec<u32>,
    corners: Vec<[u32; 8]>,
    vertices: Vec<Vertex>,
    /// First vertex at every coarse node, and the number of vertices.
    first_vertex: Vec<u32>,
}

impl CoarseMesh {
    /// The mesh of a body whose fine cells are void where `void` says so (x fastest).
    ///
    /// # Panics
    /// Panics when `void` has not one entry per fine cell.
    pub fn new(void: &[bool], partition: &Partition) -> Self {
        Self::build(void, partition, true)
    }

    /// The mesh with one element per coarse cell that is not void and one vertex per coarse node that touches one, whatever
    /// hangs together inside.
    ///
    /// # Panics
    /// Panics when `void` has not one entry per fine cell.
    pub fn unsplit(void: &[bool], partition: &Partition) -> Self {
        Self::build(void, partition, false)
    }

    fn build(void: &[bool], partition: &Partition, split: bool) -> Self {
        let (cells, nodes) = (partition.coarse().cell_count(), partition.coarse().node_count());
        let mut mesh = Self {
            partition: *partition,
            split,
            part_of: vec![VOID; partition.fine().cell_count()],
            counts: vec![0; cells],
            elements: Vec::new(),
            first_element: vec![0; cells + 1],
            copies: Vec::new(),
            copy_counts: vec![0; nodes],
            corners: Vec::new(),
            vertices: Vec::new(),
            first_vertex: Vec::new(),
        };
        mesh.find_parts(void, (0..cells).map(CoarseCell));
        mesh.list_elements();
        mesh.find_copies((0..nodes).map(CoarseNode));
        mesh.number_vertices();
        mesh
    }

    /// Takes over a body that has changed in the listed coarse cells only: parts are found again in these, copies at the coarse nodes
    /// around them, and everything is numbered anew.
    ///
    /// # Panics
    /// Panics when `void` has not one entry per fine cell.
    pub fn update(&mut self, void: &[bool], changed: &[CoarseCell]) {
        self.find_parts(void, changed.iter().copied());
        self.list_elements();
        let mut nodes: Vec<CoarseNode> = changed.iter().flat_map(|cell| self.partition.corners(*cell)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        self.find_copies(nodes.into_iter());
        self.number_vertices();
    }

    fn find_parts(&mut self, void: &[bool], cells: impl Iterator<Item = CoarseCell>) {
        assert_eq!(void.len(), self.part_of.len(), "one entry per fine cell");
        let mut finder = PartFinder::new(&self.partition);
        for cell in cells {
            self.counts[cell.0] = finder.number((&self.partition, cell), void, self.split, &mut self.part_of);
        }
    }

    /// Lists the elements; those of cells with as many parts as before keep their copies.
    fn list_elements(&mut self) {
        let old_copies = std::mem::take(&mut self.copies);
        let old_first = std::mem::take(&mut self.first_element);
        self.elements.clear();
        self.first_element.reserve(old_first.len());
        for (cell, &count) in self.counts.iter().enumerate() {
            self.first_element.push(self.elements.len() as u32);
            self.elements.extend((0..count).map(|part| CellPart { cell: CoarseCell(cell), part }));
            let old = &old_copies[old_first[cell] as usize..old_first[cell + 1] as usize];
            match old.len() == count as usize {
                true => self.copies.extend_from_slice(old),
                false => self.copies.resize(self.elements.len(), [0; 8]),
            }
        }
        self.first_element.push(self.elements.len() as u32);
    }

    fn find_copies(&mut self, nodes: impl Iterator<Item = CoarseNode>) {
        let mut finder = CopyFinder::new(&self.partition);
        for node in nodes {
            let copies = finder.find(node, &self.part_of, &self.counts);
            self.copy_counts[node.0] = if self.split { copies } else { copies.min(1) };
            let at = self.partition.coarse().node_position(Node(node.0));
            for corner in 0..8 {
                let offset = [0, 1, 2].map(|a| -((corner >> a & 1) as isize));
                let Some(cell) = self.partition.coarse().neighbour(at, offset) else { continue };
                for part in 0..self.counts[cell.0] {
                    let copy = if self.split { finder.copy_of(corner, part) } else { 0 };
                    self.copies[(self.first_element[cell.0] + part) as usize][corner] = copy;
                }
            }
        }
    }

    fn number_vertices(&mut self) {
        self.vertices.clear();
        self.first_vertex.clear();
        for (node, &count) in self.copy_counts.iter().enumerate() {
            self.first_vertex.push(self.vertices.len() as u32);
            self.vertices.extend((0..count).map(|copy| Vertex { node: CoarseNode(node), copy }));
        }
        self.first_vertex.push(self.vertices.len() as u32);
        self.corners.clear();
        self.corners.extend(self.elements.iter().zip(&self.copies).map(|(element, copies)| {
            let nodes = self.partition.corners(element.cell);
            std::array::from_fn(|i| self.first_vertex[nodes[i].0] + copies[i])
        }));
    }

    /// The partition into coarse cells.
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// Whether coarse cells in several parts have several elements.
    pub fn splits(&self) -> bool {
        self.split
    }

    /// Whether every coarse cell has at most one part and every coarse node at most one copy, so that the mesh is a lattice.
    pub fn is_lattice(&self) -> bool {
        self.counts.iter().all(|n| *n <= 1) && self.copy_counts.iter().all(|n| *n <= 1)
    }

    /// The elements, ascending.
    pub fn elements(&self) -> &[CellPart] {
        &self.elements
    }

    /// Per element its corners as numbers of vertices, x fastest.
    pub fn corners(&self) -> &[[u32; 8]] {
        &self.corners
    }

    /// The vertices, ascending.
    pub fn vertices(&self) -> &[Vertex] {
        &self.vertices
    }

    /// Numbers of the vertices at a coarse node.
    pub fn vertices_at(&self, node: CoarseNode) -> std::ops::Range<usize> {
        self.first_vertex[node.0] as usize..self.first_vertex[node.0 + 1] as usize
    }

    /// Numbers of the elements of a coarse cell; none where it is void.
    pub fn elements_of(&self, cell: CoarseCell) -> std::ops::Range<usize> {
        self.first_element[cell.0] as usize..self.first_element[cell.0 + 1] as usize
    }

    /// Number of an element, `None` where there is none.
    pub fn index_of(&self, element: CellPart) -> Option<usize> {
        self.elements_of(element.cell).nth(element.part as usize)
    }

    /// Number of the element that holds a fine cell, `None` for a void.
    pub fn element_at(&self, fine: Cell) -> Option<usize> {
        let at = self.partition.fine().cell_position(fine).map(|x| x / self.partition.degree());
        let cell = CoarseCell(self.partition.coarse().cell(at).0);
        match self.part_of[fine.0] {
            VOID => None,
            part => self.index_of(CellPart { cell, part }),
        }
    }

    /// The solid fine cells of an element, x fastest, each with its number in the coarse cell.
    pub fn fine_cells(&self, element: CellPart) -> impl Iterator<Item = (usize, Cell)> {
        let cells = self.partition.fine_cells(element.cell).enumerate();
        cells.filter(move |(_, cell)| self.part_of[cell.0] == element.part)
    }

    /// Which of the (d + 1)³ fine nodes of the coarse cell touch a solid fine cell of the element.
    pub fn touched_nodes(&self, element: CellPart) -> Vec<bool> {
        let local = self.partition.cell_lattice();
        let mut touched = vec![false; local.node_count()];
        for (index, _) in self.fine_cells(element) {
            local.corners(Cell(index)).iter().for_each(|n| touched[n.0] = true);
        }
        touched
    }

    /// Which of the (d + 1)³ fine nodes of the coarse cell touch a solid fine cell of the element or of one in a neighbouring coarse cell that shares
    /// a vertex with it: what moves with the element's material.
    pub fn tied_nodes(&self, element: CellPart) -> Vec<bool> {
        let mut tied = self.touched_nodes(element);
        let Some(own) = self.index_of(element).filter(|_| !tied.iter().all(|t| *t)) else { return tied };
        let moves_along = |fine: Cell| {
            let other = self.element_at(fine).filter(|other| self.elements[*other].cell != element.cell);
            other.is_some_and(|other| self.corners[other].iter().any(|v| self.corners[own].contains(v)))
        };
        for (tied, node) in tied.iter_mut().zip(self.partition.fine_nodes(element.cell)).filter(|(tied, _)| !**tied) {
            *tied = self.partition.fine().cells_at(node).any(moves_along);
        }
        tied
    }

    /// The fine nodes of an element: number in the coarse cell, and fine lattice node.
    pub fn fine_nodes(&self, element: CellPart) -> Vec<(u32, u32)> {
        let touched = self.touched_nodes(element);
        let nodes = self.partition.fine_nodes(element.cell).enumerate().filter(|(n, _)| touched[*n]);
        nodes.map(|(n, node)| (n as u32, node.0 as u32)).collect()
    }

    /// The fine cells of the element's coarse cell as a lattice of their own, in which other parts are void.
    pub fn window<'a>(&self, fine: &'a dyn CellStiffness, element: CellPart) -> Window<'a> {
        let cells = self.partition.cell_box(element.cell);
        let window = Window::new(fine, cells.start, cells.cells);
        match self.counts[element.cell.0] {
            0 | 1 => window,
            _ => {
                let own = self.partition.fine_cells(element.cell).map(|c| self.part_of[c.0] == element.part);
                window.limited_to(own.collect())
            }
        }
    }

    /// The vertices in the order in which a factorisation should eliminate them: nested dissection of the coarse nodes with
    /// all copies of a node in its place, and of the same eliminations the order that keeps the sides of a cut together.
    pub fn elimination_order(&self) -> Vec<u32> {
        let nodes = nested_dissection(self.partition.coarse().nodes());
        let copies = |n: u32| self.first_vertex[n as usize]..self.first_vertex[n as usize + 1];
        postordered(&nodes.into_iter().flat_map(copies).collect::<Vec<_>>(), self.corners())
    }
}

#[cfg(test)]
mod tests;
