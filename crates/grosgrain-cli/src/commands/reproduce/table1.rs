//! Table 1: the error of coarse beams by training, pattern and degree.

use super::bodies::Heterogeneity;
use super::row::{Row, digits};
use super::setting::Setting;
use super::table1_error::{Case, Trainer, error};
use super::{Findings, Study, pictures, table1_text};
use crate::failure::Failure;
use crate::interruption;

const NAME: &str = "table1";
/// Why no row has a published figure.
const LOST: &str = "the numbers of Table 1 are lost in the text that this was written from";

/// An error in percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    pub pattern: Heterogeneity,
    pub degree: usize,
    pub setting: Setting,
    pub trainer: Trainer,
    pub percent: f64,
}

/// Runs every case.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let mut entries = Vec::new();
    let mut rows = Vec::new();
    for (degree, pattern) in study.degrees.iter().flat_map(|d| study.patterns.iter().map(|p| (*d, *p))) {
        let case_entries = case(study, pattern, degree)?;
        let grid = pattern.beam(degree)?;
        for entry in &case_entries {
            let updated = entry.setting.changed_cells(&grid, degree)?.len();
            rows.push(error_row(study, entry, updated));
        }
        entries.extend(case_entries);
    }
    rows.extend(summary_rows(study, &entries));
    let written = match &study.folder {
        Some(folder) => pictures::error_charts(&entries, &study.patterns, folder)?,
        None => Vec::new(),
    };
    Ok(Findings { rows, text: table1_text::text(study, &entries), written, ..Findings::default() })
}

/// All errors of one beam: one fine solution, one coarse model per training, and one more per setting where that matters.
fn case(study: &Study, pattern: Heterogeneity, degree: usize) -> Result<Vec<Entry>, Failure> {
    let name = format!("{}, d = {degree}", pattern.name());
    interruption::check()?;
    study.progress.say(&format!("{name}: fine model"));
    let case = Case::solve(pattern, degree, study.progress)?;
    let mut entries: Vec<Entry> = Vec::new();
    for setting in Setting::ALL {
        for trainer in Trainer::ALL {
            interruption::check()?;
            let known = entries.iter().find(|e| e.trainer == trainer && !trainer.has_history());
            let percent = match known {
                Some(entry) => entry.percent,
                None => error(&case, setting, trainer, study.progress)?,
            };
            if known.is_none() {
                study.progress.say(&format!("{name}: {}, {}: {} %", trainer.name(), setting.name(), digits(percent)));
            }
            entries.push(Entry { pattern, degree, setting, trainer, percent });
        }
    }
    Ok(entries)
}

fn error_row(study: &Study, entry: &Entry, updated: usize) -> Row {
    let history = match entry.trainer.has_history() {
        true => "",
        false => "; the training has no history, so all settings are the same run",
    };
    Row {
        degree: Some(entry.degree),
        pattern: Some(entry.pattern.name()),
        setting: Some(entry.setting.name()),
        method: Some(entry.trainer.name()),
        measured: Some(entry.percent),
        updated_cells: Some(updated),
        note: Some(format!("{LOST}{history}")),
        ..Row::new(study, NAME, "error", "%")
    }
}

/// Mean errors and their ratios to the one-ring's: per degree, then over all cases.
fn summary_rows(study: &Study, entries: &[Entry]) -> Vec<Row> {
    let degrees = study.degrees.iter().map(|d| Some(*d)).chain([None]);
    let all = degrees.flat_map(|d| Setting::ALL.map(|s| (d, s)));
    let row = |(degree, setting): (Option<usize>, Setting), trainer: Trainer| {
        let base = |quantity, unit, measured| Row {
            degree,
            setting: Some(setting.name()),
            method: Some(trainer.name()),
            measured,
            note: Some(LOST.into()),
            ..Row::new(study, NAME, quantity, unit)
        };
        let (mean, ratio) = (mean(entries, degree, setting, trainer), ratio(entries, degree, setting, trainer));
        [base("mean error", "%", mean), base("mean error over one-ring", "1", ratio)]
    };
    all.flat_map(|key| Trainer::ALL.into_iter().flat_map(move |trainer| row(key, trainer))).collect()
}

/// Mean error over the patterns of a degree, or over all cases; `None` if there is none.
pub fn mean(entries: &[Entry], degree: Option<usize>, setting: Setting, trainer: Trainer) -> Option<f64> {
    let matches = |e: &&Entry| e.setting == setting && e.trainer == trainer && degree.is_none_or(|d| e.degree == d);
    let found: Vec<f64> = entries.iter().filter(matches).map(|e| e.percent).collect();
    (!found.is_empty()).then(|| found.iter().sum::<f64>() / found.len() as f64)
}

/// The same mean over that of the one-ring.
pub fn ratio(entries: &[Entry], degree: Option<usize>, setting: Setting, trainer: Trainer) -> Option<f64> {
    Some(mean(entries, degree, setting, trainer)? / mean(entries, degree, setting, Trainer::REFERENCE)?)
}
