//! What an elastic material does under large deformation.

/// The law that continues linear elasticity to large deformation. All agree for small displacement gradients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Law {
    /// Linear elasticity for small displacements: stresses follow the symmetric displacement gradient.
    #[default]
    Linear,
    /// Linear elasticity in a frame that rotates with the material point.
    Corotational,
    /// Compressible neo-Hookean.
    NeoHookean,
}

impl std::fmt::Display for Law {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Linear => "linear",
            Self::Corotational => "corotational",
            Self::NeoHookean => "neo-Hookean",
        })
    }
}
