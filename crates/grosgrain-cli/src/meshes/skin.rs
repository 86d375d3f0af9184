//! What is seen of a mesh: the boundary of tetrahedra or all triangles, whole or cut open.

use std::sync::Arc;

use grosgrain::mesh::Label;
use grosgrain::simplex::{BoundingBox, Dimension, SimplexMesh};
use grosgrain_picture::Lines;

use super::cut::{Cutter, MeshCut, Remains, Side, Vertex};
use crate::failure::Failure;
use crate::quantities::triple;

/// What is seen of a mesh: the boundary of tetrahedra with the walls of cavities, or all triangles of a plane mesh; of what is left after a cut, where there is one.
///
/// Its vertices lie on nodes, or between two where a cut meets an edge, so that it moves with displacements of the nodes.
#[derive(Clone, Debug)]
pub struct SimplexSkin {
    dimension: Dimension,
    nodes: usize,
    cell_count: usize,
    vertices: Vec<Vertex>,
    rest: Vec<[f64; 3]>,
    /// A triangle has its last vertex twice.
    faces: Arc<Vec<[u32; 4]>>,
    cells: Vec<u32>,
    tags: Arc<Vec<Label>>,
    tags_of_mesh: Vec<Label>,
}

impl SimplexSkin {
    /// The skin of a mesh, or of what a cut leaves of it.
    ///
    /// # Errors
    /// A mesh of segments; a cut that has no direction or leaves nothing.
    pub fn new(mesh: &SimplexMesh, cut: Option<&MeshCut>) -> Result<Self, Failure> {
        if let Some(cut) = cut
            && !(cut.away.iter().any(|x| *x != 0.0) && cut.away.iter().chain(&cut.through).all(|x| x.is_finite()))
        {
            let (through, away) = (cut.through, cut.away);
            let text = format!(
                "no plane goes through {through:?} with the normal {away:?}; give finite numbers, and a normal that is not zero"
            );
            return Err(Failure::Unusable(text));
        }
        let faces = match mesh.dimension() {
            Dimension::One => {
                return Err(Failure::Unusable(
                    "a mesh of segments has no surface to draw; draw its curves instead".into(),
                ));
            }
            Dimension::Two => Faces::of_triangles(mesh, cut),
            Dimension::Three => Faces::of_tetrahedra(mesh, cut),
        };
        match cut {
            Some(cut) if faces.polygons.is_empty() => Err(Failure::Unusable(format!(
                "a cut through ({}) leaves nothing of the mesh to draw; turn its normal round or move it",
                triple(cut.through).replace(" × ", ", ")
            ))),
            _ => Ok(Self::with_faces(mesh, faces)),
        }
    }

    fn with_faces(mesh: &SimplexMesh, faces: Faces) -> Self {
        let Faces { polygons, cells, cutter } = faces;
        let vertices = cutter.vertices;
        let rest = vertices.iter().map(|vertex| vertex.value(|node| mesh.nodes()[node])).collect();
        let tags = cells.iter().map(|cell| Label(mesh.tags()[*cell as usize])).collect();
        let mut tags_of_mesh: Vec<Label> = mesh.tags().iter().map(|tag| Label(*tag)).collect();
        tags_of_mesh.sort_unstable();
        tags_of_mesh.dedup();
        Self {
            dimension: mesh.dimension(),
            nodes: mesh.nodes().len(),
            cell_count: mesh.cell_count(),
            vertices,
            rest,
            faces: Arc::new(polygons),
            cells,
            tags: Arc::new(tags),
            tags_of_mesh,
        }
    }

