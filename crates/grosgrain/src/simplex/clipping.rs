//! The part of a simplex that lies within another one.
//!
//! A corner is known by its signed distances from the planes of the other simplex only. Where a plane crosses an edge, the simplex is split in two at the crossing; the
//! pieces have shares that are products of ratios in [0, 1]. Thus no share is negative and none loses digits, however small it is.

use super::SimplexMesh;
use crate::linalg::matrix3::{cross, dot};

/// Coordinates come rounded, and a distance gathers some roundings of its own; a corner that is nearer to a plane than that lies in it.
const ROUNDINGS: f64 = 8.0 * f64::EPSILON;

/// A plane through a face of a cell; its distances are signed, positive inside, and scaled by the size of the face.
///
/// The cell on the other side of the face has the same plane to the last bit with the other sign, so that both agree about every crossing: what one gains by rounding, the other loses.
#[derive(Clone, Copy, Debug)]
struct Plane {
    origin: [f64; 3],
    normal: [f64; 3],
    /// Bounds of the terms that were subtracted in `normal`.
    terms: [f64; 3],
    sign: f64,
}

impl Plane {
    /// The plane through the corners of a cell other than `opposite`.
    fn of_face(mesh: &SimplexMesh, cell: usize, opposite: usize) -> Self {
        let corners = mesh.cell(cell).len();
        let mut face = [[0.0; 3]; 3];
        (0..corners - 1).for_each(|n| face[n] = mesh.corner(cell, n + usize::from(n >= opposite)));
        let face = &mut face[..corners - 1];
        let order =
            |a: &[f64; 3], b: &[f64; 3]| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]));
        face.sort_unstable_by(order);
        if corners == 4 {
            start_between_short_edges(face);
        }
        let edge = |n: usize, otherwise: [f64; 3]| match face.get(n) {
            Some(end) => std::array::from_fn(|r| end[r] - face[0][r]),
            None => otherwise,
        };
        let (u, v) = (edge(1, [0.0, 1.0, 0.0]), edge(2, [0.0, 0.0, 1.0]));
        let (u_size, v_size) = (u.map(f64::abs), v.map(f64::abs));
        let terms = std::array::from_fn(|r| {
            let (s, t) = ((r + 1) % 3, (r + 2) % 3);
            u_size[s] * v_size[t] + u_size[t] * v_size[s]
        });
        let mut plane = Self { origin: face[0], normal: cross(&u, &v), terms, sign: 1.0 };
        if plane.height(mesh.corner(cell, opposite)) < 0.0 {
            plane.sign = -1.0;
        }
        plane
    }

    /// Distance from the plane on the side of its normal.
    fn height(&self, point: [f64; 3]) -> f64 {
        dot(&self.normal, &std::array::from_fn(|r| point[r] - self.origin[r]))
    }

    /// Greatest height of a point that may lie in the plane.
    fn rounding(&self, point: [f64; 3]) -> f64 {
        ROUNDINGS * (0..3).map(|r| self.terms[r] * (point[r].abs() + self.origin[r].abs())).sum::<f64>()
    }

    /// Distances of the corners of a simplex, zero for those in the plane.
    fn distances(&self, corners: &[[f64; 3]]) -> [f64; 4] {
        let mut heights = [0.0; 4];
        let mut within = [false; 4];
        for (n, corner) in corners.iter().enumerate() {
            heights[n] = self.height(*corner);
            within[n] = heights[n].abs() <= self.rounding(*corner);
        }
        let count = corners.len();
        if within[..count].iter().all(|w| *w) {
            // A simplex that seems to lie in the plane belongs to one side nevertheless.
            if heights[..count].iter().all(|h| *h == 0.0) {
                heights = [1.0; 4];
            }
        } else {
            (0..count).filter(|n| within[*n]).for_each(|n| heights[n] = 0.0);
        }
        heights.map(|h| self.sign * h)
    }
}

/// Turns a triangle so that its longest edge is opposite to the first corner: the normal then keeps most digits.
fn start_between_short_edges(face: &mut [[f64; 3]]) {
    let square = |a: [f64; 3], b: [f64; 3]| (0..3).map(|r| (a[r] - b[r]).powi(2)).sum::<f64>();
    let opposite = |n: usize| square(face[(n + 1) % 3], face[(n + 2) % 3]);
    let first = (1..3).fold(0, |longest, n| if opposite(n) > opposite(longest) { n } else { longest });
    face.rotate_left(first);
}

/// A cell as the intersection of the half-spaces of its faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfSpaces {
    planes: [Plane; 4],
    count: usize,
}

impl HalfSpaces {
    pub(super) fn of_cell(mesh: &SimplexMesh, cell: usize) -> Self {
        let count = mesh.cell(cell).len();
        Self { planes: std::array::from_fn(|n| Plane::of_face(mesh, cell, n.min(count - 1))), count }
    }

