//! Which material a label stands for.

use std::collections::BTreeMap;

use super::{ElasticityTensor, IsotropicMaterial, Law};
use crate::mesh::Label;

/// The elastic part of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a table holds a handful of materials, and copies keep them simple")]
pub enum Elasticity {
    /// Two constants.
    Isotropic(IsotropicMaterial),
    /// Twenty-one constants.
    Anisotropic(ElasticityTensor),
}

impl Elasticity {
    /// The elasticity tensor \[Pa\].
    pub fn tensor(&self) -> ElasticityTensor {
        match self {
            Self::Isotropic(material) => material.tensor(),
            Self::Anisotropic(tensor) => *tensor,
        }
    }
}

/// A named material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name under which the scene lists it.
    pub name: String,
    /// Its elasticity.
    pub elasticity: Elasticity,
    /// Density \[kg/m³\].
    pub density: f64,
    /// How it goes on under large deformation.
    pub law: Law,
}

impl Material {
    /// A material for small displacements.
    pub fn linear(name: impl Into<String>, elasticity: Elasticity, density: f64) -> Self {
        Self { name: name.into(), elasticity, density, law: Law::Linear }
    }
}

/// Label → material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialTable {
    entries: BTreeMap<Label, Material>,
}

impl MaterialTable {
    /// An empty table.
    pub fn new() -> Self {
        Self::default()
    }

    /// Assigns `material` to `label`; returns what the label stood for before.
    pub fn insert(&mut self, label: Label, material: Material) -> Option<Material> {
        self.entries.insert(label, material)
    }

    /// The material of `label`.
    pub fn get(&self, label: Label) -> Option<&Material> {
        self.entries.get(&label)
    }

    /// Labels and materials in ascending order of the label.
    pub fn iter(&self) -> impl Iterator<Item = (Label, &Material)> {
        self.entries.iter().map(|(label, material)| (*label, material))
    }
}
