//! A mesh of simplices of one dimension, with a tag per cell.

use super::SimplexMeshError;
use crate::linalg::matrix3::{cofactors, determinant};
use crate::linalg::sum_of_blocks;

/// Of what a mesh is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Dimension {
    /// Segments along x.
    One = 1,
    /// Triangles in the plane of x and y.
    Two = 2,
    /// Tetrahedra.
    Three = 3,
}

impl Dimension {
    /// d, the number of axes.
    pub const fn axes(self) -> usize {
        self as usize
    }

    /// d + 1, the number of corners of a cell.
    pub const fn corners(self) -> usize {
        self as usize + 1
    }

    /// d (d + 1) / 2, the number of components of a symmetric tensor and of harmonic displacements.
    pub const fn strains(self) -> usize {
        self as usize * (self as usize + 1) / 2
    }
}

impl std::fmt::Display for Dimension {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::One => "segments",
            Self::Two => "triangles",
            Self::Three => "tetrahedra",
        })
    }
}

/// Cells below this share of the measure of a regular simplex with their longest edge are flat.
const FLAT: f64 = 1e-10;
/// What the entries of a cell beyond its d + 1 corners hold.
const NO_NODE: u32 = u32::MAX;

/// Nodes, cells of d + 1 nodes each, all of positive measure, and a tag per cell that tells its material.
///
/// Coordinates \[m\] beyond the dimension are zero. Faces of cells may touch in any way; what else a body needs is checked where it is needed.
#[derive(Clone, Debug, PartialEq)]
pub struct SimplexMesh {
    dimension: Dimension,
    nodes: Vec<[f64; 3]>,
    cells: Vec<[u32; 4]>,
    tags: Vec<i32>,
}

impl SimplexMesh {
    /// A mesh of `cells`, of which the first d + 1 entries count.
    ///
    /// # Errors
    /// No cells, a number of tags that is not that of cells, coordinates that are not finite or not zero beyond the dimension, nodes that do not exist or stand twice in a
    /// cell, cells that are inside out or flat.
    pub fn new(
        dimension: Dimension,
        nodes: Vec<[f64; 3]>,
        mut cells: Vec<[u32; 4]>,
        tags: Vec<i32>,
    ) -> Result<Self, SimplexMeshError> {
        if cells.is_empty() {
            return Err(SimplexMeshError::Empty { dimension });
        }
        if cells.len() != tags.len() {
            return Err(SimplexMeshError::Tags { cells: cells.len(), tags: tags.len() });
        }
        let axes = dimension.axes();
        let is_place = |at: &[f64; 3]| at.iter().all(|x| x.is_finite()) && at[axes..].iter().all(|x| *x == 0.0);
        if let Some((node, at)) = nodes.iter().enumerate().find(|(_, at)| !is_place(at)) {
            return Err(SimplexMeshError::Coordinate { node, at: *at, axes });
        }
        for (cell, corners) in cells.iter_mut().enumerate() {
            corners[dimension.corners()..].fill(NO_NODE);
            check_corners(cell, &corners[..dimension.corners()], nodes.len())?;
        }
        let mesh = Self { dimension, nodes, cells, tags };
        mesh.check_measures()?;
        Ok(mesh)
    }

    fn check_measures(&self) -> Result<(), SimplexMeshError> {
        let (mut inverted, mut flat) = (Vec::new(), Vec::new());
        for cell in 0..self.cell_count() {
            let (measure, regular) = (self.measure(cell), self.regular_measure(cell));
            if measure == 0.0 || measure.abs() < FLAT * regular || !measure.is_finite() {
                flat.push((cell, measure));
            } else if measure < 0.0 {
                inverted.push((cell, measure));
            }
        }
        if let Some(&(cell, measure)) = flat.first() {
            return Err(SimplexMeshError::Flat { cell, measure, limit: FLAT, count: flat.len() });
        }
        match inverted.first() {
            Some(&(cell, measure)) => Err(SimplexMeshError::Inverted { cell, measure, count: inverted.len() }),
            None => Ok(()),
        }
    }

