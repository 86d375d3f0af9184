//! Writing Abaqus input files.

use super::constants::{constants, young_of_bar};
use super::names::SetNames;
use crate::simplex::{Dimension, MandelTensor, SimplexMesh};
use std::collections::BTreeMap;
use std::io::Write;

/// Element numbers on a line of a set; Abaqus takes up to 16.
const PER_LINE: usize = 16;
/// Constants on a line of `*ELASTIC, TYPE=ANISOTROPIC`.
const CONSTANTS_PER_LINE: usize = 8;
/// Letters that Abaqus and CalculiX read of a number.
const NUMBER_LENGTH: usize = 20;

/// What an Abaqus input file (`.inp`) is made of: a mesh, the names of its tags, and what its cells consist of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbaqusDeck<'a> {
    /// The mesh; tetrahedra become C3D4, triangles CPE3 (plane strain, unit thickness), segments T3D2 (unit section).
    pub mesh: &'a SimplexMesh,
    /// Names of tags, which become element sets; a tag without one becomes `TAG_n`.
    pub names: &'a [(i32, String)],
    /// What the cells consist of; without it the file holds the mesh only.
    pub materials: Option<AbaqusMaterials<'a>>,
}

/// What each cell of an [`AbaqusDeck`] consists of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbaqusMaterials<'a> {
    /// Elasticity tensor \[Pa\] of each cell.
    pub stiffness: &'a [MandelTensor],
    /// Mass density \[kg/m³\] of each cell.
    pub density: &'a [f64],
}

/// Why an Abaqus input file is not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AbaqusWriteError {
    /// Not one entry per cell.
    #[error("{found} {what} for {cells} cells; one each is needed")]
    Length {
        /// What there are too few or too many of.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// Number of cells.
        cells: usize,
    },
    /// A tensor of another dimension than the mesh.
    #[error("the elasticity tensor of cell {cell} is one for {found}, but the mesh consists of {mesh}")]
    Dimension {
        /// The cell, from 0.
        cell: usize,
        /// Dimension of its tensor.
        found: Dimension,
        /// Dimension of the mesh.
        mesh: Dimension,
    },
    /// A number is NaN or infinite.
    #[error(
        "the {what} of cell {cell} holds {value}; only finite numbers are written, check the computation that made it"
    )]
    NotFinite {
        /// Stiffness or density.
        what: &'static str,
        /// The cell, from 0.
        cell: usize,
        /// The offending number.
        value: f64,
    },
    /// The writer failed.
    #[error("the file could not be written: {0}")]
    Io(#[from] std::io::Error),
}

/// Writes an Abaqus input file, which CalculiX reads too: `*NODE`, `*ELEMENT`, an `*ELSET` per tag, and for every different material `*ELASTIC,
/// TYPE=ANISOTROPIC` with the 21 constants in the manual's order \[abaqus2024keywords\], `*DENSITY` and a `*SOLID SECTION` with the cells that consist of it. Cells with
/// equal constants share a material. Steps, loads and held nodes are for the user to add. Units are SI. Nothing is written if something is refused.
///
/// Numbers have at most 20 letters, which is all that the programs read, so at least 13 significant digits.
///
/// In two dimensions (plane strain) the constants that only the stress across the plane depends on, or that never act, are made up: D3333, D1313 and D2323 are the
/// largest diagonal entry, so that the matrix stays positive definite. In one dimension the material is `*ELASTIC` with Young's modulus and Poisson's ratio 0.
///
/// # Errors
/// Not one tensor and density per cell, tensors of another dimension than the mesh, numbers that are not finite, what the writer reports.
pub fn write_abaqus<W: Write>(mut writer: W, deck: &AbaqusDeck) -> Result<(), AbaqusWriteError> {
    if let Some(materials) = &deck.materials {
        materials.validate(deck.mesh)?;
    }
    let w = &mut writer;
    writeln!(w, "*HEADING\nA mesh of {} in SI units, written by grosgrain", deck.mesh.dimension())?;
    write_mesh(w, deck.mesh)?;
    let mut names = SetNames::default();
    write_tags(w, deck, &mut names)?;
    if let Some(materials) = &deck.materials {
        write_materials(w, deck.mesh, materials, &mut names)?;
    }
    Ok(writer.flush()?)
}

impl AbaqusMaterials<'_> {
    fn validate(&self, mesh: &SimplexMesh) -> Result<(), AbaqusWriteError> {
        let cells = mesh.cell_count();
        for (what, found) in [("elasticity tensors", self.stiffness.len()), ("densities", self.density.len())] {
            if found != cells {
                return Err(AbaqusWriteError::Length { what, found, cells });
            }
        }
        for (cell, (tensor, density)) in self.stiffness.iter().zip(self.density).enumerate() {
            if tensor.dimension != mesh.dimension() {
                let (found, mesh) = (tensor.dimension, mesh.dimension());
                return Err(AbaqusWriteError::Dimension { cell, found, mesh });
            }
            if let Some(&value) = tensor.matrix.as_flattened().iter().find(|x| !x.is_finite()) {
                return Err(AbaqusWriteError::NotFinite { what: "stiffness", cell, value });
            }
            if !density.is_finite() {
                return Err(AbaqusWriteError::NotFinite { what: "density", cell, value: *density });
            }
        }
        Ok(())
    }
}

