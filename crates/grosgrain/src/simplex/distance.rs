//! Distances of points from cells.

use super::SimplexMesh;
use crate::linalg::matrix3::dot;

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| a[r] - b[r])
}

fn squared_norm(v: [f64; 3]) -> f64 {
    dot(&v, &v)
}

/// Square of the distance \[m²\] of a point from a cell, zero inside.
pub(super) fn squared_distance(mesh: &SimplexMesh, cell: usize, point: [f64; 3]) -> f64 {
    let corner = |n: usize| difference(mesh.corner(cell, n), point);
    match mesh.cell(cell).len() {
        2 => from_segment(corner(0), corner(1)),
        3 => from_triangle([corner(0), corner(1), corner(2)]),
        _ if mesh.barycentric(cell, point).iter().all(|w| *w >= 0.0) => 0.0,
        _ => (0..4).map(|n| from_triangle([1, 2, 3].map(|k| corner((n + k) % 4)))).fold(f64::INFINITY, f64::min),
    }
}

/// Square of the distance \[m²\] of a point from a point, segment or triangle with these corners.
pub(crate) fn squared_distance_of_face(corners: &[[f64; 3]], point: [f64; 3]) -> f64 {
    let from = |n: usize| difference(corners[n], point);
    match corners.len() {
        1 => squared_norm(from(0)),
        2 => from_segment(from(0), from(1)),
        _ => from_triangle([from(0), from(1), from(2)]),
    }
}

/// Square of the distance of the origin from a segment.
fn from_segment(a: [f64; 3], b: [f64; 3]) -> f64 {
    let along = difference(b, a);
    let at = (-dot(&a, &along) / squared_norm(along)).clamp(0.0, 1.0);
    squared_norm(std::array::from_fn(|r| a[r] + at * along[r]))
}

/// Square of the distance of the origin from a triangle: from the point of its plane below the origin if this is inside, else from the nearest edge.
fn from_triangle([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let (u, v) = (difference(b, a), difference(c, a));
    let (uu, uv, vv) = (squared_norm(u), dot(&u, &v), squared_norm(v));
    let (au, av) = (-dot(&a, &u), -dot(&a, &v));
    let (second, third, gram) = (vv * au - uv * av, uu * av - uv * au, uu * vv - uv * uv);
    let edges = from_segment(a, b).min(from_segment(b, c)).min(from_segment(c, a));
    if gram > 0.0 && second >= 0.0 && third >= 0.0 && second + third <= gram {
        let (s, t) = (second / gram, third / gram);
        // A needle's foot point may be rounded off its place; it is never nearer than the true one.
        return edges.min(squared_norm(std::array::from_fn(|r| a[r] + s * u[r] + t * v[r])));
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::super::Dimension;
    use super::*;
    use proptest::prelude::*;

    const CORNERS: [[f64; 3]; 4] = [[0.3, 0.1, -0.2], [1.2, 0.0, 0.1], [0.1, 0.9, 0.2], [0.4, 0.3, 1.5]];

    fn cell(dimension: Dimension) -> SimplexMesh {
        let flat = |c: &[f64; 3]| std::array::from_fn(|r| if r < dimension.axes() { c[r] } else { 0.0 });
        let nodes = CORNERS.iter().map(flat).collect();
        SimplexMesh::new(dimension, nodes, vec![[0, 1, 2, 3]], vec![0]).unwrap()
    }

    proptest! {
        /// The foot of the point is where the squared distance is stationary: no convex combination comes nearer, and some come as near.
        #[test]
        fn no_point_of_a_cell_is_nearer_than_its_distance(point in prop::array::uniform3(-2.0..3.0f64), which in 0..3usize) {
            let dimension = [Dimension::One, Dimension::Two, Dimension::Three][which];
            let (mesh, point) = (cell(dimension), std::array::from_fn(|r| if r <= which { point[r] } else { 0.0 }));
            let least = squared_distance(&mesh, 0, point);
            // Frank-Wolfe with exact steps, a slow but independent minimiser over the simplex; its gap bounds the error.
            let mut x = mesh.corner(0, 0);
            for _ in 0..4000 {
                let slope = difference(x, point);
                let value = |n: &usize| dot(&slope, &mesh.corner(0, *n));
                let best = (0..dimension.corners()).min_by(|a, b| value(a).total_cmp(&value(b))).unwrap();
                let along = difference(mesh.corner(0, best), x);
                let step = (-dot(&slope, &along) / squared_norm(along).max(1e-300)).clamp(0.0, 1.0);
                x = std::array::from_fn(|r| x[r] + step * along[r]);
            }
            let slope = difference(x, point);
            let lowest = (0..dimension.corners()).map(|n| dot(&slope, &difference(mesh.corner(0, n), x))).fold(0.0, f64::min);
            let found = squared_norm(slope);
            prop_assert!(least <= found + 1e-12 && least >= found + 2.0 * lowest - 1e-12, "{least} {found} {lowest}");
        }
    }

    #[test]
    fn distances_are_those_of_closed_forms() {
        let mesh = SimplexMesh::new(
            Dimension::Three,
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            vec![[0, 1, 2, 3]],
            vec![0],
        );
        let mesh = mesh.unwrap();
        let cases = [
            ([0.1, 0.1, 0.1], 0.0),
            ([0.2, 0.3, -2.0], 4.0),
            ([1.0, 1.0, 1.0], 4.0 / 3.0),
            ([0.5, -3.0, -4.0], 25.0),
            ([3.0, 0.0, 0.0], 4.0),
            ([-1.0, -2.0, -2.0], 9.0),
        ];
        for (point, squared) in cases {
            assert!((squared_distance(&mesh, 0, point) - squared).abs() < 1e-14, "{point:?}");
        }
    }
}