    /// Segments, triangles or tetrahedra.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// Positions \[m\] of the nodes.
    pub fn nodes(&self) -> &[[f64; 3]] {
        &self.nodes
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len()
    }

    /// The d + 1 nodes of a cell, so ordered that its measure is positive.
    pub fn cell(&self, cell: usize) -> &[u32] {
        &self.cells[cell][..self.dimension.corners()]
    }

    /// The tag of each cell.
    pub fn tags(&self) -> &[i32] {
        &self.tags
    }

    /// Position \[m\] of corner `corner` of a cell.
    pub fn corner(&self, cell: usize, corner: usize) -> [f64; 3] {
        self.nodes[self.cells[cell][corner] as usize]
    }

    /// Edges from the first corner of a cell to the others, as columns `edges[row][n]`; unit vectors beyond the dimension.
    pub fn edges(&self, cell: usize) -> [[f64; 3]; 3] {
        let first = self.corner(cell, 0);
        let mut edges = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for n in 0..self.dimension.axes() {
            let other = self.corner(cell, n + 1);
            (0..3).for_each(|r| edges[r][n] = other[r] - first[r]);
        }
        edges
    }

    /// Length \[m\], area \[m²\] or volume \[m³\] of a cell.
    pub fn measure(&self, cell: usize) -> f64 {
        determinant(&self.edges(cell)) / [1.0, 2.0, 6.0][self.dimension.axes() - 1]
    }

    /// Measure of a regular simplex with the longest edge of a cell.
    fn regular_measure(&self, cell: usize) -> f64 {
        let corners = self.dimension.corners();
        let square = |a: usize, b: usize| -> f64 {
            let (a, b) = (self.corner(cell, a), self.corner(cell, b));
            (0..3).map(|r| (a[r] - b[r]).powi(2)).sum()
        };
        let longest = (1..corners).flat_map(|b| (0..b).map(move |a| (a, b))).map(|(a, b)| square(a, b));
        let longest = longest.fold(0.0, f64::max).sqrt();
        longest.powi(self.dimension.axes() as i32)
            * [1.0, 3f64.sqrt() / 4.0, 2f64.sqrt() / 12.0][self.dimension.axes() - 1]
    }

    /// Gradients \[1/m\] of the d + 1 barycentric coordinates in a cell, zero beyond.
    pub fn gradients(&self, cell: usize) -> [[f64; 3]; 4] {
        let edges = self.edges(cell);
        let (cofactors, determinant) = (cofactors(&edges), determinant(&edges));
        let mut gradients = [[0.0; 3]; 4];
        for n in 0..self.dimension.axes() {
            for r in 0..self.dimension.axes() {
                gradients[n + 1][r] = cofactors[r][n] / determinant;
                gradients[0][r] -= gradients[n + 1][r];
            }
        }
        gradients
    }

    /// Barycentric coordinates of a point in a cell, negative outside of it, zero beyond d + 1.
    pub fn barycentric(&self, cell: usize, point: [f64; 3]) -> [f64; 4] {
        let (gradients, first) = (self.gradients(cell), self.corner(cell, 0));
        let mut weights: [f64; 4] =
            std::array::from_fn(|n| (0..3).map(|r| gradients[n][r] * (point[r] - first[r])).sum());
        weights[0] += 1.0;
        weights
    }

    /// Mean \[m\] of the corners of a cell.
    pub fn centre(&self, cell: usize) -> [f64; 3] {
        let corners = self.dimension.corners();
        std::array::from_fn(|r| (0..corners).map(|n| self.corner(cell, n)[r]).sum::<f64>() / corners as f64)
    }

    /// What the nodes have when every cell gives an equal part of what it has to each of its corners: of the masses of cells the lumped masses of nodes.
    pub fn lumped(&self, of_cell: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut of_nodes = vec![0.0; self.nodes.len()];
        for cell in 0..self.cell_count() {
            let part = of_cell(cell) / self.dimension.corners() as f64;
            self.cell(cell).iter().for_each(|node| of_nodes[*node as usize] += part);
        }
        of_nodes
    }

