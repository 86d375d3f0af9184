//! Where points lie in a mesh, and from which cells a field is extrapolated to those outside.

use super::distance::squared_distance;
use super::{BoundingBox, BoundingTree, SimplexMesh};

/// A point with a barycentric coordinate above minus this is still inside: coordinates come rounded.
const ROUNDING: f64 = 1e-10;
/// Cells whose distances differ by less than this share of the nearest are equally near.
const EQUALLY_NEAR: f64 = 1e-6;
/// Cells from which a field is extrapolated at most.
const MOST_CELLS: usize = 3;
/// Cells that enlarge errors this many times more than the mildest one are left out.
const STEEPER: f64 = 2.0;

/// A cell that takes part in the value at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellWeights {
    /// The cell.
    pub cell: u32,
    /// Barycentric coordinates of the point in the cell: their sum is 1; some are negative if the point is outside; zero beyond d + 1.
    pub weights: [f64; 4],
    /// Its part in the value; the shares of a place sum to 1.
    pub share: f64,
}

/// Where a point lies: the cell that holds it, or the one to three closest cells, from which linear fields are extrapolated (`kharevych2009numerical`, section 4.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    cells: [CellWeights; MOST_CELLS],
    count: usize,
    /// No cell holds the point.
    pub outside: bool,
    /// Distance \[m\] from the mesh, zero inside.
    pub distance: f64,
}

impl Place {
    /// The cells that take part, the mildest extrapolation first; never empty.
    pub fn cells(&self) -> &[CellWeights] {
        &self.cells[..self.count]
    }

    /// Nodes and their weights in the value at the point, Σ = 1; a node of several cells comes several times.
    pub fn weights<'a>(&'a self, mesh: &'a SimplexMesh) -> impl Iterator<Item = (u32, f64)> + 'a {
        self.cells().iter().flat_map(|c| {
            mesh.cell(c.cell as usize).iter().zip(c.weights).map(move |(node, weight)| (*node, c.share * weight))
        })
    }

    /// Value at the point of a field that is given at the nodes.
    pub fn value<const N: usize>(&self, mesh: &SimplexMesh, field: &[[f64; N]]) -> [f64; N] {
        let mut value = [0.0; N];
        for (node, weight) in self.weights(mesh) {
            (0..N).for_each(|k| value[k] += weight * field[node as usize][k]);
        }
        value
    }

    /// Σ share Σ |weight|: how many times an error of the nodal values may grow; 1 inside.
    pub fn amplification(&self) -> f64 {
        self.cells().iter().map(|c| c.share * steepness(&c.weights)).sum()
    }

    fn inside(cell: u32, weights: [f64; 4]) -> Self {
        let mut cells = [CellWeights::default(); MOST_CELLS];
        cells[0] = CellWeights { cell, weights, share: 1.0 };
        Self { cells, count: 1, outside: false, distance: 0.0 }
    }
}

fn steepness(weights: &[f64; 4]) -> f64 {
    weights.iter().map(|w| w.abs()).sum()
}

/// Finds the cells of points in a mesh.
#[derive(Clone, Debug)]
pub struct Locator<'a> {
    mesh: &'a SimplexMesh,
    tree: BoundingTree,
}

impl<'a> Locator<'a> {
    /// Prepares the search in a mesh.
    pub fn new(mesh: &'a SimplexMesh) -> Self {
        let around = |cell: usize| {
            let around = BoundingBox::of_cell(mesh, cell);
            around.grown(ROUNDING * around.diagonal())
        };
        Self { mesh, tree: BoundingTree::new((0..mesh.cell_count()).map(around).collect()) }
    }