    /// Triangles or tetrahedra.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// Number of nodes of the mesh.
    pub fn node_count(&self) -> usize {
        self.nodes
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// The four vertices of each face against the clock as seen from outside; a triangle has its last one twice.
    pub fn faces(&self) -> &Arc<Vec<[u32; 4]>> {
        &self.faces
    }

    /// The cell that each face belongs to.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// The tag of each face's cell.
    pub fn tags(&self) -> &Arc<Vec<Label>> {
        &self.tags
    }

    /// All tags of the mesh, seen or not, ascending.
    pub fn tags_of_mesh(&self) -> &[Label] {
        &self.tags_of_mesh
    }

    /// Places \[m\] of the vertices at rest.
    pub fn rest(&self) -> &[[f64; 3]] {
        &self.rest
    }

    /// Longest side \[m\] of the box around it at rest.
    pub fn size(&self) -> f64 {
        let around = BoundingBox::of_points(self.rest.iter().copied());
        (0..3).map(|r| around.upper[r] - around.lower[r]).fold(0.0, f64::max)
    }

    /// Places \[m\] of the vertices under displacements \[m\] of the nodes, three per node, `scale` times.
    ///
    /// # Panics
    /// Displacements that are not three per node of the mesh.
    pub fn displaced<'a>(&'a self, displacement: &'a [f64], scale: f64) -> impl Iterator<Item = [f64; 3]> + 'a {
        assert_eq!(displacement.len(), 3 * self.nodes, "three displacements per node");
        let moved = move |vertex: &Vertex| vertex.value(|node| [0, 1, 2].map(|r| displacement[3 * node + r]));
        let places = self.rest.iter().zip(self.vertices.iter().map(moved));
        places.map(move |(at, u)| std::array::from_fn(|r| at[r] + scale * u[r]))
    }

    /// Values at the vertices of a field that is linear between nodes.
    ///
    /// # Panics
    /// Values that are not one per node of the mesh.
    pub fn at_vertices(&self, values: &[f64]) -> Vec<f64> {
        assert_eq!(values.len(), self.nodes, "one value per node");
        self.vertices.iter().map(|vertex| vertex.value(|node| [values[node]])[0]).collect()
    }

    /// Values of the faces' cells.
    ///
    /// # Panics
    /// Values that are not one per cell of the mesh.
    pub fn of_faces(&self, values: &[f64]) -> Vec<f64> {
        assert_eq!(values.len(), self.cell_count, "one value per cell");
        self.cells.iter().map(|cell| values[*cell as usize]).collect()
    }

    /// Edges at rest at which the skin ends, or its faces meet at more than 41 degrees: the outline of a plane mesh, the edges of a box.
    pub fn outline(&self) -> Lines {
        let normals: Vec<[f64; 3]> =
            self.faces.iter().map(|face| unit_normal(face.map(|v| self.rest[v as usize]))).collect();
        let with_face = |(n, face): (usize, &[u32; 4])| sides(face).map(|edge| (edge, n)).collect::<Vec<_>>();
        let mut of_faces: Vec<([u32; 2], usize)> = self.faces.iter().enumerate().flat_map(with_face).collect();
        of_faces.sort_unstable();
        let is_sharp = |group: &&[([u32; 2], usize)]| match group {
            [one, other] => (0..3).map(|r| normals[one.1][r] * normals[other.1][r]).sum::<f64>() < 0.75,
            _ => true,
        };
        of_faces
            .chunk_by(|a, b| a.0 == b.0)
            .filter(is_sharp)
            .map(|group| group[0].0.map(|v| self.rest[v as usize]))
            .collect()
    }
}

impl Vertex {
    fn value<const N: usize>(&self, at_node: impl Fn(usize) -> [f64; N]) -> [f64; N] {
        let [a, b] = self.nodes.map(|node| at_node(node as usize));
        match self.nodes[0] == self.nodes[1] {
            true => a,
            false => std::array::from_fn(|r| (1.0 - self.share) * a[r] + self.share * b[r]),
        }
    }
}

/// The edges of a face, the lesser vertex first.
fn sides(face: &[u32; 4]) -> impl Iterator<Item = [u32; 2]> + use<> {
    let [a, b, c, d] = *face;
    let pairs = [(a, b), (b, c), (c, d), (d, a)].into_iter().filter(|(p, q)| p != q);
    pairs.map(|(p, q)| [p.min(q), p.max(q)])
}

/// Zero for a face without area.
fn unit_normal([a, b, c, d]: [[f64; 3]; 4]) -> [f64; 3] {
    let [p, q]: [[f64; 3]; 2] = [[a, c], [b, d]].map(|[from, to]| std::array::from_fn(|r| to[r] - from[r]));
    let normal = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    normal.map(|x| if length > 0.0 { x / length } else { 0.0 })
}

/// Polygons of three or four vertices, and their cells.
struct Faces {
    polygons: Vec<[u32; 4]>,
    cells: Vec<u32>,
    cutter: Cutter,
}

impl Faces {
    fn new(mesh: &SimplexMesh, cut: Option<&MeshCut>) -> (Self, Vec<Remains>) {
        let cutter = Cutter::new(mesh, cut);
        let is_spared = |cell: usize| cut.is_some_and(|cut| cut.spared.contains(&Label(mesh.tags()[cell])));
        let remains = |cell: usize| match is_spared(cell) {
            true => Remains::Whole,
            false => cutter.remains(mesh.cell(cell)),
        };
        let remains = (0..mesh.cell_count()).map(remains).collect();
        (Self { polygons: Vec::new(), cells: Vec::new(), cutter }, remains)
    }

