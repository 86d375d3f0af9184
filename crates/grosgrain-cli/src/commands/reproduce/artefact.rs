//! The tables and figures that can be reproduced, by name.

use std::ops::RangeInclusive;
use std::str::FromStr;

use super::bodies::Heterogeneity;
use super::moving::{self, FIG1, FIG4, FIG5};
use super::tensors::{cheese, composite, crack, homogeneous, layers, liver, springs};
use super::{Findings, Study, fig2, fig3, table1, table2, table3};
use crate::failure::Failure;
use crate::results;
use crate::scene::{enumeration, nearest};

/// A table or figure of `he2022fast` or `kharevych2009numerical`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Artefact {
    /// Errors of trainings.
    Table1,
    /// Times of training data.
    Table2,
    /// Times of fits.
    Table3,
    /// The beam whose stiff cells are erased.
    Fig1,
    /// The beams of Table 1.
    Fig2,
    /// Single cells, on which fits are compared.
    Fig3,
    /// The trunk from a CT that is cut.
    Fig4,
    /// The plate of active material that is twisted.
    Fig5,
    /// Springs in series replaced by one.
    Springs,
    /// A homogeneous body coarsened into its own material.
    Homogeneous,
    /// A cube of soft and stiff layers.
    Layers,
    /// A bar with a thin slice of soft material.
    Crack,
    /// A composite on a single triangle.
    Composite,
    /// A wheel of cheese with holes in one half falls.
    Cheese,
    /// A liver with its veins falls.
    Liver,
}

/// Why a name is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("nothing is published as {name:?}{hint}; expected {expected}")]
pub struct UnknownArtefact {
    name: String,
    hint: String,
    expected: String,
}

impl Artefact {
    const ALL: [Self; 15] = [
        Self::Table1,
        Self::Table2,
        Self::Table3,
        Self::Fig1,
        Self::Fig2,
        Self::Fig3,
        Self::Fig4,
        Self::Fig5,
        Self::Springs,
        Self::Homogeneous,
        Self::Layers,
        Self::Crack,
        Self::Composite,
        Self::Cheese,
        Self::Liver,
    ];

    /// How many at the end are of `kharevych2009numerical`.
    const OF_TENSORS: usize = 7;

