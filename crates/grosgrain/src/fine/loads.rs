//! Loads on the lattice: three forces \[N\] per node, x fastest.

use super::FineModel;
use crate::element::Hex8;
use crate::mesh::{Cell, Lattice};

/// Number of harmonic displacements in three dimensions: one per entry of a symmetric stress.
pub const HARMONIC_FIELDS: usize = 6;

/// The constant stress σ_αβ = ½(e_α⊗e_β + e_β⊗e_α) of field 0…5, in the order xx, yy, zz, yz, xz, xy (`kharevych2009numerical`).
pub fn constant_stress(field: usize) -> [[f64; 3]; 3] {
    const PAIRS: [(usize, usize); HARMONIC_FIELDS] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];
    let (alpha, beta) = PAIRS[field];
    let mut stress = [[0.0; 3]; 3];
    stress[alpha][beta] += 0.5;
    stress[beta][alpha] += 0.5;
    stress
}

/// Loads of the six harmonic displacements, one lattice vector after the other: f = ∫ ε(v):σ_αβ dV over the cells of
/// `hull` (solid cells and interior voids), which is the traction σ_αβ n on the hull's outer surface.
pub fn constant_stress_loads(lattice: Lattice, spacing: [f64; 3], hull: &[bool], loads: &mut [f64]) {
    let stride = 3 * lattice.node_count();
    let element = Hex8::new(spacing);
    loads.fill(0.0);
    for (field, column) in loads.chunks_exact_mut(stride).enumerate() {
        let force = element.constant_stress_load(&constant_stress(field));
        for cell in (0..hull.len()).filter(|&c| hull[c]) {
            for (a, node) in lattice.corners(Cell(cell)).iter().enumerate() {
                (0..3).for_each(|r| column[3 * node.0 + r] += force[3 * a + r]);
            }
        }
        clear_rounding(column, &force);
    }
}

/// Inside a hull the loads of neighbouring cells cancel; what rounding leaves is set to zero, because a node
/// inside an interior void has no stiffness to carry it.
fn clear_rounding(column: &mut [f64], force: &[f64; 24]) {
    let largest = force.iter().fold(0.0f64, |m, f| m.max(f.abs()));
    column.iter_mut().filter(|f| f.abs() < 1e-12 * largest).for_each(|f| *f = 0.0);
}

/// Loads of a uniform acceleration \[m/s²\]: ρ V g / 8 on each corner of each cell.
pub fn gravity(model: &FineModel, acceleration: [f64; 3]) -> Vec<f64> {
    let lattice = model.grid().lattice;
    let mut loads = vec![0.0; 3 * lattice.node_count()];
    for cell in (0..lattice.cell_count()).map(Cell) {
        let share = model.cell_mass(cell) / 8.0;
        for node in lattice.corners(cell) {
            (0..3).for_each(|r| loads[3 * node.0 + r] += share * acceleration[r]);
        }
    }
    loads
}

/// Loads of a traction \[Pa\] on the body's surface: on every face between a solid cell and a void (or the outside) all
/// four nodes of which are selected. The second value is the loaded area \[m²\].
pub fn traction(model: &FineModel, selected: &[bool], traction: [f64; 3]) -> (Vec<f64>, f64) {
    let grid = model.grid();
    let lattice = grid.lattice;
    let mut loads = vec![0.0; 3 * lattice.node_count()];
    let mut area = 0.0;
    for cell in (0..lattice.cell_count()).map(Cell).filter(|c| !model.is_void(*c)) {
        let corners = lattice.corners(cell);
        for (axis, side) in (0..6).map(|f| (f / 2, f % 2)) {
            let face = (0..8).filter(|a| a >> axis & 1 == side).map(|a| corners[a].0);
            if !is_outer(model, cell, axis, side) || !face.clone().all(|n| selected[n]) {
                continue;
            }
            let face_area = grid.cell_volume() / grid.spacing[axis];
            area += face_area;
            for node in face {
                (0..3).for_each(|r| loads[3 * node + r] += 0.25 * face_area * traction[r]);
            }
        }
    }
    (loads, area)
}

fn is_outer(model: &FineModel, cell: Cell, axis: usize, side: usize) -> bool {
    let lattice = model.grid().lattice;
    let mut at = lattice.cell_position(cell);
    if side == 0 && at[axis] == 0 || side == 1 && at[axis] + 1 == lattice.cells[axis] {
        return true;
    }
    at[axis] = at[axis] + 2 * side - 1;
    model.is_void(lattice.cell(at))
}

/// Loads of a total force \[N\] spread evenly over the selected nodes that touch a solid cell.
pub fn node_forces(model: &FineModel, selected: &[bool], total: [f64; 3]) -> Vec<f64> {
    let mut loads = vec![0.0; 3 * selected.len()];
    let nodes: Vec<usize> = (0..selected.len()).filter(|&n| selected[n] && model.active()[n]).collect();
    for &n in &nodes {
        (0..3).for_each(|r| loads[3 * n + r] = total[r] / nodes.len() as f64);
    }
    loads
}
