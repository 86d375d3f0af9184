//! Why a mesh file is not read.

use crate::simplex::{Dimension, SimplexMeshError};
use std::fmt;
use std::path::{Path, PathBuf};

/// Where in a file something stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line, from 1.
    Line(usize),
    /// A byte of binary data, from 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// Why a mesh file is not read: the place, the numbers and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshReadError {
    /// Something is wrong with a file; its path and the reason.
    #[error("{}: {reason}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: Box<MeshReadError>,
    },
    /// The operating system refuses.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// Neither name nor content is that of a known format.
    #[error("is in no mesh format that is read; known are {known}")]
    UnknownFormat {
        /// The formats with their endings.
        known: &'static str,
    },
    /// Something else stands where a word or a number must stand.
    #[error("{place}: `{found}` stands where {expected} is expected; write the file again, or correct it there")]
    Unexpected {
        /// Where.
        place: Place,
        /// What stands there.
        found: String,
        /// What must stand there.
        expected: &'static str,
    },
    /// The file ends too early.
    #[error("{place}: the file ends where {expected} is expected; fetch or write the file again")]
    CutOff {
        /// Where the file ends.
        place: Place,
        /// What must come.
        expected: &'static str,
    },
    /// A count is larger than what can stand in the rest of the file.
    #[error("{place}: {claimed} {what} are announced, but only {left} bytes follow; fetch or write the file again")]
    Claim {
        /// Where the count stands.
        place: Place,
        /// The count.
        claimed: u64,
        /// What is counted.
        what: &'static str,
        /// Bytes that follow.
        left: usize,
    },
    /// Compressed or marked-up data are damaged.
    #[error("{place}: {part} cannot be read ({reason}); fetch or write the file again")]
    Damaged {
        /// Where they stand.
        place: Place,
        /// What they are.
        part: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// A needed section is absent.
    #[error("the file has no {section}; {remedy}")]
    Missing {
        /// The section.
        section: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// An element names a node that does not exist.
    #[error("{place}: an element names node {node}, which the file does not list; export nodes and elements together")]
    NoSuchNode {
        /// Where the element stands.
        place: Place,
        /// The number of the node in the file.
        node: i64,
    },
    /// Two nodes have the same number.
    #[error("two nodes have the number {node}; number the nodes anew")]
    RepeatedNode {
        /// The number.
        node: i64,
    },
    /// More nodes than can be counted.
    #[error("{nodes} nodes are more than can be numbered with 32 bits; use a coarser mesh")]
    TooManyNodes {
        /// How many.
        nodes: usize,
    },
    /// A valid file of a kind that is not read.
    #[error("{what} cannot be read; {remedy}")]
    Unsupported {
        /// The kind.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The body has elements that are not simplices of first order.
    #[error(
        "the body has {count} {kind}; only segments, triangles and tetrahedra with straight edges and no nodes between their corners are read: mesh the body with those, or cut its elements into them"
    )]
    NotSimplices {
        /// What they are.
        kind: &'static str,
        /// How many.
        count: usize,
    },
    /// There is nothing to make a body from.
    #[error("the file lists {nodes} nodes and no segments, triangles or tetrahedra; export the volume elements too")]
    NoCells {
        /// Number of nodes.
        nodes: usize,
    },
    /// Triangles or segments in space.
    #[error(
        "the file holds a surface or curve, not a body: its {dimension} do not lie {}, as node {node} at ({}, {}, {}) shows; export the volume elements too, or move a flat body there",
        flat_place(*.dimension), at[0], at[1], at[2]
    )]
    Surface {
        /// Triangles or segments.
        dimension: Dimension,
        /// The first node that lies elsewhere, from 0.
        node: usize,
        /// Where it lies.
        at: [f64; 3],
    },
    /// The cells make no mesh.
    #[error(transparent)]
    Mesh(#[from] SimplexMeshError),
}

const fn flat_place(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::One => "on the x axis",
        _ => "in the plane z = 0",
    }
}

impl MeshReadError {
    /// Names the file in which the failure happened, unless it is already named.
    pub(in crate::io) fn in_file(self, path: &Path) -> Self {
        match self {
            Self::InFile { .. } => self,
            reason => Self::InFile { path: path.to_path_buf(), reason: Box::new(reason) },
        }
    }
}