    fn name(self) -> &'static str {
        match self {
            Self::Table1 => "table1",
            Self::Table2 => "table2",
            Self::Table3 => "table3",
            Self::Fig1 => FIG1.name,
            Self::Fig2 => "fig2",
            Self::Fig3 => "fig3",
            Self::Fig4 => FIG4.name,
            Self::Fig5 => FIG5.name,
            Self::Springs => springs::NAME,
            Self::Homogeneous => homogeneous::NAME,
            Self::Layers => layers::NAME,
            Self::Crack => crack::NAME,
            Self::Composite => composite::NAME,
            Self::Cheese => cheese::NAME,
            Self::Liver => liver::NAME,
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Table1 => "errors of training data: beams of three patterns, d = 2 to 7",
            Self::Table2 => "times of training data for one interior cell, d = 2 to 7",
            Self::Table3 => "times of shape functions for one cell, d = 2 to 5",
            Self::Fig1 => "a beam of layers in motion, stiff cells erased: with update, without, fine",
            Self::Fig2 => "pictures of the beams of Table 1",
            Self::Fig3 => "single cells of three patterns, d = 2 to 5: three fits compared, and pictures",
            Self::Fig4 => "a trunk from a CT in motion, cut by a blade: with update, without, fine",
            Self::Fig5 => "a plate of active material, twisted and softened: with update, without, fine",
            Self::Springs => "springs in series replaced by one, against the closed form",
            Self::Homogeneous => "a homogeneous body coarsened into its own material, in 1, 2 and 3 dimensions",
            Self::Layers => {
                "a cube of soft and stiff layers: harmonic displacements, at rest and in motion, tensors and averages against fine"
            }
            Self::Crack => {
                "a bar of triangles with a thin soft slice: at rest and in motion, tensors and averages against fine"
            }
            Self::Composite => {
                "fig. 6: a composite that hangs from its top, shown by a single triangle, by 4 and by 16"
            }
            Self::Cheese => "a wheel of cheese with holes in one half falls: fine and coarse, cost",
            Self::Liver => "a liver with its veins falls: fine and coarse, cost",
        }
    }

    fn has_scene(self) -> bool {
        matches!(self, Self::Fig1 | Self::Fig4 | Self::Fig5)
    }

    /// The published degrees; `None` for what has none or is described by a scene.
    fn published_degrees(self) -> Option<RangeInclusive<usize>> {
        match self {
            Self::Table1 | Self::Table2 | Self::Fig2 => Some(2..=7),
            Self::Table3 | Self::Fig3 => Some(2..=5),
            Self::Fig1 | Self::Fig4 | Self::Fig5 | Self::Springs | Self::Homogeneous => None,
            Self::Layers | Self::Crack | Self::Composite | Self::Cheese | Self::Liver => None,
        }
    }

    /// Runs it.
    pub fn run(self, study: &Study) -> Result<Findings, Failure> {
        match self {
            Self::Table1 => table1::run(study),
            Self::Table2 => table2::run(study),
            Self::Table3 => table3::run(study),
            Self::Fig1 => moving::run(study, &FIG1),
            Self::Fig2 => fig2::run(study),
            Self::Fig3 => fig3::run(study),
            Self::Fig4 => moving::run(study, &FIG4),
            Self::Fig5 => moving::run(study, &FIG5),
            Self::Springs => springs::run(study),
            Self::Homogeneous => homogeneous::run(study),
            Self::Layers => layers::run(study),
            Self::Crack => crack::run(study),
            Self::Composite => composite::run(study),
            Self::Cheese => cheese::run(study),
            Self::Liver => liver::run(study),
        }
    }

    /// The degrees asked for, ascending, or all published ones.
    pub fn degrees(self, asked: &[usize]) -> Result<Vec<usize>, Failure> {
        let Some(published) = self.published_degrees() else {
            return match asked {
                [] => Ok(Vec::new()),
                _ => Err(self.without("--degrees")),
            };
        };
        if let Some(degree) = asked.iter().find(|d| !published.contains(d)) {
            let (low, high) = (published.start(), published.end());
            let name = self.name();
            return Err(Failure::Unusable(format!("{name} has degrees {low} to {high}, not {degree}; see --list")));
        }
        let mut degrees = if asked.is_empty() { published.collect() } else { asked.to_vec() };
        degrees.sort_unstable();
        degrees.dedup();
        Ok(degrees)
    }

    fn without(self, option: &str) -> Failure {
        let why = if self.has_scene() { "is described by its scene" } else { "has nothing to choose" };
        Failure::Unusable(format!("{} {why}; leave {option} out", self.name()))
    }

    /// Whether it moves without a scene.
    fn falls(self) -> bool {
        matches!(self, Self::Cheese | Self::Liver)
    }

    /// Refuses a folder of meshes for what reads none.
    pub fn check_meshes(self, meshes: bool) -> Result<(), Failure> {
        match meshes && self != Self::Liver {
            true => Err(Failure::Unusable(format!(
                "{} reads no meshes; leave --meshes out, which is for liver",
                self.name()
            ))),
            false => Ok(()),
        }
    }

    /// Refuses options about scenes and steps for what has none.
    pub fn check_scene(self, steps: bool, scenes: bool) -> Result<(), Failure> {
        let steps = steps && !self.falls();
        let option = if steps { "--steps" } else { "--scenes" };
        if !self.has_scene() && (steps || scenes) {
            let sentence =
                format!("{} has no scene; leave {option} out, which is for fig1, fig4 and fig5", self.name());
            return Err(Failure::Unusable(sentence));
        }
        Ok(())
    }

    /// The patterns asked for, each once and in the paper's order, or all of them.
    pub fn patterns(self, asked: &[Heterogeneity]) -> Result<Vec<Heterogeneity>, Failure> {
        if self.published_degrees().is_none() && !asked.is_empty() {
            return Err(self.without("--patterns"));
        }
        if matches!(self, Self::Table2 | Self::Table3) && !asked.is_empty() {
            let name = self.name();
            return Err(Failure::Unusable(format!("{name} is measured on one body; leave --patterns out")));
        }
        let wanted = |pattern: &Heterogeneity| asked.is_empty() || asked.contains(pattern);
        Ok(Heterogeneity::ALL.into_iter().filter(wanted).collect())
    }
}

