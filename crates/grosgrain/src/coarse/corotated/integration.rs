//! How the energy of an element is found from its fine cells.

use crate::element::{CellMatrix, Hex8};
use crate::fine::FineModel;
use crate::material::{Material, PointLaw};

/// How the elastic energy of an element depends on its displacement v in the rotated frame. All have the same stiffness at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integration {
    /// The material's law at the 2×2×2 Gauss points of every fine cell, as in the fine model.
    Gauss,
    /// The material's law at the centre of every fine cell, and ½ v·K v for what the centre does not see: K is the difference of the
    /// stiffnesses with eight points and with one.
    Centre,
    /// ½ v·K̄ v with the stiffness K̄ of the coarse model: the law does not matter, and all fine cells of the element rotate with it.
    #[default]
    Stiffness,
}

/// What the cells of one material share, for a factor of one.
#[derive(Clone, Debug)]
pub(super) struct SharedMaterial {
    pub law: PointLaw,
    /// Stiffness of a fine cell with eight points \[N/m\].
    pub stiffness: CellMatrix,
    /// The same less that with one point \[N/m\].
    pub unseen_by_centre: CellMatrix,
}

impl SharedMaterial {
    /// The materials of `model`, by index.
    pub fn all(model: &FineModel) -> Vec<Self> {
        let cell = Hex8::new(model.grid().spacing);
        let centre = cell.strain_matrix([0.5; 3]);
        let of_material = |material: &Material| {
            let tensor = material.elasticity.tensor();
            let stiffness = cell.stiffness(&tensor);
            let c = tensor.voigt();
            let one_point = |a: usize, b: usize| -> f64 {
                let sum: f64 = (0..36).map(|n| centre[n / 6][a] * c[n / 6][n % 6] * centre[n % 6][b]).sum();
                cell.volume() * sum
            };
            let mut unseen_by_centre = stiffness;
            for (a, b) in (0..24).flat_map(|a| (a..24).map(move |b| (a, b))) {
                unseen_by_centre[24 * a + b] -= one_point(a, b);
                unseen_by_centre[24 * b + a] = unseen_by_centre[24 * a + b];
            }
            Self { law: PointLaw::of(material, 1.0), stiffness, unseen_by_centre }
        };
        model.materials().iter().map(|(_, material)| of_material(material)).collect()
    }

    /// Whether the material keeps to small displacements.
    pub fn is_linear(&self) -> bool {
        matches!(self.law, PointLaw::Linear(_))
    }
}
