//! A body on a lattice with another number of cells.

use rayon::prelude::*;

use super::{Cell, Label, Lattice, VoxelGrid, VoxelGridError};

/// Why a body cannot be resampled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResampleError {
    /// A target count is zero.
    #[error("cannot resample to {0:?} cells along x, y, z; every count must be at least 1")]
    NoCells([usize; 3]),
    /// The body itself is unusable.
    #[error(transparent)]
    Grid(#[from] VoxelGridError),
}

/// The same box with `cells` cells along x, y, z; the size of the box stays, so the spacing follows.
///
/// A new cell sums what the old ones hold, weighted by the exact volume they share (the weights are integers: no
/// rounding, and any ratio of counts is allowed, up or down). It is void if more than half of its volume is void.
/// If solid, its label is the one with the largest volume among the solid ones; of equals the one that comes first
/// in `order`, then the lowest. Modulus and density are the volume means over its solid part.
/// Time is linear in old plus new cells.
///
/// # Errors
/// A target count of zero; a grid that [`VoxelGrid::validate`] refuses.
pub fn resample(grid: &VoxelGrid, cells: [usize; 3], order: &[Label]) -> Result<VoxelGrid, ResampleError> {
    if cells.contains(&0) {
        return Err(ResampleError::NoCells(cells));
    }
    grid.validate()?;
    let lattice = Lattice::new(cells);
    let overlaps: [Vec<Overlap>; 3] = std::array::from_fn(|a| axis_overlaps(grid.lattice.cells[a], cells[a]));
    let sampled: Vec<Sample> = (0..lattice.cell_count())
        .into_par_iter()
        .map(|c| {
            let at = lattice.cell_position(Cell(c));
            sample(grid, std::array::from_fn(|a| &overlaps[a][at[a]]), order)
        })
        .collect();
    Ok(VoxelGrid {
        lattice,
        spacing: std::array::from_fn(|a| grid.spacing[a] * grid.lattice.cells[a] as f64 / cells[a] as f64),
        origin: grid.origin,
        labels: sampled.iter().map(|s| s.label).collect(),
        void: sampled.iter().map(|s| s.void).collect(),
        young: grid.young.as_ref().map(|_| sampled.iter().map(|s| s.young).collect()),
        density: grid.density.as_ref().map(|_| sampled.iter().map(|s| s.density).collect()),
    })
}

/// The old cells that a new one covers along an axis, and by how much.
struct Overlap {
    first: usize,
    /// In units of (axis length) / (old count · new count).
    weights: Vec<u64>,
}

/// New cell t covers [t m, (t+1) m] and old cell s covers [s n, (s+1) n], with m old and n new cells.
fn axis_overlaps(old: usize, new: usize) -> Vec<Overlap> {
    let overlap = |t: usize| {
        let (low, high) = (t * old, (t + 1) * old);
        let first = low / new;
        let weights = (first..high.div_ceil(new)).map(|s| (high.min((s + 1) * new) - low.max(s * new)) as u64);
        Overlap { first, weights: weights.collect() }
    };
    (0..new).map(overlap).collect()
}

struct Sample {
    label: Label,
    void: bool,
    young: f64,
    density: f64,
}

/// Volumes that a new cell covers, by label.
#[derive(Default)]
struct Tally(Vec<(Label, u64)>);

impl Tally {
    fn add(&mut self, label: Label, weight: u64) {
        match self.0.iter_mut().find(|(l, _)| *l == label) {
            Some((_, sum)) => *sum += weight,
            None => self.0.push((label, weight)),
        }
    }

    fn total(&self) -> u64 {
        self.0.iter().map(|(_, weight)| weight).sum()
    }

    fn winner(&self, order: &[Label]) -> Option<Label> {
        let rank = |label: Label| (order.iter().position(|o| *o == label).unwrap_or(order.len()), label);
        let best = self.0.iter().max_by_key(|(label, weight)| (*weight, std::cmp::Reverse(rank(*label))));
        best.map(|(label, _)| *label)
    }
}

fn sample(grid: &VoxelGrid, overlaps: [&Overlap; 3], order: &[Label]) -> Sample {
    let (mut solid, mut void) = (Tally::default(), Tally::default());
    let (mut young, mut density) = (0.0, 0.0);
    for_each_overlap(&grid.lattice, overlaps, |cell, weight| {
        if grid.void[cell.0] {
            return void.add(grid.labels[cell.0], weight);
        }
        solid.add(grid.labels[cell.0], weight);
        let of = |field: &Option<Vec<f64>>| field.as_ref().map_or(0.0, |values| weight as f64 * values[cell.0]);
        young += of(&grid.young);
        density += of(&grid.density);
    });
    let volume = solid.total();
    let is_void = void.total() > volume;
    let winner = if is_void { void.winner(order) } else { solid.winner(order) };
    let mean = |sum: f64| if is_void { 0.0 } else { sum / volume as f64 };
    Sample { label: winner.unwrap_or(Label(0)), void: is_void, young: mean(young), density: mean(density) }
}

