//! How the body is coarsened: `[coarsening]`.

use grosgrain::coarse::Integration;
use grosgrain::coarsening::{BaseKind, Objective};
use grosgrain::training::TrainingKind;

use super::document::{Item, Noted, Reading};
use super::mesh_body::{MESH_KEYS, MeshCoarsening, read_mesh_coarsening, refuse_mesh_keys};

/// Where training data come from, as the scene says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Training {
    /// A kind that the library trains.
    Kind(TrainingKind),
    /// The exact kind that is cheaper to renew after an edit.
    Auto,
}

/// The `[coarsening]` table of a voxel body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coarsening {
    /// Fine cells along an edge of a coarse cell.
    pub degree: usize,
    /// Where the training data come from.
    pub training: Training,
    /// Rings of substructured training whose error may be larger are trained exactly.
    pub data_tolerance: Option<f64>,
    /// The base of the shape functions.
    pub base: BaseKind,
    /// How the shape functions are found.
    pub objective: Objective,
    /// Whether coarse cells in several parts get an element for each.
    pub split: bool,
    /// How energies are integrated, where the scene says it.
    pub integration: Option<Integration>,
    /// Whether edits renew the shape functions.
    pub update: bool,
}

const KEYS: &[&str] = &[
    "degree",
    "training",
    "data_tolerance",
    "fields",
    "base",
    "objective",
    "split",
    "integration",
    "update",
    "mesh",
    "cells",
    "downsampling",
    "held",
    "map",
];

impl Default for Coarsening {
    fn default() -> Self {
        Self {
            degree: 1,
            training: Training::Kind(TrainingKind::OneRing),
            data_tolerance: None,
            base: BaseKind::Harmonic,
            objective: Objective::ClosedForm,
            split: true,
            integration: None,
            update: true,
        }
    }
}

impl Coarsening {
    /// The integration that the scene gives, or the one closest to the fine model.
    pub fn integration_or_default(&self) -> Integration {
        self.integration.unwrap_or(Integration::Gauss)
    }
}

/// Reads `[coarsening]` of a mesh.
pub fn read_coarsening_of_mesh(item: &Item) -> Reading<MeshCoarsening> {
    read_mesh_coarsening(item, KEYS)
}

/// Reads `[coarsening]` of a voxel body.
pub fn read_coarsening(item: &Item) -> Reading<Coarsening> {
    let section = item.section(KEYS)?;
    let misplaced = refuse_mesh_keys(&section, MESH_KEYS);
    let degree = section.required("degree", "an integer of at least 1", Item::count);
    let training = section.optional("training", read_training);
    let data_tolerance = section.optional("data_tolerance", Item::positive);
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
    let integrations =
        [("gauss", Integration::Gauss), ("centre", Integration::Centre), ("stiffness", Integration::Stiffness)];
    let integration = section.optional("integration", |i| i.choice(&integrations));
    let update = section.optional("update", Item::boolean);
    fields?;
    misplaced?;
    let default = Coarsening::default();
    let (training, data_tolerance) = (training?.unwrap_or(default.training), data_tolerance?);
    if data_tolerance.is_some() && training != Training::Kind(TrainingKind::Substructured) {
        let sentence = "coarsening.data_tolerance: only substructured training has a tolerance; expected training = \"substructured\", or no data_tolerance";
        return Err(section.note_at(&["data_tolerance"], sentence.into()));
    }
    Ok(Coarsening {
        degree: degree?,
        training,
        data_tolerance,
        base: base?.unwrap_or(default.base),
        objective: objective?.unwrap_or(default.objective),
        split: split?.unwrap_or(default.split),
        integration: integration?,
        update: update?.unwrap_or(default.update),
    })
}

fn read_training(item: &Item) -> Reading<Training> {
    let choices = [
        ("one-ring", Training::Kind(TrainingKind::OneRing)),
        ("global", Training::Kind(TrainingKind::Global)),
        ("single-cell", Training::Kind(TrainingKind::SingleCell)),
        ("substructured", Training::Kind(TrainingKind::Substructured)),
        ("auto", Training::Auto),
    ];
    item.choice(&choices)
}

fn not_yet(item: &Item, instead: &str) -> Noted {
    item.refuse_for_now(instead)
}
