//! Named values at the points or cells of a grid.

use super::VtkError;
use crate::simplex::{Dimension, MandelTensor};

/// A named array with one entry per point or per cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DataArray<'a> {
    /// Name shown by viewers: `displacement`, `young`, `von_mises`.
    pub name: &'a str,
    /// The entries.
    pub values: Values<'a>,
}

/// The entries of a [`DataArray`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Values<'a> {
    /// One number each, Float64.
    Scalar(&'a [f64]),
    /// Three components x, y, z each, Float64.
    Vector(&'a [[f64; 3]]),
    /// Symmetric tensors xx, yy, zz, yz, xz, xy, Float64. Shear entries are tensor components (half the
    /// engineering shear). Written in VTK's order XX YY ZZ XY YZ XZ, with component names.
    Tensor(&'a [[f64; 6]]),
    /// One integer each, Int32: labels, indices.
    Integer(&'a [i32]),
    /// Elasticity tensors, all of one dimension, Float64: n × n components each, row by row, of the Voigt matrix in the order xx | xx, yy, xy |
    /// xx, yy, zz, yz, xz, xy with engineering shear (γ = 2ε), for stiffnesses. Components are named `xx_yy` by row and column.
    Stiffness(&'a [MandelTensor]),
}

/// Names of the rows of Voigt matrices in our order.
const fn voigt_names(dimension: Dimension) -> &'static [&'static str] {
    match dimension {
        Dimension::One => &["xx"],
        Dimension::Two => &["xx", "yy", "xy"],
        Dimension::Three => &["xx", "yy", "zz", "yz", "xz", "xy"],
    }
}

/// VTK's names and our positions of the components of a symmetric tensor, in VTK's order.
const TENSOR: [(&str, usize); 6] = [("XX", 0), ("YY", 1), ("ZZ", 2), ("XY", 5), ("YZ", 3), ("XZ", 4)];

impl Values<'_> {
    /// Number of entries.
    pub fn len(&self) -> usize {
        match self {
            Self::Scalar(v) => v.len(),
            Self::Vector(v) => v.len(),
            Self::Tensor(v) => v.len(),
            Self::Integer(v) => v.len(),
            Self::Stiffness(v) => v.len(),
        }
    }

    /// True if there are no entries.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The attributes that describe the entries: type, and number and names of components. A single component is not
    /// counted, since meshio would then read a column instead of a list.
    pub(super) fn attributes(&self) -> String {
        let names = |names: &[&str]| {
            let named = names.iter().enumerate().map(|(i, n)| format!(" ComponentName{i}=\"{n}\""));
            format!("type=\"Float64\" NumberOfComponents=\"{}\"{}", names.len(), named.collect::<String>())
        };
        match self {
            Self::Scalar(_) => "type=\"Float64\"".into(),
            Self::Integer(_) => "type=\"Int32\"".into(),
            Self::Vector(_) => names(&["X", "Y", "Z"]),
            Self::Tensor(_) => names(&TENSOR.map(|(name, _)| name)),
            Self::Stiffness(v) => {
                let rows = v.first().map_or(&[][..], |tensor| voigt_names(tensor.dimension));
                let all: Vec<String> = rows.iter().flat_map(|r| rows.iter().map(move |c| format!("{r}_{c}"))).collect();
                names(&all.iter().map(String::as_str).collect::<Vec<_>>())
            }
        }
    }

    /// What a reader of the file has to know about the components beyond their names.
    pub(super) fn component_order(&self) -> Option<String> {
        let Self::Stiffness([first, ..]) = self else { return None };
        let order = voigt_names(first.dimension).join(" ");
        Some(format!(
            "Voigt matrix in Pa, row by row, component_order {order}, engineering shear (2 * tensor component)"
        ))
    }

    /// Little-endian bytes in VTK's component order.
    pub(super) fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Scalar(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Vector(v) => v.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Tensor(v) => v.iter().flat_map(|t| TENSOR.map(|(_, at)| t[at].to_le_bytes())).flatten().collect(),
            Self::Integer(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Stiffness(v) => v.iter().flat_map(voigt_entries).flat_map(f64::to_le_bytes).collect(),
        }
    }

    /// Index of the first entry with a number that is not finite, and that number.
    fn not_finite(&self) -> Option<(usize, f64)> {
        let (at, components, value) = match self {
            Self::Scalar(v) => first_not_finite(v.iter().copied()).map(|(at, x)| (at, 1, x)),
            Self::Vector(v) => first_not_finite(v.as_flattened().iter().copied()).map(|(at, x)| (at, 3, x)),
            Self::Tensor(v) => first_not_finite(v.as_flattened().iter().copied()).map(|(at, x)| (at, 6, x)),
            Self::Stiffness(v) => {
                first_not_finite(v.iter().flat_map(|t| t.matrix.into_iter().flatten())).map(|(at, x)| (at, 36, x))
            }
            Self::Integer(_) => None,
        }?;
        Some((at / components, value))
    }

    /// Index of the first tensor that has another dimension than the first, if any has.
    fn other_dimension(&self) -> Option<usize> {
        let Self::Stiffness(tensors) = self else { return None };
        tensors.iter().position(|tensor| tensor.dimension != tensors[0].dimension)
    }
}

/// The n × n entries of the Voigt matrix, row by row.
fn voigt_entries(tensor: &MandelTensor) -> impl Iterator<Item = f64> + use<> {
    let rows = tensor.rows();
    tensor.voigt().into_iter().take(rows).flat_map(move |row| row.into_iter().take(rows))
}

fn first_not_finite(numbers: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    numbers.enumerate().find(|(_, x)| !x.is_finite())
}

impl DataArray<'_> {
    pub(super) fn check_finite(&self) -> Result<(), VtkError> {
        match self.values.not_finite() {
            None => Ok(()),
            Some((index, value)) => Err(VtkError::NotFinite { name: self.name.to_owned(), index, value }),
        }
    }
}

/// Refuses arrays of the wrong length, with numbers that are not finite, or with equal names.
pub(super) fn check(arrays: &[DataArray], expected: usize, per: &'static str) -> Result<(), VtkError> {
    for (at, array) in arrays.iter().enumerate() {
        let (name, found) = (array.name.to_owned(), array.values.len());
        if found != expected {
            return Err(VtkError::Length { name, found, expected, per });
        }
        if arrays[..at].iter().any(|other| other.name == array.name) {
            return Err(VtkError::Duplicate { name, per });
        }
        array.check_finite()?;
        if let Some(index) = array.values.other_dimension() {
            return Err(VtkError::Dimensions { name, index });
        }
    }
    Ok(())
}