    /// The share of a simplex, from 0 to 1, that lies within.
    pub(super) fn share_of(&self, corners: &[[f64; 3]]) -> f64 {
        let mut distances = [[0.0; 4]; 4];
        let mut crossing = 0;
        for plane in &self.planes[..self.count] {
            let own = plane.distances(corners);
            let own = &own[..corners.len()];
            if own.iter().all(|d| *d <= 0.0) {
                return 0.0;
            }
            if own.iter().any(|d| *d < 0.0) {
                own.iter().enumerate().for_each(|(n, d)| distances[n][crossing] = *d);
                crossing += 1;
            }
        }
        share_inside(&mut distances[..corners.len()], 0, crossing)
    }
}

/// The share of a simplex in which all distances from `plane` up to `planes` are positive. `corners[n][k]` is the distance of corner n from plane k;
/// it is changed and restored.
fn share_inside(corners: &mut [[f64; 4]], plane: usize, planes: usize) -> f64 {
    for plane in plane..planes {
        let (mut inner, mut outer) = (0, 0);
        for n in 1..corners.len() {
            inner = if corners[n][plane] > corners[inner][plane] { n } else { inner };
            outer = if corners[n][plane] < corners[outer][plane] { n } else { outer };
        }
        let (most, least) = (corners[inner][plane], corners[outer][plane]);
        if least >= 0.0 {
            continue;
        }
        if most <= 0.0 {
            return 0.0;
        }
        let (to_outer, to_inner) = (most / (most - least), -least / (most - least));
        let (a, b) = (corners[inner], corners[outer]);
        let mut crossing: [f64; 4] = std::array::from_fn(|k| to_inner * a[k] + to_outer * b[k]);
        crossing[plane] = 0.0;
        corners[outer] = crossing;
        let near = to_outer * share_inside(corners, plane, planes);
        corners[outer] = b;
        corners[inner] = crossing;
        let far = to_inner * share_inside(corners, plane, planes);
        corners[inner] = a;
        return near + far;
    }
    1.0
}

#[cfg(test)]
mod tests {
    use super::super::Dimension;
    use super::*;
    use proptest::prelude::*;

    /// Share of a simplex of n corners above a plane that has these heights: Σ hᵢ₊ⁿ⁻¹ / Πⱼ (hᵢ − hⱼ), a divided difference.
    fn share_above(heights: &[f64]) -> f64 {
        let term = |i: usize| {
            let others = (0..heights.len()).filter(|j| *j != i).map(|j| heights[i] - heights[j]);
            heights[i].max(0.0).powi(heights.len() as i32 - 1) / others.product::<f64>()
        };
        (0..heights.len()).map(term).sum()
    }

    fn simplex(dimension: Dimension, corners: [[f64; 3]; 4]) -> Option<SimplexMesh> {
        let flat = |c: [f64; 3]| std::array::from_fn(|r| if r < dimension.axes() { c[r] } else { 0.0 });
        let nodes: Vec<[f64; 3]> = corners.map(flat).to_vec();
        let make = |cell| SimplexMesh::new(dimension, nodes.clone(), vec![cell], vec![0]).ok();
        make([0, 1, 2, 3]).or_else(|| make([1, 0, 2, 3]))
    }

    fn corners_of(mesh: &SimplexMesh) -> Vec<[f64; 3]> {
        mesh.cell(0).iter().map(|n| mesh.nodes()[*n as usize]).collect()
    }

    fn common(a: &SimplexMesh, b: &SimplexMesh) -> f64 {
        HalfSpaces::of_cell(b, 0).share_of(&corners_of(a)) * a.measure(0)
    }

