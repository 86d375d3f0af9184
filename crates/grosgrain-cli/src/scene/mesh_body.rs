//! Scenes whose body is a mesh: its file, the mesh that it is coarsened to, and what of voxel bodies it cannot have.

use std::path::PathBuf;

use grosgrain::homogenization::{Blending, Downsampling};
use grosgrain::material::Law;
use grosgrain::update::LooseParts;

use super::Scene;
use super::body::{Body, Keep, Source};
use super::document::{Item, Reading};
use super::labels::Labelling;
use super::section::Section;

/// Keys of `[coarsening]` that belong to meshes.
pub const MESH_KEYS: &[&str] = &["mesh", "cells", "downsampling", "held", "map"];

/// A mesh file that is the body.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshSource {
    /// The file.
    pub file: PathBuf,
    /// What lengths in it, and in the file of the coarse mesh, are multiplied by.
    pub scale: f64,
}

/// The coarse mesh of a body that is a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CoarseMeshSource {
    /// A file.
    File(PathBuf),
    /// Those cells of a lattice of boxes that the body meets: about so many.
    Lattice(usize),
    /// A lattice with a hundredth of the body's cells.
    #[default]
    Default,
}

/// The `[coarsening]` table of a body that is a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshCoarsening {
    /// Where the coarse mesh comes from.
    pub mesh: CoarseMeshSource,
    /// How harmonic displacements are taken to the coarse mesh.
    pub downsampling: Downsampling,
    /// Whether harmonic displacements are held where the scene holds the body.
    pub held: bool,
    /// How harmonic displacements take part in the displacement of the fine mesh; `None` for the barycentric map without them.
    pub map: Option<Blending>,
}

/// Whether a scene's body is a mesh; other tables have other keys then.
pub fn is_mesh(root: &Section) -> bool {
    root.get("body").is_some_and(|body| body.child("mesh").is_some())
}

/// Reads `[body]` with `mesh`; `known` are the keys of any body.
pub fn read_mesh_body(section: &Section, known: &[&str]) -> Reading<Body> {
    let foreign = known.iter().filter(|key| !["mesh", "scale"].contains(key)).filter_map(|key| section.get(key));
    let refused: Vec<Reading<()>> = foreign.map(|item| refuse_voxel_key(&item, "leave it out, or body.mesh")).collect();
    let file = section.required("mesh", "a mesh file", Item::existing_path);
    let scale = section.optional("scale", Item::positive);
    refused.into_iter().collect::<Reading<()>>()?;
    Ok(Body {
        source: Source::Mesh(MeshSource { file: file?, scale: scale?.unwrap_or(1.0) }),
        spacing: None,
        resample: None,
        labelling: Labelling::Own { void: Vec::new() },
        modulus: None,
        keep: Keep::All,
        loose: LooseParts::Keep,
    })
}

/// Reads `[coarsening]` of a mesh; `known` are the keys that any body has there.
pub fn read_mesh_coarsening(item: &Item, known: &'static [&'static str]) -> Reading<MeshCoarsening> {
    let section = item.section(known)?;
    let foreign = known.iter().filter(|key| !MESH_KEYS.contains(key)).filter_map(|key| section.get(key));
    let refused: Vec<Reading<()>> = foreign.map(|item| refuse_voxel_key(&item, "expected mesh or cells")).collect();
    section
        .exclusive(&["mesh", "cells"], "the coarse mesh comes from a file, or from a lattice of about so many cells")?;
    let file = section.optional("mesh", Item::existing_path);
    let cells = section.optional("cells", Item::count);
    let choices = [("nodes", Downsampling::AtNodes), ("fitted", Downsampling::Fitted)];
    let downsampling = section.optional("downsampling", |how| how.choice(&choices));
    let held = section.optional("held", Item::boolean);
    let maps = [
        ("barycentric", None),
        ("harmonic", Some(Blending::PerCell)),
        ("harmonic-blended", Some(Blending::Continuous)),
    ];
    let map = section.optional("map", |map| map.choice(&maps));
    refused.into_iter().collect::<Reading<()>>()?;
    let mesh = match (file?, cells?) {
        (Some(file), _) => CoarseMeshSource::File(file),
        (None, Some(cells)) => CoarseMeshSource::Lattice(cells),
        (None, None) => CoarseMeshSource::Default,
    };
    Ok(MeshCoarsening {
        mesh,
        downsampling: downsampling?.unwrap_or_default(),
        held: held?.unwrap_or_default(),
        map: map?.flatten(),
    })
}

fn refuse_voxel_key(item: &Item, advice: &str) -> Reading<()> {
    Err(item.note(format!("{} is for voxels, but the body is a mesh; {advice}", item.key())))
}

/// Refuses keys of meshes where the body consists of voxels.
pub fn refuse_mesh_keys(section: &Section, names: &[&str]) -> Reading<()> {
    let given = names.iter().filter_map(|name| section.get(name));
    let refuse =
        |item: Item| Err(item.note(format!("{} is for a body that is a mesh; expected body.mesh", item.key())));
    given.map(refuse).collect::<Vec<_>>().into_iter().collect()
}

/// Notes what a scene asks for that a mesh cannot do.
pub fn check(root: &Section, scene: &Scene) -> Reading<()> {
    if !scene.is_mesh() {
        return Ok(());
    }
    let refuse = |bad: bool, names: &[&str], sentence: &str| match bad {
        true => Err(root.note_at(names, sentence.into())),
        false => Ok(()),
    };
    let edits = refuse(
        !scene.edits.is_empty(),
        &["edit"],
        "edit: cells of a mesh cannot be edited; leave the edits out, or take a body of voxels",
    );
    let volume = refuse(
        scene.output.volume,
        &["output", "volume"],
        "output.volume is true, but the body comes from no volume; expected false, or body.volume",
    );
    edits.and(volume).and(refuse_laws(root, scene))
}

fn refuse_laws(root: &Section, scene: &Scene) -> Reading<()> {
    let unfit = scene.materials.iter().filter(|material| material.law == Law::NeoHookean);
    let refuse = |name: &str| {
        let sentence = format!(
            "materials.{name}.model is \"neo-hookean\", but the body is a mesh; expected \"linear\" or \"corotational\""
        );
        Err(root.note_at(&["materials", name, "model"], sentence))
    };
    unfit.map(|material| refuse(&material.name)).collect::<Vec<_>>().into_iter().collect()
}

impl Scene {
    /// Whether the body is a mesh.
    pub fn is_mesh(&self) -> bool {
        matches!(self.body.source, Source::Mesh(_))
    }
}
