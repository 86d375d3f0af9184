//! From the values of a volume to labels and voids.

use super::{Cell, Label, Lattice, Volume, VoxelGrid};

/// Which values get a label. Rules are tried in order, the first that matches decides.
///
/// With neither `below` nor `values` a rule catches all that is left.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelRule {
    /// The label given.
    pub label: Label,
    /// Catches values smaller than this.
    pub below: Option<f64>,
    /// Catches these values.
    pub values: Option<Vec<i32>>,
    /// The voxels caught are void.
    pub void: bool,
}

/// Why a volume cannot be labelled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LabellingError {
    /// The volume holds fewer or more values than voxels.
    #[error("the volume holds {found} values for {cells:?} voxels")]
    Length {
        /// Number of values.
        found: usize,
        /// Voxels along x, y, z.
        cells: [usize; 3],
    },
    /// A rule has both conditions.
    #[error("label rule {0} has both `below` and `values`; give one of them, or two rules")]
    TwoConditions(usize),
    /// A rule's threshold is not a number.
    #[error("label rule {0} has `below` = NaN; it must be a number")]
    Threshold(usize),
    /// A rule catches nothing because earlier rules catch it all.
    #[error("label rule {rule} can never catch {what}: an earlier rule does; reorder the rules or remove it")]
    Unreachable {
        /// The rule, counted from 1.
        rule: usize,
        /// What it would have caught.
        what: String,
    },
    /// A voxel's value is NaN or infinite.
    #[error("voxel ({}, {}, {}) is {value}; every value must be finite", at[0], at[1], at[2])]
    NotFinite {
        /// The voxel.
        at: [usize; 3],
        /// Its value.
        value: f64,
    },
    /// No rule catches a voxel's value.
    #[error(
        "no label rule catches voxel ({}, {}, {}) with value {value}; add a last rule without a condition",
        at[0], at[1], at[2]
    )]
    Uncaught {
        /// The voxel.
        at: [usize; 3],
        /// Its value.
        value: f64,
    },
    /// The volume's own values were to be labels but are no integers.
    #[error(
        "voxel ({}, {}, {}) is {value}, which is no 32-bit integer and so no label; give label rules with thresholds",
        at[0], at[1], at[2]
    )]
    NotIntegral {
        /// The voxel.
        at: [usize; 3],
        /// Its value.
        value: f64,
    },
}

impl LabelRule {
    fn catches(&self, value: f64) -> bool {
        self.below.is_none_or(|below| value < below)
            && self.values.as_ref().is_none_or(|values| values.iter().any(|v| f64::from(*v) == value))
    }
}

/// The body whose labels `rules` give to the values of the volume; `spacing` is the edge lengths of a voxel \[m\].
///
/// # Errors
/// Rules that contradict each other or can never match; a voxel that is not finite or that no rule catches.
pub fn label_by_rules(volume: &Volume, rules: &[LabelRule], spacing: [f64; 3]) -> Result<VoxelGrid, LabellingError> {
    check_rules(rules)?;
    label_each(volume, spacing, |value, at| {
        let rule = rules.iter().find(|rule| rule.catches(value));
        rule.map(|rule| (rule.label, rule.void)).ok_or(LabellingError::Uncaught { at, value })
    })
}

/// The body whose labels are the volume's own integers; voxels with one of the labels in `void` are void.
///
/// # Errors
/// A voxel that is not finite or no 32-bit integer.
pub fn label_by_integers(volume: &Volume, void: &[Label], spacing: [f64; 3]) -> Result<VoxelGrid, LabellingError> {
    label_each(volume, spacing, |value, at| {
        let label = Label(value as i32);
        if f64::from(label.0) != value {
            return Err(LabellingError::NotIntegral { at, value });
        }
        Ok((label, void.contains(&label)))
    })
}

fn label_each(
    volume: &Volume,
    spacing: [f64; 3],
    decide: impl Fn(f64, [usize; 3]) -> Result<(Label, bool), LabellingError>,
) -> Result<VoxelGrid, LabellingError> {
    let lattice = Lattice::new(volume.cells);
    if volume.values.len() != lattice.cell_count() {
        return Err(LabellingError::Length { found: volume.values.len(), cells: volume.cells });
    }
    let decided: Result<Vec<_>, _> = (volume.values.iter().enumerate())
        .map(|(c, &value)| {
            let at = lattice.cell_position(Cell(c));
            if value.is_finite() { decide(value, at) } else { Err(LabellingError::NotFinite { at, value }) }
        })
        .collect();
    let (labels, void) = decided?.into_iter().unzip();
    Ok(VoxelGrid { lattice, spacing, origin: [0.0; 3], labels, void, young: None, density: None })
}

