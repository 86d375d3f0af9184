//! Synthetic patterns of labels.

use rand_chacha::ChaCha8Rng;

use super::spheres::{self, SphereCentres};
use super::uniform::{random_stream, uniform};
use super::{Bars, Cell, Label, Lattice, VoxelGrid};

/// A pattern of labels on a grid. Lengths are in fine cells and positions in cell indices, so a pattern stretches
/// with cells that are not cubes.
#[derive(Clone, Debug, PartialEq)]
pub enum Pattern {
    /// Plane layers: the label with index ⌊s L / period⌋ mod L of the L labels, s = direction · (i, j, k).
    ///
    /// The direction is *not* normalised: \[1, 1, 1\] makes s = i + j + k.
    Layers {
        /// Direction across the layers.
        direction: [f64; 3],
        /// Advance of s that runs through all labels once; 4 with two labels makes each layer 2 cells thick.
        period: f64,
        /// The labels in turn.
        labels: Vec<Label>,
    },
    /// Cubes of `size` cells: the label with index ⌊i/size⌋ + ⌊j/size⌋ + ⌊k/size⌋ mod L of the L labels.
    Checkerboard {
        /// Edge of a cube in cells.
        size: usize,
        /// The labels in turn.
        labels: Vec<Label>,
    },
    /// Cubes of `size` cells, each with a label drawn independently of the others.
    ///
    /// One number of a ChaCha8 stream per cube, x fastest: the same on any machine.
    Random {
        /// Seed of the stream.
        seed: u64,
        /// Edge of a cube in cells; 1 draws per cell.
        size: usize,
        /// The labels to draw from.
        labels: Vec<Label>,
        /// Probability of each label, summing to 1; equal if `None`.
        fractions: Option<Vec<f64>>,
    },
    /// Spheres in a matrix: a cell is inside if its centre is no further than `radius` from a sphere's centre.
    Spheres {
        /// Radius in cells.
        radius: f64,
        /// Where the spheres are.
        centres: SphereCentres,
        /// Label of the matrix, label of the spheres.
        labels: [Label; 2],
    },
    /// A grid of bars in a matrix.
    Grid {
        /// Where the bars are.
        bars: Bars,
        /// Label of the matrix, label of the bars.
        labels: [Label; 2],
    },
}

/// Why a pattern is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PatternError {
    /// The list of labels is empty.
    #[error("the pattern has no labels; list at least one")]
    NoLabels,
    /// The direction of layers is zero or not finite.
    #[error("the direction {0:?} of the layers must be finite and not zero")]
    Direction([f64; 3]),
    /// A length is not positive.
    #[error("the {what} of the pattern is {value} fine cells; it must be positive and finite")]
    Length {
        /// Which length.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Fractions do not match the labels.
    #[error("the pattern has {fractions} fractions for {labels} labels; give one fraction per label")]
    FractionCount {
        /// Number of fractions.
        fractions: usize,
        /// Number of labels.
        labels: usize,
    },
    /// Fractions are no probabilities.
    #[error("the fractions {0:?} of the pattern must not be negative and must sum to 1")]
    Fractions(Vec<f64>),
    /// A box of cells is none, or not inside the grid.
    #[error("the box {extent:?} of the pattern must hold cells, and only cells of the grid, which has {cells:?}")]
    Extent {
        /// First cell and the one after the last.
        extent: [[usize; 3]; 2],
        /// The grid's cells.
        cells: [usize; 3],
    },
    /// A centre is not finite.
    #[error("the centre {0:?} of a sphere must be finite")]
    Centre([f64; 3]),
    /// A sphere is too large for the grid.
    #[error("spheres of radius {radius} do not fit into a grid of {cells:?} cells; make them smaller")]
    TooLarge {
        /// Radius in cells.
        radius: f64,
        /// The grid's cells.
        cells: [usize; 3],
    },
    /// Spheres without overlap were not found.
    #[error(
        "only {placed} of {count} spheres of radius {radius} found a place without overlap; \
         ask for fewer or smaller spheres"
    )]
    Crowded {
        /// Number of spheres placed.
        placed: usize,
        /// Number of spheres asked for.
        count: usize,
        /// Radius in cells.
        radius: f64,
    },
}

