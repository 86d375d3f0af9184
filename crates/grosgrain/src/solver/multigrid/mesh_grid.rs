//! Meshes of elements in the cells of a lattice, and the next coarser ones with the same topology.
//!
//! Cells are halved as those of lattices are. The elements in a coarse cell that hang together by vertices become one element; where they
//! do not, it is split. At a coarse node two elements use the same vertex when they share a finer vertex, directly or through others around that node.
//! So both sides of a cut keep their own unknowns on every level (`nesme2009preserving`), and a prolongation that is trilinear in each element is continuous.

use rayon::prelude::*;

use super::galerkin::{CellMatrices, add, projected};
use super::grid::Coarsening;
use crate::element::CellMatrix;
use crate::linalg::{DisjointSets, nested_dissection};
use crate::mesh::{Cell, Lattice};

/// Elements with their cells, and the vertices that they use at their corners.
#[derive(Clone, Debug)]
pub(in crate::solver) struct MeshGrid {
    pub lattice: Lattice,
    /// Cell of each element.
    pub cells: Vec<u32>,
    pub corners: Vec<[u32; 8]>,
    pub vertices: usize,
}

/// From a mesh to the next coarser one.
#[derive(Debug)]
pub(super) struct MeshCoarsening {
    pub coarse: MeshGrid,
    /// Edges of the coarse cells.
    pub edges: [f64; 3],
    weights: [[[f64; 8]; 8]; 8],
    /// Element and octant of each coarse element's children.
    children: Rows<(u32, u8)>,
    /// Coarse vertices and weights of each fine one.
    parents: Rows<(u32, f32)>,
    /// The same by coarse vertex.
    parts: Rows<(u32, f32)>,
}

impl MeshCoarsening {
    /// Halves the cells of `fine`, whose edges are `spacing`.
    pub fn new(fine: &MeshGrid, spacing: [f64; 3]) -> Self {
        let (step, edges) = Coarsening::new(fine.lattice, spacing);
        let incidences = Rows::gathered(fine.vertices, fine.corners.iter().flatten().zip(0u32..).map(|(v, n)| (*v, n)));
        let places: Vec<(u32, u8)> = fine.cells.iter().map(|cell| place(&step, *cell)).collect();
        let (parent, cells) = components(&incidences, &places);
        let (corners, vertices) = coarse_corners(&step, &cells, (&incidences, &parent));
        let weights = std::array::from_fn(|octant| step.weights(octant));
        let child = |element: u32| (parent[element as usize], (element, places[element as usize].1));
        let children = Rows::gathered(cells.len(), (0..parent.len() as u32).map(child));
        let interpolation = |v: u32| {
            let first = incidences.row(v as usize).first().copied();
            first.into_iter().flat_map(move |n| (0..8).map(move |c| (n as usize / 8, n as usize % 8, c)))
        };
        let pairs: Vec<(u32, u32, f32)> = (0..fine.vertices as u32)
            .flat_map(|v| interpolation(v).map(move |(element, f, c)| (v, element, f, c)))
            .map(|(v, element, f, c): (u32, usize, usize, usize)| {
                let weights: &[[[f64; 8]; 8]; 8] = &weights;
                let weight = weights[usize::from(places[element].1)][f][c] as f32;
                (v, corners[parent[element] as usize][c], weight)
            })
            .filter(|(_, _, weight)| *weight > 0.0)
            .collect();
        let parents = Rows::gathered(fine.vertices, pairs.iter().map(|(v, w, weight)| (*v, (*w, *weight))));
        let parts = Rows::gathered(vertices, pairs.iter().map(|(v, w, weight)| (*w, (*v, *weight))));
        Self {
            coarse: MeshGrid { lattice: step.coarse, cells, corners, vertices },
            edges,
            weights,
            children,
            parents,
            parts,
        }
    }

    /// Pᵀ K P of each coarse element.
    pub fn galerkin(&self, stiffness: &(impl Fn(usize) -> CellMatrix + Sync)) -> CellMatrices {
        let sum = |element: usize| {
            let mut sum = [0.0; 576];
            for (child, octant) in self.children.row(element) {
                let matrix = stiffness(*child as usize);
                add(&mut sum, 1.0, &projected(&matrix, &self.weights[usize::from(*octant)]));
            }
            sum
        };
        (0..self.coarse.cells.len()).into_par_iter().map(sum).collect()
    }

