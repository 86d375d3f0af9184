//! Meshes with every edge cut in two.

use std::collections::HashMap;

use super::{Dimension, SimplexMesh, SimplexMeshError};

/// An edge by its corners.
type Edge = [usize; 2];

/// The three pairs of opposite edges of a tetrahedron, and the midpoints of the other edges around the line between theirs, in a right-handed turn about it.
const AROUND: [(Edge, Edge, [Edge; 4]); 3] = [
    ([0, 1], [2, 3], [[0, 2], [0, 3], [1, 3], [1, 2]]),
    ([0, 2], [1, 3], [[0, 3], [0, 1], [1, 2], [2, 3]]),
    ([0, 3], [1, 2], [[0, 1], [0, 2], [2, 3], [1, 3]]),
];

/// Nodes at the midpoints of edges, made when first asked for.
struct Midpoints {
    nodes: Vec<[f64; 3]>,
    numbers: HashMap<[u32; 2], u32>,
}

impl Midpoints {
    /// The node between two others.
    fn between(&mut self, a: u32, b: u32) -> u32 {
        if a == b {
            return a;
        }
        let Self { nodes, numbers } = self;
        *numbers.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let [x, y] = [a.min(b), a.max(b)].map(|node| nodes[node as usize]);
            nodes.push(std::array::from_fn(|r| 0.5 * (x[r] + y[r])));
            nodes.len() as u32 - 1
        })
    }
}

impl SimplexMesh {
    /// The mesh with every edge cut in two and every cell into 2^d of equal measure, which keep its tag and stand in its place (regular refinement,
    /// `bey1995tetrahedral`). The nodes of this mesh come first.
    ///
    /// Corners of a tetrahedron give four cells of its own shape; of the three ways to cut what remains, an octahedron, the one along the shortest diagonal is taken.
    ///
    /// # Errors
    /// Cells that are so thin that what remains of one counts as flat.
    pub fn refined(&self) -> Result<Self, SimplexMeshError> {
        let mut midpoints = Midpoints { nodes: self.nodes().to_vec(), numbers: HashMap::new() };
        let count = 1 << self.dimension().axes();
        let mut cells = Vec::with_capacity(count * self.cell_count());
        for cell in 0..self.cell_count() {
            let corners = self.cell(cell);
            let mut mid = |[a, b]: Edge| midpoints.between(corners[a], corners[b]);
            // Towards each corner the cell itself at half its size.
            for corner in 0..corners.len() {
                cells.push(std::array::from_fn(|n| if n < corners.len() { mid([n, corner]) } else { 0 }));
            }
            match self.dimension() {
                Dimension::One => {}
                Dimension::Two => cells.push([mid([1, 2]), mid([0, 2]), mid([0, 1]), 0]),
                Dimension::Three => {
                    let (from, to, around) = AROUND[self.shortest_diagonal(cell)];
                    let (from, to, around) = (mid(from), mid(to), around.map(mid));
                    cells.extend((0..4).map(|n| [from, to, around[n], around[(n + 1) % 4]]));
                }
            }
        }
        let tags = self.tags().iter().flat_map(|tag| std::iter::repeat_n(*tag, count)).collect();
        Self::new(self.dimension(), midpoints.nodes, cells, tags)
    }

    /// Which pair of opposite edges has the closest midpoints.
    fn shortest_diagonal(&self, cell: usize) -> usize {
        let sum = |[a, b]: Edge, r: usize| self.corner(cell, a)[r] + self.corner(cell, b)[r];
        let length = |n: usize| -> f64 { (0..3).map(|r| (sum(AROUND[n].0, r) - sum(AROUND[n].1, r)).powi(2)).sum() };
        (1..3).fold(0, |best, n| if length(n) < length(best) { n } else { best })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Boundary, BoundingBox, BoxCut, Dimension, SimplexLattice, SimplexMesh};

    fn lattice(dimension: Dimension) -> SimplexMesh {
        let around = BoundingBox { lower: [0.0; 3], upper: [1.0, 1.4, 0.9] };
        let mesh = SimplexLattice { dimension, boxes: [3, 2, 2], around, cut: BoxCut::Alternating }.mesh().unwrap();
        mesh.tagged(|x| i32::from(x[0] > 0.4))
    }

    #[test]
    fn cells_are_divided_into_equal_parts_of_the_same_tag_and_share_whole_faces() {
        for dimension in [Dimension::One, Dimension::Two, Dimension::Three] {
            let mesh = lattice(dimension);
            let fine = mesh.refined().unwrap();
            let parts = 1 << dimension.axes();
            assert_eq!(fine.cell_count(), parts * mesh.cell_count());
            assert_eq!(&fine.nodes()[..mesh.nodes().len()], mesh.nodes());
            for cell in 0..fine.cell_count() {
                let from = cell / parts;
                let share = fine.measure(cell) * parts as f64 / mesh.measure(from);
                assert!((share - 1.0).abs() < 1e-13, "{dimension}, cell {cell}: {share}");
                assert_eq!(fine.tags()[cell], mesh.tags()[from]);
                assert!(mesh.barycentric(from, fine.centre(cell)).iter().all(|w| *w > -1e-14), "inside its cell");
            }
            // Faces inside have two cells: none is left but those of the boundary, each in as many parts as a face has.
            let faces = |mesh: &SimplexMesh| Boundary::of_mesh(mesh).unwrap().faces().len();
            assert_eq!(faces(&fine), (parts / 2) * faces(&mesh), "{dimension}");
        }
    }

    #[test]
    fn shapes_do_not_degrade_however_often_a_mesh_is_refined() {
        let least =
            |mesh: &SimplexMesh| (0..mesh.cell_count()).map(|c| mesh.shape_quality(c)).fold(f64::INFINITY, f64::min);
        let nodes = vec![[0.3, 0.1, -0.2], [1.2, 0.0, 0.1], [0.1, 0.9, 0.2], [0.4, 0.3, 1.1]];
        let mut mesh = SimplexMesh::new(Dimension::Three, nodes, vec![[0, 1, 2, 3]], vec![7]).unwrap();
        let (mut last, first) = (0.0, least(&mesh));
        for level in 0..4 {
            mesh = mesh.refined().unwrap();
            let now = least(&mesh);
            assert!(now > 0.5 * first, "level {level}: {now} after {first}");
            assert!(level < 2 || now > 0.999 * last, "level {level}: {now} after {last}");
            last = now;
        }
        assert_eq!(mesh.cell_count(), 4096);
    }
}