    /// The same mesh with the tags that `tag` gives to the centres \[m\] of cells.
    #[must_use]
    pub fn tagged(mut self, tag: impl Fn([f64; 3]) -> i32) -> Self {
        self.tags = (0..self.cell_count()).map(|cell| tag(self.centre(cell))).collect();
        self
    }

    /// The mesh of the cells that `keeps` accepts by their number, and the old number of each of them; nodes that none of them has are left out, the others keep their order.
    ///
    /// # Errors
    /// No cell is accepted.
    pub fn part(&self, keeps: impl Fn(usize) -> bool) -> Result<(Self, Vec<u32>), SimplexMeshError> {
        let kept: Vec<u32> = (0..self.cell_count()).filter(|cell| keeps(*cell)).map(|cell| cell as u32).collect();
        if kept.is_empty() {
            return Err(SimplexMeshError::Empty { dimension: self.dimension });
        }
        let mut numbers = vec![NO_NODE; self.nodes.len()];
        kept.iter().flat_map(|cell| self.cell(*cell as usize)).for_each(|node| numbers[*node as usize] = 0);
        let used = numbers.iter_mut().zip(&self.nodes).filter(|(number, _)| **number == 0);
        let nodes = used.zip(0..).map(|((number, at), n)| {
            *number = n;
            *at
        });
        let nodes = nodes.collect();
        let renumbered = |node: u32| numbers.get(node as usize).copied().unwrap_or(NO_NODE);
        let cells = kept.iter().map(|cell| self.cells[*cell as usize].map(renumbered)).collect();
        let tags = kept.iter().map(|cell| self.tags[*cell as usize]).collect();
        Ok((Self { dimension: self.dimension, nodes, cells, tags }, kept))
    }

    /// Sum of the measures of all cells.
    pub fn total_measure(&self) -> f64 {
        sum_of_blocks(self.cell_count(), &|from, to| [(from..to).map(|c| self.measure(c)).sum()])[0]
    }
}