impl Pattern {
    /// Sets the label of every cell of the grid; voids stay void.
    ///
    /// # Errors
    /// Parameters that make no pattern: see [`PatternError`]. The grid is then left as it was.
    pub fn paint(&self, grid: &mut VoxelGrid) -> Result<(), PatternError> {
        grid.labels = self.labels(&grid.lattice)?;
        Ok(())
    }

    /// The label of every cell, x fastest.
    ///
    /// # Errors
    /// Parameters that make no pattern: see [`PatternError`].
    pub fn labels(&self, lattice: &Lattice) -> Result<Vec<Label>, PatternError> {
        self.validate()?;
        Ok(match self {
            Self::Layers { direction, period, labels } => layers(lattice, *direction, *period, labels),
            Self::Checkerboard { size, labels } => per_cell(lattice, |at| {
                labels[at.iter().map(|i| (i / size) % labels.len()).sum::<usize>() % labels.len()]
            }),
            Self::Random { seed, size, labels, fractions } => {
                let mut stream = random_stream(*seed);
                random(lattice, *size, || draw(&mut stream, labels, fractions.as_deref()))
            }
            Self::Spheres { radius, centres, labels } => {
                let inside = spheres::inside(lattice, *radius, centres)?;
                inside.into_iter().map(|i| labels[usize::from(i)]).collect()
            }
            Self::Grid { bars, labels } => {
                let cells = lattice.cells;
                let refused = || PatternError::Extent { extent: bars.extent.unwrap_or([[0; 3], cells]), cells };
                let extent = bars.extent_on(lattice).ok_or_else(refused)?;
                per_cell(lattice, |at| labels[usize::from(bars.contain(extent, at))])
            }
        })
    }

    fn validate(&self) -> Result<(), PatternError> {
        match self {
            Self::Layers { direction, period, labels } => {
                if !direction.iter().all(|d| d.is_finite()) || *direction == [0.0; 3] {
                    return Err(PatternError::Direction(*direction));
                }
                check_length("period", *period)?;
                check_labels(labels)
            }
            Self::Checkerboard { size, labels } => {
                check_length("size", *size as f64)?;
                check_labels(labels)
            }
            Self::Random { size, labels, fractions, .. } => {
                check_length("size", *size as f64)?;
                check_labels(labels)?;
                fractions.as_ref().map_or(Ok(()), |fractions| check_fractions(fractions, labels.len()))
            }
            Self::Spheres { radius, centres, .. } => {
                check_length("radius", *radius)?;
                match centres {
                    SphereCentres::Periodic { period } => check_length("period", *period),
                    _ => Ok(()),
                }
            }
            Self::Grid { bars, .. } => {
                check_length("width", bars.width as f64)?;
                bars.period.into_iter().try_for_each(|period| check_length("period", period as f64))
            }
        }
    }
}

fn check_labels(labels: &[Label]) -> Result<(), PatternError> {
    if labels.is_empty() { Err(PatternError::NoLabels) } else { Ok(()) }
}

fn check_length(what: &'static str, value: f64) -> Result<(), PatternError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(PatternError::Length { what, value }) }
}

fn check_fractions(fractions: &[f64], labels: usize) -> Result<(), PatternError> {
    if fractions.len() != labels {
        return Err(PatternError::FractionCount { fractions: fractions.len(), labels });
    }
    let sum: f64 = fractions.iter().sum();
    if fractions.iter().all(|f| *f >= 0.0) && (sum - 1.0).abs() <= 1e-9 {
        Ok(())
    } else {
        Err(PatternError::Fractions(fractions.to_vec()))
    }
}

fn per_cell(lattice: &Lattice, label: impl FnMut([usize; 3]) -> Label) -> Vec<Label> {
    (0..lattice.cell_count()).map(|c| lattice.cell_position(Cell(c))).map(label).collect()
}

