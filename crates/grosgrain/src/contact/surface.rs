//! The part of the body's surface that belongs to each of its nodes.

use crate::fine::FineModel;
use crate::mesh::Cell;

/// Area \[m²\] of the body's surface at every lattice node: a quarter of every face between a solid cell and a void or the outside.
/// Zero inside and at void nodes.
pub fn surface_areas(model: &FineModel) -> Vec<f64> {
    let grid = model.grid();
    let lattice = grid.lattice;
    let mut areas = vec![0.0; lattice.node_count()];
    for cell in (0..lattice.cell_count()).map(Cell).filter(|c| !model.is_void(*c)) {
        let (corners, at) = (lattice.corners(cell), lattice.cell_position(cell));
        for (axis, side) in (0..6).map(|f| (f / 2, f % 2)) {
            let mut offset = [0isize; 3];
            offset[axis] = 2 * side as isize - 1;
            if lattice_neighbour(model, at, offset) {
                continue;
            }
            let quarter = 0.25 * grid.cell_volume() / grid.spacing[axis];
            (0..8).filter(|a| a >> axis & 1 == side).for_each(|a| areas[corners[a].0] += quarter);
        }
    }
    areas
}

/// Whether there is a solid cell next to the cell at `at`.
fn lattice_neighbour(model: &FineModel, at: [usize; 3], offset: [isize; 3]) -> bool {
    model.grid().lattice.neighbour(at, offset).is_some_and(|cell| !model.is_void(cell))
}