fn check_corners(cell: usize, corners: &[u32], nodes: usize) -> Result<(), SimplexMeshError> {
    for (n, node) in corners.iter().enumerate() {
        if *node as usize >= nodes {
            return Err(SimplexMeshError::NoSuchNode { cell, node: *node, nodes });
        }
        if corners[..n].contains(node) {
            return Err(SimplexMeshError::Repeated { cell, node: *node });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron(nodes: [[f64; 3]; 4]) -> Result<SimplexMesh, SimplexMeshError> {
        SimplexMesh::new(Dimension::Three, nodes.to_vec(), vec![[0, 1, 2, 3]], vec![7])
    }

    const CORNERS: [[f64; 3]; 4] = [[0.3, 0.1, -0.2], [1.2, 0.0, 0.1], [0.1, 0.9, 0.2], [0.4, 0.3, 1.5]];

    #[test]
    fn gradients_and_barycentric_coordinates_reproduce_linear_fields() {
        let linear = |x: [f64; 3]| 2.0 + 3.0 * x[0] - 5.0 * x[1] + 0.7 * x[2];
        let slopes = [3.0, -5.0, 0.7];
        for dimension in [Dimension::One, Dimension::Two, Dimension::Three] {
            let (axes, n) = (dimension.axes(), dimension.corners());
            let nodes: Vec<[f64; 3]> =
                CORNERS.iter().map(|c| std::array::from_fn(|r| if r < axes { c[r] } else { 0.0 })).collect();
            let mesh = SimplexMesh::new(dimension, nodes, vec![[0, 1, 2, 3]], vec![0]).unwrap();
            let (gradients, weights) = (mesh.gradients(0), mesh.barycentric(0, [0.25, 0.0, 0.0]));
            let values: Vec<f64> = (0..n).map(|c| linear(mesh.corner(0, c))).collect();
            for r in 0..axes {
                let slope: f64 = (0..n).map(|c| gradients[c][r] * values[c]).sum();
                assert!((slope - slopes[r]).abs() < 1e-13, "{dimension}: {slope}");
            }
            let value: f64 = (0..n).map(|c| weights[c] * values[c]).sum();
            assert!((value - linear([0.25, 0.0, 0.0])).abs() < 1e-13, "{dimension}: {value}");
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14 && weights[n..].iter().all(|w| *w == 0.0));
        }
    }

    #[test]
    fn a_regular_simplex_has_the_measure_by_which_flatness_is_judged() {
        let nodes = [[0.0; 3], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
        let mesh = tetrahedron(nodes).unwrap();
        assert!((mesh.measure(0) - 1.0 / 3.0).abs() < 1e-15 && (mesh.regular_measure(0) - 1.0 / 3.0).abs() < 1e-15);
        assert!((mesh.total_measure() - 1.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn a_part_has_the_nodes_of_its_cells_in_their_order() {
        let nodes = [0.0, 4.0, 1.0, 3.0, 2.0].map(|x| [x, 0.0, 0.0]).to_vec();
        let cells = [[0, 2], [2, 4], [4, 3], [3, 1]].map(|[a, b]| [a, b, 0, 0]).to_vec();
        let mesh = SimplexMesh::new(Dimension::One, nodes, cells, vec![5, 6, 7, 8]).unwrap();
        let (part, cells) = mesh.part(|cell| cell > 1).unwrap();
        assert_eq!(cells, [2, 3]);
        assert_eq!(
            (part.nodes().iter().map(|x| x[0]).collect::<Vec<_>>(), part.tags()),
            (vec![4.0, 3.0, 2.0], &[7, 8][..])
        );
        assert_eq!((part.cell(0), part.cell(1), part.total_measure()), (&[2, 1][..], &[1, 0][..], 2.0));
        assert_eq!(mesh.part(|_| false).unwrap_err(), SimplexMeshError::Empty { dimension: Dimension::One });
        assert_eq!(mesh.lumped(|cell| [2.0, 4.0, 6.0, 8.0][cell]), [1.0, 4.0, 3.0, 7.0, 5.0]);
        assert_eq!(mesh.tagged(|x| (2.0 * x[0]) as i32).tags(), [1, 3, 5, 7]);
    }

    #[test]
    fn each_damage_is_refused_with_its_place() {
        let [a, b, c, d] = CORNERS;
        let inverted = tetrahedron([b, a, c, d]).unwrap_err();
        assert!(matches!(inverted, SimplexMeshError::Inverted { cell: 0, count: 1, .. }), "{inverted}");
        let between = std::array::from_fn(|r| 0.25 * a[r] + 0.5 * b[r] + 0.25 * c[r]);
        let flat = tetrahedron([a, b, c, between]).unwrap_err();
        assert!(matches!(flat, SimplexMeshError::Flat { cell: 0, .. }), "{flat}");
        for dimension in [Dimension::One, Dimension::Two, Dimension::Three] {
            let at_one_place = SimplexMesh::new(dimension, vec![[0.0; 3]; 4], vec![[0, 1, 2, 3]], vec![0]).unwrap_err();
            assert!(matches!(at_one_place, SimplexMeshError::Flat { cell: 0, .. }), "{at_one_place}");
        }
        let odd = tetrahedron([a, b, c, [f64::NAN; 3]]).unwrap_err();
        assert!(matches!(odd, SimplexMeshError::Coordinate { node: 3, .. }), "{odd}");
        let make = |cells: Vec<[u32; 4]>, tags| SimplexMesh::new(Dimension::Three, CORNERS.to_vec(), cells, tags);
        assert_eq!(
            make(vec![], vec![]).unwrap_err().to_string(),
            "the mesh has no tetrahedra; export the volume elements too"
        );
        assert_eq!(make(vec![[0, 1, 2, 3]], vec![]).unwrap_err(), SimplexMeshError::Tags { cells: 1, tags: 0 });
        let missing = make(vec![[0, 1, 2, 3], [0, 1, 2, 4]], vec![0, 0]).unwrap_err();
        assert_eq!(missing, SimplexMeshError::NoSuchNode { cell: 1, node: 4, nodes: 4 });
        let twice = make(vec![[0, 1, 2, 1]], vec![0]).unwrap_err();
        assert_eq!(twice, SimplexMeshError::Repeated { cell: 0, node: 1 });
    }
}
