//! How a command ends when it does not succeed.

use std::process::ExitCode;

use grosgrain::io::{MeshReadError, MeshWriteError, ReadError, WriteError};

use crate::scene::SceneError;

/// Why a command did not do its work.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// The arguments or the scene cannot be used; exit code 2.
    #[error("{0}")]
    Unusable(String),
    /// The run failed; exit code 1.
    #[error("{0}")]
    Failed(String),
    /// The user interrupted the run; exit code 1.
    #[error("interrupted; no half-written file is left")]
    Interrupted,
    /// Whoever read the results stopped reading; exit code 0.
    #[error("nobody reads the results")]
    ReaderGone,
}

impl Failure {
    /// The exit code: 2 for unusable input, 1 for a run that failed, 0 where nothing is wrong.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Unusable(_) => ExitCode::from(2),
            Self::Failed(_) | Self::Interrupted => ExitCode::from(1),
            Self::ReaderGone => ExitCode::SUCCESS,
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Unusable(error.to_string())
    }
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<MeshReadError> for Failure {
    fn from(error: MeshReadError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<MeshWriteError> for Failure {
    fn from(error: MeshWriteError) -> Self {
        Self::Failed(error.to_string())
    }
}
