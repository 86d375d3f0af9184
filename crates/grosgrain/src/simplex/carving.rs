//! Meshes cut along a surface that is given by a function.

use std::collections::HashMap;

use super::prism::{of_prism, of_pyramid};
use super::{CellsAround, Dimension, SimplexMesh, SimplexMeshError};
use crate::linalg::matrix3::determinant;

/// Nodes closer to the surface than this share of an edge are moved onto it, so that no slivers are cut off.
const SNAPPED: f64 = 0.3;
/// Nodes that cannot be moved count as on the surface where they are closer than this.
const NEAR: f64 = 0.1;
/// No cell may lose more than this share of its measure when a node is moved.
const SQUEEZED: f64 = 0.8;
/// A node is moved only where the cells around it keep their measure to this share: otherwise it would dent the boundary.
const KEPT: f64 = 1e-9;
/// Halvings by which a point of the surface is found.
const HALVINGS: usize = 50;

/// Why a mesh cannot be carved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CarvingError {
    /// The cells are not tetrahedra.
    #[error("the mesh has {dimension}; only tetrahedra can be carved")]
    Dimension {
        /// What it has.
        dimension: Dimension,
    },
    /// The function is not a number somewhere.
    #[error("the depth at node {node}, at {at:?} m, is {depth}; it must be a number everywhere")]
    Depth {
        /// The node, from 0.
        node: usize,
        /// Its place \[m\].
        at: [f64; 3],
        /// The depth there \[m\].
        depth: f64,
    },
    /// The function is positive nowhere, or the surface cuts off cells that are flat.
    #[error(transparent)]
    Mesh(#[from] SimplexMeshError),
}

impl SimplexMesh {
    /// The part of a mesh of tetrahedra where `depth` is positive, bounded by faces of tetrahedra with their nodes on depth = 0: cavities and outlines that are curved
    /// come out smooth instead of in steps (isosurface stuffing, `labelle2007isosurface`). Cells keep their tags.
    ///
    /// `depth` is continuous and near its zeros roughly a distance \[m\] into the body. What it does within an edge without changing sign from one end to the other is
    /// not seen: the mesh must be finer than the features. Nodes near the surface are moved onto it along an edge, where that leaves the body's own boundary as it is, and
    /// interfaces between tags move with them; where it does not, nodes closer than a tenth of an edge stay and count as on the surface. Cells that the surface still cuts are
    /// divided.
    ///
    /// # Errors
    /// Segments or triangles; a depth that is not a number; nothing left; pieces that count as flat.
    pub fn carved(&self, depth: impl Fn([f64; 3]) -> f64) -> Result<Self, CarvingError> {
        if self.dimension() != Dimension::Three {
            return Err(CarvingError::Dimension { dimension: self.dimension() });
        }
        let depths: Vec<f64> = self.nodes().iter().map(|at| depth(*at)).collect();
        if let Some(node) = depths.iter().position(|depth| depth.is_nan()) {
            return Err(CarvingError::Depth { node, at: self.nodes()[node], depth: depths[node] });
        }
        let mut carving = Carving { mesh: self, depth, nodes: self.nodes().to_vec(), depths, cuts: HashMap::new() };
        carving.snap();
        let (mut cells, mut tags) = (Vec::new(), Vec::new());
        for cell in 0..self.cell_count() {
            carving.divide(cell, &mut cells);
            tags.resize(cells.len(), self.tags()[cell]);
        }
        let Carving { nodes, .. } = carving;
        let (nodes, cells) = compacted(&nodes, cells);
        Ok(Self::new(Dimension::Three, nodes, cells, tags)?)
    }
}

struct Carving<'a, D> {
    mesh: &'a SimplexMesh,
    depth: D,
    /// The nodes of the mesh, some moved, then points where the surface cuts edges.
    nodes: Vec<[f64; 3]>,
    /// Depths at the nodes of the mesh, zero on the surface.
    depths: Vec<f64>,
    /// The point on each edge that is cut.
    cuts: HashMap<[u32; 2], u32>,
}

