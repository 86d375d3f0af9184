//! The voxels of a body, from files or patterns.

use std::path::Path;

use grosgrain::io::read_volume;
use grosgrain::mesh::{Label, ModulusLaw, Volume, VoxelGrid, label_by_integers, label_by_rules};

use super::unusable;
use crate::failure::Failure;
use crate::quantities::triple_count;
use crate::scene::{Filling, Grid, Labelling, Scene, Source, VoxelModulus};

/// The labelled grid of `scene`, with moduli and densities per voxel where the scene asks for them, and the volume
/// that it comes from.
pub fn read_grid(scene: &Scene) -> Result<(VoxelGrid, Option<Volume>), Failure> {
    let (mut grid, volume) = match &scene.body.source {
        Source::Volume(path) => {
            let volume = read(scene, "body.volume", path)?;
            (label(scene, &volume, spacing(scene, path, &volume)?)?, Some(volume))
        }
        Source::Moduli(path) => {
            let volume = read(scene, "body.young", path)?;
            (moduli(scene, path, &volume)?, Some(volume))
        }
        Source::Grid(grid, filling) => (fill(scene, grid, filling)?, None),
        Source::Mesh(_) => {
            let sentence = "the body is a mesh where voxels are needed; expected body.volume, or grid with pattern";
            return Err(unusable(scene, "body.mesh", sentence));
        }
    };
    match &scene.body.modulus {
        None => {}
        Some(VoxelModulus::File(path)) => {
            let volume = read(scene, "body.young", path)?;
            require_same_size(scene, "body.young", path, volume.cells, grid.lattice.cells)?;
            apply_law(scene, "body.young", &ModulusLaw::Direct, None, &volume, &mut grid)?;
        }
        Some(VoxelModulus::Law { law, floor, .. }) => {
            if let Some(volume) = &volume {
                apply_law(scene, "body.modulus", law, *floor, volume, &mut grid)?;
            }
        }
    }
    Ok((grid, volume))
}

fn read(scene: &Scene, key: &str, path: &Path) -> Result<Volume, Failure> {
    read_volume(path).map_err(|error| unusable(scene, key, error))
}

fn spacing(scene: &Scene, path: &Path, volume: &Volume) -> Result<[f64; 3], Failure> {
    let expected = "carries no voxel size; expected three positive numbers in metres per voxel";
    let missing = || unusable(scene, "body.spacing", format!("{} {expected}", path.display()));
    scene.body.spacing.or(volume.spacing).ok_or_else(missing)
}

fn label(scene: &Scene, volume: &Volume, spacing: [f64; 3]) -> Result<VoxelGrid, Failure> {
    let labelled = match &scene.body.labelling {
        Labelling::Rules(rules) => label_by_rules(volume, rules, spacing),
        Labelling::Own { void } => label_by_integers(volume, void, spacing),
        Labelling::One => return Ok(VoxelGrid::uniform(volume.cells, spacing, Label(0))),
    };
    labelled.map_err(|error| unusable(scene, "body.labels", error))
}

fn moduli(scene: &Scene, path: &Path, volume: &Volume) -> Result<VoxelGrid, Failure> {
    let spacing = spacing(scene, path, volume)?;
    let field = ModulusLaw::Direct.apply(volume, None).map_err(|error| unusable(scene, "body.young", error))?;
    Ok(field.into_grid(spacing, Label(0)))
}

fn fill(scene: &Scene, grid: &Grid, filling: &Filling) -> Result<VoxelGrid, Failure> {
    let spacing = std::array::from_fn(|a| grid.size[a] / grid.cells[a] as f64);
    let mut filled = VoxelGrid::uniform(grid.cells, spacing, Label(0));
    match filling {
        Filling::Pattern(pattern) => {
            pattern.paint(&mut filled).map_err(|error| unusable(scene, "body.pattern", error))?;
        }
        Filling::File(path) => {
            let volume = read(scene, "body.pattern.file", path)?;
            require_same_size(scene, "body.pattern.file", path, volume.cells, grid.cells)?;
            filled = label_by_integers(&volume, &[], spacing)
                .map_err(|error| unusable(scene, "body.pattern.file", error))?;
        }
    }
    if let Labelling::Own { void } = &scene.body.labelling {
        filled.void = filled.labels.iter().map(|label| void.contains(label)).collect();
    }
    Ok(filled)
}

fn require_same_size(
    scene: &Scene,
    key: &str,
    path: &Path,
    found: [usize; 3],
    expected: [usize; 3],
) -> Result<(), Failure> {
    let sentence = || {
        let (found, expected) = (triple_count(found), triple_count(expected));
        format!("{} has {found} voxels; expected {expected}, the body's", path.display())
    };
    if found == expected { Ok(()) } else { Err(unusable(scene, key, sentence())) }
}

/// Gives every voxel its modulus and density; solid voxels that take them are void where the modulus is zero.
///
/// Voxels whose material has constants of its own stay solid: `fill_fields` overwrites what the law made of them.
fn apply_law(
    scene: &Scene,
    key: &str,
    law: &ModulusLaw,
    floor: Option<f64>,
    volume: &Volume,
    grid: &mut VoxelGrid,
) -> Result<(), Failure> {
    let field = law.apply(volume, floor).map_err(|error| unusable(scene, key, error))?;
    let gives_own = |label: Label| super::materials::has_own_constants(scene, label);
    for (cell, void) in grid.void.iter_mut().enumerate() {
        *void |= field.void[cell] && !gives_own(grid.labels[cell]);
    }
    grid.young = Some(field.young);
    grid.density = field.density;
    Ok(())
}