    /// A convex polyhedron as polygons, clipped by half-spaces one after the other; its volume is a sum of cones from its first corner.
    fn clipped_polyhedron(a: &SimplexMesh, b: &SimplexMesh) -> f64 {
        let corners = corners_of(a);
        let mut faces: Vec<Vec<[f64; 3]>> = (0..4).map(|n| (1..4).map(|k| corners[(n + k) % 4]).collect()).collect();
        for n in 0..4 {
            let at = b.corner(0, (n + 1) % 4);
            let inward = b.gradients(0)[n];
            let height = |x: &[f64; 3]| dot(&inward, &std::array::from_fn(|r| x[r] - at[r]));
            let mut lid: Vec<[f64; 3]> = Vec::new();
            for face in &mut faces {
                let mut kept = Vec::new();
                for (x, y) in face.iter().zip(face.iter().cycle().skip(1)) {
                    let (p, q) = (height(x), height(y));
                    if p >= 0.0 {
                        kept.push(*x);
                    }
                    if (p < 0.0) != (q < 0.0) {
                        let crossing = std::array::from_fn(|r| (p * y[r] - q * x[r]) / (p - q));
                        kept.push(crossing);
                        lid.push(crossing);
                    }
                }
                *face = kept;
            }
            faces.retain(|face| face.len() > 2);
            if lid.len() > 2 {
                let centre: [f64; 3] =
                    std::array::from_fn(|r| lid.iter().map(|x| x[r]).sum::<f64>() / lid.len() as f64);
                let out = |x: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|r| x[r] - centre[r]) };
                let first = out(&lid[0]);
                let second = cross(&inward, &first);
                let scale = dot(&inward, &inward).sqrt();
                let angle = |x: &[f64; 3]| (dot(&second, &out(x)) / scale).atan2(dot(&first, &out(x)));
                lid.sort_by(|x, y| angle(x).total_cmp(&angle(y)));
                faces.push(lid);
            }
        }
        let Some(apex) = faces.first().map(|face| face[0]) else { return 0.0 };
        let from = |x: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|r| x[r] - apex[r]) };
        let cone = |face: &Vec<[f64; 3]>| -> f64 {
            let fan = (1..face.len() - 1).map(|n| dot(&from(&face[0]), &cross(&from(&face[n]), &from(&face[n + 1]))));
            fan.sum::<f64>().abs() / 6.0
        };
        faces.iter().map(cone).sum()
    }

    fn any_corners() -> impl Strategy<Value = [[f64; 3]; 4]> {
        prop::array::uniform4(prop::array::uniform3(-1.0..1.0f64))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn one_plane_cuts_off_what_a_divided_difference_says(heights in prop::array::uniform4(-1.0..1.0f64), corners in 2..5usize) {
            let mut apart = heights[..corners].to_vec();
            apart.sort_by(f64::total_cmp);
            prop_assume!(apart.windows(2).all(|pair| pair[1] - pair[0] > 1e-2));
            let mut distances = heights.map(|h| [h, 0.0, 0.0, 0.0]);
            let share = share_inside(&mut distances[..corners], 0, 1);
            prop_assert!((share - share_above(&heights[..corners])).abs() < 1e-9, "{}", share);
            prop_assert_eq!(distances, heights.map(|h| [h, 0.0, 0.0, 0.0]));
        }

        #[test]
        fn tetrahedra_share_what_the_clipped_polyhedron_holds(a in any_corners(), b in any_corners()) {
            let (Some(a), Some(b)) = (simplex(Dimension::Three, a), simplex(Dimension::Three, b)) else { return Ok(()) };
            prop_assume!(b.measure(0) > 1e-3);
            let (measure, other) = (common(&a, &b), clipped_polyhedron(&a, &b));
            prop_assert!((measure - other).abs() < 1e-13, "{measure} {other}");
        }

        /// |A ∩ B| by clipping A against that by clipping B: other planes, other corners.
        #[test]
        fn both_ways_give_the_same_measure(a in any_corners(), b in any_corners(), which in 0..3usize) {
            let dimension = [Dimension::One, Dimension::Two, Dimension::Three][which];
            let (Some(a), Some(b)) = (simplex(dimension, a), simplex(dimension, b)) else { return Ok(()) };
            prop_assume!(a.measure(0).min(b.measure(0)) > 1e-3);
            let (one, other) = (common(&a, &b), common(&b, &a));
            prop_assert!((one - other).abs() < 1e-13 && one >= 0.0, "{one} {other}");
            prop_assert!(one <= a.measure(0).min(b.measure(0)) * (1.0 + 1e-13));
        }
    }

    #[test]
    fn closed_forms_hold() {
        let unit = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for dimension in [Dimension::One, Dimension::Two, Dimension::Three] {
            let (axes, a) = (dimension.axes() as i32, simplex(dimension, unit).unwrap());
            for shift in [0.0, 0.25, 0.5, 0.9375] {
                // Moved along x, the common part is the same simplex, smaller.
                let b = simplex(dimension, unit.map(|c| [c[0] + shift, c[1], c[2]])).unwrap();
                let exact = a.measure(0) * (1.0 - shift).powi(axes);
                assert!((common(&a, &b) - exact).abs() < 1e-15, "{dimension}, {shift}");
            }
            for shift in [1.0, 1.5, -1.0] {
                let b = simplex(dimension, unit.map(|c| [c[0] + shift, c[1], c[2]])).unwrap();
                assert_eq!(common(&a, &b), 0.0, "{dimension}, {shift}");
            }
        }
        // Two regular tetrahedra in a cube, the stella octangula, have an octahedron in common: half of either.
        let even = [[0.0; 3], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
        let odd = even.map(|c| [1.0 - c[0], c[1], c[2]]);
        let (even, odd) = (simplex(Dimension::Three, even).unwrap(), simplex(Dimension::Three, odd).unwrap());
        assert!((common(&even, &odd) - 1.0 / 6.0).abs() < 1e-15);
    }
}
