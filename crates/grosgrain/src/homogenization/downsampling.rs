//! Fields of a fine mesh at the nodes of a coarse one (KMOD09, `kharevych2009numerical`, §3.2).

use rayon::prelude::*;

use super::HarmonicDisplacements;
use crate::simplex::{Locator, Place, SimplexMesh};

/// Harmonic displacements at the nodes of a coarse mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Downsampled {
    /// The fields, linear in every coarse cell.
    pub fields: HarmonicDisplacements,
    /// Coarse nodes outside the fine mesh, whose values are extrapolated from the closest fine cells.
    pub extrapolated: Vec<u32>,
    /// How many times an error of fine values may grow by extrapolation at worst; 1 without.
    pub amplification: f64,
}

/// Takes harmonic displacements of a fine mesh at the nodes of `coarse`: interpolated in the fine cell that holds the node, extrapolated by the barycentric coordinates of the
/// closest cells where none does.
pub fn downsample(fine: &Locator<'_>, fields: &HarmonicDisplacements, coarse: &SimplexMesh) -> Downsampled {
    let places: Vec<Place> = coarse.nodes().par_iter().map(|node| fine.locate(*node)).collect();
    let value = |place: &Place| {
        let mut sum = [[0.0; 6]; 3];
        for (node, weight) in place.weights(fine.mesh()) {
            let field = fields.fields[node as usize].as_flattened();
            sum.as_flattened_mut().iter_mut().zip(field).for_each(|(s, f)| *s += weight * f);
        }
        sum
    };
    let extrapolated = (0..).zip(&places).filter(|(_, place)| place.outside).map(|(node, _)| node).collect();
    let amplification = places.iter().fold(1.0f64, |worst, place| worst.max(place.amplification()));
    Downsampled {
        fields: HarmonicDisplacements { fields: places.iter().map(value).collect() },
        extrapolated,
        amplification,
    }
}