    /// The mesh that is searched.
    pub fn mesh(&self) -> &'a SimplexMesh {
        self.mesh
    }

    /// The place of a point \[m\]: in the cell where its least barycentric coordinate is greatest if that holds it, else outside.
    ///
    /// Outside, all cells at the least distance are compared: one if a face is nearest, several at edges and corners. Up to three of them with the least
    /// Σ |weight| take part, each with a share in inverse proportion to it. Every choice reproduces linear fields.
    pub fn locate(&self, point: [f64; 3]) -> Place {
        let mut best: Option<(u32, [f64; 4], f64)> = None;
        self.tree.visit(&BoundingBox { lower: point, upper: point }, |cell| {
            let weights = self.mesh.barycentric(cell as usize, point);
            let least = self.least(&weights);
            let better = |(other, _, most): &(u32, [f64; 4], f64)| least > *most || (least == *most && cell < *other);
            if least >= -ROUNDING && best.as_ref().is_none_or(better) {
                best = Some((cell, weights, least));
            }
        });
        match best {
            Some((cell, weights, _)) => Place::inside(cell, weights),
            None => self.extrapolate(point),
        }
    }

    fn least(&self, weights: &[f64; 4]) -> f64 {
        weights[..self.mesh.dimension().corners()].iter().copied().fold(f64::INFINITY, f64::min)
    }

    fn extrapolate(&self, point: [f64; 3]) -> Place {
        let squared = |cell: u32| squared_distance(self.mesh, cell as usize, point);
        // A mesh is never empty.
        let least = self.tree.nearest(point, squared).map_or(0.0, |(_, least)| least);
        let limit = least * (1.0 + EQUALLY_NEAR).powi(2);
        let mut place = Place { cells: Default::default(), count: 0, outside: true, distance: least.sqrt() };
        self.tree.visit_within(point, limit, |cell| {
            if squared(cell) <= limit {
                insert(&mut place, cell, self.mesh.barycentric(cell as usize, point));
            }
        });
        let mildest = steepness(&place.cells[0].weights);
        place.count = place.cells().iter().take_while(|c| steepness(&c.weights) <= STEEPER * mildest).count();
        let inverse: f64 = place.cells().iter().map(|c| 1.0 / steepness(&c.weights)).sum();
        let count = place.count;
        place.cells[..count].iter_mut().for_each(|c| c.share = 1.0 / (steepness(&c.weights) * inverse));
        place
    }
}