impl<D: Fn([f64; 3]) -> f64> Carving<'_, D> {
    /// Moves nodes onto the surface.
    fn snap(&mut self) {
        let around = CellsAround::new(self.mesh);
        for node in 0..self.depths.len() {
            let mut near = self.crossings(node, around.of(node));
            near.sort_by(|a, b| a.1.total_cmp(&b.1));
            let moved = near.iter().find(|(_, _, to)| self.may_move(node, *to, around.of(node)));
            if let Some((_, _, to)) = moved {
                self.nodes[node] = *to;
                self.depths[node] = 0.0;
            } else if near.iter().any(|(share, ..)| *share < NEAR) {
                self.depths[node] = 0.0;
            }
        }
    }

    /// Points where the surface cuts edges of a node close to it: at which share of the edge, at which distance, where.
    fn crossings(&self, node: usize, cells: &[u32]) -> Vec<(f64, f64, [f64; 3])> {
        let mut others: Vec<u32> = cells.iter().flat_map(|cell| self.mesh.cell(*cell as usize)).copied().collect();
        others.sort_unstable();
        others.dedup();
        let cut = others.iter().filter(|other| self.depths[node] * self.depths[**other as usize] < 0.0);
        let crossing = |other: &u32| {
            let at = self.on_surface(node as u32, *other);
            let (from, to) = (self.nodes[node], self.nodes[*other as usize]);
            (distance(from, at) / distance(from, to), distance(from, at), at)
        };
        cut.map(crossing).filter(|(share, ..)| *share < SNAPPED).collect()
    }

    /// Whether a node may be moved: the body keeps its shape, and no cell becomes much thinner.
    fn may_move(&self, node: usize, to: [f64; 3], cells: &[u32]) -> bool {
        let (mut before, mut after, mut least) = (0.0, 0.0, f64::INFINITY);
        for cell in cells {
            let corners = self.mesh.cell(*cell as usize);
            let place = |n: u32| if n as usize == node { to } else { self.nodes[n as usize] };
            let moved = volume(std::array::from_fn(|n| place(corners[n])));
            before += volume(std::array::from_fn(|n| self.nodes[corners[n] as usize]));
            after += moved;
            least = least.min(moved / self.mesh.measure(*cell as usize));
        }
        (after - before).abs() <= KEPT * before && least >= 1.0 - SQUEEZED
    }

    /// Where the surface cuts an edge between nodes on both sides of it.
    fn on_surface(&self, a: u32, b: u32) -> [f64; 3] {
        // From the same end for both cells.
        let [a, b] = [a.min(b) as usize, a.max(b) as usize];
        let (from, to, is_inside) = (self.nodes[a], self.nodes[b], self.depths[a] > 0.0);
        let at = |share: f64| -> [f64; 3] { std::array::from_fn(|r| from[r] + share * (to[r] - from[r])) };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let side = if ((self.depth)(at(middle)) > 0.0) == is_inside { &mut low } else { &mut high };
            *side = middle;
        }
        at(0.5 * (low + high))
    }

    /// The node where the surface cuts an edge.
    fn cut(&mut self, a: u32, b: u32) -> u32 {
        let key = [a.min(b), a.max(b)];
        if let Some(node) = self.cuts.get(&key) {
            return *node;
        }
        let node = self.nodes.len() as u32;
        self.nodes.push(self.on_surface(a, b));
        self.cuts.insert(key, node);
        node
    }

    /// Adds what is left of a cell.
    fn divide(&mut self, cell: usize, cells: &mut Vec<[u32; 4]>) {
        let (mut inside, mut on, mut outside) = (Vec::new(), Vec::new(), Vec::new());
        for node in self.mesh.cell(cell) {
            let depth = self.depths[*node as usize];
            let side = if depth > 0.0 {
                &mut inside
            } else if depth < 0.0 {
                &mut outside
            } else {
                &mut on
            };
            side.push(*node);
        }
        let first = cells.len();
        match (&*inside, &*on, &*outside) {
            ([], ..) => {}
            (.., []) => cells.push(std::array::from_fn(|n| self.mesh.cell(cell)[n])),
            (&[a], &[b, c], &[x]) => cells.push([a, b, c, self.cut(a, x)]),
            (&[a], &[b], &[x, y]) => cells.push([a, b, self.cut(a, x), self.cut(a, y)]),
            (&[a], &[], &[x, y, z]) => cells.push([a, self.cut(a, x), self.cut(a, y), self.cut(a, z)]),
            (&[a, b], &[c], &[x]) => cells.extend(of_pyramid([a, b, self.cut(b, x), self.cut(a, x)], c)),
            (&[a, b], &[], &[x, y]) => {
                cells.extend(of_prism([a, self.cut(a, x), self.cut(a, y), b, self.cut(b, x), self.cut(b, y)]));
            }
            (&[a, b, c], &[], &[x]) => {
                cells.extend(of_prism([self.cut(a, x), self.cut(b, x), self.cut(c, x), a, b, c]))
            }
            // Four corners are not divided in any other way.
            _ => {}
        }
        for cell in &mut cells[first..] {
            if volume(cell.map(|node| self.nodes[node as usize])) < 0.0 {
                cell.swap(0, 1);
            }
        }
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|r| (a[r] - b[r]).powi(2)).sum::<f64>().sqrt()
}

