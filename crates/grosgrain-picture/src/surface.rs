//! What shading and line drawing need to know about a surface: normals and kinds of edges. A triangle is a quad whose last two corners are one.

use crate::{
    QuadSurface,
    camera::{Camera, Vec3, cross, dot, norm, unit},
};

/// Cosine of the angle from which on two neighbouring quads meet in a crease.
const CREASE: f64 = 0.75;

/// An edge of the surface and what makes it worth drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Edge {
    pub(crate) vertices: [u32; 2],
    pub(crate) kind: EdgeKind,
}

/// Why an edge is seen, the strongest reason first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum EdgeKind {
    /// Two categories meet.
    Boundary,
    /// The surface ends.
    Rim,
    /// One side is turned to the eye, the other away.
    Silhouette,
    /// Two quads meet at an angle.
    Crease,
    /// An edge within a smooth part.
    Cell,
}

/// Normals of a surface's quads and of their corners.
pub(crate) struct Normals {
    /// Unit normal per quad, turned to the eye; zero for a degenerate quad.
    pub(crate) of_quad: Vec<Vec3>,
    /// True where the quad's own orientation faces the eye.
    facing: Vec<bool>,
    /// Unit normal per quad corner, smoothed over neighbours up to a crease.
    pub(crate) of_corner: Vec<[Vec3; 4]>,
}

impl Normals {
    pub(crate) fn new(surface: &QuadSurface, camera: &Camera) -> Self {
        let corners = |quad: &[u32; 4]| quad.map(|v| surface.positions[v as usize]);
        let areas: Vec<Vec3> = surface.quads.iter().map(|q| quad_area(corners(q))).collect();
        let to_eye = |quad: &[u32; 4]| camera.to_eye(surface.positions[quad[0] as usize]);
        let facing: Vec<bool> = surface.quads.iter().zip(&areas).map(|(q, n)| dot(*n, to_eye(q)) > 0.0).collect();
        let turned: Vec<Vec3> = areas.iter().zip(&facing).map(|(n, f)| if *f { *n } else { n.map(|x| -x) }).collect();
        let of_quad: Vec<Vec3> = turned.iter().map(|n| unit(*n).unwrap_or([0.0; 3])).collect();
        let of_corner = corner_normals(surface, &turned, &of_quad);
        Self { of_quad, facing, of_corner }
    }
}

/// Half the cross product of the diagonals: the area vector of a quad, and of a triangle.
fn quad_area([a, b, c, d]: [Vec3; 4]) -> Vec3 {
    let diagonal = |p: Vec3, q: Vec3| -> Vec3 { std::array::from_fn(|k| q[k] - p[k]) };
    cross(diagonal(a, c), diagonal(b, d)).map(|x| 0.5 * x)
}

fn corner_normals(surface: &QuadSurface, areas: &[Vec3], units: &[Vec3]) -> Vec<[Vec3; 4]> {
    let around = quads_around_vertices(surface);
    let smooth = |quad: usize, vertex: u32| {
        let mut sum = [0.0; 3];
        for &other in around.of(vertex) {
            if dot(units[quad], units[other as usize]) > CREASE {
                sum = std::array::from_fn(|k| sum[k] + areas[other as usize][k]);
            }
        }
        unit(sum).unwrap_or(units[quad])
    };
    surface.quads.iter().enumerate().map(|(quad, corners)| corners.map(|v| smooth(quad, v))).collect()
}

/// The four or three vertices of a quad or triangle.
fn corners(quad: &[u32; 4]) -> &[u32] {
    if quad[2] == quad[3] { &quad[..3] } else { quad }
}

struct Incidence {
    start: Vec<usize>,
    quads: Vec<u32>,
}

impl Incidence {
    fn of(&self, vertex: u32) -> &[u32] {
        &self.quads[self.start[vertex as usize]..self.start[vertex as usize + 1]]
    }
}

fn quads_around_vertices(surface: &QuadSurface) -> Incidence {
    let mut start = vec![0; surface.positions.len() + 1];
    for v in surface.quads.iter().flat_map(corners) {
        start[*v as usize + 1] += 1;
    }
    for v in 1..start.len() {
        start[v] += start[v - 1];
    }
    let mut next = start.clone();
    let mut quads = vec![0; start[surface.positions.len()]];
    for (quad, vertices) in surface.quads.iter().enumerate() {
        for v in corners(vertices) {
            quads[next[*v as usize]] = quad as u32;
            next[*v as usize] += 1;
        }
    }
    Incidence { start, quads }
}

/// The edges, each once, of the faces that are turned to the eye.
pub(crate) fn edges_to_eye(surface: &QuadSurface, camera: &Camera) -> Vec<[u32; 2]> {
    let to_eye = |quad: &&[u32; 4]| {
        let area = quad_area(quad.map(|v| surface.positions[v as usize]));
        dot(area, camera.to_eye(surface.positions[quad[0] as usize])) > 0.0
    };
    let mut edges: Vec<[u32; 2]> = surface.quads.iter().filter(to_eye).flat_map(|quad| sides(corners(quad))).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// The edges of a quad or triangle, the lesser vertex first.
fn sides(corners: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| [*a.min(b), *a.max(b)])
}

