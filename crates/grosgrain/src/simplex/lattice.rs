//! Meshes of boxes: a lattice of equal boxes, each cut into simplices.

use super::{BoundingBox, Dimension, OverlapError, SimplexMesh, SimplexMeshError};

/// How a box is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BoxCut {
    /// Along one diagonal, alike in all boxes, into d! cells: two triangles, six tetrahedra.
    #[default]
    Alike,
    /// Mirrored from box to neighbour: two triangles, five tetrahedra. No direction is preferred over its mirror image.
    Alternating,
}

/// Why there is no such lattice.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplexLatticeError {
    /// A number of boxes is zero, or there are more nodes than can be numbered.
    #[error("a lattice of {} × {} × {} boxes cannot be made; take at least one along each axis, and fewer than 2³⁰ in all", boxes[0], boxes[1], boxes[2])]
    Boxes {
        /// Along each axis.
        boxes: [usize; 3],
    },
    /// The box has no extent along an axis.
    #[error("the lattice reaches from {from} to {to} along {}; make it longer than zero", ["x", "y", "z"][*axis])]
    Extent {
        /// The axis, from 0.
        axis: usize,
        /// Least coordinate \[m\].
        from: f64,
        /// Greatest coordinate \[m\].
        to: f64,
    },
    /// Boxes are so long or thin that their cells count as flat.
    #[error(transparent)]
    Cells(#[from] SimplexMeshError),
    /// The boxes have no size.
    #[error("boxes of size {size} do not fill anything; give a length above zero")]
    Size {
        /// Length \[m\] of an edge.
        size: f64,
    },
    /// The object and the lattice do not meet.
    #[error(transparent)]
    Overlap(#[from] OverlapError),
    /// No cell of the lattice meets the object in the share asked for.
    #[error("no cell of the lattice is filled to {share} by the object; take smaller cells or a smaller share")]
    NothingLeft {
        /// Least share of a cell that the object must fill.
        share: f64,
    },
}

/// A lattice of equal boxes in d dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimplexLattice {
    /// d.
    pub dimension: Dimension,
    /// Number of boxes along each axis; those beyond d do not count.
    pub boxes: [usize; 3],
    /// What the boxes fill together; axes beyond d do not count.
    pub around: BoundingBox,
    /// How each box is cut.
    pub cut: BoxCut,
}

impl SimplexLattice {
    /// The mesh: nodes with x fastest, conforming, all tags zero.
    ///
    /// # Errors
    /// No or too many boxes, no extent, boxes so thin that their cells are flat.
    pub fn mesh(&self) -> Result<SimplexMesh, SimplexLatticeError> {
        let axes = self.dimension.axes();
        let boxes: [usize; 3] = std::array::from_fn(|r| if r < axes { self.boxes[r] } else { 1 });
        let count = boxes.iter().try_fold(1usize, |all, n| all.checked_mul(*n));
        if boxes.contains(&0) || count.is_none_or(|all| all >= 1 << 30) {
            return Err(SimplexLatticeError::Boxes { boxes });
        }
        for axis in 0..axes {
            let (from, to) = (self.around.lower[axis], self.around.upper[axis]);
            if !(to - from > 0.0 && (to - from).is_finite()) {
                return Err(SimplexLatticeError::Extent { axis, from, to });
            }
        }
        let points: [usize; 3] = std::array::from_fn(|r| if r < axes { boxes[r] + 1 } else { 1 });
        let nodes = places(points).map(|at| self.node(at)).collect();
        let patterns = [false, true].map(|mirrored| self.pattern(mirrored));
        let mut cells = Vec::with_capacity(count.unwrap_or(0) * patterns[0].len());
        for at in places(boxes) {
            let mirrored = self.cut == BoxCut::Alternating && at.iter().sum::<usize>() % 2 == 1;
            let number = |corner: usize| {
                let place: [usize; 3] = std::array::from_fn(|r| at[r] + (corner >> r & 1));
                (place[0] + points[0] * (place[1] + points[1] * place[2])) as u32
            };
            cells.extend(patterns[usize::from(mirrored)].iter().map(|cell| cell.map(number)));
        }
        let tags = vec![0; cells.len()];
        Ok(SimplexMesh::new(self.dimension, nodes, cells, tags)?)
    }

    fn node(&self, at: [usize; 3]) -> [f64; 3] {
        let BoundingBox { lower, upper } = self.around;
        std::array::from_fn(|r| {
            if r >= self.dimension.axes() {
                return 0.0;
            }
            // Both ends come out exactly.
            let (whole, part) = (self.boxes[r] as f64, at[r] as f64);
            (lower[r] * (whole - part) + upper[r] * part) / whole
        })
    }