/// Keeps the mildest three cells in order, the first in the mesh where two are alike.
fn insert(place: &mut Place, cell: u32, weights: [f64; 4]) {
    let comes_before = |other: &CellWeights| {
        steepness(&weights).total_cmp(&steepness(&other.weights)).then(cell.cmp(&other.cell)).is_lt()
    };
    let at = place.cells().iter().position(comes_before).unwrap_or(place.count);
    if at < MOST_CELLS {
        place.count = (place.count + 1).min(MOST_CELLS);
        place.cells[at..place.count].rotate_right(1);
        place.cells[at] = CellWeights { cell, weights, share: 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BoxCut, Dimension, SimplexLattice};
    use super::*;
    use proptest::prelude::*;

    fn lattice(dimension: Dimension) -> SimplexMesh {
        let around = BoundingBox { lower: [0.0; 3], upper: [1.0, 2.0, 1.0] };
        SimplexLattice { dimension, boxes: [3, 4, 2], around, cut: BoxCut::Alternating }.mesh().unwrap()
    }

    fn flattened(dimension: Dimension, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|r| if r < dimension.axes() { point[r] } else { 0.0 })
    }

    const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];

    proptest! {
        #[test]
        fn linear_fields_are_reproduced_inside_and_outside(point in prop::array::uniform3(-3.0..4.0f64), which in 0..3usize) {
            let mesh = lattice(DIMENSIONS[which]);
            let point = flattened(DIMENSIONS[which], point);
            let linear = |x: [f64; 3]| [1.0 + 2.0 * x[0] - 3.0 * x[1] + 0.5 * x[2], x[1]];
            let field: Vec<[f64; 2]> = mesh.nodes().iter().map(|x| linear(*x)).collect();
            let place = Locator::new(&mesh).locate(point);
            let (value, exact) = (place.value(&mesh, &field), linear(point));
            prop_assert!((0..2).all(|k| (value[k] - exact[k]).abs() < 1e-12), "{:?} {:?}", value, exact);
            let shares: f64 = place.cells().iter().map(|c| c.share).sum();
            prop_assert!((shares - 1.0).abs() < 1e-15);

            // The box is convex, so its distance is that of the mesh.
            let around = BoundingBox { lower: [0.0; 3], upper: flattened(DIMENSIONS[which], [1.0, 2.0, 1.0]) };
            let distance = around.squared_distance(point).sqrt();
            prop_assert!((place.distance - distance).abs() < 1e-14, "{} {}", place.distance, distance);
            prop_assert_eq!(place.outside, distance > 0.0);
            prop_assert!(place.outside || (place.amplification() - 1.0).abs() < 1e-9);
        }
    }

    proptest! {
        /// Against a look at every cell, in a body with holes and steps.
        #[test]
        fn the_nearest_cells_are_found(point in prop::array::uniform3(-1.0..3.0f64), seed in any::<u64>(), which in 0..3usize) {
            let dimension = DIMENSIONS[which];
            let Ok((mesh, _)) = lattice(dimension).part(|cell| (seed >> (cell % 61)) & 1 == 0) else { return Ok(()) };
            let point = flattened(dimension, point);
            let place = Locator::new(&mesh).locate(point);
            let squared = |cell: usize| squared_distance(&mesh, cell, point);
            let least = (0..mesh.cell_count()).map(squared).fold(f64::INFINITY, f64::min);
            prop_assert!((place.distance - least.sqrt()).abs() < 1e-14);
            for cell in place.cells() {
                prop_assert!(squared(cell.cell as usize).sqrt() <= least.sqrt() * (1.0 + 2.0 * EQUALLY_NEAR));
                prop_assert_eq!(cell.weights, mesh.barycentric(cell.cell as usize, point));
            }
            let as_near = (0..mesh.cell_count()).filter(|c| squared(*c).sqrt() <= least.sqrt() * (1.0 + 1e-9));
            let mildest = as_near.map(|c| steepness(&mesh.barycentric(c, point))).fold(f64::INFINITY, f64::min);
            prop_assert!(!place.outside || steepness(&place.cells()[0].weights) <= mildest);
        }
    }

    #[test]
    fn cells_nodes_and_shared_faces_are_found() {
        for dimension in DIMENSIONS {
            let mesh = lattice(dimension);
            let locator = Locator::new(&mesh);
            for cell in 0..mesh.cell_count() {
                let corners = dimension.corners();
                let mean = |n: usize| -> [f64; 3] {
                    std::array::from_fn(|r| (0..n).map(|c| mesh.corner(cell, c)[r]).sum::<f64>() / n as f64)
                };
                assert_eq!(locator.locate(mean(corners)).cells()[0].cell as usize, cell);
                let (face, node) = (locator.locate(mean(corners - 1)), locator.locate(mesh.corner(cell, 0)));
                assert!(!face.outside && !node.outside && face.cells().len() == 1 && node.cells().len() == 1);
                let own = node.weights(&mesh).find(|(n, _)| *n == mesh.cell(cell)[0]).unwrap();
                assert!((own.1 - 1.0).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn points_far_from_the_origin_are_found_on_faces_too() {
        let near = lattice(Dimension::Three);
        let nodes: Vec<[f64; 3]> = near.nodes().iter().map(|x| x.map(|x| x + 1e3 / 3.0)).collect();
        let cells = (0..near.cell_count()).map(|c| std::array::from_fn(|n| near.cell(c)[n])).collect();
        let mesh = SimplexMesh::new(Dimension::Three, nodes, cells, near.tags().to_vec()).unwrap();
        let locator = Locator::new(&mesh);
        for cell in 0..mesh.cell_count() {
            for n in 0..4 {
                let [a, b, c] = [1, 2, 3].map(|k| mesh.corner(cell, (n + k) % 4));
                let place = locator.locate(std::array::from_fn(|r| 0.3 * a[r] + 0.5 * b[r] + 0.2 * c[r]));
                assert!(!place.outside, "{cell}: {place:?}");
            }
        }
    }

    /// The point has one nearest cell above a side, two beyond an edge that two cells share, three of many beyond a node.
    #[test]
    fn sharp_places_take_more_cells() {
        let nodes =
            vec![[0.0; 3], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0], [-1.0, 1.0, 0.0], [-2.0, 0.0, 0.0]];
        let cells = vec![[0, 1, 2, 0], [0, 2, 3, 0], [0, 3, 4, 0], [0, 4, 5, 0]];
        let fan = SimplexMesh::new(Dimension::Two, nodes, cells, vec![0; 4]).unwrap();
        let locator = Locator::new(&fan);
        let cells = |point| -> Vec<u32> { locator.locate(point).cells().iter().map(|c| c.cell).collect() };
        assert_eq!(cells([0.4, -0.5, 0.0]), [0]);
        assert_eq!(cells([0.0, 2.5, 0.0]), [1, 2]);
        let below = locator.locate([0.0, -0.5, 0.0]);
        // Σ |weight| is 2, 1.5, 1.5, 2 in the four cells.
        let shares: Vec<(u32, f64)> = below.cells().iter().map(|c| (c.cell, (11.0 * c.share * 1e9).round())).collect();
        assert_eq!(shares, [(1, 4e9), (2, 4e9), (0, 3e9)]);
        assert!(below.outside && (below.distance - 0.5).abs() < 1e-15);
        let tip = lattice(Dimension::Three);
        let place = Locator::new(&tip).locate([1.2, 2.3, 1.4]);
        assert!((1..=3).contains(&place.cells().len()) && place.amplification() > 1.0);
        let expected: f64 = 0.2f64.hypot(0.3).hypot(0.4);
        assert!((place.distance - expected).abs() < 1e-15);
    }

    #[test]
    fn a_needle_is_left_out_where_another_cell_is_as_near() {
        let nodes = vec![[0.0; 3], [2.0, 0.0, 0.0], [2.0, 0.05, 0.0], [0.0, 2.0, 0.0]];
        let mesh = SimplexMesh::new(Dimension::Two, nodes, vec![[0, 1, 2, 0], [0, 2, 3, 0]], vec![0; 2]).unwrap();
        let place = Locator::new(&mesh).locate([-0.5, -0.5, 0.0]);
        assert_eq!((place.cells().len(), place.cells()[0].cell), (1, 1));
        assert!(place.amplification() < 3.0);
    }
}