fn layers(lattice: &Lattice, direction: [f64; 3], period: f64, labels: &[Label]) -> Vec<Label> {
    let count = labels.len() as f64;
    per_cell(lattice, |at| {
        let s: f64 = (0..3).map(|a| direction[a] * at[a] as f64).sum();
        let turn = guarded_floor(s * count / period).rem_euclid(count);
        labels[(turn as usize).min(labels.len() - 1)]
    })
}

/// ⌊x⌋, taking a value that rounding left just below a whole number for that number.
fn guarded_floor(x: f64) -> f64 {
    let nearest = x.round();
    if (x - nearest).abs() <= 1e-9 * x.abs().max(1.0) { nearest } else { x.floor() }
}

fn random(lattice: &Lattice, size: usize, draw: impl FnMut() -> Label) -> Vec<Label> {
    let blocks = Lattice::new(lattice.cells.map(|n| n.div_ceil(size)));
    let drawn: Vec<Label> = std::iter::repeat_with(draw).take(blocks.cell_count()).collect();
    per_cell(lattice, |at| drawn[blocks.cell(at.map(|i| i / size)).0])
}

fn draw(stream: &mut ChaCha8Rng, labels: &[Label], fractions: Option<&[f64]>) -> Label {
    let u = uniform(stream);
    let last = labels.len() - 1;
    let Some(fractions) = fractions else {
        return labels[((u * labels.len() as f64) as usize).min(last)];
    };
    let mut reached = 0.0;
    let chosen = fractions.iter().position(|f| {
        reached += f;
        u < reached
    });
    let likely = fractions.iter().rposition(|f| *f > 0.0).unwrap_or(last);
    labels[chosen.unwrap_or(likely)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const AB: [Label; 2] = [Label(0), Label(1)];

    fn layered(cells: [usize; 3], direction: [f64; 3], period: f64) -> Vec<i32> {
        let pattern = Pattern::Layers { direction, period, labels: AB.to_vec() };
        pattern.labels(&Lattice::new(cells)).unwrap().iter().map(|l| l.0).collect()
    }

    proptest! {
        #[test]
        fn layers_along_111_alternate_with_the_sum_of_the_indices(cells in [1..9usize, 1..9, 1..9], t in 1..6usize) {
            let lattice = Lattice::new(cells);
            let found = layered(cells, [1.0; 3], 2.0 * t as f64);
            for (c, label) in found.iter().enumerate() {
                let sum: usize = lattice.cell_position(Cell(c)).iter().sum();
                prop_assert_eq!(*label, (sum / t % 2) as i32);
            }
        }
    }

    #[test]
    fn layers_are_exact_where_the_direction_is_rounded() {
        let tenths: Vec<i32> = (0..40).map(|i| i / 2 % 2).collect();
        assert_eq!(layered([40, 1, 1], [0.1, 0.0, 0.0], 0.4), tenths);
    }

    #[test]
    fn a_negative_direction_counts_downwards() {
        assert_eq!(layered([5, 1, 1], [-1.0, 0.0, 0.0], 4.0), [0, 1, 1, 0, 0]);
    }

    #[test]
    fn a_checkerboard_has_cubes_of_its_size() {
        let lattice = Lattice::new([4, 4, 2]);
        let labels = Pattern::Checkerboard { size: 2, labels: AB.to_vec() }.labels(&lattice).unwrap();
        assert_eq!(labels[..8].iter().map(|l| l.0).collect::<Vec<_>>(), [0, 0, 1, 1, 0, 0, 1, 1]);
        assert_eq!(labels[8..16].iter().map(|l| l.0).collect::<Vec<_>>(), [1, 1, 0, 0, 1, 1, 0, 0]);
        assert_eq!(labels[..16], labels[16..]);
    }

    fn bars(period: [usize; 3], width: usize, extent: Option<[[usize; 3]; 2]>) -> Pattern {
        Pattern::Grid { bars: Bars { period, width, extent }, labels: AB }
    }

    #[test]
    fn bars_cross_in_a_grid_inside_their_box() {
        let ribs = bars([3, 2, 1], 1, Some([[1, 0, 0], [6, 3, 1]])).labels(&Lattice::new([7, 4, 2])).unwrap();
        let rows: Vec<String> = ribs.chunks(7).map(|row| row.iter().map(|l| l.to_string()).collect()).collect();
        assert_eq!(rows[..4], ["0111110", "0100100", "0111110", "0000000"]);
        assert_eq!(rows[4..], ["0000000"; 4]);
        let lattice = Lattice::new([4; 3]);
        let cross = bars([4; 3], 1, None).labels(&lattice).unwrap();
        for (c, label) in cross.iter().enumerate() {
            let zeros = lattice.cell_position(Cell(c)).iter().filter(|i| **i == 0).count();
            assert_eq!(label.0, i32::from(zeros >= 2), "three edges of a cube meet: cell {c}");
        }
        assert_eq!(cross.iter().filter(|label| label.0 == 1).count(), 10);
    }

    #[test]
    fn a_random_pattern_is_the_same_for_ever() {
        let pattern = Pattern::Random { seed: 7, size: 1, labels: AB.to_vec(), fractions: None };
        let labels = pattern.labels(&Lattice::new([8, 2, 1])).unwrap();
        let text: String = labels.iter().map(|l| l.to_string()).collect();
        assert_eq!(text, "1000000011110011");
        let blocks = Pattern::Random { seed: 7, size: 3, labels: AB.to_vec(), fractions: None };
        let coarse = blocks.labels(&Lattice::new([24, 6, 1])).unwrap();
        for (c, label) in coarse.iter().enumerate() {
            assert_eq!(*label, labels[c % 24 / 3 + 8 * (c / 72)], "cell {c} takes the label of its block");
        }
    }

    #[test]
    fn random_fractions_are_met_within_five_standard_deviations() {
        let fractions = vec![0.2, 0.0, 0.8];
        let labels = vec![Label(0), Label(1), Label(2)];
        let pattern = Pattern::Random { seed: 1, size: 1, labels, fractions: Some(fractions) };
        let n = 40 * 40 * 40;
        let painted = pattern.labels(&Lattice::new([40; 3])).unwrap();
        let count = |l| painted.iter().filter(|p| **p == Label(l)).count() as f64;
        let deviation = (n as f64 * 0.2 * 0.8).sqrt();
        assert_eq!(count(1), 0.0);
        assert!((count(0) - 0.2 * n as f64).abs() < 5.0 * deviation, "{} of {n} cells", count(0));
    }

    #[test]
    fn parameters_that_make_no_pattern_are_refused_and_leave_the_grid() {
        let mut body = VoxelGrid::uniform([2; 3], [1.0; 3], Label(5));
        let labels = AB.to_vec();
        let layers = |direction, period, labels| Pattern::Layers { direction, period, labels };
        let random = |fractions| Pattern::Random { seed: 0, size: 1, labels: AB.to_vec(), fractions: Some(fractions) };
        for (pattern, part) in [
            (layers([0.0; 3], 4.0, labels.clone()), "must be finite and not zero"),
            (layers([f64::NAN, 0.0, 1.0], 4.0, labels.clone()), "must be finite and not zero"),
            (layers([1.0; 3], 0.0, labels.clone()), "period of the pattern is 0"),
            (layers([1.0; 3], 4.0, vec![]), "no labels"),
            (Pattern::Checkerboard { size: 0, labels }, "size of the pattern is 0"),
            (bars([2, 0, 2], 1, None), "period of the pattern is 0"),
            (bars([2; 3], 0, None), "width of the pattern is 0"),
            (bars([2; 3], 1, Some([[0; 3], [2, 2, 3]])), "only cells of the grid, which has [2, 2, 2]"),
            (bars([2; 3], 1, Some([[1, 0, 0], [1, 2, 2]])), "must hold cells"),
            (random(vec![1.0]), "1 fractions for 2 labels"),
            (random(vec![0.7, 0.7]), "must sum to 1"),
            (random(vec![1.5, -0.5]), "must not be negative"),
        ] {
            let message = pattern.paint(&mut body).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
        assert_eq!(body.labels, vec![Label(5); 8]);
    }
}
