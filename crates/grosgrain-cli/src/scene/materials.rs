//! The `[materials.*]` tables.

use grosgrain::material::{Elasticity, ElasticityTensor, IsotropicMaterial, Law};
use grosgrain::mesh::Label;

use super::document::{Item, Reading};
use super::section::Section;
use super::selector::read_label;

/// The elastic constants that a material gives.
#[derive(Clone, Debug, PartialEq)]
pub enum Constants {
    /// All constants.
    Given(Box<Elasticity>),
    /// Poisson's ratio; Young's modulus comes from the body, voxel by voxel.
    YoungPerVoxel {
        /// Poisson's ratio.
        poisson: f64,
    },
}

/// A material of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMaterial {
    /// The name of its table.
    pub name: String,
    /// The label that it belongs to.
    pub label: Label,
    /// Its law.
    pub law: Law,
    /// Its elastic constants.
    pub constants: Constants,
    /// Density \[kg/m³\]; `None` where the scene gives none.
    pub density: Option<f64>,
}

impl SceneMaterial {
    /// Its elasticity, if the material gives all constants itself.
    pub fn own_elasticity(&self) -> Option<&Elasticity> {
        match &self.constants {
            Constants::Given(elasticity) => Some(elasticity),
            Constants::YoungPerVoxel { .. } => None,
        }
    }
}

const KEYS: &[&str] = &["label", "model", "young", "poisson", "stiffness", "density"];
const POISSON: &str = "a number between -1 and 0.5, both excluded";

/// Reads all materials; `young_per_voxel` says that the body may give Young's modulus instead of the material.
pub fn read_materials(item: &Item, young_per_voxel: bool) -> Reading<Vec<SceneMaterial>> {
    let names = item.named_entries("one table [materials.NAME] for each material")?;
    let read = |(name, item): &(&str, Item)| read_material(name, item, young_per_voxel);
    let materials: Vec<Reading<SceneMaterial>> = names.iter().map(read).collect();
    let materials = materials.into_iter().collect::<Reading<Vec<_>>>()?;
    for (n, second) in materials.iter().enumerate() {
        if let Some(first) = materials[..n].iter().find(|m| m.label == second.label) {
            let (a, b, label) = (&first.name, &second.name, second.label);
            return Err(names[n].1.note(format!(
                "materials.{a} and materials.{b} both have label {label}; expected one material for each label"
            )));
        }
    }
    Ok(materials)
}

fn read_material(name: &str, item: &Item, young_per_voxel: bool) -> Reading<SceneMaterial> {
    if !item.is_table() {
        return Err(item.refuse("a table with label, young, poisson and density"));
    }
    let section = item.section(KEYS)?;
    let label = section.required("label", "the integer label that the material belongs to", read_label);
    let models = [("linear", Law::Linear), ("corotational", Law::Corotational), ("neo-hookean", Law::NeoHookean)];
    let model = section.optional("model", |m| m.choice(&models));
    let constants = read_constants(&section, young_per_voxel);
    let density = section.optional("density", Item::non_negative);
    let law = model?.unwrap_or_default();
    let nonlinear = models.iter().find(|(_, known)| *known == law && law != Law::Linear);
    if let (Some(stiffness), Some((name, _))) = (section.get("stiffness"), nonlinear) {
        return Err(stiffness.note(format!(
            "{} is given to a {name} material; expected young and poisson, or model = \"linear\"",
            stiffness.key()
        )));
    }
    Ok(SceneMaterial { name: name.into(), label: label?, law, constants: constants?, density: density? })
}

fn read_constants(section: &Section, young_per_voxel: bool) -> Reading<Constants> {
    section.exclusive(&["young", "stiffness"], "give young and poisson, or stiffness")?;
    section.exclusive(&["poisson", "stiffness"], "give young and poisson, or stiffness")?;
    if let Some(stiffness) = section.get("stiffness") {
        return read_stiffness(&stiffness).map(|t| Constants::Given(Box::new(Elasticity::Anisotropic(t))));
    }
    let young = section.optional("young", |e| e.number_where("a positive finite number of pascals", |v| v > 0.0));
    let poisson = section.required("poisson", POISSON, |nu| nu.number_where(POISSON, |v| v > -1.0 && v < 0.5));
    let (young, poisson) = (young?, poisson?);
    match young {
        None if young_per_voxel => Ok(Constants::YoungPerVoxel { poisson }),
        None => Err(section.missing("young", "a positive finite number of pascals")),
        Some(young) => match IsotropicMaterial::new(young, poisson) {
            Ok(material) => Ok(Constants::Given(Box::new(Elasticity::Isotropic(material)))),
            Err(error) => Err(section.note(format!("{}: {error}", section.key()))),
        },
    }
}

fn read_stiffness(item: &Item) -> Reading<ElasticityTensor> {
    let expected = "6 rows of 6 numbers, Voigt order xx, yy, zz, yz, xz, xy, in pascals";
    let rows = item.array(expected, |row| row.array(expected, Item::number))?;
    ElasticityTensor::from_voigt(rows).map_err(|error| item.note(format!("{}: {error}", item.key())))
}
