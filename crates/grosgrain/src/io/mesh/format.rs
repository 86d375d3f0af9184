//! Which format a mesh file has.

use std::fmt;
use std::path::Path;

/// A mesh format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MeshFormat {
    /// Gmsh: `.msh`.
    Gmsh,
    /// Medit: `.mesh`.
    Medit,
    /// TetGen or Triangle: `.node` with `.ele`.
    TetGen,
    /// VTK's XML format: `.vtu`.
    Vtu,
    /// VTK's legacy format: `.vtk`.
    VtkLegacy,
    /// Abaqus and CalculiX: `.inp`.
    Abaqus,
}

/// The formats that are read, with their endings, for errors.
pub(super) const KNOWN: &str = "Gmsh (.msh), Medit (.mesh), TetGen (.node with .ele), VTK (.vtu, .vtk), Abaqus (.inp)";

impl MeshFormat {
    /// The format that a file's extension stands for; `None` if for none.
    pub fn of_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_ascii_lowercase();
        match extension.as_str() {
            "msh" => Some(Self::Gmsh),
            "mesh" | "meshb" => Some(Self::Medit),
            "node" | "ele" => Some(Self::TetGen),
            "vtu" => Some(Self::Vtu),
            "vtk" => Some(Self::VtkLegacy),
            "inp" => Some(Self::Abaqus),
            _ => None,
        }
    }

    /// The format that a file's content shows by its first word; `None` if none of the known ones stands there.
    pub fn of_content(bytes: &[u8]) -> Option<Self> {
        let start = bytes.trim_ascii_start();
        let marks: [(&[u8], Self); 6] = [
            (b"$MeshFormat", Self::Gmsh),
            (b"$NOD", Self::Gmsh),
            (b"MeshVersionFormatted", Self::Medit),
            (b"MFEM", Self::Medit),
            (b"<VTKFile", Self::Vtu),
            (b"# vtk DataFile", Self::VtkLegacy),
        ];
        marks.iter().find(|(mark, _)| start.starts_with(mark)).map(|(_, format)| *format)
    }
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gmsh => "Gmsh",
            Self::Medit => "Medit",
            Self::TetGen => "TetGen",
            Self::Vtu => "VTU",
            Self::VtkLegacy => "legacy VTK",
            Self::Abaqus => "Abaqus",
        })
    }
}
