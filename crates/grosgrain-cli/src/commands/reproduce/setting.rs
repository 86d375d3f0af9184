//! The body that a training was initialised on before its cells were updated to the case.

use grosgrain::mesh::{VoxelGrid, random_subset};
use grosgrain::partition::{CoarseCell, Partition};

use super::bodies::PHASES;
use crate::failure::Failure;

/// Seed of the coarse cells of [`Setting::Tenth`].
const SEED: u64 = 2022;

/// What a training knew at the start. Trainings without history see the body as it is and do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// The case itself, as in the paper.
    Own,
    /// The case with its phases swapped; then every cell is updated.
    Swapped,
    /// The case with its phases swapped in a tenth of the coarse cells; then these are set right.
    Tenth,
}

impl Setting {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Own, Self::Swapped, Self::Tenth];

    /// Its name in rows.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Swapped => "swapped",
            Self::Tenth => "tenth",
        }
    }

    /// What it means.
    pub const fn sentence(self) -> &'static str {
        match self {
            Self::Own => "initialised on the case itself, as in the paper",
            Self::Swapped => "initialised on the swapped phases, then every cell updated",
            Self::Tenth => "initialised with a tenth of the coarse cells swapped, then these updated",
        }
    }

    /// The body of initialisation for a case of this degree.
    pub fn initial(self, case: &VoxelGrid, degree: usize) -> Result<VoxelGrid, Failure> {
        let partition = partition(case, degree)?;
        let count = partition.coarse().cell_count();
        let swapped = match self {
            Self::Own => Vec::new(),
            Self::Swapped => (0..count).collect(),
            Self::Tenth => random_subset(SEED, (count as f64 / 10.0).round() as usize, count),
        };
        let mut initial = case.clone();
        for cell in swapped.into_iter().flat_map(|cell| partition.fine_cells(CoarseCell(cell))) {
            let label = &mut initial.labels[cell.0];
            *label = if *label == PHASES[0] { PHASES[1] } else { PHASES[0] };
        }
        Ok(initial)
    }

    /// The coarse cells that must be updated from the body of initialisation to the case, ascending.
    pub fn changed_cells(self, case: &VoxelGrid, degree: usize) -> Result<Vec<CoarseCell>, Failure> {
        let (initial, partition) = (self.initial(case, degree)?, partition(case, degree)?);
        let changed = |cell: &CoarseCell| partition.fine_cells(*cell).any(|c| initial.labels[c.0] != case.labels[c.0]);
        Ok((0..partition.coarse().cell_count()).map(CoarseCell).filter(changed).collect())
    }
}

fn partition(grid: &VoxelGrid, degree: usize) -> Result<Partition, Failure> {
    Partition::new(grid.lattice, degree).map_err(|error| Failure::Failed(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::reproduce::bodies::Heterogeneity;

    #[test]
    fn none_all_or_a_tenth_of_the_cells_change_and_change_whole() {
        let case = Heterogeneity::Oblique.beam(2).unwrap();
        let changed = Setting::ALL.map(|setting| setting.changed_cells(&case, 2).unwrap().len());
        assert_eq!(changed, [0, 256, 26]);
        let initial = Setting::Tenth.initial(&case, 2).unwrap();
        let differing = initial.labels.iter().zip(&case.labels).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 26 * 8);
    }
}
