//! Named values at the points or cells of a grid.

use super::VtkError;

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
        }
    }

    /// Little-endian bytes in VTK's component order.
    pub(super) fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Scalar(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Vector(v) => v.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Tensor(v) => v.iter().flat_map(|t| TENSOR.map(|(_, at)| t[at].to_le_bytes())).flatten().collect(),
            Self::Integer(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
        }
    }

    /// The numbers and how many belong to one entry; integers are always finite and give none.
    fn numbers(&self) -> (&[f64], usize) {
        match self {
            Self::Scalar(v) => (v, 1),
            Self::Vector(v) => (v.as_flattened(), 3),
            Self::Tensor(v) => (v.as_flattened(), 6),
            Self::Integer(_) => (&[], 1),
        }
    }
}

impl DataArray<'_> {
    pub(super) fn check_finite(&self) -> Result<(), VtkError> {
        let (numbers, components) = self.values.numbers();
        match numbers.iter().position(|x| !x.is_finite()) {
            None => Ok(()),
            Some(at) => {
                let (index, value) = (at / components, numbers[at]);
                Err(VtkError::NotFinite { name: self.name.to_owned(), index, value })
            }
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
    }
    Ok(())
}
