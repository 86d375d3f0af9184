//! The `[body]` table: where the voxels, or the mesh, come from and what they mean.

use std::path::PathBuf;

use grosgrain::mesh::{DensityLaw, ModulusLaw};
use grosgrain::update::LooseParts;

use super::document::{Item, Reading};
use super::labels::{Labelling, read_labelling};
use super::mesh_body::{MeshSource, read_mesh_body, refuse_mesh_keys};
use super::pattern::{Filling, Grid, read_cells, read_grid, read_pattern};
use super::section::Section;

/// Where the voxels or the cells of a mesh come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A volume file; its values become labels.
    Volume(PathBuf),
    /// A file of Young moduli \[Pa\]; zero is void, all else has label 0.
    Moduli(PathBuf),
    /// A grid that a pattern or a file fills.
    Grid(Grid, Filling),
    /// A mesh of simplices; the tags of its cells are the labels.
    Mesh(MeshSource),
}

/// Where Young's modulus comes from for materials that give none.
#[derive(Clone, Debug, PartialEq)]
pub enum VoxelModulus {
    /// A volume file of moduli \[Pa\].
    File(PathBuf),
    /// A law from the volume's values.
    Law {
        /// The law.
        law: ModulusLaw,
        /// Poisson's ratio where no material gives one.
        poisson: f64,
        /// Lower moduli are raised to this one \[Pa\].
        floor: Option<f64>,
    },
}

/// Which connected components of the body stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// All of them.
    All,
    /// The largest one.
    Largest,
    /// Those that a `[[fix]]` holds.
    Supported,
}

/// The `[body]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Where the voxels come from.
    pub source: Source,
    /// Edge lengths of a voxel \[m\], in place of the file's.
    pub spacing: Option<[f64; 3]>,
    /// Number of fine cells to resample to.
    pub resample: Option<[usize; 3]>,
    /// How values become labels.
    pub labelling: Labelling,
    /// Young's modulus voxel by voxel.
    pub modulus: Option<VoxelModulus>,
    /// Which components stay.
    pub keep: Keep,
    /// What happens to parts that edits cut loose.
    pub loose: LooseParts,
}

const KEYS: &[&str] = &[
    "volume", "grid", "pattern", "mesh", "scale", "spacing", "resample", "labels", "void", "young", "modulus", "keep",
    "loose",
];

/// Reads `[body]`; parts that edits cut loose fall in a dynamic run, and are dropped in a static one, unless the scene says it.
pub fn read_body(item: &Item, dynamic: bool) -> Reading<Body> {
    let section = item.section(KEYS)?;
    if section.has("mesh") {
        return read_mesh_body(&section, KEYS);
    }
    let misplaced = refuse_mesh_keys(&section, &["scale"]);
    let source = read_source(&section);
    let spacing = section
        .optional("spacing", |spacing| spacing.array("three positive numbers in metres per voxel", Item::positive));
    let resample = section.optional("resample", read_cells);
    let is_modulus = matches!(source, Ok(Source::Moduli(_))) || section.has("modulus");
    let labelling = read_labelling(&section, is_modulus);
    let modulus = read_modulus(&section);
    let keeps = [("all", Keep::All), ("largest", Keep::Largest), ("supported", Keep::Supported)];
    let keep = section.optional("keep", |keep| keep.choice(&keeps));
    let loose = section.optional("loose", |l| l.choice(&[("drop", LooseParts::Drop), ("keep", LooseParts::Keep)]));
    let (source, labelling, modulus) = (source?, labelling?, modulus?);
    refuse_rules_without_values(&section, &source)?;
    misplaced?;
    let (keep, loose) =
        (keep?.unwrap_or(Keep::All), loose?.unwrap_or(if dynamic { LooseParts::Keep } else { LooseParts::Drop }));
    Ok(Body { source, spacing: spacing?, resample: resample?, labelling, modulus, keep, loose })
}

fn read_source(section: &Section) -> Reading<Source> {
    section.exclusive(&["volume", "grid"], "a body comes from one of them")?;
    section.exclusive(&["volume", "pattern"], "a pattern fills a grid; a volume brings its own voxels")?;
    section.exclusive(&["grid", "spacing"], "the grid's size gives the spacing")?;
    if let Some(volume) = section.get("volume") {
        return volume.existing_path().map(Source::Volume);
    }
    if section.has("grid") || section.has("pattern") {
        let grid = section.required("grid", "{ cells = [nx, ny, nz], size = [x, y, z] } for the pattern", read_grid);
        let pattern =
            section.required("pattern", "{ kind = \"layers\", .. } or another kind for the grid", read_pattern);
        return Ok(Source::Grid(grid?, pattern?));
    }
    match section.get("young") {
        Some(young) => young.existing_path().map(Source::Moduli),
        None => Err(section.note("body holds nothing; expected volume, grid with pattern, young, or mesh".into())),
    }
}

fn read_modulus(section: &Section) -> Reading<Option<VoxelModulus>> {
    section.exclusive(&["young", "modulus"], "Young's modulus comes from one of them")?;
    match section.has("volume") || section.has("grid") || section.has("modulus") {
        true => {}
        false => return Ok(None),
    }
    if let Some(young) = section.get("young") {
        return young.existing_path().map(|path| Some(VoxelModulus::File(path)));
    }
    section.optional("modulus", read_law)
}

fn read_law(item: &Item) -> Reading<VoxelModulus> {
    let section = item.section(&["law", "coefficient", "exponent", "density", "poisson", "floor"])?;
    let law = section.required("law", "\"power\"", |law| law.choice(&[("power", ())]));
    let coefficient = section.required("coefficient", "a positive number of pascals", Item::positive);
    let exponent = section.required("exponent", "a number", Item::number);
    let density = section.required("density", "{ slope = .., intercept = .. } in g/cm³", read_density);
    let expected = "a number between -1 and 0.5, both excluded";
    let poisson = section.required("poisson", expected, |nu| nu.number_where(expected, |v| v > -1.0 && v < 0.5));
    let floor = section.optional("floor", Item::positive);
    law?;
    let law = ModulusLaw::Power { coefficient: coefficient?, exponent: exponent?, density: density? };
    Ok(VoxelModulus::Law { law, poisson: poisson?, floor: floor? })
}

fn read_density(item: &Item) -> Reading<DensityLaw> {
    let section = item.section(&["slope", "intercept"])?;
    let slope = section.required("slope", "g/cm³ per unit of the volume's value", Item::number);
    let intercept = section.required("intercept", "g/cm³ at value zero", Item::number);
    Ok(DensityLaw { slope: slope?, intercept: intercept? })
}

/// Rules and laws need the values of a volume.
fn refuse_rules_without_values(section: &Section, source: &Source) -> Reading<()> {
    if matches!(source, Source::Volume(_)) {
        return Ok(());
    }
    for name in ["labels", "modulus"] {
        if let Some(item) = section.get(name) {
            return Err(item.note(format!("{} needs the values of a volume; expected the key volume", item.key())));
        }
    }
    Ok(())
}
