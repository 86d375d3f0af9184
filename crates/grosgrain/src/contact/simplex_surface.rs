//! The part of the surface of a mesh of simplices that belongs to each of its nodes.

use crate::simplex::{Boundary, BoundaryError, SimplexMesh};

/// Size of the body's surface at every node: a d-th of every boundary face at each of its nodes, walls of cavities included; area \[m²\] in three dimensions, length \[m\] in
/// two, number of ends in one. Zero inside.
///
/// # Errors
/// A mesh with faces that do not divide inside from outside.
pub fn simplex_surface_areas(mesh: &SimplexMesh) -> Result<Vec<f64>, BoundaryError> {
    let mut areas = vec![0.0; mesh.nodes().len()];
    for face in Boundary::of_mesh(mesh)?.faces() {
        let share = face.measure() / mesh.dimension().axes() as f64;
        face.nodes().iter().for_each(|node| areas[*node as usize] += share);
    }
    Ok(areas)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simplex::{BoundingBox, BoxCut, Dimension, SimplexLattice};

    #[test]
    fn areas_of_a_box_sum_to_its_surface_and_none_lies_inside() {
        let around = BoundingBox { lower: [1.0, -1.0, 0.0], upper: [3.0, 2.0, 4.0] };
        for (dimension, surface, inside) in
            [(Dimension::One, 2.0, 3), (Dimension::Two, 10.0, 6), (Dimension::Three, 52.0, 6)]
        {
            for cut in [BoxCut::Alike, BoxCut::Alternating] {
                let mesh = SimplexLattice { dimension, boxes: [4, 3, 2], around, cut }.mesh().unwrap();
                let areas = simplex_surface_areas(&mesh).unwrap();
                let sum: f64 = areas.iter().sum();
                assert!((sum - surface).abs() < 1e-12, "{dimension}: {sum}");
                assert_eq!(areas.iter().filter(|a| **a == 0.0).count(), inside, "{dimension}");
            }
        }
    }
}
