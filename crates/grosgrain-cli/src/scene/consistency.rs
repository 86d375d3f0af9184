//! Checks between the tables of a scene.

use std::collections::BTreeSet;

use grosgrain::material::Elasticity;
use grosgrain::mesh::{Label, Pattern};

use super::body::{Keep, Source, VoxelModulus};
use super::conditions::LoadKind;
use super::document::Reading;
use super::edits;
use super::labels::Labelling;
use super::materials::Constants;
use super::pattern::Filling;
use super::section::{Section, enumeration};
use super::{Scene, SceneMaterial, mesh_body, run_kind};

/// Notes what does not fit together.
pub fn check(root: &Section, scene: &Scene) -> Reading<()> {
    let checks = [
        refuse_missing_materials(root, scene),
        refuse_missing_density(root, scene),
        refuse_idle_keys(root, scene),
        edits::check(root, scene),
        run_kind::check(root, scene),
        mesh_body::check(root, scene),
    ];
    checks.into_iter().collect()
}

/// The labels of the body's solid voxels, where the scene alone tells them.
fn solid_labels(scene: &Scene) -> Option<BTreeSet<Label>> {
    match (&scene.body.labelling, &scene.body.source) {
        (Labelling::Rules(rules), _) => Some(rules.iter().filter(|r| !r.void).map(|r| r.label).collect()),
        (Labelling::One, _) => Some([Label(0)].into()),
        (Labelling::Own { void }, Source::Grid(_, Filling::Pattern(pattern))) => {
            Some(pattern_labels(pattern).iter().copied().filter(|l| !void.contains(l)).collect())
        }
        _ => None,
    }
}

fn pattern_labels(pattern: &Pattern) -> &[Label] {
    match pattern {
        Pattern::Layers { labels, .. } | Pattern::Checkerboard { labels, .. } | Pattern::Random { labels, .. } => {
            labels
        }
        Pattern::Spheres { labels, .. } | Pattern::Grid { labels, .. } => labels,
    }
}

fn has_law(scene: &Scene) -> bool {
    matches!(scene.body.modulus, Some(VoxelModulus::Law { .. }))
}

fn refuse_missing_materials(root: &Section, scene: &Scene) -> Reading<()> {
    let Some(labels) = solid_labels(scene).filter(|_| !has_law(scene)) else { return Ok(()) };
    let lacks = |label: &Label| scene.materials.iter().all(|m| m.label != *label);
    let missing: Vec<String> = labels.into_iter().filter(lacks).map(|label| label.to_string()).collect();
    let noun = if missing.len() == 1 { "label" } else { "labels" };
    match missing.is_empty() {
        true => Ok(()),
        false => Err(root.note_at(
            if root.get("body").is_some_and(|body| body.child("pattern").is_some()) {
                &["body", "pattern", "labels"]
            } else {
                &["body", "labels"]
            },
            format!(
                "the body has {noun} {} without a material; expected a table [materials.NAME] with label = {}",
                enumeration(&missing),
                missing[0]
            ),
        )),
    }
}

/// Gravity and inertia need densities; so does a law that gives some voxels one, since then every voxel must have one.
fn refuse_missing_density(root: &Section, scene: &Scene) -> Reading<()> {
    let gravity = scene.loads.iter().find(|load| matches!(load.kind, LoadKind::Gravity(_)));
    let reason = match gravity {
        Some(gravity) => format!("{} is gravity", gravity.key),
        None if scene.is_dynamic() => "the run is dynamic".into(),
        None if has_law(scene) => "body.modulus gives other voxels a density".into(),
        None => return Ok(()),
    };
    let from_law = |m: &SceneMaterial| has_law(scene) && matches!(m.constants, Constants::YoungPerVoxel { .. });
    let missing = |m: &SceneMaterial| {
        let sentence = format!("materials.{}.density is missing, but {reason}; expected the density in kg/m³", m.name);
        Err(root.note_at(&["materials", &m.name], sentence))
    };
    let weightless = |m: &SceneMaterial| {
        let sentence = "is zero, but the run is dynamic; expected a positive density in kg/m³";
        Err(root.note_at(&["materials", &m.name, "density"], format!("materials.{}.density {sentence}", m.name)))
    };
    let checks = scene.materials.iter().map(|m| match m.density {
        None if !from_law(m) => missing(m),
        Some(0.0) if scene.is_dynamic() => weightless(m),
        _ => Ok(()),
    });
    checks.collect::<Vec<_>>().into_iter().collect()
}

