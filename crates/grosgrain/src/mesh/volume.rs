//! A scalar volume as read from a file, before it becomes a body.

/// A three-dimensional scalar image: what a file holds, before labels and materials.
///
/// Voxels keep the order and the axes of the file (no reorientation); `values` are x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Number of voxels along x, y, z.
    pub cells: [usize; 3],
    /// Edge lengths of a voxel in metres; `None` where the format carries none.
    pub spacing: Option<[f64; 3]>,
    /// Voxel index (i, j, k, 1) to world coordinates in millimetres, RAS as NIfTI has it,
    /// the position being that of a voxel's centre; row-major. `None` where the format carries none.
    pub voxel_to_world: Option<[[f64; 4]; 4]>,
    /// One value per voxel, x fastest, with the file's slope and intercept applied.
    pub values: Vec<f64>,
    /// True if every value is a whole number as stored (labels, CT numbers).
    pub integral: bool,
}

impl Volume {
    /// Smallest and largest value, `None` for an empty volume. NaN is ignored.
    pub fn range(&self) -> Option<(f64, f64)> {
        let finite = self.values.iter().copied().filter(|v| !v.is_nan());
        finite.fold(None, |range, v| match range {
            None => Some((v, v)),
            Some((low, high)) => Some((low.min(v), high.max(v))),
        })
    }
}
