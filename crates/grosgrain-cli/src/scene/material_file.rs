//! Files that hold materials only: the `[materials.*]` tables of a scene.

use std::path::Path;

use super::materials::{SceneMaterial, read_materials};
use super::problem::SceneError;
use super::section::Section;
use super::{KEYS, read_document};

/// Reads the materials in `file`. What else a scene may hold is accepted and not read, so that a scene serves too.
///
/// # Errors
/// A file that cannot be read; every problem of one that can, each with its key, its line and what is expected.
pub fn read_material_file(file: &Path) -> Result<Vec<SceneMaterial>, SceneError> {
    read_document(file, |document, table| {
        let root = Section::new(document, String::new(), 0..0, table.get_ref()).limited_to(KEYS);
        root.required("materials", "one table [materials.NAME] for each tag of the mesh", |item| {
            read_materials(item, false)
        })
    })
}
