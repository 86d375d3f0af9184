//! Figs. 1 and 7 of KMOD09 (`kharevych2009numerical`): bodies that fall on the ground, in a fine mesh and in coarse ones.

pub mod cheese;
mod course;
mod films;
pub mod liver;
mod moduli;
mod pair;
mod stills;
mod text;

/// The models, the reference first, then the coarse ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Model {
    /// The fine mesh.
    Fine,
    /// Effective tensors.
    Tensor,
    /// Mean of the coefficients of materials.
    Average,
    /// Mean of stiffness matrices.
    Stiffness,
}

impl Model {
    const ALL: [Self; 4] = [Self::Fine, Self::Tensor, Self::Average, Self::Stiffness];
    const COARSE: [Self; 3] = [Self::Tensor, Self::Average, Self::Stiffness];

    const fn name(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Tensor => "tensor",
            Self::Average => "average",
            Self::Stiffness => "trilinear",
        }
    }

    const fn label(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Tensor => "effective tensors",
            Self::Average => "mean coefficients",
            Self::Stiffness => "mean stiffness",
        }
    }
}
