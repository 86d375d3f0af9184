//! Meshes and their materials, read and checked.

use std::path::Path;

use grosgrain::homogenization::SimplexModel;
use grosgrain::io::mesh::read_mesh;
use grosgrain::material::{Material, MaterialTable};
use grosgrain::simplex::{BoxCut, Severity, SimplexLattice, SimplexMesh, check_mesh};

use crate::progress::Progress;
use crate::quantities::count;
use crate::scene::SceneMaterial;

/// Cells of a lattice around a body that are filled to a smaller share are left out.
pub const LEAST_FILLED: f64 = 0.1;
/// Any body may have a coarse mesh of so many cells, however few it has itself.
const FEW_CELLS: usize = 5;

/// A mesh, and the names that its file gives to tags.
pub type NamedMesh = (SimplexMesh, Vec<(i32, String)>);

/// Reads a mesh, all lengths times `scale`, and tells what is odd about it; what cannot be computed with is refused.
///
/// # Errors
/// The sentence, with the file's name.
pub fn read_checked(file: &Path, scale: f64, progress: &Progress) -> Result<NamedMesh, String> {
    let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
    let contents = read_mesh(file).map_err(|error| error.to_string())?;
    for sentence in &contents.skipped {
        progress.say(&format!("{}: {sentence}", file.display()));
    }
    let names = contents.names.clone();
    let mesh = contents.scaled(scale).into_mesh().map_err(|error| failed(&error))?;
    for finding in check_mesh(&mesh) {
        match finding.severity() {
            Severity::Warning => progress.warn(&format!("{}: {finding}", file.display())),
            Severity::Error => return Err(failed(&finding)),
        }
    }
    Ok((mesh, names))
}

/// A coarse mesh for a body that has none: a lattice of about so many cells around it.
///
/// # Errors
/// The sentence, where that is more cells than the body has, or no lattice.
pub fn lattice_around(fine: &SimplexMesh, cells: usize) -> Result<SimplexMesh, String> {
    let most = fine.cell_count().max(FEW_CELLS);
    if cells > most {
        return Err(format!(
            "{} coarse cells are more than the {} of the body; expected fewer",
            count(cells),
            count(fine.cell_count())
        ));
    }
    SimplexLattice::mesh_of_about(cells, fine, BoxCut::Alternating, LEAST_FILLED).map_err(|error| error.to_string())
}

/// The materials by tag; those that give no density have none. Tensors are those of small strains, whatever law the material has beyond.
pub fn material_table(materials: &[SceneMaterial]) -> MaterialTable {
    let mut table = MaterialTable::new();
    for material in materials {
        let Some(elasticity) = material.own_elasticity() else { continue };
        let density = material.density.unwrap_or(0.0);
        table.insert(material.label, Material::linear(material.name.clone(), *elasticity, density));
    }
    table
}

/// Warns of materials that no cell has: often a slip in a label.
pub fn tell_unused(table: &MaterialTable, model: &SimplexModel, names: &[(i32, String)], progress: &Progress) {
    for (label, material) in table.iter().filter(|(label, _)| !model.mesh().tags().contains(&label.0)) {
        let named: Vec<String> = names.iter().map(|(tag, name)| format!("{tag} is {name}")).collect();
        let hint = if named.is_empty() { String::new() } else { format!(" (in the file {})", named.join(", ")) };
        progress.warn(&format!("materials.{} has label {label}, which no cell has{hint}", material.name));
    }
}
