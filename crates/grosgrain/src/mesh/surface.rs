//! The surface of a voxel body.

use super::{Cell, Lattice, Node};

/// A face between a solid cell and a void, or the outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryFace {
    /// The solid cell.
    pub cell: Cell,
    /// The face's corners, counter-clockwise seen from outside.
    pub corners: [Node; 4],
}

/// All faces between solid cells and voids or the outside, by cell, then −x, +x, −y, +y, −z, +z.
pub fn boundary_faces(void: &[bool], lattice: &Lattice) -> Vec<BoundaryFace> {
    let mut faces = Vec::new();
    for cell in (0..void.len()).map(Cell).filter(|c| !void[c.0]) {
        let at = lattice.cell_position(cell);
        let corners = lattice.corners(cell);
        for (axis, side) in (0..6).map(|f| (f / 2, f % 2)) {
            let mut offset = [0; 3];
            offset[axis] = 2 * side as isize - 1;
            if lattice.neighbour(at, offset).is_none_or(|other| void[other.0]) {
                faces.push(BoundaryFace { cell, corners: around(axis, side).map(|a| corners[a]) });
            }
        }
    }
    faces
}

/// Corner numbers of a face of a cell in order around it.
fn around(axis: usize, side: usize) -> [usize; 4] {
    let (b, c) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    let base = side << axis;
    match side {
        1 => [base, base + b, base + b + c, base + c],
        _ => [base, base + c, base + b + c, base + b],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_surface_of_a_box_is_closed_and_points_outwards() {
        let lattice = Lattice::new([3, 2, 2]);
        let faces = boundary_faces(&[false; 12], &lattice);
        assert_eq!(faces.len(), 2 * (3 * 2 + 3 * 2 + 2 * 2));
        let mut volume = 0.0;
        for face in faces {
            let x = face.corners.map(|n| lattice.node_position(n).map(|v| v as f64));
            let (u, v) = ([0, 1, 2].map(|a| x[1][a] - x[0][a]), [0, 1, 2].map(|a| x[3][a] - x[0][a]));
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            volume += (0..3).map(|a| x[0][a] * normal[a] / 3.0).sum::<f64>();
        }
        assert!((volume - 12.0).abs() < 1e-12, "volume by the divergence theorem: {volume}");
    }

    #[test]
    fn an_inner_void_has_a_surface() {
        let lattice = Lattice::new([3, 3, 3]);
        let mut void = [false; 27];
        void[13] = true;
        assert_eq!(boundary_faces(&void, &lattice).len(), 54 + 6);
    }
}