/// Every edge once, with its kind. `category` gives the category of a quad.
pub(crate) fn edges(surface: &QuadSurface, normals: &Normals, category: impl Fn(usize) -> u32) -> Vec<Edge> {
    let mut all: Vec<([u32; 2], u32)> = Vec::with_capacity(4 * surface.quads.len());
    for (quad, corners) in surface.quads.iter().map(corners).enumerate() {
        all.extend(sides(corners).map(|edge| (edge, quad as u32)));
    }
    all.sort_unstable();
    let kind = |group: &[([u32; 2], u32)]| {
        let first = group[0].1 as usize;
        let others = || group.iter().map(|side| side.1 as usize);
        if others().any(|q| category(q) != category(first)) {
            EdgeKind::Boundary
        } else if group.len() == 1 {
            EdgeKind::Rim
        } else if group.len() == 2 && normals.facing[group[1].1 as usize] != normals.facing[first] {
            EdgeKind::Silhouette
        } else if group.len() != 2 || dot(normals.of_quad[first], normals.of_quad[group[1].1 as usize]) < CREASE {
            EdgeKind::Crease
        } else {
            EdgeKind::Cell
        }
    };
    all.chunk_by(|a, b| a.0 == b.0).map(|group| Edge { vertices: group[0].0, kind: kind(group) }).collect()
}

/// Light on a surface with the unit normal `n` (right, up, to the eye): a sky, a lamp at the upper left, a weak one at the right.
pub(crate) fn light(n: Vec3) -> f64 {
    const LAMP: Vec3 = [-0.45, 0.60, 0.66];
    const FILL: Vec3 = [0.85, 0.05, 0.52];
    let lambert = |lamp: Vec3| (dot(n, lamp) / norm(lamp)).max(0.0);
    (0.50 + 0.50 * lambert(LAMP) + 0.22 * lambert(FILL)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::View;

    fn two_quads(lift: f64) -> QuadSurface {
        QuadSurface {
            positions: vec![
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [2.0, 0.0, lift],
                [0.0, 1.0, 0.0],
                [1.0, 1.0, 0.0],
                [2.0, 1.0, lift],
            ],
            quads: vec![[0, 1, 4, 3], [1, 2, 5, 4]],
        }
    }

    fn shared_edge(lift: f64, category: fn(usize) -> u32) -> Option<EdgeKind> {
        let surface = two_quads(lift);
        let view = View { toward: [0.0, 0.1, -1.0], up: [0.0, 1.0, 0.0], perspective: 0.0 };
        let camera = Camera::new(Some(view), &surface.positions).ok()?;
        let normals = Normals::new(&surface, &camera);
        edges(&surface, &normals, category).iter().find(|e| e.vertices == [1, 4]).map(|e| e.kind)
    }

    #[test]
    fn an_edge_is_a_boundary_a_crease_or_just_a_cell_edge() {
        assert_eq!(shared_edge(0.0, |_| 0), Some(EdgeKind::Cell));
        assert_eq!(shared_edge(1.0, |_| 0), Some(EdgeKind::Crease));
        assert_eq!(shared_edge(0.0, |q| q as u32), Some(EdgeKind::Boundary));
    }

    #[test]
    fn a_triangle_has_three_edges_and_the_area_of_half_a_square() -> Result<(), crate::PictureError> {
        let square = two_quads(0.0);
        let surface =
            QuadSurface::of_triangles(square.positions.clone(), &[[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]);
        let view = View { toward: [0.0, 0.1, -1.0], up: [0.0, 1.0, 0.0], perspective: 0.0 };
        let camera = Camera::new(Some(view), &surface.positions)?;
        let normals = Normals::new(&surface, &camera);
        assert!(normals.of_quad.iter().all(|n| *n == [0.0, 0.0, 1.0]), "{:?}", normals.of_quad);
        assert_eq!(quad_area([[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 0.0]]), [0.0, 0.0, 0.5]);
        let edges = edges(&surface, &normals, |_| 0);
        let of_kind = |kind| edges.iter().filter(|e| e.kind == kind).count();
        // Six sides around, two diagonals and the side between the squares within.
        assert_eq!((of_kind(EdgeKind::Rim), of_kind(EdgeKind::Cell), edges.len()), (6, 3, 9));
        let around = quads_around_vertices(&surface);
        assert_eq!((around.of(4), around.of(1)), (&[0, 1, 3][..], &[0, 2, 3][..]));
        Ok(())
    }

    #[test]
    fn only_edges_of_faces_turned_to_the_eye_are_wires() -> Result<(), crate::PictureError> {
        let mut surface = two_quads(0.0);
        let view = View { toward: [0.0, 0.1, -1.0], up: [0.0, 1.0, 0.0], perspective: 0.0 };
        let camera = Camera::new(Some(view), &surface.positions)?;
        assert_eq!(edges_to_eye(&surface, &camera).len(), 7);
        surface.quads[1].reverse();
        assert_eq!(edges_to_eye(&surface, &camera), [[0, 1], [0, 3], [1, 4], [3, 4]]);
        Ok(())
    }

    #[test]
    fn light_is_smooth_within_a_bend_and_breaks_at_a_crease() -> Result<(), crate::PictureError> {
        for (lift, shared) in [(0.2, true), (2.0, false)] {
            let surface = two_quads(lift);
            let camera = Camera::new(None, &surface.positions)?;
            let normals = Normals::new(&surface, &camera);
            assert_eq!(normals.of_corner[0][1] == normals.of_corner[1][0], shared, "lift {lift}");
        }
        Ok(())
    }
}
