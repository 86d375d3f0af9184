//! Loads add up to the force and the moment of what they stand for.

mod bodies;

use bodies::*;
use grosgrain::fine::{FineModel, constant_stress_loads, gravity, node_forces, traction};
use grosgrain::mesh::{Cell, Label, Node, VoxelGrid, hull};

/// Two materials, densities per voxel, non-cubic cells, a quarter of them void.
fn body() -> FineModel {
    let mut grid = VoxelGrid::uniform([6, 5, 4], [0.5, 1.25, 2.0], Label(0));
    let mut random = Uniform(11);
    for c in 0..grid.lattice.cell_count() {
        grid.void[c] = random.next() < 0.25;
        grid.labels[c] = Label(i32::from(random.next() < 0.5));
    }
    grid.density = Some((0..grid.lattice.cell_count()).map(|_| 500.0 + 1000.0 * random.next()).collect());
    FineModel::new(grid, &table(&[isotropic(1.0, 0.3), isotropic(9.0, 0.2)])).unwrap()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

/// Total force and moment about the origin of a lattice load.
fn resultant(model: &FineModel, loads: &[f64]) -> [f64; 6] {
    let mut total = [0.0; 6];
    for (n, f) in loads.as_chunks::<3>().0.iter().enumerate() {
        let moment = cross(model.node_position(Node(n)), *f);
        (0..3).for_each(|a| total[a] += f[a]);
        (0..3).for_each(|a| total[3 + a] += moment[a]);
    }
    total
}

fn force_at(point: [f64; 3], force: [f64; 3]) -> [f64; 6] {
    let moment = cross(point, force);
    std::array::from_fn(|i| if i < 3 { force[i] } else { moment[i - 3] })
}

#[test]
fn gravity_is_the_weight_at_the_centre_of_mass() {
    let model = body();
    let acceleration = [1.0, -2.0, -9.81];
    let mut exact = [0.0; 6];
    let mut mass = 0.0;
    for cell in (0..model.grid().lattice.cell_count()).map(Cell).filter(|c| !model.is_void(*c)) {
        let centre = model.grid().centre(model.grid().lattice.cell_position(cell));
        let cell_mass = model.grid().density.as_ref().unwrap()[cell.0] * 0.5 * 1.25 * 2.0;
        mass += cell_mass;
        let weight = force_at(centre, acceleration.map(|g| cell_mass * g));
        (0..6).for_each(|i| exact[i] += weight[i]);
    }
    assert!((model.mass() / mass - 1.0).abs() < 1e-14, "mass {} against {mass}", model.mass());
    let error = relative(&resultant(&model, &gravity(&model, acceleration)), &exact);
    assert!(error < 1e-13, "{error:.1e}");
}

#[test]
fn a_traction_is_its_value_times_the_area_at_the_centre_of_the_surface() {
    let grid = VoxelGrid::uniform([6, 5, 4], [0.5, 1.25, 2.0], Label(0));
    let model = FineModel::new(grid, &table(&[isotropic(1.0, 0.3)])).unwrap();
    let lattice = model.grid().lattice;
    let value = [3.0, -1.0, 2.0];
    let size = [3.0, 6.25, 8.0];
    for (axis, side) in (0..6).map(|f| (f / 2, f % 2)) {
        let (loads, area) = traction(&model, &plane(lattice, axis, side * lattice.cells[axis]), value);
        let exact_area: f64 = (0..3).filter(|a| *a != axis).map(|a| size[a]).product();
        let centre = std::array::from_fn(|a| if a == axis { side as f64 * size[a] } else { 0.5 * size[a] });
        assert!((area / exact_area - 1.0).abs() < 1e-14, "face {axis} {side}: area {area}");
        let exact = force_at(centre, value.map(|t| t * exact_area));
        let error = relative(&resultant(&model, &loads), &exact);
        assert!(error < 1e-13, "face {axis} {side}: {error:.1e}");
    }
}

#[test]
fn the_traction_on_all_faces_of_a_body_with_voids_acts_on_its_whole_surface() {
    let model = body();
    let lattice = model.grid().lattice;
    let solid = |at: [usize; 3], step: [isize; 3]| lattice.neighbour(at, step).is_some_and(|c| !model.is_void(c));
    let mut exact = 0.0;
    for cell in (0..lattice.cell_count()).map(Cell).filter(|c| !model.is_void(*c)) {
        let at = lattice.cell_position(cell);
        for (axis, step) in [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)] {
            let mut offset = [0; 3];
            offset[axis] = step;
            exact += if solid(at, offset) { 0.0 } else { 1.25 / model.grid().spacing[axis] };
        }
    }
    let (loads, area) = traction(&model, &vec![true; lattice.node_count()], [0.0, 0.0, 7.0]);
    assert!((area / exact - 1.0).abs() < 1e-13, "{area} against {exact} m²");
    assert!((resultant(&model, &loads)[2] / (7.0 * exact) - 1.0).abs() < 1e-13);
}

#[test]
fn a_force_is_shared_by_the_selected_nodes_of_the_body() {
    let model = body();
    let selected = plane(model.grid().lattice, 0, 6);
    let total = [1.0, 2.0, -3.0];
    let loads = node_forces(&model, &selected, total);
    let found = resultant(&model, &loads);
    assert!(relative(&found[..3], &total) < 1e-14, "{found:?}");
    for n in (0..selected.len()).filter(|&n| !(selected[n] && model.active()[n])) {
        assert_eq!(loads[3 * n..3 * n + 3], [0.0; 3], "node {n}");
    }
}

#[test]
fn constant_stress_loads_are_in_equilibrium_and_vanish_inside_the_hull() {
    let model = body();
    let lattice = model.grid().lattice;
    let inside = hull(&model.grid().void, &lattice);
    let mut loads = vec![0.0; 18 * lattice.node_count()];
    constant_stress_loads(lattice, model.grid().spacing, &inside, &mut loads);
    for (field, column) in loads.chunks_exact(3 * lattice.node_count()).enumerate() {
        let total = resultant(&model, column);
        assert!(largest(&total) < 1e-12 * 8.0 * norm(column), "field {field}: {total:?}");
        assert!(largest(column) > 0.0);
        for n in 0..lattice.node_count() {
            let around: Vec<Cell> = lattice.cells_at(Node(n)).collect();
            if around.len() == 8 && around.iter().all(|c| inside[c.0]) || around.iter().all(|c| !inside[c.0]) {
                assert_eq!(column[3 * n..3 * n + 3], [0.0; 3], "field {field}, node {n}");
            }
        }
    }
}
