//! What kind of run is made: `[time]`.

use grosgrain::dynamics::{Damping, Integrator};

use super::document::{Item, Reading};
use super::section::Section;

/// Smallest change of a residual that double precision can show; a tolerance below it is never met.
const SMALLEST_TOLERANCE: f64 = 1e-12;
/// More halvings leave nothing of a step.
const MOST_HALVINGS: i64 = 30;

/// What follows from what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Equilibria: one, or with edits one for each step.
    #[default]
    Static,
    /// Motion with inertia.
    Dynamic,
}

/// The `[time]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct Time {
    /// The kind of run.
    pub mode: Mode,
    /// Seconds per step; every dynamic run has them.
    pub step: Option<f64>,
    /// Number of steps after the beginning; every dynamic run has it.
    pub steps: Option<usize>,
    /// How a dynamic run steps.
    pub integrator: Integrator,
    /// How a dynamic run loses energy.
    pub damping: Damping,
    /// Residual of Newton's method, relative to the forces.
    pub tolerance: f64,
    /// How often a step or increment that fails is halved.
    pub halvings: usize,
    /// In how many increments a nonlinear static run puts the loads and motions on at first.
    pub increments: usize,
    /// The keys that the scene gives.
    pub given: Vec<&'static str>,
}

impl Default for Time {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            step: None,
            steps: None,
            integrator: Integrator::default(),
            damping: Damping::default(),
            tolerance: 1e-5,
            halvings: 8,
            increments: 1,
            given: Vec::new(),
        }
    }
}

const KEYS: &[&str] = &["mode", "step", "steps", "integrator", "damping", "tolerance", "halvings", "increments"];

/// Whether a scene's `[time]` asks for a dynamic run; other tables have other defaults then.
pub fn is_dynamic(root: &Section) -> bool {
    let mode = root.get("time").and_then(|time| time.child("mode"));
    mode.is_some_and(|mode| mode.says("dynamic"))
}

/// Reads `[time]`.
pub fn read_time(item: &Item) -> Reading<Time> {
    let section = item.section(KEYS)?;
    let default = Time::default();
    let mode = section.optional("mode", |m| m.choice(&[("static", Mode::Static), ("dynamic", Mode::Dynamic)]));
    let step = section.optional("step", Item::positive);
    let steps = section.optional("steps", Item::count);
    let integrators = [("implicit-euler", Integrator::ImplicitEuler), ("midpoint", Integrator::Midpoint)];
    let integrator = section.optional("integrator", |i| i.choice(&integrators));
    let damping = section.optional("damping", read_damping);
    let tolerance = section.optional("tolerance", |t| {
        let expected = format!("a number from {SMALLEST_TOLERANCE:e} on and below 1");
        t.number_where(&expected, |t| (SMALLEST_TOLERANCE..1.0).contains(&t))
    });
    let halvings = section.optional("halvings", |h| {
        let expected = format!("an integer from 0 to {MOST_HALVINGS}");
        h.integer_where(&expected, |h| (0..=MOST_HALVINGS).contains(&h)).map(|h| h as usize)
    });
    let increments = section.optional("increments", Item::count);
    let mode = mode?.unwrap_or_default();
    let complete = require_steps(&section, mode);
    let time = Time {
        mode,
        step: step?,
        steps: steps?,
        integrator: integrator?.unwrap_or_default(),
        damping: damping?.unwrap_or_default(),
        tolerance: tolerance?.unwrap_or(default.tolerance),
        halvings: halvings?.unwrap_or(default.halvings),
        increments: increments?.unwrap_or(default.increments),
        given: KEYS.iter().copied().filter(|key| section.has(key)).collect(),
    };
    complete.map(|()| time)
}

fn require_steps(section: &Section, mode: Mode) -> Reading<()> {
    if mode == Mode::Static {
        return Ok(());
    }
    let wanted = [("step", "the seconds per step of a dynamic run"), ("steps", "the number of steps of a dynamic run")];
    let missing = wanted.into_iter().filter(|(key, _)| !section.has(key));
    missing.map(|(key, expected)| Err(section.missing(key, expected))).collect::<Vec<_>>().into_iter().collect()
}

/// A number is a share of the mass.
fn read_damping(item: &Item) -> Reading<Damping> {
    if !item.is_table() {
        let expected = "a finite number that is not negative, or { mass = .., stiffness = .. }";
        return item.number_where(expected, |v| v >= 0.0).map(|mass| Damping { mass, stiffness: 0.0 });
    }
    let section = item.section(&["mass", "stiffness"])?;
    let mass = section.optional("mass", Item::non_negative);
    let stiffness = section.optional("stiffness", Item::non_negative);
    Ok(Damping { mass: mass?.unwrap_or_default(), stiffness: stiffness?.unwrap_or_default() })
}
