//! The ways to model a body of voxels, by name, and names as they come from the command line.

use std::fmt;
use std::str::FromStr;

use grosgrain::training::TrainingKind;

use crate::failure::Failure;
use crate::meshes::MeshMethod;
use crate::scene::{Training, nearest};

/// A way to model a body of voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The fine model.
    Fine,
    /// Coarse trilinear elements with the materials integrated at the fine quadrature points.
    Trilinear,
    /// Coarse trilinear elements of volume-averaged material.
    Average,
    /// Shape functions fitted to training data.
    Coarsened(TrainingKind),
    /// The exact training, global or one-ring, that is cheaper to renew after an edit.
    Auto,
}

/// Why a name is no method.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MethodError {
    /// No method has the name.
    #[error(
        "{name:?} is no method{hint}; expected fine, trilinear, average, global, one-ring, single-cell, substructured or auto, \
         or for meshes fine, tensor, average, trilinear or sampled"
    )]
    Unknown {
        /// What was given.
        name: String,
        /// A nearby name.
        hint: String,
    },
    /// The method exists, but not here.
    #[error(
        "{0:?} is not in this version; it has fine, trilinear, average, global, one-ring, single-cell, substructured and auto, \
         with 6 training fields"
    )]
    NotYet(String),
    /// A method of meshes, asked for a body of voxels.
    #[error(
        "{0} is a method for meshes, but the body consists of voxels; expected fine, trilinear, average, global, one-ring, \
         single-cell, substructured or auto"
    )]
    NotForVoxels(String),
    /// A method of voxels, asked for a mesh.
    #[error("{0} is a method for voxels, but the body is a mesh; expected fine, tensor, average, trilinear or sampled")]
    NotForMeshes(String),
}

impl From<MethodError> for Failure {
    fn from(error: MethodError) -> Self {
        Self::Unusable(error.to_string())
    }
}

/// A method as it is asked for before it is known what the body is made of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AskedMethod {
    name: String,
    voxels: Option<Method>,
    mesh: Option<MeshMethod>,
}

impl AskedMethod {
    /// The method for a body of voxels.
    ///
    /// # Errors
    /// A method for meshes.
    pub fn for_voxels(&self) -> Result<Method, MethodError> {
        self.voxels.ok_or_else(|| MethodError::NotForVoxels(self.name.clone()))
    }

    /// The method for a mesh.
    ///
    /// # Errors
    /// A method for voxels.
    pub fn for_mesh(&self) -> Result<MeshMethod, MethodError> {
        self.mesh.ok_or_else(|| MethodError::NotForMeshes(self.name.clone()))
    }
}

impl FromStr for AskedMethod {
    type Err = MethodError;

    fn from_str(name: &str) -> Result<Self, MethodError> {
        let (voxels, mesh) = (name.parse::<Method>(), MeshMethod::named(name));
        match voxels {
            Err(error) if mesh.is_none() => Err(error),
            voxels => Ok(Self { name: name.into(), voxels: voxels.ok(), mesh }),
        }
    }
}

impl Method {
    /// Every method with its name.
    pub const ALL: [(&'static str, Self); 8] = [
        ("fine", Self::Fine),
        ("trilinear", Self::Trilinear),
        ("average", Self::Average),
        ("global", Self::Coarsened(TrainingKind::Global)),
        ("one-ring", Self::Coarsened(TrainingKind::OneRing)),
        ("single-cell", Self::Coarsened(TrainingKind::SingleCell)),
        ("substructured", Self::Coarsened(TrainingKind::Substructured)),
        ("auto", Self::Auto),
    ];

    /// The method of a scene's training.
    pub const fn of_training(training: Training) -> Self {
        match training {
            Training::Kind(kind) => Self::Coarsened(kind),
            Training::Auto => Self::Auto,
        }
    }

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Trilinear => "trilinear",
            Self::Average => "average",
            Self::Coarsened(TrainingKind::Global) => "global",
            Self::Coarsened(TrainingKind::OneRing) => "one-ring",
            Self::Coarsened(TrainingKind::Substructured) => "substructured",
            Self::Coarsened(TrainingKind::SingleCell) => "single-cell",
            Self::Auto => "auto",
        }
    }
}

impl FromStr for Method {
    type Err = MethodError;

    fn from_str(name: &str) -> Result<Self, MethodError> {
        let (stem, fields) = name.split_once('+').map_or((name, None), |(stem, n)| (stem, Some(n)));
        let known = Self::ALL.iter().find(|(known, _)| *known == stem).map(|(_, method)| *method);
        let trained = matches!(known, Some(Self::Coarsened(_) | Self::Auto));
        match (known, fields) {
            (Some(method), None) => Ok(method),
            (Some(method), Some("6")) if trained => Ok(method),
            (_, Some(n)) if trained && n.parse::<usize>().is_ok() => Err(MethodError::NotYet(name.into())),
            (None, None) if MeshMethod::named(stem).is_some() => Err(MethodError::NotForVoxels(name.into())),
            _ => {
                let names = Self::ALL.map(|(known, _)| known).into_iter().chain(MeshMethod::ALL.map(MeshMethod::name));
                let near = nearest(stem, &names.collect::<Vec<_>>());
                let hint = near.map_or_else(String::new, |near| format!(" (did you mean {near:?}?)"));
                Err(MethodError::Unknown { name: name.into(), hint })
            }
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_read_back_from_its_name() {
        for (name, method) in Method::ALL {
            assert_eq!((method.name(), name.parse()), (name, Ok(method)));
        }
        assert_eq!("one-ring+6".parse(), Ok(Method::Coarsened(TrainingKind::OneRing)));
    }

    #[test]
    fn methods_beyond_this_version_are_recognised_and_refused() {
        for name in ["one-ring+18", "substructured+18"] {
            assert_eq!(name.parse::<Method>(), Err(MethodError::NotYet(name.into())));
        }
    }

    #[test]
    fn a_method_is_for_voxels_or_for_meshes_or_for_both() {
        let asked = |name: &str| name.parse::<AskedMethod>().unwrap();
        assert_eq!((asked("fine").for_voxels(), asked("fine").for_mesh()), (Ok(Method::Fine), Ok(MeshMethod::Fine)));
        assert_eq!(asked("trilinear").for_mesh(), Ok(MeshMethod::Stiffness));
        for name in ["tensor", "sampled"] {
            assert_eq!(asked(name).for_voxels(), Err(MethodError::NotForVoxels(name.into())));
            assert_eq!(asked(name).for_mesh().map(MeshMethod::name), Ok(name));
        }
        for name in ["global", "one-ring+6", "auto"] {
            assert_eq!(asked(name).for_mesh(), Err(MethodError::NotForMeshes(name.into())));
        }
        let message = "tensors".parse::<AskedMethod>().unwrap_err().to_string();
        assert!(message.contains("did you mean \"tensor\"?"), "{message}");
    }

    #[test]
    fn a_misspelt_method_gets_a_suggestion() {
        for name in ["onering", "fine+6", "one-ring+", "one-ring+x", "zzz"] {
            let message = name.parse::<Method>().unwrap_err().to_string();
            assert!(message.starts_with(&format!("{name:?} is no method")), "{message}");
        }
        assert!("onering".parse::<Method>().unwrap_err().to_string().contains("did you mean \"one-ring\"?"));
    }
}