    /// coarse = Pᵀ fine.
    pub fn restrict(&self, fine: &[f64], coarse: &mut [f64]) {
        let (fine, _) = fine.as_chunks::<3>();
        self.parts.for_each_row(coarse, |row, sum| *sum = weighted(row, fine));
    }

    /// fine += P coarse where bits of `free` say so.
    pub fn prolong(&self, coarse: &[f64], free: &[u8], fine: &mut [f64]) {
        let (coarse, _) = coarse.as_chunks::<3>();
        fine.par_chunks_mut(3 * TASK).zip(free.par_chunks(TASK)).enumerate().for_each(|(task, (fine, free))| {
            let (fine, _) = fine.as_chunks_mut::<3>();
            for (n, (fine, free)) in fine.iter_mut().zip(free).enumerate() {
                let value = weighted(self.parents.row(TASK * task + n), coarse);
                (0..3).filter(|r| free >> r & 1 == 1).for_each(|r| fine[r] += value[r]);
            }
        });
    }
}

/// Vertices per task.
const TASK: usize = 1024;

fn weighted(row: &[(u32, f32)], x: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (index, weight) in row {
        let x = &x[*index as usize];
        (0..3).for_each(|r| sum[r] += f64::from(*weight) * x[r]);
    }
    sum
}

/// Coarse cell and octant of a cell.
fn place(step: &Coarsening, cell: u32) -> (u32, u8) {
    let at = step.fine.cell_position(Cell(cell as usize));
    let coarse = std::array::from_fn(|a| if step.halved[a] { at[a] / 2 } else { at[a] });
    let octant = (0..3).filter(|a| step.halved[*a]).fold(0, |bits, a| bits | (at[a] & 1) << a);
    (step.coarse.cell(coarse).0 as u32, octant as u8)
}

/// The coarse element of each element, and the coarse cell of each coarse element: parts of coarse cells that hang together by vertices.
fn components(incidences: &Rows<u32>, places: &[(u32, u8)]) -> (Vec<u32>, Vec<u32>) {
    let mut sets = DisjointSets::new(places.len());
    for v in 0..incidences.len() {
        let row = incidences.row(v);
        for (n, a) in row.iter().enumerate() {
            let same = row[..n].iter().find(|b| places[**b as usize / 8].0 == places[*a as usize / 8].0);
            same.into_iter().for_each(|b| sets.unite(a / 8, b / 8));
        }
    }
    let mut number = vec![u32::MAX; places.len()];
    let mut cells = Vec::new();
    let parent = (0..places.len() as u32).map(|element| {
        let root = sets.root(element) as usize;
        if number[root] == u32::MAX {
            number[root] = cells.len() as u32;
            cells.push(places[root].0);
        }
        number[root]
    });
    let parent = parent.collect();
    (parent, cells)
}

/// The vertices at the corners of the coarse elements, numbered in elimination order, and their number.
fn coarse_corners(
    step: &Coarsening,
    cells: &[u32],
    (incidences, parent): (&Rows<u32>, &[u32]),
) -> (Vec<[u32; 8]>, usize) {
    let nodes: Vec<[usize; 8]> = cells.iter().map(|c| step.coarse.corners(Cell(*c as usize)).map(|n| n.0)).collect();
    let mut sets = DisjointSets::new(8 * cells.len());
    let mut around = Vec::new();
    for v in 0..incidences.len() {
        around.clear();
        around.extend(incidences.row(v).iter().map(|n| parent[*n as usize / 8]));
        around.sort_unstable();
        around.dedup();
        for (n, a) in around.iter().enumerate() {
            for b in &around[..n] {
                for (c, d) in (0..64).map(|m| (m / 8, m % 8)) {
                    if nodes[*a as usize][c] == nodes[*b as usize][d] {
                        sets.unite(8 * a + c as u32, 8 * b + d as u32);
                    }
                }
            }
        }
    }
    let mut rank = vec![0; step.coarse.node_count()];
    nested_dissection(step.coarse.nodes()).iter().zip(0u32..).for_each(|(node, r)| rank[*node as usize] = r);
    let key = |n: u32| rank[nodes[n as usize / 8][n as usize % 8]];
    let mut roots: Vec<u32> = (0..8 * cells.len() as u32).filter(|n| sets.root(*n) == *n).collect();
    roots.sort_unstable_by_key(|n| (key(*n), *n));
    let mut number = vec![0; 8 * cells.len()];
    roots.iter().zip(0u32..).for_each(|(root, v)| number[*root as usize] = v);
    let mut vertex = |n: u32| number[sets.root(n) as usize];
    let corners = (0..cells.len() as u32).map(|e| std::array::from_fn(|c| vertex(8 * e + c as u32))).collect();
    (corners, roots.len())
}