impl FromStr for Artefact {
    type Err = UnknownArtefact;

    fn from_str(name: &str) -> Result<Self, UnknownArtefact> {
        let known = Self::ALL.into_iter().find(|artefact| artefact.name() == name);
        known.ok_or_else(|| {
            let near = nearest(name, &Self::ALL.map(Self::name));
            let hint = near.map_or_else(String::new, |near| format!(" (did you mean {near:?}?)"));
            let expected = enumeration(&Self::ALL.map(|artefact| artefact.name().to_owned()));
            UnknownArtefact { name: name.into(), hint, expected }
        })
    }
}

/// What `--list` prints.
pub fn list() -> String {
    let rows = Artefact::ALL.map(|artefact| (artefact.name().to_owned(), artefact.title().to_owned()));
    let (fast, tensors) = rows.split_at(Artefact::ALL.len() - Artefact::OF_TENSORS);
    let patterns = enumeration(&Heterogeneity::ALL.map(|pattern| pattern.name().to_owned()));
    format!(
        "he2022fast (He, Pérez and Otaduy 2022), patterns {patterns}\n{}\nkharevych2009numerical (Kharevych, Mullen, Owhadi and Desbrun 2009)\n{}",
        results::table(fast),
        results::table(tensors)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_artefact_is_read_back_from_its_name_and_a_misspelt_one_gets_a_suggestion() {
        for artefact in Artefact::ALL {
            assert_eq!(artefact.name().parse(), Ok(artefact));
        }
        let message = "tabel1".parse::<Artefact>().unwrap_err().to_string();
        assert!(message.contains("did you mean \"table1\"?") && message.contains("fig5"), "{message}");
        assert!(!"zzz".parse::<Artefact>().unwrap_err().to_string().contains("did you mean"));
    }

    #[test]
    fn degrees_and_patterns_are_sorted_without_repetition_and_checked() {
        assert_eq!(Artefact::Table1.degrees(&[4, 2, 4]).unwrap(), [2, 4]);
        assert_eq!(Artefact::Table3.degrees(&[]).unwrap(), [2, 3, 4, 5]);
        assert!(Artefact::Fig3.degrees(&[6]).unwrap_err().to_string().contains("degrees 2 to 5, not 6"));
        let [oblique, horizontal, _] = Heterogeneity::ALL;
        assert_eq!(Artefact::Fig2.patterns(&[horizontal, oblique, oblique]).unwrap(), [oblique, horizontal]);
        assert!(Artefact::Table2.patterns(&[oblique]).is_err());
        assert!(Artefact::Fig1.degrees(&[4]).is_err() && Artefact::Fig5.patterns(&[oblique]).is_err());
        assert!(Artefact::Springs.degrees(&[2]).unwrap_err().to_string().contains("nothing to choose"));
        assert!(Artefact::Homogeneous.check_scene(true, false).is_err());
        assert!(Artefact::Fig4.check_scene(true, true).is_ok() && Artefact::Fig2.check_scene(true, false).is_err());
        assert!(Artefact::Liver.check_scene(true, false).is_ok() && Artefact::Cheese.check_scene(true, true).is_err());
        assert!(Artefact::Liver.check_meshes(true).is_ok() && Artefact::Cheese.check_meshes(true).is_err());
        assert_eq!(Artefact::Fig4.degrees(&[]).unwrap(), [0; 0]);
    }
}
