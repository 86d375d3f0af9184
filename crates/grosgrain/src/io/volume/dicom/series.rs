//! From slices in any order to one straight, evenly spaced stack.

use super::super::ReadError;
use super::super::geometry::{self, Geometry, LPS_TO_RAS, spacing_from_mm};
use super::error::{DicomError, SeriesSummary};
use super::slice::Slice;
use crate::mesh::Volume;

/// Distances may differ by this part of their mean: positions are rounded decimals.
const DISTANCE_TOLERANCE: f64 = 0.01;
/// Direction cosines may differ by this much.
const DIRECTION_TOLERANCE: f64 = 1e-3;

/// The volume of a whole series.
pub(super) fn assemble(mut slices: Vec<Slice>) -> Result<Volume, ReadError> {
    refuse_several_series(&slices)?;
    let first = slices.first().ok_or(ReadError::NoSlices { files: 0 })?;
    let normal = cross(first.orientation[0], first.orientation[1]);
    slices.iter().try_for_each(|slice| compare(first, slice))?;
    slices.sort_by(|a, b| dot(a.position, normal).total_cmp(&dot(b.position, normal)));
    let geometry = stack_geometry(&slices, normal)?;
    let values = slices.into_iter().flat_map(Slice::into_values).collect();
    geometry.with_values(values)
}

fn stack_geometry(slices: &[Slice], normal: [f64; 3]) -> Result<Geometry, ReadError> {
    let (Some(first), Some(last)) = (slices.first(), slices.last()) else {
        return Err(ReadError::NoSlices { files: 0 });
    };
    let distance = match slices.len() {
        1 => first.distance.ok_or(DicomError::SingleSlice)?,
        count => (dot(last.position, normal) - dot(first.position, normal)) / (count - 1) as f64,
    };
    refuse_uneven(slices, normal, distance)?;
    let mm = [first.spacing[0], first.spacing[1], distance];
    let spacing = spacing_from_mm(mm, "PixelSpacing and the distance of slices")?;
    let [row, column] = first.orientation;
    let axes = [row.map(|v| v * mm[0]), column.map(|v| v * mm[1]), normal.map(|v| v * mm[2])];
    let world = geometry::mirrored(geometry::affine(axes, first.position), LPS_TO_RAS);
    let cells = [first.size[0] as usize, first.size[1] as usize, slices.len()];
    Ok(Geometry { cells, spacing: Some(spacing), voxel_to_world: Some(world) })
}

fn refuse_several_series(slices: &[Slice]) -> Result<(), DicomError> {
    let mut series: Vec<SeriesSummary> = Vec::new();
    for slice in slices {
        match series.iter_mut().find(|s| s.uid == slice.series) {
            Some(known) => known.slices += 1,
            None => series.push(SeriesSummary {
                uid: slice.series.clone(),
                description: slice.description.clone(),
                slices: 1,
                file: slice.file.clone(),
            }),
        }
    }
    match series.len() {
        0 | 1 => Ok(()),
        _ => Err(DicomError::SeveralSeries(series)),
    }
}

fn compare(first: &Slice, slice: &Slice) -> Result<(), DicomError> {
    let file = || slice.file.clone();
    if slice.size != first.size {
        return Err(DicomError::Size { file: file(), found: slice.size, expected: first.size });
    }
    let cosines = slice.orientation.as_flattened().iter().zip(first.orientation.as_flattened());
    if cosines.into_iter().any(|(a, b)| (a - b).abs() > DIRECTION_TOLERANCE) {
        return Err(DicomError::Differs { file: file(), what: "orientation" });
    }
    if slice.spacing != first.spacing {
        return Err(DicomError::Differs { file: file(), what: "pixel spacing" });
    }
    Ok(())
}

/// Neighbours must be `mean` apart along the normal and straight above each other.
fn refuse_uneven(slices: &[Slice], normal: [f64; 3], mean: f64) -> Result<(), DicomError> {
    let tolerance = DISTANCE_TOLERANCE * mean;
    let Some(base) = slices.first() else { return Ok(()) };
    for pair in slices.windows(2) {
        let (first, second) = (pair[0].file.clone(), pair[1].file.clone());
        let distance = dot(difference(&pair[1], &pair[0]), normal);
        if distance <= tolerance {
            let position = dot(pair[0].position, normal);
            return Err(DicomError::SamePlace { first, second, position });
        }
        if (distance - mean).abs() > tolerance {
            return Err(DicomError::Distance { first, second, distance, mean });
        }
        let offset = difference(&pair[1], base);
        let along = dot(offset, normal);
        let aside: [f64; 3] = std::array::from_fn(|a| offset[a] - along * normal[a]);
        // A rounded normal moves the end of a long stack aside by its error times the length.
        let shift = geometry::norm(aside);
        if shift > DISTANCE_TOLERANCE * mean + DIRECTION_TOLERANCE * along {
            return Err(DicomError::Sheared { file: second, shift });
        }
    }
    Ok(())
}

fn difference(a: &Slice, b: &Slice) -> [f64; 3] {
    std::array::from_fn(|c| a.position[c] - b.position[c])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