/// Lists of different lengths, one after the other.
#[derive(Debug)]
struct Rows<T> {
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T: Copy + Sync> Rows<T> {
    /// Sorts items into their rows, in the order in which they come.
    fn gathered(count: usize, items: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        let mut starts = vec![0u32; count + 1];
        items.clone().for_each(|(row, _)| starts[row as usize + 1] += 1);
        (0..count).for_each(|row| starts[row + 1] += starts[row]);
        let mut next = starts.clone();
        let total = starts[count] as usize;
        let mut sorted = Vec::with_capacity(total);
        if let Some((_, first)) = items.clone().next() {
            sorted.resize(total, first);
        }
        for (row, item) in items {
            sorted[next[row as usize] as usize] = item;
            next[row as usize] += 1;
        }
        Self { starts, items: sorted }
    }

    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    fn row(&self, n: usize) -> &[T] {
        &self.items[self.starts[n] as usize..self.starts[n + 1] as usize]
    }

    /// Calls `visit` with each row and its three entries of `vector`.
    fn for_each_row(&self, vector: &mut [f64], visit: impl Fn(&[T], &mut [f64; 3]) + Sync) {
        vector.par_chunks_mut(3 * TASK).enumerate().for_each(|(task, chunk)| {
            let (chunk, _) = chunk.as_chunks_mut::<3>();
            chunk.iter_mut().enumerate().for_each(|(n, three)| visit(self.row(TASK * task + n), three));
        });
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::mesh::Node;

    pub fn noise(seed: usize, count: usize) -> Vec<f64> {
        (0..count).map(|i| ((seed as f64 + 0.37) * 91.7 * (i + 1) as f64).sin()).collect()
    }

    /// Vertices at the nodes; those of the plane in the middle of z are doubled, but for the plane x = 0.
    pub fn slit(cells: [usize; 3]) -> MeshGrid {
        let lattice = Lattice::new(cells);
        let (nodes, plane) = (lattice.node_count(), cells[2] / 2);
        let mut copy = vec![u32::MAX; nodes];
        let mut vertices = nodes as u32;
        for n in 0..nodes {
            let [i, _, k] = lattice.node_position(Node(n));
            if i > 0 && k == plane {
                (copy[n], vertices) = (vertices, vertices + 1);
            }
        }
        let corners = |c: usize| {
            let is_above = lattice.cell_position(Cell(c))[2] >= plane;
            lattice.corners(Cell(c)).map(|n| if is_above && copy[n.0] != u32::MAX { copy[n.0] } else { n.0 as u32 })
        };
        let corners = (0..lattice.cell_count()).map(corners).collect();
        MeshGrid { lattice, cells: (0..lattice.cell_count() as u32).collect(), corners, vertices: vertices as usize }
    }

    /// Vertices of a mesh with their places, x fastest along the lattice.
    fn places(grid: &MeshGrid) -> Vec<[usize; 3]> {
        let mut places = vec![[usize::MAX; 3]; grid.vertices];
        for (cell, corners) in grid.cells.iter().zip(&grid.corners) {
            for (node, vertex) in grid.lattice.corners(Cell(*cell as usize)).iter().zip(corners) {
                let at = grid.lattice.node_position(*node);
                let place = &mut places[*vertex as usize];
                assert!(*place == at || *place == [usize::MAX; 3], "a vertex stands at one node");
                *place = at;
            }
        }
        places
    }

    #[test]
    fn coarse_meshes_keep_a_slit_and_close_where_the_body_hangs_together() {
        let fine = slit([8, 4, 8]);
        let coarse = MeshCoarsening::new(&fine, [1.0; 3]).coarse;
        assert_eq!((coarse.lattice.cells, coarse.cells.len()), ([4, 2, 4], 32));
        // The plane z = 2 of the coarse nodes is doubled but for x = 0 and x = 1: the cells between these hang together by the fine vertices at x = 0.
        assert_eq!(coarse.vertices, 5 * 3 * 5 + 3 * 3);
        let places = places(&coarse);
        let doubled: Vec<_> = (0..places.len()).filter(|v| places[..*v].contains(&places[*v])).collect();
        assert!(doubled.iter().all(|v| places[*v][2] == 2 && places[*v][0] > 1), "{doubled:?}");
        // A slit inside a coarse cell splits the cell: 3 of 6 layers below, so that the cells of the second layer fall in two; at
        // x = 0 both parts hang together by the vertices there.
        let inside = MeshCoarsening::new(&slit([8, 4, 6]), [1.0; 3]).coarse;
        assert_eq!(inside.lattice.cells, [4, 2, 3]);
        assert_eq!(inside.cells.len(), 4 * 2 * 3 + 3 * 2);
    }

    #[test]
    fn separate_bodies_in_the_same_cells_stay_separate() {
        let single = slit([6, 5, 4]);
        let mut twice = single.clone();
        twice.cells.extend(&single.cells);
        twice.corners.extend(single.corners.iter().map(|c| c.map(|v| v + single.vertices as u32)));
        twice.vertices *= 2;
        let coarse = [&single, &twice].map(|grid| MeshCoarsening::new(grid, [1.0; 3]).coarse);
        assert_eq!(coarse[1].cells.len(), 2 * coarse[0].cells.len());
        assert_eq!(coarse[1].vertices, 2 * coarse[0].vertices);
    }

    #[test]
    fn prolongation_is_exact_for_linear_fields_and_restriction_is_its_transpose() {
        let fine = slit([7, 4, 6]);
        let coarsening = MeshCoarsening::new(&fine, [1.0, 1.0, 1.0]);
        let linear = |at: &[usize; 3], scale: usize| -> [f64; 3] {
            let x = at.map(|i| (i * scale) as f64);
            std::array::from_fn(|r| 1.0 + (r + 1) as f64 * x[0] - 2.0 * x[1] + 0.5 * x[(r + 2) % 3])
        };
        let coarse: Vec<f64> = places(&coarsening.coarse).iter().flat_map(|at| linear(at, 2)).collect();
        let mut prolonged = vec![0.0; 3 * fine.vertices];
        coarsening.prolong(&coarse, &vec![7; fine.vertices], &mut prolonged);
        let expected: Vec<f64> = places(&fine).iter().flat_map(|at| linear(at, 1)).collect();
        let error = prolonged.iter().zip(&expected).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(error < 1e-12, "{error:e}");

        let (x, y) = (noise(1, coarse.len()), noise(2, prolonged.len()));
        let (mut px, mut py) = (vec![0.0; y.len()], vec![f64::NAN; x.len()]);
        coarsening.prolong(&x, &vec![7; fine.vertices], &mut px);
        coarsening.restrict(&y, &mut py);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(&px, &y) - dot(&x, &py)).abs() < 1e-10);
    }

