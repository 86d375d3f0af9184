//! How the body is coarsened, and what kind of run is made: `[coarsening]` and `[time]`.

use grosgrain::coarsening::{BaseKind, Objective};
use grosgrain::training::TrainingKind;

use super::document::{Item, Noted, Reading};

/// The `[coarsening]` table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coarsening {
    /// Fine cells along an edge of a coarse cell.
    pub degree: usize,
    /// Where the training data come from.
    pub training: TrainingKind,
    /// The base of the shape functions.
    pub base: BaseKind,
    /// How the shape functions are found.
    pub objective: Objective,
    /// Whether coarse cells in several parts get an element for each.
    pub split: bool,
}

const KEYS: &[&str] = &["degree", "training", "fields", "base", "objective", "split"];

/// Reads `[coarsening]`.
pub fn read_coarsening(item: &Item) -> Reading<Coarsening> {
    let section = item.section(KEYS)?;
    let degree = section.required("degree", "an integer of at least 1", Item::count);
    let training = section.optional("training", read_training);
    let fields = section.optional("fields", |fields| match fields.count()? {
        6 => Ok(()),
        _ => Err(not_yet(fields, "6")),
    });
    let bases =
        [("harmonic", BaseKind::Harmonic), ("trilinear", BaseKind::Trilinear), ("material", BaseKind::Material)];
    let base = section.optional("base", |base| base.choice(&bases));
    let objectives = [("closed-form", Objective::ClosedForm), ("coupled", Objective::Coupled)];
    let objective = section.optional("objective", |objective| objective.choice(&objectives));
    let split = section.optional("split", Item::boolean);
    fields?;
    Ok(Coarsening {
        degree: degree?,
        training: training?.unwrap_or(TrainingKind::OneRing),
        base: base?.unwrap_or(BaseKind::Harmonic),
        objective: objective?.unwrap_or(Objective::ClosedForm),
        split: split?.unwrap_or(true),
    })
}

fn read_training(item: &Item) -> Reading<TrainingKind> {
    if item.says("substructured") || item.says("auto") {
        return Err(not_yet(item, "\"one-ring\", \"global\" or \"single-cell\""));
    }
    let choices = [
        ("one-ring", TrainingKind::OneRing),
        ("global", TrainingKind::Global),
        ("single-cell", TrainingKind::SingleCell),
    ];
    item.choice(&choices)
}

/// Reads `[time]`: only static runs exist in this version. Returns a warning for each key that has no effect in one.
pub fn read_time(item: &Item) -> Reading<Vec<String>> {
    let section = item.section(&["mode", "step", "steps", "integrator", "damping"])?;
    let mode = section.optional("mode", |mode| match mode.says("dynamic") {
        true => Err(not_yet(mode, "\"static\"")),
        false => mode.choice(&[("static", ())]),
    });
    let integrators = [("implicit-euler", ()), ("midpoint", ())];
    let unused = [
        section.optional("step", |step| step.positive().map(|_| without_effect(step))),
        section.optional("steps", |steps| steps.count().map(|_| without_effect(steps))),
        section.optional("integrator", |i| i.choice(&integrators).map(|()| without_effect(i))),
        section
            .optional("damping", |d| d.number_where("a number of at least 0", |v| v >= 0.0).map(|_| without_effect(d))),
    ];
    mode?;
    let warnings: Reading<Vec<Option<String>>> = unused.into_iter().collect();
    Ok(warnings?.into_iter().flatten().collect())
}

fn without_effect(item: &Item) -> String {
    format!("{} has no effect in a static run", item.key())
}

fn not_yet(item: &Item, instead: &str) -> Noted {
    item.refuse_for_now(instead)
}