fn volume([a, b, c, d]: [[f64; 3]; 4]) -> f64 {
    determinant(&std::array::from_fn(|r| [b[r] - a[r], c[r] - a[r], d[r] - a[r]])) / 6.0
}

/// Only the nodes that cells use, in their order.
fn compacted(nodes: &[[f64; 3]], mut cells: Vec<[u32; 4]>) -> (Vec<[f64; 3]>, Vec<[u32; 4]>) {
    let mut is_used = vec![false; nodes.len()];
    cells.iter().flatten().for_each(|node| is_used[*node as usize] = true);
    let (mut numbers, mut kept) = (vec![0; nodes.len()], Vec::new());
    for (node, at) in nodes.iter().enumerate().filter(|(node, _)| is_used[*node]) {
        numbers[node] = kept.len() as u32;
        kept.push(*at);
    }
    cells.iter_mut().flatten().for_each(|node| *node = numbers[*node as usize]);
    (kept, cells)
}

#[cfg(test)]
mod tests {
    use super::super::{Boundary, BoundingBox, BoxCut, SimplexCylinder, SimplexLattice};
    use super::*;
    use std::f64::consts::PI;

    fn cube(boxes: usize, cut: BoxCut) -> SimplexMesh {
        let around = BoundingBox { lower: [-1.0; 3], upper: [1.0; 3] };
        SimplexLattice { dimension: Dimension::Three, boxes: [boxes; 3], around, cut }.mesh().unwrap()
    }

    fn ball(centre: [f64; 3], radius: f64) -> impl Fn([f64; 3]) -> f64 {
        move |at| distance(at, centre) - radius
    }