    #[test]
    fn the_energy_of_a_coarse_field_is_that_of_its_prolongation() {
        let fine = slit([5, 4, 6]);
        let coarsening = MeshCoarsening::new(&fine, [1.0; 3]);
        let half = noise(3, 576);
        let symmetric: CellMatrix = std::array::from_fn(|e| half[e] + half[24 * (e % 24) + e / 24]);
        let energy = |grid: &MeshGrid, matrices: &dyn Fn(usize) -> CellMatrix, u: &[f64]| -> f64 {
            let of = |element: usize| {
                let v: Vec<f64> = (0..24).map(|i| u[3 * grid.corners[element][i / 3] as usize + i % 3]).collect();
                let matrix = matrices(element);
                (0..576).map(|e| v[e / 24] * matrix[e] * v[e % 24]).sum::<f64>()
            };
            (0..grid.cells.len()).map(of).sum()
        };
        let scaled = |element: usize| symmetric.map(|value| (1.0 + (element % 5) as f64) * value);
        let coarse = coarsening.galerkin(&scaled);
        let u = noise(4, 3 * coarsening.coarse.vertices);
        let mut prolonged = vec![0.0; 3 * fine.vertices];
        coarsening.prolong(&u, &vec![7; fine.vertices], &mut prolonged);
        let (a, b) = (energy(&coarsening.coarse, &|e| coarse[e], &u), energy(&fine, &scaled, &prolonged));
        assert!((a - b).abs() <= 1e-10 * b.abs().max(1.0), "{a} against {b}");
    }
}