fn refuse_idle_keys(root: &Section, scene: &Scene) -> Reading<()> {
    let refuse = |bad: bool, names: &[&str], sentence: &str| match bad {
        true => Err(root.note_at(names, sentence.into())),
        false => Ok(()),
    };
    let file = matches!(scene.body.modulus, Some(VoxelModulus::File(_)));
    let per_voxel = |m: &SceneMaterial| matches!(m.constants, Constants::YoungPerVoxel { .. });
    let from_file = file || matches!(scene.body.source, Source::Moduli(_));
    let young = refuse(
        from_file && !scene.materials.is_empty() && !scene.materials.iter().any(per_voxel),
        &["body", "young"],
        "body.young is never used, because every material gives its own constants; \
         expected a material without young, or no body.young",
    );
    let volume = refuse(
        scene.output.volume && matches!(scene.body.source, Source::Grid(..)),
        &["output", "volume"],
        "output.volume is true, but the body comes from no volume; expected false, or body.volume",
    );
    let keep = refuse(
        scene.body.keep == Keep::Supported && scene.fixes.is_empty(),
        &["body", "keep"],
        "body.keep is \"supported\", but nothing is held; expected at least one table [[fix]]",
    );
    young.and(volume).and(keep).and(refuse_mixed_stiffness(root, scene))
}

/// A modulus per voxel scales an isotropic material only.
fn refuse_mixed_stiffness(root: &Section, scene: &Scene) -> Reading<()> {
    if scene.body.modulus.is_none() {
        return Ok(());
    }
    let is_mixed = |m: &&SceneMaterial| m.own_elasticity().is_some_and(|e| matches!(e, Elasticity::Anisotropic(_)));
    let refuse = |m: &SceneMaterial| {
        let sentence = "is given in a body with a Young modulus per voxel; expected young and poisson";
        Err(root.note_at(&["materials", &m.name, "stiffness"], format!("materials.{}.stiffness {sentence}", m.name)))
    };
    scene.materials.iter().filter(is_mixed).map(refuse).collect::<Vec<_>>().into_iter().collect()
}

/// What the user should know although the scene is usable.
pub fn warnings(scene: &Scene) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(labels) = solid_labels(scene) {
        let used_later = |name: &String| scene.edits.iter().any(|e| e.sets(name));
        let idle = scene.materials.iter().filter(|m| !labels.contains(&m.label) && !used_later(&m.name));
        warnings.extend(idle.map(|m| {
            format!("materials.{} is never used: no solid part of the body has its label {}", m.name, m.label)
        }));
    }
    warnings.extend(run_kind::warnings(scene));
    warnings.extend(late_edits(scene));
    warnings
}

/// Edits that come too late.
fn late_edits(scene: &Scene) -> Vec<String> {
    let time = &scene.time;
    let mut warnings = Vec::new();
    for edit in &scene.edits {
        let end = time.steps.filter(|steps| scene.is_dynamic() && edit.step(0, time.step) == Some(*steps));
        warnings.extend(end.map(|steps| {
            format!("{} is due at step {steps}, when the run ends: nothing moves after it, so it is not made", edit.key)
        }));
        let cut_off = time.steps.zip(edit.last_step(time.step)).filter(|(steps, last)| last > steps);
        let told = edit.repeat.is_some_and(|r| r.times.is_some() || r.until.is_some());
        if let Some((steps, last)) = cut_off.filter(|_| told) {
            warnings.push(format!("{} repeats up to step {last}, but the run ends at step {steps}", edit.key));
        }
    }
    warnings
}
