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
}

const KEYS: &[&str] = &["degree", "training", "fields", "base", "objective"];

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
    fields?;
    Ok(Coarsening {
        degree: degree?,
        training: training?.unwrap_or(TrainingKind::OneRing),
        base: base?.unwrap_or(BaseKind::Harmonic),
        objective: objective?.unwrap_or(Objective::ClosedForm),
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

/// Reads `[time]`: only static runs exist in this version.
pub fn read_time(item: &Item) -> Reading<()> {
    let section = item.section(&["mode", "step", "steps", "integrator", "damping"])?;
    section.optional("mode", |mode| match mode.says("dynamic") {
        true => Err(not_yet(mode, "\"static\"")),
        false => mode.choice(&[("static", ())]),
    })?;
    let names = ["step", "steps", "integrator", "damping"];
    let notes: Vec<Reading<()>> =
        names.iter().map(|name| section.optional(name, belongs_to_dynamic).map(drop)).collect();
    notes.into_iter().collect()
}

fn belongs_to_dynamic(item: &Item) -> Reading<()> {
    Err(item.note(format!(
        "{} belongs to a dynamic run, which this version cannot do; leave it out for a static one",
        item.key()
    )))
}

fn not_yet(item: &Item, instead: &str) -> Noted {
    item.refuse_for_now(instead)
}
