//! What kind of run is made: `[time]`.

use super::document::{Item, Reading};

/// The `[time]` table. A static run has one equilibrium, or with edits one for each step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Time {
    /// Seconds per step.
    pub step: Option<f64>,
    /// Number of steps after the first equilibrium.
    pub steps: Option<usize>,
    /// The keys given that no static run uses.
    pub unused: Vec<String>,
}

/// Reads `[time]`: only static runs exist in this version.
pub fn read_time(item: &Item) -> Reading<Time> {
    let section = item.section(&["mode", "step", "steps", "integrator", "damping"])?;
    let mode = section.optional("mode", |mode| match mode.says("dynamic") {
        true => Err(mode.refuse_for_now("\"static\"")),
        false => mode.choice(&[("static", ())]),
    });
    let step = section.optional("step", Item::positive);
    let steps = section.optional("steps", Item::count);
    let integrators = [("implicit-euler", ()), ("midpoint", ())];
    let unused = [
        section.optional("integrator", |i| i.choice(&integrators).map(|()| i.key().to_owned())),
        section.optional("damping", |d| d.non_negative().map(|_| d.key().to_owned())),
    ];
    mode?;
    let unused: Reading<Vec<Option<String>>> = unused.into_iter().collect();
    Ok(Time { step: step?, steps: steps?, unused: unused?.into_iter().flatten().collect() })
}
