//! Checks between the tables of a scene.

use std::collections::BTreeSet;

use grosgrain::mesh::Label;

use super::body::{Source, VoxelModulus};
use super::conditions::LoadKind;
use super::document::Reading;
use super::labels::Labelling;
use super::materials::{Constants, MaterialModel};
use super::pattern::Pattern;
use super::section::{Section, enumeration};
use super::{Problem, Scene, SceneError, SceneMaterial};

/// Notes what does not fit together.
pub fn check(root: &Section, scene: &Scene) -> Reading<()> {
    let checks =
        [refuse_missing_materials(root, scene), refuse_missing_density(root, scene), refuse_idle_keys(root, scene)];
    checks.into_iter().collect()
}

/// The labels of the body's solid voxels, where the scene alone tells them.
fn solid_labels(scene: &Scene) -> Option<BTreeSet<Label>> {
    match (&scene.body.labelling, &scene.body.source) {
        (Labelling::Rules(rules), _) => Some(rules.iter().filter(|r| !r.void).map(|r| r.label).collect()),
        (Labelling::Own { .. }, Source::Volume(_)) => None,
        (Labelling::Own { .. }, Source::Moduli(_)) => Some([Label(0)].into()),
        (Labelling::Own { void }, Source::Pattern(_, pattern)) => {
            let labels = match pattern {
                Pattern::Layers { labels, .. }
                | Pattern::Checkerboard { labels, .. }
                | Pattern::Random { labels, .. } => labels.as_slice(),
                Pattern::Spheres { labels, .. } => labels.as_slice(),
                Pattern::FromFile(_) => return None,
            };
            Some(labels.iter().copied().filter(|l| !void.contains(l)).collect())
        }
    }
}

fn has_law(scene: &Scene) -> bool {
    matches!(scene.body.modulus, Some(VoxelModulus::Law(_)))
}

fn refuse_missing_materials(root: &Section, scene: &Scene) -> Reading<()> {
    let Some(labels) = solid_labels(scene).filter(|_| !has_law(scene)) else { return Ok(()) };
    let lacks = |label: &Label| scene.materials.iter().all(|m| m.label != *label);
    let missing: Vec<String> = labels.into_iter().filter(lacks).map(|label| label.to_string()).collect();
    let noun = if missing.len() == 1 { "label" } else { "labels" };
    match missing.is_empty() {
        true => Ok(()),
        false => Err(root.note_at(
            &["body", "labels"],
            format!(
                "the body has {noun} {} without a material; expected a table [materials.NAME] with label = {}",
                enumeration(&missing),
                missing[0]
            ),
        )),
    }
}

fn refuse_missing_density(root: &Section, scene: &Scene) -> Reading<()> {
    let gravity = scene.loads.iter().find(|load| matches!(load.kind, LoadKind::Gravity(_)));
    let Some(gravity) = gravity else { return Ok(()) };
    let from_law = |m: &SceneMaterial| has_law(scene) && matches!(m.constants, Constants::YoungPerVoxel { .. });
    let lacking: Vec<&SceneMaterial> = scene.materials.iter().filter(|m| m.density.is_none() && !from_law(m)).collect();
    let notes = lacking.iter().map(|m| {
        Err(root.note_at(
            &["materials", &m.name],
            format!(
                "materials.{}.density is missing, but {} is gravity; expected the density in kg/m³",
                m.name, gravity.key
            ),
        ))
    });
    notes.collect::<Vec<Reading<()>>>().into_iter().collect()
}

fn refuse_idle_keys(root: &Section, scene: &Scene) -> Reading<()> {
    let per_voxel = |m: &SceneMaterial| matches!(m.constants, Constants::YoungPerVoxel { .. });
    let needs_material =
        matches!(scene.body.modulus, Some(VoxelModulus::File(_))) || matches!(scene.body.source, Source::Moduli(_));
    let idle_young = needs_material && !scene.materials.is_empty() && !scene.materials.iter().any(per_voxel);
    let young = match idle_young {
        true => Err(root.note_at(
            &["body", "young"],
            "body.young is never used, because every material gives its own young; \
             expected a material without young, or no body.young"
                .into(),
        )),
        false => Ok(()),
    };
    let volume = match (scene.output.volume, &scene.body.source) {
        (true, Source::Pattern(..)) => Err(root.note_at(
            &["output", "volume"],
            "output.volume is true, but the body comes from no volume; expected false, or body.volume".into(),
        )),
        _ => Ok(()),
    };
    young.and(volume)
}

/// What the user should know although the scene is usable.
pub fn warnings(scene: &Scene) -> Vec<String> {
    let nonlinear = scene.materials.iter().filter(|m| m.model != MaterialModel::Linear);
    let mut warnings: Vec<String> = nonlinear
        .map(|m| {
            let name = match m.model {
                MaterialModel::NeoHookean => "neo-hookean",
                _ => "corotational",
            };
            format!("materials.{}.model {name:?} is treated as linear for small displacements in this version", m.name)
        })
        .collect();
    if let Some(labels) = solid_labels(scene) {
        let idle = scene.materials.iter().filter(|m| !labels.contains(&m.label));
        warnings.extend(idle.map(|m| {
            format!("materials.{} is never used: no solid part of the body has its label {}", m.name, m.label)
        }));
    }
    warnings
}

impl Scene {
    /// Refuses a static run of a body that nothing holds or nothing loads.
    ///
    /// # Errors
    /// No `[[fix]]`; no `[[load]]`.
    pub fn require_conditions(&self) -> Result<(), SceneError> {
        let mut sentences = Vec::new();
        if self.fixes.is_empty() {
            sentences.push("the body hangs on nothing; expected at least one table [[fix]]");
        }
        if self.loads.is_empty() {
            sentences.push("nothing loads the body, so it would not move; expected at least one table [[load]]");
        }
        let problem = |sentence: &str| Problem { line: 0, sentence: sentence.into() };
        match sentences.is_empty() {
            true => Ok(()),
            false => Err(SceneError::Unusable {
                file: self.file.clone(),
                problems: sentences.into_iter().map(problem).collect(),
            }),
        }
    }
}
