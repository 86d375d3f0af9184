//! Normals of the coarse boundary around a fine one.

use crate::linalg::matrix3::dot;
use crate::simplex::{
    Boundary, BoundaryError, BoundaryFace, BoundingBox, BoundingTree, SimplexMesh, squared_distance_of_face,
};

/// For each face of [`Boundary::outer`] of the fine mesh the unit normal of the coarse outer face nearest to its centre, for the tractions of harmonic displacements
/// (`kharevych2009numerical`, §4.2).
///
/// A fine face that does not look the same way as that face (n · N ≤ 0), such as the wall of a crevice, keeps its own normal: walls that look at each other would otherwise both be pulled outwards.
///
/// # Errors
/// A mesh without a boundary that divides inside from outside.
pub fn bounding_normals(fine: &SimplexMesh, coarse: &SimplexMesh) -> Result<Vec<[f64; 3]>, BoundaryError> {
    let (boundary, around) = (Boundary::of_mesh(fine)?, Boundary::of_mesh(coarse)?);
    let candidates: Vec<&BoundaryFace> = around.outer().collect();
    let corners = |face: usize| candidates[face].nodes().iter().map(|node| coarse.nodes()[*node as usize]);
    let tree = BoundingTree::new((0..candidates.len()).map(|face| BoundingBox::of_points(corners(face))).collect());
    let nearest = |point: [f64; 3]| {
        let squared = |face: u32| {
            let (mut places, count) = ([[0.0; 3]; 3], candidates[face as usize].nodes().len());
            places.iter_mut().zip(corners(face as usize)).for_each(|(place, corner)| *place = corner);
            squared_distance_of_face(&places[..count], point)
        };
        tree.nearest(point, squared).map(|(face, _)| candidates[face as usize].normal)
    };
    let normal = |face: &BoundaryFace| {
        let nodes = face.nodes();
        let sum = |r: usize| nodes.iter().map(|node| fine.nodes()[*node as usize][r]).sum::<f64>();
        let centre = std::array::from_fn(|r| sum(r) / nodes.len() as f64);
        let chosen = nearest(centre).filter(|other| dot(other, &face.normal) > 0.0).unwrap_or(face.normal);
        let length = dot(&chosen, &chosen).sqrt();
        chosen.map(|n| n / length)
    };
    Ok(boundary.outer().map(normal).collect())
}