    /// Cells of one box by its corners, bit r of a corner telling the side along axis r, all of positive measure.
    fn pattern(&self, mirrored: bool) -> Vec<[usize; 4]> {
        let mut cells = match (self.dimension, self.cut) {
            (Dimension::One, _) => vec![[0, 1, 0, 0]],
            (Dimension::Two, _) => vec![[0, 1, 3, 0], [0, 2, 3, 0]],
            (Dimension::Three, BoxCut::Alike) => {
                vec![[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]]
            }
            (Dimension::Three, BoxCut::Alternating) => {
                vec![[0, 3, 5, 6], [1, 0, 3, 5], [2, 0, 3, 6], [4, 0, 5, 6], [7, 3, 5, 6]]
            }
        };
        // A segment has no other half; mirroring along x turns the diagonals of the others.
        if mirrored && self.dimension != Dimension::One {
            cells.iter_mut().flatten().for_each(|corner| *corner ^= 1);
        }
        for cell in &mut cells {
            let side = |corner: usize, r: usize| f64::from((corner >> r & 1) as u32);
            let mut edges = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            for n in 0..self.dimension.axes() {
                (0..3).for_each(|r| edges[r][n] = side(cell[n + 1], r) - side(cell[0], r));
            }
            if crate::linalg::matrix3::determinant(&edges) < 0.0 {
                cell.swap(0, 1);
            }
        }
        cells
    }
}

/// All places of a lattice, x fastest.
fn places(count: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..count[2]).flat_map(move |k| (0..count[1]).flat_map(move |j| (0..count[0]).map(move |i| [i, j, k])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    const AROUND: BoundingBox = BoundingBox { lower: [-1.0, 0.3, 0.1], upper: [2.0, 1.0, 0.7] };

    fn lattice(dimension: Dimension, boxes: [usize; 3], cut: BoxCut) -> SimplexLattice {
        SimplexLattice { dimension, boxes, around: AROUND, cut }
    }

    #[test]
    fn cells_fill_the_box_and_share_whole_faces() {
        for (dimension, measure) in [(Dimension::One, 3.0), (Dimension::Two, 2.1), (Dimension::Three, 1.26)] {
            for cut in [BoxCut::Alike, BoxCut::Alternating] {
                let mesh = lattice(dimension, [4, 3, 2], cut).mesh().unwrap();
                assert!((mesh.total_measure() - measure).abs() < 1e-14, "{dimension}, {cut:?}");
                // In a conforming mesh a face has one or two cells, and those with one lie in a side of the box.
                let mut faces: HashMap<Vec<u32>, usize> = HashMap::new();
                for cell in 0..mesh.cell_count() {
                    for n in 0..dimension.corners() {
                        let mut face = mesh.cell(cell).to_vec();
                        face.remove(n);
                        face.sort_unstable();
                        *faces.entry(face).or_default() += 1;
                    }
                }
                for (face, cells) in faces {
                    let on = |r: usize, x: f64| face.iter().all(|node| mesh.nodes()[*node as usize][r] == x);
                    let outer = (0..dimension.axes()).any(|r| on(r, AROUND.lower[r]) || on(r, AROUND.upper[r]));
                    assert_eq!(cells, if outer { 1 } else { 2 }, "{dimension}, {cut:?}, {face:?}");
                }
            }
        }
    }

    #[test]
    fn boxes_give_six_or_five_tetrahedra() {
        let count = |cut| lattice(Dimension::Three, [4, 3, 2], cut).mesh().unwrap().cell_count();
        assert_eq!((count(BoxCut::Alike), count(BoxCut::Alternating)), (6 * 24, 5 * 24));
    }

    #[test]
    fn what_cannot_be_made_is_refused() {
        let none = lattice(Dimension::Three, [4, 0, 2], BoxCut::Alike).mesh().unwrap_err();
        assert_eq!(none, SimplexLatticeError::Boxes { boxes: [4, 0, 2] });
        let many = lattice(Dimension::Three, [1 << 40, 1 << 40, 1], BoxCut::Alike).mesh().unwrap_err();
        assert!(matches!(many, SimplexLatticeError::Boxes { .. }));
        let mut flat = lattice(Dimension::Two, [4, 1, 0], BoxCut::Alike);
        flat.around.upper[1] = 0.3;
        let message = flat.mesh().unwrap_err().to_string();
        assert_eq!(message, "the lattice reaches from 0.3 to 0.3 along y; make it longer than zero");
        flat.around.upper[1] = 0.3 + 1e-13;
        assert!(matches!(flat.mesh().unwrap_err(), SimplexLatticeError::Cells(_)));
    }
}
