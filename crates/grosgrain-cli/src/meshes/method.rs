//! The ways to model a body that is a mesh, by name.

use std::fmt;

use grosgrain::homogenization::CoarseMaterials;

/// A way to model a body that is a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshMethod {
    /// The fine mesh itself.
    Fine,
    /// The coarse mesh with effective tensors (`kharevych2009numerical`).
    Tensor,
    /// The coarse mesh with the mean material coefficients of every cell.
    Average,
    /// The coarse mesh with the materials integrated over every cell, which is the mean of stiffness matrices.
    Stiffness,
    /// The coarse mesh with the materials at the quadrature points of its cells.
    Sampled,
}

impl MeshMethod {
    /// All of them, as `compare` lists them.
    pub const ALL: [Self; 5] = [Self::Fine, Self::Tensor, Self::Average, Self::Stiffness, Self::Sampled];

    /// The name in scenes, tables and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Tensor => "tensor",
            Self::Average => "average",
            Self::Stiffness => "trilinear",
            Self::Sampled => "sampled",
        }
    }

    /// What pictures call it.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Fine => "fine mesh",
            Self::Tensor => "effective tensors",
            Self::Average => "mean coefficients",
            Self::Stiffness => "mean stiffness",
            Self::Sampled => "sampled materials",
        }
    }

    /// The method of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }

    /// What the coarse cells are made of; `None` for the fine mesh.
    pub const fn coarse_materials(self) -> Option<CoarseMaterials> {
        match self {
            Self::Fine => None,
            Self::Tensor => Some(CoarseMaterials::Effective),
            Self::Average => Some(CoarseMaterials::MeanCoefficients),
            Self::Stiffness => Some(CoarseMaterials::MeanStiffness),
            Self::Sampled => Some(CoarseMaterials::Sampled),
        }
    }
}

impl fmt::Display for MeshMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
