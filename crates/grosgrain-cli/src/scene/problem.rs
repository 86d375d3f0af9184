//! What is wrong with a scene, in sentences that name the place.

use std::path::PathBuf;

/// One thing wrong with a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The line, from 1; 0 where the problem belongs to no line.
    pub line: usize,
    /// A sentence: the key, what was found, what is expected.
    pub sentence: String,
}

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file cannot be read as text.
    #[error("{}: the scene cannot be read: {reason}", file.display())]
    Unreadable {
        /// The scene file.
        file: PathBuf,
        /// What the system says.
        reason: std::io::Error,
    },
    /// The file holds something that is not a usable scene.
    #[error("{}", listing(file, problems))]
    Unusable {
        /// The scene file.
        file: PathBuf,
        /// Everything that was found, in the order of the lines.
        problems: Vec<Problem>,
    },
}

fn listing(file: &std::path::Path, problems: &[Problem]) -> String {
    let place = |line| match line {
        0 => format!("{}", file.display()),
        _ => format!("{}:{line}", file.display()),
    };
    let lines: Vec<String> = problems.iter().map(|p| format!("{}: {}", place(p.line), p.sentence)).collect();
    lines.join("\n")
}
