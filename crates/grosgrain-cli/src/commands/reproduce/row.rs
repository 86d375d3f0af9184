//! One figure, measured beside published.

use serde::Serialize;

use super::Study;
use crate::timing::Spread;

/// One figure: what it is of, what was published and what was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// The table or figure.
    pub name: &'static str,
    /// What is told: `error`, `time`, `difference`, …
    pub quantity: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Coarsening degree; null for a mean over all.
    pub degree: Option<usize>,
    /// Pattern of the body; null where there is only one, or for a mean over all.
    pub pattern: Option<&'static str>,
    /// What the training was initialised on; null where that is no question.
    pub setting: Option<&'static str>,
    /// The method, or the two that are compared.
    pub method: Option<&'static str>,
    /// The published figure; null where there is none.
    pub published: Option<f64>,
    /// The figure measured in this run; null where there is none.
    pub measured: Option<f64>,
    /// Fastest and slowest sample of a time.
    pub range: Option<[f64; 2]>,
    /// Published over measured; null where either is missing.
    pub published_over_measured: Option<f64>,
    /// Coarse cells updated between initialisation and measurement, or by an edit; null where that is no question.
    pub updated_cells: Option<usize>,
    /// What must be known to read the row.
    pub note: Option<String>,
    /// Processor and threads that it was measured on.
    pub machine: String,
}

/// Seconds to milliseconds.
const MILLI: f64 = 1e-3;

impl Row {
    /// A row without figures.
    pub fn new(study: &Study, name: &'static str, quantity: &'static str, unit: &'static str) -> Self {
        Self { name, quantity, unit, machine: study.machine.to_string(), ..Self::default() }
    }

    /// A time in milliseconds on one thread beside the published one, if either is known.
    pub fn time(study: &Study, name: &'static str, published: Option<f64>, measured: Option<Spread>) -> Self {
        let machine = format!("{}, 1 thread", study.machine.processor);
        let milliseconds = measured.map(|spread| spread.median / MILLI);
        Self {
            published,
            measured: milliseconds,
            range: measured.map(|spread| [spread.low / MILLI, spread.high / MILLI]),
            published_over_measured: published.zip(milliseconds).map(|(p, m)| p / m),
            machine,
            ..Self::new(study, name, "time", "ms")
        }
    }
}

/// The figure in a cell of a table, or a dash.
pub fn or_dash(value: Option<f64>, show: impl Fn(f64) -> String) -> String {
    value.map_or_else(|| "–".into(), show)
}

/// Three significant digits: `0.0512`, `12.3`, `28900`.
pub fn digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let power = value.abs().log10().floor() as i32;
    match power {
        -4..=2 => format!("{value:.decimals$}", decimals = (2 - power) as usize),
        3..=5 => format!("{value:.0}"),
        _ => format!("{value:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_shown_with_three_digits() {
        let shown = [0.0, 0.05123, 1.0, 12.34, 804.2, 28900.4, 3.2e-9].map(digits);
        assert_eq!(shown, ["0", "0.0512", "1.00", "12.3", "804", "28900", "3.2e-9"]);
        assert_eq!(or_dash(None, digits), "–");
    }
}