/// Nodes and cells, numbered from 1.
fn write_mesh<W: Write>(w: &mut W, mesh: &SimplexMesh) -> Result<(), AbaqusWriteError> {
    writeln!(w, "*NODE")?;
    for (node, at) in mesh.nodes().iter().enumerate() {
        writeln!(w, "{}, {}, {}, {}", node + 1, number(at[0]), number(at[1]), number(at[2]))?;
    }
    let kind = match mesh.dimension() {
        Dimension::One => "T3D2",
        Dimension::Two => "CPE3",
        Dimension::Three => "C3D4",
    };
    writeln!(w, "*ELEMENT, TYPE={kind}")?;
    for cell in 0..mesh.cell_count() {
        write!(w, "{}", cell + 1)?;
        mesh.cell(cell).iter().try_for_each(|node| write!(w, ", {}", node + 1))?;
        writeln!(w)?;
    }
    Ok(())
}

fn write_tags<W: Write>(w: &mut W, deck: &AbaqusDeck, names: &mut SetNames) -> Result<(), AbaqusWriteError> {
    let mut sets: BTreeMap<i32, Vec<usize>> = BTreeMap::new();
    deck.mesh.tags().iter().enumerate().for_each(|(cell, tag)| sets.entry(*tag).or_default().push(cell));
    for (tag, cells) in sets {
        let given = deck.names.iter().find(|(named, _)| *named == tag).map(|(_, name)| name.as_str());
        let name = names.unused(given.unwrap_or(&format!("TAG_{tag}")));
        write_set(w, &name, &cells)?;
    }
    Ok(())
}

fn write_set<W: Write>(w: &mut W, name: &str, cells: &[usize]) -> Result<(), AbaqusWriteError> {
    writeln!(w, "*ELSET, ELSET={name}")?;
    for line in cells.chunks(PER_LINE) {
        let line: Vec<String> = line.iter().map(|cell| (cell + 1).to_string()).collect();
        writeln!(w, "{}", line.join(", "))?;
    }
    Ok(())
}

fn write_materials<W: Write>(
    w: &mut W,
    mesh: &SimplexMesh,
    materials: &AbaqusMaterials,
    names: &mut SetNames,
) -> Result<(), AbaqusWriteError> {
    // Anisotropic materials need an orientation; this one is the axes of the nodes.
    writeln!(w, "*ORIENTATION, NAME=GLOBAL, SYSTEM=RECTANGULAR\n1., 0., 0., 0., 1., 0.")?;
    for (cells, material) in alike(materials).into_iter().zip(1..) {
        let (tensor, density) = (&materials.stiffness[cells[0]], materials.density[cells[0]]);
        let name = names.unused(&format!("MATERIAL_{material}"));
        write_set(w, &name, &cells)?;
        writeln!(w, "*MATERIAL, NAME={name}")?;
        write_elasticity(w, tensor)?;
        writeln!(w, "*DENSITY\n{}", number(density))?;
        match mesh.dimension() {
            Dimension::One => writeln!(w, "*SOLID SECTION, ELSET={name}, MATERIAL={name}\n1.")?,
            Dimension::Two => writeln!(w, "*SOLID SECTION, ELSET={name}, MATERIAL={name}, ORIENTATION=GLOBAL\n1.")?,
            Dimension::Three => writeln!(w, "*SOLID SECTION, ELSET={name}, MATERIAL={name}, ORIENTATION=GLOBAL")?,
        }
    }
    Ok(())
}

/// Cells of the same material, bit by bit, in the order of the first of each.
fn alike(materials: &AbaqusMaterials) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut known: BTreeMap<([[u64; 6]; 6], u64), usize> = BTreeMap::new();
    for (cell, (tensor, density)) in materials.stiffness.iter().zip(materials.density).enumerate() {
        let key = (tensor.matrix.map(|row| row.map(f64::to_bits)), density.to_bits());
        let group = *known.entry(key).or_insert(groups.len());
        match groups.get_mut(group) {
            Some(cells) => cells.push(cell),
            None => groups.push(vec![cell]),
        }
    }
    groups
}

fn write_elasticity<W: Write>(w: &mut W, tensor: &MandelTensor) -> Result<(), AbaqusWriteError> {
    let Some(constants) = constants(tensor) else {
        return Ok(writeln!(w, "*ELASTIC\n{}, 0.", number(young_of_bar(tensor)))?);
    };
    writeln!(w, "*ELASTIC, TYPE=ANISOTROPIC")?;
    for line in constants.chunks(CONSTANTS_PER_LINE) {
        writeln!(w, "{}", line.iter().map(|c| number(*c)).collect::<Vec<_>>().join(", "))?;
    }
    Ok(())
}

/// The shortest decimal number that stands for `x`, or the nearest one of 20 letters; always with a point, which tells it from an integer.
fn number(x: f64) -> String {
    let pointed = |text: String| match text.split_once('e') {
        Some((mantissa, exponent)) if !mantissa.contains('.') => format!("{mantissa}.e{exponent}"),
        _ => text,
    };
    let shortest = pointed(format!("{x:e}"));
    let rounded = (8..17).rev().map(|digits| format!("{x:.digits$e}"));
    std::iter::once(shortest)
        .chain(rounded)
        .find(|text| text.len() <= NUMBER_LENGTH)
        .unwrap_or_else(|| format!("{x:.8e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_at_most_twenty_letters_and_thirteen_digits() {
        assert_eq!(number(0.0), "0.e0");
        assert_eq!(number(-2.5e-7), "-2.5e-7");
        assert_eq!(number(1.0 / 3.0), "3.333333333333333e-1");
        for x in [-std::f64::consts::PI * 1e-200, f64::MAX / 4.0, -f64::MIN_POSITIVE, 1e300 / 7.0, -2.0 / 3.0, 1e5] {
            let text = number(x);
            let back: f64 = text.parse().unwrap();
            assert!(text.len() <= 20 && text.contains('.'), "{text}");
            assert!((back / x - 1.0).abs() < 5e-13, "{x:e} as {text}");
        }
    }
}
