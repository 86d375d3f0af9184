//! Picking nodes, cells and faces of a mesh by where they are.

use super::{BoundaryFace, BoundingBox, Dimension, SimplexMesh};
use crate::mesh::{PlaneAt, SelectionError, Selector};

/// How far below the body's end a node may lie, in shortest edges at the node: flat faces of scanned bodies are flat to a fraction of a voxel only.
const AT_END: f64 = 0.1;
/// How far from a coordinate a node may lie, in shortest edges at the node.
const AT_COORDINATE: f64 = 0.5;
/// Growth of boxes, balls and brushes, as a share of the size of the mesh.
const SLACK: f64 = 1e-9;

/// What selectors ask of a mesh, found once.
struct Picker<'a> {
    mesh: &'a SimplexMesh,
    /// Shortest edge \[m\] at each node; infinite at nodes that no cell uses.
    shortest: Vec<f64>,
    /// Around the nodes that cells use.
    around: BoundingBox,
    slack: f64,
}

impl<'a> Picker<'a> {
    fn new(mesh: &'a SimplexMesh) -> Self {
        let mut shortest = vec![f64::INFINITY; mesh.nodes().len()];
        for cell in 0..mesh.cell_count() {
            let corners = mesh.cell(cell);
            for (n, m) in (1..corners.len()).flat_map(|n| (0..n).map(move |m| (n, m))) {
                let (a, b) = (mesh.corner(cell, n), mesh.corner(cell, m));
                let length = (0..3).map(|r| (a[r] - b[r]).powi(2)).sum::<f64>().sqrt();
                for node in [corners[n], corners[m]] {
                    shortest[node as usize] = shortest[node as usize].min(length);
                }
            }
        }
        let used = mesh.nodes().iter().zip(&shortest).filter(|(_, edge)| edge.is_finite()).map(|(at, _)| *at);
        let around = BoundingBox::of_points(used);
        let slack = SLACK * around.diagonal();
        Self { mesh, shortest, around, slack }
    }

    fn is_used(&self, node: usize) -> bool {
        self.shortest[node].is_finite()
    }

    fn is_in_plane(&self, node: usize, axis: usize, at: PlaneAt) -> bool {
        let (x, edge) = (self.mesh.nodes()[node][axis], self.shortest[node]);
        match at {
            PlaneAt::Min => x - self.around.lower[axis] <= AT_END * edge,
            PlaneAt::Max => self.around.upper[axis] - x <= AT_END * edge,
            PlaneAt::Coordinate(at) => (x - at).abs() <= AT_COORDINATE * edge + self.slack,
        }
    }

    fn meets_plane(&self, cell: usize, axis: usize, at: PlaneAt) -> bool {
        let corners = self.mesh.cell(cell).iter().map(|node| *node as usize);
        let PlaneAt::Coordinate(at) = at else {
            return corners.into_iter().any(|node| self.is_in_plane(node, axis, at));
        };
        let range = BoundingBox::of_cell(self.mesh, cell).grown(self.slack);
        range.lower[axis] <= at && at <= range.upper[axis]
    }

    /// Whether boxes, balls and brushes hold a point; `None` for other selectors.
    fn holds(&self, selector: &Selector, x: [f64; 3]) -> Option<bool> {
        let slack = self.slack;
        match selector {
            Selector::Box { low, high } => Some((0..3).all(|a| x[a] >= low[a] - slack && x[a] <= high[a] + slack)),
            Selector::Sphere { centre, radius } => {
                let reach = radius + slack;
                Some((0..3).map(|a| (x[a] - centre[a]).powi(2)).sum::<f64>() <= reach * reach)
            }
            Selector::Brush(brush) => Some(brush.reaches(x, slack)),
            _ => None,
        }
    }

    fn cells(&self, selector: &Selector) -> Vec<bool> {
        let all = |holds: &dyn Fn(usize) -> bool| (0..self.mesh.cell_count()).map(holds).collect();
        match selector {
            Selector::All => all(&|_| true),
            Selector::Plane { axis, at } => all(&|cell| self.meets_plane(cell, *axis as usize, *at)),
            Selector::Label(label) => all(&|cell| self.mesh.tags()[cell] == label.0),
            Selector::Not(part) => self.cells(part).into_iter().map(|inside| !inside).collect(),
            Selector::And(parts) => merged(all(&|_| true), parts.iter().map(|part| self.cells(part)), |a, b| a && b),
            Selector::Or(parts) => merged(all(&|_| false), parts.iter().map(|part| self.cells(part)), |a, b| a || b),
            _ => all(&|cell| self.holds(selector, self.mesh.centre(cell)).unwrap_or(false)),
        }
    }

