//! What a plane leaves of a mesh, and where it meets faces and cells.

use std::collections::HashMap;

use grosgrain::mesh::Label;
use grosgrain::simplex::SimplexMesh;

/// A half space that is cut away from a mesh at rest, so that its inside is seen.
///
/// Cells that the plane meets are cut through, so that the section is plane; it moves with the body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshCut {
    /// A point of the plane \[m\].
    pub through: [f64; 3],
    /// Normal of the plane, of any length, to the side that is cut away.
    pub away: [f64; 3],
    /// Cells with these tags stay whole, such as those of vessels.
    pub spared: Vec<Label>,
}

/// What is left of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Remains {
    Whole,
    Part,
    Nothing,
}

/// Which side of the plane is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Kept,
    Away,
}

/// A point between two nodes: (1 − share) of the first and share of the second; a node stands twice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    pub(super) nodes: [u32; 2],
    pub(super) share: f64,
}

/// Cuts polygons and cells, and numbers the points that come out.
pub(super) struct Cutter {
    /// Height of each node over the plane; below all nodes without a cut.
    heights: Vec<f64>,
    numbers: HashMap<[u32; 2], u32>,
    pub(super) vertices: Vec<Vertex>,
}

impl Cutter {
    pub(super) fn new(mesh: &SimplexMesh, cut: Option<&MeshCut>) -> Self {
        let height =
            |at: &[f64; 3]| cut.map_or(-1.0, |cut| (0..3).map(|r| (at[r] - cut.through[r]) * cut.away[r]).sum::<f64>());
        Self { heights: mesh.nodes().iter().map(height).collect(), numbers: HashMap::new(), vertices: Vec::new() }
    }

    fn height(&self, node: u32) -> f64 {
        self.heights[node as usize]
    }

    /// What is left of a cell of these nodes.
    pub(super) fn remains(&self, corners: &[u32]) -> Remains {
        let any = |has: fn(f64) -> bool| corners.iter().any(|node| has(self.height(*node)));
        match (any(|h| h < 0.0), any(|h| h > 0.0)) {
            (_, false) => Remains::Whole,
            (true, true) => Remains::Part,
            (false, true) => Remains::Nothing,
        }
    }

    /// A polygon as vertices.
    pub(super) fn whole(&mut self, polygon: &[u32]) -> Vec<u32> {
        polygon.iter().map(|node| self.node(*node)).collect()
    }

    /// The part of a convex polygon on one side, as vertices; fewer than three where there is none.
    pub(super) fn clip(&mut self, polygon: &[u32], side: Side) -> Vec<u32> {
        let sign = if side == Side::Kept { 1.0 } else { -1.0 };
        let mut part = Vec::with_capacity(4);
        for (n, &a) in polygon.iter().enumerate() {
            let b = polygon[(n + 1) % polygon.len()];
            let (here, next) = (sign * self.height(a), sign * self.height(b));
            if here <= 0.0 {
                part.push(self.node(a));
            }
            if here < 0.0 && next > 0.0 || here > 0.0 && next < 0.0 {
                part.push(self.crossing(a, b));
            }
        }
        part
    }

    /// The polygon in which the plane cuts a tetrahedron that has nodes on both sides.
    pub(super) fn section(&mut self, corners: &[u32]) -> Vec<u32> {
        let on = |has: fn(f64) -> bool| -> Vec<u32> {
            corners.iter().copied().filter(|node| has(self.height(*node))).collect()
        };
        let (below, within, above) = (on(|h| h < 0.0), on(|h| h == 0.0), on(|h| h > 0.0));
        let mut polygon: Vec<u32> = within.into_iter().map(|node| self.node(node)).collect();
        match (&below[..], &above[..]) {
            // Around the quadrilateral neighbours share a node.
            ([a, b], [c, d]) => {
                polygon.extend([[*a, *c], [*a, *d], [*b, *d], [*b, *c]].map(|[p, q]| self.crossing(p, q)))
            }
            _ => {
                for (p, q) in below.iter().flat_map(|p| above.iter().map(move |q| (*p, *q))) {
                    polygon.push(self.crossing(p, q));
                }
            }
        }
        polygon
    }

    fn node(&mut self, node: u32) -> u32 {
        self.number(Vertex { nodes: [node; 2], share: 0.0 })
    }

    /// Where the plane meets an edge; the same vertex for every cell and face with the edge.
    fn crossing(&mut self, a: u32, b: u32) -> u32 {
        let nodes = [a.min(b), a.max(b)];
        let [first, second] = nodes.map(|node| self.height(node));
        self.number(Vertex { nodes, share: first / (first - second) })
    }

    fn number(&mut self, vertex: Vertex) -> u32 {
        let next = self.vertices.len() as u32;
        let number = *self.numbers.entry(vertex.nodes).or_insert(next);
        if number == next {
            self.vertices.push(vertex);
        }
        number
    }
}
