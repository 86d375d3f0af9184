//! From a path to a mesh, and back.

use super::format::KNOWN;
use super::{MeshFile, MeshFormat, MeshReadError, MeshWriteError, medit, tetgen};
use super::{abaqus, gmsh};
use crate::io::{vtk, write_atomically};
use crate::simplex::SimplexMesh;
use std::path::{Path, PathBuf};

/// Reads a mesh file; what it is, is seen from its first word, else from its name.
///
/// Gmsh 2.0 to 2.2 and 4.1 (`.msh`), Medit (`.mesh`), TetGen and Triangle (`.node` or `.ele`, the other file beside it), VTK (`.vtu`, `.vtk`), Abaqus (`.inp`).
///
/// # Errors
/// [`MeshReadError::InFile`] with the path and the reason.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<MeshFile, MeshReadError> {
    let path = path.as_ref();
    read_any(path).map_err(|e| e.in_file(path))
}

fn read_any(path: &Path) -> Result<MeshFile, MeshReadError> {
    if MeshFormat::of_name(path) == Some(MeshFormat::TetGen) {
        let [nodes, elements] = tetgen_files(path);
        let read = tetgen::read_nodes(&read_file(&nodes)?).map_err(|e| e.in_file(&nodes))?;
        let read = tetgen::read_elements(read, &read_file(&elements)?).map_err(|e| e.in_file(&elements))?;
        return read.into_file();
    }
    let bytes = read_file(path)?;
    match MeshFormat::of_content(&bytes).or_else(|| MeshFormat::of_name(path)) {
        Some(MeshFormat::Gmsh) => gmsh::read_gmsh(&bytes),
        Some(MeshFormat::Medit) => medit::read_medit(&bytes),
        Some(MeshFormat::Vtu) => vtk::read_vtu(&bytes),
        Some(MeshFormat::VtkLegacy) => vtk::read_vtk_legacy(&bytes),
        Some(MeshFormat::Abaqus) => abaqus::read_abaqus(&bytes),
        Some(MeshFormat::TetGen) | None => Err(MeshReadError::UnknownFormat { known: KNOWN }),
    }
}

/// The files of nodes and of elements that belong together, in the letters of the one that is given.
fn tetgen_files(path: &Path) -> [PathBuf; 2] {
    let is_upper = path.extension().is_some_and(|e| e.to_string_lossy().chars().all(char::is_uppercase));
    ["node", "ele"].map(|e| path.with_extension(if is_upper { e.to_ascii_uppercase() } else { e.to_owned() }))
}

fn read_file(path: &Path) -> Result<Vec<u8>, MeshReadError> {
    let read = || match std::fs::metadata(path)?.is_file() {
        true => Ok(std::fs::read(path)?),
        false => Err(MeshReadError::UnknownFormat { known: KNOWN }),
    };
    read().map_err(|e: MeshReadError| e.in_file(path))
}

/// Writes a mesh in the format that the name stands for, Gmsh 4.1 text (`.msh`), Medit text (`.mesh`), VTU (`.vtu`) or Abaqus (`.inp`); whatever was there is replaced at the end, at once.
///
/// `names` are names of tags; Medit and VTU have none.
///
/// # Errors
/// [`MeshWriteError::InFile`] with the path and the reason.
pub fn write_mesh(path: impl AsRef<Path>, mesh: &SimplexMesh, names: &[(i32, String)]) -> Result<(), MeshWriteError> {
    let path = path.as_ref();
    let is_binary = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("meshb"));
    let written = match MeshFormat::of_name(path) {
        Some(MeshFormat::Gmsh) => write_atomically(path, |out| gmsh::write_gmsh(out, mesh, names)),
        Some(MeshFormat::Medit) if !is_binary => write_atomically(path, |out| medit::write_medit(out, mesh)),
        Some(MeshFormat::Vtu) => write_atomically(path, |out| {
            vtk::write_simplex_vtu(out, &vtk::SimplexGrid::new(mesh)).map_err(MeshWriteError::from)
        }),
        Some(MeshFormat::Abaqus) => write_atomically(path, |out| {
            abaqus::write_abaqus(out, &abaqus::AbaqusDeck { mesh, names, materials: None })
                .map_err(MeshWriteError::from)
        }),
        _ => Err(MeshWriteError::UnknownFormat),
    };
    written.map_err(|reason| MeshWriteError::InFile { path: path.to_path_buf(), reason: Box::new(reason) })
}