/// Refuses rules with two conditions and rules that earlier ones leave nothing to.
fn check_rules(rules: &[LabelRule]) -> Result<(), LabellingError> {
    let mut caught_below = f64::NEG_INFINITY;
    let mut caught_values: Vec<i32> = Vec::new();
    for (rule, n) in rules.iter().zip(1..) {
        let unreachable = |what: String| Err(LabellingError::Unreachable { rule: n, what });
        match (rule.below, &rule.values) {
            (Some(_), Some(_)) => return Err(LabellingError::TwoConditions(n)),
            (Some(below), None) if below.is_nan() => return Err(LabellingError::Threshold(n)),
            (Some(below), None) if below <= caught_below => return unreachable(format!("values below {below}")),
            (Some(below), None) => caught_below = below,
            (None, Some(values)) => {
                let gone = |v: &&i32| f64::from(**v) < caught_below || caught_values.contains(v);
                if let Some(value) = values.iter().find(gone) {
                    return unreachable(format!("the value {value}"));
                }
                caught_values.extend(values);
            }
            (None, None) if caught_below == f64::INFINITY => return unreachable("any value".into()),
            (None, None) => caught_below = f64::INFINITY,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(values: &[f64]) -> Volume {
        let values = values.to_vec();
        Volume { cells: [values.len(), 1, 1], spacing: None, voxel_to_world: None, values, integral: false }
    }

    fn rule(label: i32, below: Option<f64>, values: Option<Vec<i32>>, void: bool) -> LabelRule {
        LabelRule { label: Label(label), below, values, void }
    }

    #[test]
    fn the_first_rule_that_matches_decides() {
        let rules = [
            rule(0, Some(-300.0), None, true),
            rule(7, None, Some(vec![5, -2]), false),
            rule(1, Some(150.0), None, false),
            rule(2, None, None, false),
        ];
        let values = [-1000.0, -300.0, 5.0, -2.0, 5.5, 150.0, 1e9];
        let grid = label_by_rules(&volume(&values), &rules, [1.0, 2.0, 3.0]).unwrap();
        assert_eq!(grid.labels.iter().map(|l| l.0).collect::<Vec<_>>(), [0, 1, 7, 7, 1, 2, 2]);
        assert_eq!(grid.void, [true, false, false, false, false, false, false]);
        assert_eq!((grid.spacing, grid.origin), ([1.0, 2.0, 3.0], [0.0; 3]));
    }

    #[test]
    fn a_value_that_no_rule_catches_is_named_with_its_voxel() {
        let error = label_by_rules(&volume(&[1.0, 3.0]), &[rule(0, Some(2.0), None, false)], [1.0; 3]).unwrap_err();
        assert_eq!(error, LabellingError::Uncaught { at: [1, 0, 0], value: 3.0 });
        assert!(error.to_string().contains("voxel (1, 0, 0) with value 3"), "{error}");
    }

    #[test]
    fn voxels_that_are_not_finite_are_refused_even_by_a_rule_that_catches_the_rest() {
        for value in [f64::NAN, f64::INFINITY] {
            let error = label_by_rules(&volume(&[0.0, value]), &[rule(0, None, None, false)], [1.0; 3]).unwrap_err();
            assert!(matches!(error, LabellingError::NotFinite { at: [1, 0, 0], .. }), "{error}");
        }
    }

    #[test]
    fn rules_that_can_never_match_are_refused() {
        let low = rule(0, Some(0.0), None, false);
        let rest = rule(1, None, None, false);
        for (rules, part) in [
            (vec![rest.clone(), low.clone()], "rule 2 can never catch values below 0"),
            (vec![rest.clone(), rest.clone()], "rule 2 can never catch any value"),
            (vec![low.clone(), low.clone()], "rule 2 can never catch values below 0"),
            (vec![low.clone(), rule(2, None, Some(vec![3, -1]), false)], "the value -1"),
            (vec![rule(2, None, Some(vec![3]), false), rule(3, None, Some(vec![3]), false)], "the value 3"),
            (vec![rule(2, Some(1.0), Some(vec![3]), false)], "rule 1 has both"),
            (vec![rule(2, Some(f64::NAN), None, false)], "NaN"),
        ] {
            let message = label_by_rules(&volume(&[1.0]), &rules, [1.0; 3]).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn integers_are_labels_and_fractions_are_refused() {
        let grid = label_by_integers(&volume(&[3.0, -4.0, 0.0]), &[Label(0), Label(9)], [1.0; 3]).unwrap();
        assert_eq!(grid.labels, [Label(3), Label(-4), Label(0)]);
        assert_eq!(grid.void, [false, false, true]);
        for bad in [0.5, 3e9] {
            let error = label_by_integers(&volume(&[1.0, bad]), &[], [1.0; 3]).unwrap_err();
            assert_eq!(error, LabellingError::NotIntegral { at: [1, 0, 0], value: bad });
        }
    }

    #[test]
    fn a_volume_of_the_wrong_length_is_refused() {
        let mut short = volume(&[1.0, 2.0]);
        short.cells = [3, 1, 1];
        let error = label_by_integers(&short, &[], [1.0; 3]).unwrap_err();
        assert_eq!(error, LabellingError::Length { found: 2, cells: [3, 1, 1] });
    }
}