    fn nodes(&self, selector: &Selector) -> Vec<bool> {
        let all = |holds: &dyn Fn(usize) -> bool| (0..self.mesh.nodes().len()).map(holds).collect();
        match selector {
            Selector::All => all(&|_| true),
            Selector::Plane { axis, at } => all(&|node| self.is_in_plane(node, *axis as usize, *at)),
            Selector::Label(_) => {
                let mut marks = all(&|_| false);
                let cells = self.cells(selector).into_iter().enumerate().filter(|(_, inside)| *inside);
                cells.flat_map(|(cell, _)| self.mesh.cell(cell)).for_each(|node| marks[*node as usize] = true);
                marks
            }
            Selector::Not(part) => self.nodes(part).into_iter().map(|inside| !inside).collect(),
            Selector::And(parts) => merged(all(&|_| true), parts.iter().map(|part| self.nodes(part)), |a, b| a && b),
            Selector::Or(parts) => merged(all(&|_| false), parts.iter().map(|part| self.nodes(part)), |a, b| a || b),
            _ => all(&|node| self.holds(selector, self.mesh.nodes()[node]).unwrap_or(false)),
        }
    }
}

fn merged(start: Vec<bool>, masks: impl Iterator<Item = Vec<bool>>, join: fn(bool, bool) -> bool) -> Vec<bool> {
    masks.fold(start, |marks, mask| marks.into_iter().zip(mask).map(|(a, b)| join(a, b)).collect())
}

/// Refuses what makes no sense, and what takes away voxels.
fn validate(mesh: &SimplexMesh, selector: &Selector) -> Result<(), SelectionError> {
    let what = match selector {
        Selector::Cut(_) => "a cut",
        Selector::Blade(_) => "a blade",
        Selector::Plane { axis, .. } if *axis as usize >= mesh.dimension().axes() => {
            let instead = if mesh.dimension() == Dimension::One { "X" } else { "X or Y" };
            return Err(SelectionError::NoExtent { axis: *axis, of: mesh.dimension().to_string(), instead });
        }
        Selector::Not(part) => return validate(mesh, part),
        Selector::And(parts) | Selector::Or(parts) => return parts.iter().try_for_each(|part| validate(mesh, part)),
        _ => return selector.validate(),
    };
    Err(SelectionError::NotOfMeshes { what, of: mesh.dimension().to_string() })
}

/// The nodes inside a selector, one mark per node; nodes that no cell uses are never marked.
///
/// Boxes, balls and brushes hold points and are grown by 1e-9 of the size of the mesh; a label picks the nodes of the cells that bear it as their tag. A plane at the body's end picks nodes
/// within a tenth of the shortest edge at the node, so that a face of a scanned body that is flat to a fraction of a voxel is picked as a whole; a plane at a coordinate picks nodes
/// within half of it. On a box of cubes these are the nodes that a voxel grid picks.
///
/// # Errors
/// A selector that makes no sense ([`Selector::validate`]), that takes away voxels (cuts, blades), a plane normal to an axis that the mesh has not, no node picked.
pub fn select_nodes(mesh: &SimplexMesh, selector: &Selector) -> Result<Vec<bool>, SelectionError> {
    validate(mesh, selector)?;
    let picker = Picker::new(mesh);
    let inside = picker.nodes(selector).into_iter().enumerate();
    let marks: Vec<bool> = inside.map(|(node, inside)| inside && picker.is_used(node)).collect();
    match marks.contains(&true) {
        true => Ok(marks),
        false => Err(SelectionError::Empty { low: picker.around.lower, high: picker.around.upper }),
    }
}

/// The cells inside a selector, one mark per cell, perhaps none.
///
/// Boxes, balls and brushes hold the centres of cells, labels are their tags. A plane at the body's end picks cells with a corner there (see [`select_nodes`]), a plane at a coordinate those that it crosses or
/// touches.
///
/// # Errors
/// A selector that makes no sense or takes away voxels, a plane normal to an axis that the mesh has not.
pub fn select_cells(mesh: &SimplexMesh, selector: &Selector) -> Result<Vec<bool>, SelectionError> {
    validate(mesh, selector)?;
    Ok(Picker::new(mesh).cells(selector))
}

/// The faces whose nodes are all marked.
pub fn selected_faces<'a>(
    faces: impl IntoIterator<Item = &'a BoundaryFace>,
    nodes: &[bool],
) -> impl Iterator<Item = &'a BoundaryFace> {
    faces.into_iter().filter(|face| face.nodes().iter().all(|node| nodes[*node as usize]))
}

/// Nodal forces \[N\], three per node, of a constant traction \[Pa\] on faces, f_i = ∫ N_i t dA, and the area \[m²\] of these (per metre of thickness in two
/// dimensions, square metres of the bar in one).
///
/// # Panics
/// Panics when a face has a node that the mesh has not.
pub fn traction_forces<'a>(
    mesh: &SimplexMesh,
    faces: impl IntoIterator<Item = &'a BoundaryFace>,
    traction: [f64; 3],
) -> (Vec<f64>, f64) {
    let (mut forces, mut area) = (vec![0.0; 3 * mesh.nodes().len()], 0.0);
    for face in faces {
        let share = face.measure() / mesh.dimension().axes() as f64;
        area += face.measure();
        for node in face.nodes() {
            (0..3).for_each(|r| forces[3 * *node as usize + r] += share * traction[r]);
        }
    }
    (forces, area)
}
