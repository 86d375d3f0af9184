//! Where a volume's voxels lie: spacing and axes, in the units and the frame of [`Volume`].

use super::ReadError;
use super::samples::position;
use crate::mesh::Volume;

/// Metres per millimetre.
pub(super) const METRES_PER_MM: f64 = 1e-3;

/// Voxel index (i, j, k, 1) to world coordinates.
pub(super) type Affine = [[f64; 4]; 4];

/// Names of the axes in errors.
pub(super) const AXES: [char; 3] = ['x', 'y', 'z'];

/// Extents and position of a volume; the values are still to come.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Geometry {
    /// Number of voxels along x, y, z.
    pub cells: [usize; 3],
    /// Edge lengths of a voxel \[m\].
    pub spacing: Option<[f64; 3]>,
    /// Voxel index to millimetres, RAS.
    pub voxel_to_world: Option<Affine>,
}

impl Geometry {
    /// The volume with these values, x fastest.
    ///
    /// # Errors
    /// NaN among the values.
    pub fn with_values(self, values: Vec<f64>) -> Result<Volume, ReadError> {
        let count = values.iter().filter(|v| v.is_nan()).count();
        if let Some(first) = values.iter().position(|v| v.is_nan()) {
            let first = position(first, self.cells);
            return Err(ReadError::NotANumber { count, total: values.len(), first });
        }
        let integral = values.iter().all(|v| v.fract() == 0.0);
        let Self { cells, spacing, voxel_to_world } = self;
        Ok(Volume { cells, spacing, voxel_to_world, values, integral })
    }
}

/// Voxel edges in millimetres as metres, refused where they are no lengths.
pub(super) fn spacing_from_mm(mm: [f64; 3], field: &'static str) -> Result<[f64; 3], ReadError> {
    match mm.iter().position(|h| !(h.is_finite() && *h > 0.0 && *h * METRES_PER_MM > 0.0)) {
        None => Ok(mm.map(|h| h * METRES_PER_MM)),
        Some(a) => Err(ReadError::Spacing { axis: AXES[a], value: mm[a], field }),
    }
}

/// Lengths of the first three columns.
pub(super) fn column_norms(affine: &Affine) -> [f64; 3] {
    std::array::from_fn(|c| norm([affine[0][c], affine[1][c], affine[2][c]]))
}

/// Euclidean length.
pub(super) fn norm(v: [f64; 3]) -> f64 {
    // A column along one axis must keep its length to the last bit.
    match v.map(f64::abs) {
        [x, 0.0, 0.0] => x,
        [0.0, y, 0.0] => y,
        [0.0, 0.0, z] => z,
        [x, y, z] => (x * x + y * y + z * z).sqrt(),
    }
}

/// The affine with these voxel axes as columns and the first voxel's centre at `origin`.
pub(super) fn affine(axes: [[f64; 3]; 3], origin: [f64; 3]) -> Affine {
    let row = |r: usize| [axes[0][r], axes[1][r], axes[2][r], origin[r]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

/// Mirrors the world's axes whose sign is −1.
pub(super) fn mirrored(affine: Affine, signs: [f64; 3]) -> Affine {
    // Adding 0 turns −0 into 0.
    let mirror = |r: usize| affine[r].map(|v| v * signs[r] + 0.0);
    [mirror(0), mirror(1), mirror(2), affine[3]]
}

/// LPS, the frame of DICOM and ITK, to RAS or back.
pub(super) const LPS_TO_RAS: [f64; 3] = [-1.0, -1.0, 1.0];

/// Whether all twelve numbers are finite.
pub(super) fn is_finite(affine: &Affine) -> bool {
    affine.iter().flatten().all(|v| v.is_finite())
}

/// The volume's affine in millimetres with columns as long as its spacing; axis-parallel from 0 where it has none.
///
/// The spacing is what counts: it may have been overridden after reading.
pub(super) fn affine_to_write(volume: &Volume, spacing: [f64; 3]) -> Affine {
    let world =
        volume.voxel_to_world.filter(is_finite).unwrap_or(affine([[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]], [0.0; 3]));
    let norms = column_norms(&world);
    let axis = |c: usize| {
        let mm = spacing[c] / METRES_PER_MM;
        match norms[c] > 0.0 {
            true => std::array::from_fn(|r| world[r][c] * (mm / norms[c])),
            false => std::array::from_fn(|r| if r == c { mm } else { 0.0 }),
        }
    };
    affine([axis(0), axis(1), axis(2)], [world[0][3], world[1][3], world[2][3]])
}
