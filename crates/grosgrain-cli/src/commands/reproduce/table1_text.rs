//! Table 1 as people read it.

use super::Study;
use super::row::{digits, or_dash};
use super::setting::Setting;
use super::table1::{Entry, mean, ratio};
use super::table1_error::Trainer;
use crate::results;

const COLUMNS: usize = 1 + Trainer::ALL.len();

const HEADING: &str = "Table 1 of he2022fast: RMS error of coarse beams in percent of the fine solution
16 × 4 × 4 coarse cells held at x = 0 under gravity, layers of d/2 fine cells (rounded up), ratio of moduli 50, Poisson's ratio 0.45
published: the table's numbers are lost in the text that this was written from, so no column stands beside these. The text says:
  global is only marginally better than one-ring, both are accurate; substructured is slightly worse than one-ring;
  single-cell suffers large errors";

/// A block per setting.
pub fn text(study: &Study, entries: &[Entry]) -> String {
    let mut parts = vec![HEADING.to_owned()];
    for setting in Setting::ALL {
        parts.push(format!("{}:\n{}", capitalised(setting.sentence()), block(study, entries, setting)));
    }
    parts.push(format!("machine: {}", study.machine));
    parts.join("\n")
}

fn block(study: &Study, entries: &[Entry], setting: Setting) -> String {
    let mut lines = vec![row("case", Trainer::ALL.map(|trainer| trainer.name().to_owned()))];
    for &degree in &study.degrees {
        for pattern in &study.patterns {
            let percent = |trainer| {
                let is_it =
                    |e: &&Entry| (e.pattern, e.degree, e.setting, e.trainer) == (*pattern, degree, setting, trainer);
                or_dash(entries.iter().find(is_it).map(|e| e.percent), digits)
            };
            lines.push(row(&format!("{}, d = {degree}", pattern.name()), Trainer::ALL.map(percent)));
        }
        lines.extend(summary(entries, Some(degree), setting));
    }
    lines.extend(summary(entries, None, setting));
    results::columns(&lines)
}

fn summary(entries: &[Entry], degree: Option<usize>, setting: Setting) -> [[String; COLUMNS]; 2] {
    let of = degree.map_or_else(|| "all cases".to_owned(), |d| format!("d = {d}"));
    let means = Trainer::ALL.map(|trainer| or_dash(mean(entries, degree, setting, trainer), digits));
    let ratios = Trainer::ALL
        .map(|trainer| or_dash(ratio(entries, degree, setting, trainer), |ratio| format!("× {}", digits(ratio))));
    [row(&format!("mean of {of}"), means), row("  over one-ring", ratios)]
}

fn row(name: &str, cells: [String; Trainer::ALL.len()]) -> [String; COLUMNS] {
    let mut line: [String; COLUMNS] = Default::default();
    line[0] = name.to_owned();
    line[1..].clone_from_slice(&cells);
    line
}

fn capitalised(sentence: &str) -> String {
    let mut letters = sentence.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
