//! What the labels of a body stand for.

use std::collections::BTreeMap;

use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Label, VoxelGrid};

use super::unusable;
use crate::failure::Failure;
use crate::quantities::counted;
use crate::scene::{Constants, Scene, SceneMaterial, VoxelModulus, enumeration};

/// Labels without material that are told one by one.
const TOLD_LABELS: usize = 5;

/// The name of the material that a modulus law makes.
const LAW_NAME: &str = "modulus law";

/// Young's modulus \[Pa\] of a table entry whose modulus is given voxel by voxel; never used in a computation.
const PLACEHOLDER_YOUNG: f64 = 1.0;

/// Whether the material of `label` gives all its constants itself.
pub fn has_own_constants(scene: &Scene, label: Label) -> bool {
    scene.materials.iter().any(|m| m.label == label && m.own_elasticity().is_some())
}

fn law_poisson(scene: &Scene) -> Option<f64> {
    match scene.body.modulus {
        Some(VoxelModulus::Law { poisson, .. }) => Some(poisson),
        _ => None,
    }
}

/// Refuses solid voxels whose label has no material.
pub fn require_materials(scene: &Scene, grid: &VoxelGrid) -> Result<(), Failure> {
    if law_poisson(scene).is_some() {
        return Ok(());
    }
    let missing: Vec<String> = solid_counts(grid)
        .into_iter()
        .filter(|(label, _)| scene.materials.iter().all(|m| m.label != *label))
        .map(|(label, voxels)| format!("label {label} ({})", counted(voxels, "voxel")))
        .collect();
    match missing.first() {
        None => Ok(()),
        Some(_) => Err(unusable(
            scene,
            "materials",
            format!(
                "the body has {} without a material; expected a table [materials.NAME] with that label, \
                 or the label in body.void",
                abridged(missing)
            ),
        )),
    }
}

/// `a and b`; of a long list the first ones and how many more there are.
fn abridged(mut names: Vec<String>) -> String {
    let more = names.len().saturating_sub(TOLD_LABELS);
    if more > 1 {
        names.truncate(TOLD_LABELS);
        names.push(format!("{more} more labels"));
    }
    enumeration(&names)
}

/// How many solid voxels each label has.
pub fn solid_counts(grid: &VoxelGrid) -> BTreeMap<Label, usize> {
    let mut counts = BTreeMap::new();
    let solid = grid.labels.iter().zip(&grid.void).filter(|(_, void)| !**void);
    solid.for_each(|(label, _)| *counts.entry(*label).or_default() += 1);
    counts
}

/// Where moduli or densities are given voxel by voxel, fills in those of materials that bring their own.
pub fn fill_fields(scene: &Scene, grid: &mut VoxelGrid) {
    let by_label: BTreeMap<Label, &SceneMaterial> = scene.materials.iter().map(|m| (m.label, m)).collect();
    if let Some(young) = &mut grid.young {
        for (value, label) in young.iter_mut().zip(&grid.labels) {
            if let Some(Elasticity::Isotropic(own)) = by_label.get(label).and_then(|m| m.own_elasticity()) {
                *value = own.young();
            }
        }
    }
    if let Some(density) = &mut grid.density {
        for (value, label) in density.iter_mut().zip(&grid.labels) {
            *value = by_label.get(label).and_then(|m| m.density).unwrap_or(*value);
        }
    }
}

/// The table of the scene's materials; under a modulus law the other labels of `grid` get the law's Poisson ratio.
pub fn table(scene: &Scene, grid: &VoxelGrid) -> Result<MaterialTable, Failure> {
    let mut table = MaterialTable::new();
    for material in &scene.materials {
        let elasticity = match &material.constants {
            Constants::Given(elasticity) => **elasticity,
            Constants::YoungPerVoxel { poisson } => placeholder(scene, *poisson)?,
        };
        let density = material.density.unwrap_or(0.0);
        table.insert(material.label, Material { name: material.name.clone(), elasticity, density, law: material.law });
    }
    let Some(poisson) = law_poisson(scene) else { return Ok(table) };
    let elasticity = placeholder(scene, poisson)?;
    for label in solid_counts(grid).into_keys() {
        if table.get(label).is_none() {
            table.insert(label, Material::linear(LAW_NAME, elasticity, 0.0));
        }
    }
    Ok(table)
}

fn placeholder(scene: &Scene, poisson: f64) -> Result<Elasticity, Failure> {
    let material = IsotropicMaterial::new(PLACEHOLDER_YOUNG, poisson);
    material.map(Elasticity::Isotropic).map_err(|error| unusable(scene, "body.modulus.poisson", error))
}