    fn least_quality(mesh: &SimplexMesh) -> f64 {
        (0..mesh.cell_count()).map(|cell| mesh.shape_quality(cell)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_spherical_cavity_is_a_closed_shell_on_the_sphere_and_its_volume_converges_with_the_square_of_the_cells() {
        let (centre, radius) = ([0.07, -0.11, 0.05], 0.63f64);
        let exact = 8.0 - 4.0 / 3.0 * PI * radius.powi(3);
        for cut in [BoxCut::Alike, BoxCut::Alternating] {
            let mut errors = Vec::new();
            for boxes in [6, 12, 24] {
                let mesh = cube(boxes, cut).tagged(|x| i32::from(x[0] > 0.0)).carved(ball(centre, radius)).unwrap();
                let boundary = Boundary::of_mesh(&mesh).unwrap();
                let shells = boundary.shells();
                assert_eq!((shells.len(), boundary.branching().len()), (2, 0), "{boxes} boxes, {cut:?}");
                assert_eq!(shells.iter().filter(|shell| shell.is_cavity()).count(), 1);
                for face in boundary.faces().iter().filter(|face| boundary.is_cavity(face)) {
                    for node in face.nodes() {
                        let off = distance(mesh.nodes()[*node as usize], centre) - radius;
                        assert!(off.abs() < 1e-12, "{boxes} boxes: {off}");
                    }
                }
                assert!(least_quality(&mesh) > 0.1, "{boxes} boxes, {cut:?}: {}", least_quality(&mesh));
                errors.push((mesh.total_measure() - exact).abs());
            }
            println!("{cut:?}: {errors:?}");
            // Under an edge of length √3 / 3, the longest of the first mesh, the sphere rises by e² / 8 r.
            let most = 4.0 * PI * radius * radius * (1.0 / 3.0) / (8.0 * radius);
            assert!(errors[0] < most && errors[1] < 0.35 * errors[0] && errors[2] < 0.35 * errors[1], "{errors:?}");
        }
    }

    #[test]
    fn a_hollow_that_opens_to_the_outside_leaves_one_shell_and_the_rest_of_the_boundary_as_it_was() {
        let cylinder = SimplexCylinder { radius: 1.0, height: 0.6, rings: 12, layers: 7 }.mesh().unwrap();
        let outline = |mesh: &SimplexMesh| {
            let least = |r: usize| mesh.nodes().iter().map(|x| x[r]).fold(f64::INFINITY, f64::min);
            [0, 1, 2].map(least)
        };
        for centre in [[0.1, 0.2, 0.6], [0.71, 0.69, 0.3], [0.97, 0.1, 0.55]] {
            let mesh = cylinder.carved(ball(centre, 0.23)).unwrap();
            let boundary = Boundary::of_mesh(&mesh).unwrap();
            assert_eq!((boundary.shells().len(), boundary.branching().len()), (1, 0), "{centre:?}");
            assert!(least_quality(&mesh) > 0.02, "{centre:?}: {}", least_quality(&mesh));
            assert!(mesh.total_measure() < cylinder.total_measure() - 0.3 * 4.0 / 3.0 * PI * 0.23f64.powi(3));
            assert_eq!(outline(&mesh), outline(&cylinder));
        }
    }

    #[test]
    fn a_plane_cuts_off_exactly_what_lies_beyond_it() {
        // The plane cuts the sides of the cube too, where nodes may only slide along them.
        for offset in [-0.31, 0.0, 0.1234, 0.9] {
            let mesh = cube(5, BoxCut::Alternating);
            let part = mesh.carved(|x| offset - x[2]).unwrap();
            assert!((part.total_measure() - 4.0 * (1.0 + offset)).abs() < 1e-12, "{offset}: {}", part.total_measure());
            let whole = part.total_measure() + mesh.carved(|x| x[2] - offset).unwrap().total_measure();
            assert!((whole - 8.0).abs() < 1e-12, "{offset}: {whole}");
            assert_eq!(Boundary::of_mesh(&part).unwrap().shells().len(), 1);
        }
    }

    #[test]
    fn tags_stay_and_nothing_changes_where_nothing_is_cut() {
        let mesh = cube(4, BoxCut::Alternating).tagged(|x| i32::from(x[1] > 0.0));
        assert_eq!(mesh.carved(|_| 1.0).unwrap(), mesh);
        let carved = mesh.carved(ball([0.0; 3], 0.4)).unwrap();
        let right = (0..carved.cell_count()).filter(|c| (carved.centre(*c)[1] > 0.0) == (carved.tags()[*c] == 1));
        assert!(right.count() as f64 > 0.98 * carved.cell_count() as f64);
    }

    #[test]
    fn what_cannot_be_carved_is_refused() {
        let mesh = cube(2, BoxCut::Alike);
        assert!(matches!(mesh.carved(|_| f64::NAN).unwrap_err(), CarvingError::Depth { node: 0, .. }));
        let nothing = mesh.carved(|_| -1.0).unwrap_err();
        assert_eq!(nothing, CarvingError::Mesh(SimplexMeshError::Empty { dimension: Dimension::Three }));
        let around = BoundingBox { lower: [0.0; 3], upper: [1.0; 3] };
        let flat =
            SimplexLattice { dimension: Dimension::Two, boxes: [2; 3], around, cut: BoxCut::Alike }.mesh().unwrap();
        assert_eq!(
            flat.carved(|_| 1.0).unwrap_err().to_string(),
            "the mesh has triangles; only tetrahedra can be carved"
        );
    }
}