    fn of_triangles(mesh: &SimplexMesh, cut: Option<&MeshCut>) -> Self {
        let (mut faces, remains) = Self::new(mesh, cut);
        for (cell, remains) in remains.into_iter().enumerate() {
            faces.add_part(cell as u32, mesh.cell(cell), remains, Remains::Nothing);
        }
        faces
    }

    fn of_tetrahedra(mesh: &SimplexMesh, cut: Option<&MeshCut>) -> Self {
        let (mut faces, remains) = Self::new(mesh, cut);
        let mut sides: Vec<([u32; 3], u32, [u32; 3])> = Vec::with_capacity(4 * mesh.cell_count());
        for cell in 0..mesh.cell_count() {
            for corners in [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]] {
                let outward = corners.map(|n: usize| mesh.cell(cell)[n]);
                let mut key = outward;
                key.sort_unstable();
                sides.push((key, cell as u32, outward));
            }
        }
        sides.sort_unstable();
        let left = |cell: u32| remains[cell as usize];
        for group in sides.chunk_by(|a, b| a.0 == b.0) {
            match group {
                [(_, cell, outward)] => faces.add_part(*cell, outward, left(*cell), Remains::Nothing),
                [(_, a, from_a), (_, b, from_b)] => {
                    faces.add_part(*a, from_a, left(*a), left(*b));
                    faces.add_part(*b, from_b, left(*b), left(*a));
                }
                // Three cells at a face overlap: none of its sides is seen.
                _ => {}
            }
        }
        for cell in (0..mesh.cell_count()).filter(|cell| remains[*cell] == Remains::Part) {
            faces.add_section(mesh, cell, cut);
        }
        faces
    }

    /// Adds what a cell has of a face (or of itself in the plane) and the cell on the other side has not.
    fn add_part(&mut self, cell: u32, polygon: &[u32], own: Remains, other: Remains) {
        let part = match (own, other) {
            (Remains::Whole, Remains::Nothing) => self.cutter.whole(polygon),
            (Remains::Whole, Remains::Part) => self.cutter.clip(polygon, Side::Away),
            (Remains::Part, Remains::Nothing) => self.cutter.clip(polygon, Side::Kept),
            _ => return,
        };
        self.add(cell, &part);
    }

    fn add(&mut self, cell: u32, polygon: &[u32]) {
        let quad = match *polygon {
            [a, b, c] => [a, b, c, c],
            [a, b, c, d] => [a, b, c, d],
            _ => return,
        };
        self.polygons.push(quad);
        self.cells.push(cell);
    }

    /// Adds the section of a cell, turned outwards.
    fn add_section(&mut self, mesh: &SimplexMesh, cell: usize, cut: Option<&MeshCut>) {
        let mut polygon = self.cutter.section(mesh.cell(cell));
        let Some(cut) = cut.filter(|_| polygon.len() > 2) else { return };
        let at = |n: usize| {
            self.cutter.vertices[polygon[n.min(polygon.len() - 1)] as usize].value(|node| mesh.nodes()[node])
        };
        let normal = unit_normal([at(0), at(1), at(2), at(3)]);
        if (0..3).map(|r| normal[r] * cut.away[r]).sum::<f64>() < 0.0 {
            polygon.reverse();
        }
        self.add(cell as u32, &polygon);
    }
}