fn for_each_overlap(lattice: &Lattice, overlaps: [&Overlap; 3], mut visit: impl FnMut(Cell, u64)) {
    let [x, y, z] = overlaps;
    for (k, wz) in z.weights.iter().enumerate() {
        for (j, wy) in y.weights.iter().enumerate() {
            let row = lattice.cell([x.first, y.first + j, z.first + k]).0;
            for (i, wx) in x.weights.iter().enumerate() {
                visit(Cell(row + i), wx * wy * wz);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labelled(cells: [usize; 3], labels: &[i32]) -> VoxelGrid {
        let mut grid = VoxelGrid::uniform(cells, [1.0; 3], Label(0));
        grid.labels = labels.iter().map(|l| Label(*l)).collect();
        grid
    }

    proptest! {
        #[test]
        fn overlaps_cover_every_cell_exactly_once(old in 1..40usize, new in 1..40usize) {
            let mut covered = vec![0; old];
            for overlap in axis_overlaps(old, new) {
                prop_assert_eq!(overlap.weights.iter().sum::<u64>(), old as u64);
                for (i, w) in overlap.weights.iter().enumerate() {
                    prop_assert!(*w > 0);
                    covered[overlap.first + i] += w;
                }
            }
            prop_assert_eq!(covered, vec![new as u64; old]);
        }

        #[test]
        fn upsampling_by_whole_factors_and_back_returns_the_body(
            factor in [1..4usize, 1..4, 1..4],
            values in prop::collection::vec((0..3i32, any::<bool>(), 1..100u32), 24)
        ) {
            let mut grid = VoxelGrid::uniform([4, 3, 2], [1.0, 0.5, 0.25], Label(0));
            for (c, (label, void, young)) in values.iter().enumerate() {
                grid.labels[c] = Label(*label);
                grid.void[c] = *void && c > 0;
                let young = if grid.void[c] { 0.0 } else { f64::from(*young) };
                grid.young.get_or_insert(vec![0.0; 24])[c] = young;
            }
            let fine = resample(&grid, std::array::from_fn(|a| factor[a] * grid.lattice.cells[a]), &[]).unwrap();
            let back = resample(&fine, [4, 3, 2], &[]).unwrap();
            for a in 0..3 {
                prop_assert!((back.spacing[a] - grid.spacing[a]).abs() <= 4.0 * f64::EPSILON * grid.spacing[a]);
            }
            prop_assert_eq!(&back.labels, &grid.labels);
            prop_assert_eq!(&back.void, &grid.void);
            prop_assert_eq!(&back.young, &grid.young, "sums of small integers are exact");
            let fine_count = |l| (0..fine.labels.len()).filter(|&c| fine.labels[c] == Label(l) && !fine.void[c]).count();
            let count = |l| (0..24).filter(|&c| grid.labels[c] == Label(l) && !grid.void[c]).count();
            for l in 0..3 {
                prop_assert_eq!(fine_count(l), count(l) * factor.iter().product::<usize>());
            }
        }

        #[test]
        fn the_volume_integral_of_the_modulus_is_conserved(
            cells in [1..6usize, 1..6, 1..6], young in prop::collection::vec(1.0..100.0f64, 60)
        ) {
            let mut grid = VoxelGrid::uniform([5, 4, 3], [1.0, 2.0, 3.0], Label(1));
            grid.density = Some(young.iter().map(|e| 2.0 * e).collect());
            grid.young = Some(young);
            let to = resample(&grid, cells, &[]).unwrap();
            let integral = |g: &VoxelGrid, f: &Option<Vec<f64>>| g.cell_volume() * f.iter().flatten().sum::<f64>();
            for field in [|g: &VoxelGrid| g.young.clone(), |g: &VoxelGrid| g.density.clone()] {
                let (a, b) = (integral(&grid, &field(&grid)), integral(&to, &field(&to)));
                // At most 60 + 125 additions of positive terms, each with one rounding.
                prop_assert!((a - b).abs() <= 200.0 * f64::EPSILON * a, "{} and {}", a, b);
            }
        }
    }

    #[test]
    fn a_ratio_that_is_no_integer_is_exact() {
        let mut grid = labelled([3, 1, 1], &[1, 1, 2]);
        grid.young = Some(vec![1.0, 2.0, 4.0]);
        let to = resample(&grid, [2, 1, 1], &[]).unwrap();
        assert_eq!(to.young, Some(vec![4.0 / 3.0, 10.0 / 3.0]));
        assert_eq!(to.labels, [Label(1), Label(2)]);
        assert_eq!(to.spacing, [1.5, 1.0, 1.0]);
    }

    #[test]
    fn ties_go_to_the_label_first_in_the_order_and_then_to_the_lowest() {
        let grid = labelled([2, 2, 1], &[3, 2, 2, 3]);
        let winner = |order: &[i32]| {
            let order: Vec<Label> = order.iter().map(|l| Label(*l)).collect();
            resample(&grid, [1; 3], &order).unwrap().labels[0].0
        };
        assert_eq!([winner(&[]), winner(&[3, 2]), winner(&[7]), winner(&[3])], [2, 3, 2, 3]);
    }

    #[test]
    fn a_cell_is_void_when_more_than_half_of_it_is_however_many_labels_share_the_rest() {
        let mut grid = labelled([5, 1, 1], &[1, 2, 3, 0, 9]);
        grid.young = Some(vec![1.0, 2.0, 6.0, 0.0, 0.0]);
        grid.void = vec![false, false, false, true, true];
        let to = resample(&grid, [1; 3], &[]).unwrap();
        assert_eq!((to.void[0], to.labels[0], to.young), (false, Label(1), Some(vec![3.0])));
        grid.void[2] = true;
        let to = resample(&grid, [1; 3], &[Label(9)]).unwrap();
        assert_eq!((to.void[0], to.labels[0], to.young), (true, Label(9), Some(vec![0.0])));
    }

    #[test]
    fn unusable_input_is_refused() {
        let mut grid = labelled([2, 1, 1], &[1, 2]);
        assert_eq!(resample(&grid, [1, 0, 1], &[]), Err(ResampleError::NoCells([1, 0, 1])));
        grid.void.pop();
        assert!(matches!(resample(&grid, [1; 3], &[]), Err(ResampleError::Grid(VoxelGridError::Length { .. }))));
    }
}
