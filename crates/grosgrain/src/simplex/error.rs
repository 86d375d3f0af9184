//! Why a list of nodes and cells is no mesh.

/// What is wrong with a mesh, with the place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplexMeshError {
    /// There are no cells.
    #[error("the mesh has no {cells}; export the volume elements too", cells = .dimension)]
    Empty {
        /// What there is none of.
        dimension: super::Dimension,
    },
    /// Cells and tags differ in number.
    #[error("{cells} cells but {tags} tags; give one tag per cell")]
    Tags {
        /// Number of cells.
        cells: usize,
        /// Number of tags.
        tags: usize,
    },
    /// A coordinate is not a number, or not zero beyond the dimension.
    #[error("node {node} lies at ({}, {}, {}), which is no place in {axes} dimensions", at[0], at[1], at[2])]
    Coordinate {
        /// The node, from 0.
        node: usize,
        /// Its coordinates.
        at: [f64; 3],
        /// Number of dimensions.
        axes: usize,
    },
    /// A cell names a node that does not exist.
    #[error("cell {cell} names node {node}, but there are only {nodes} nodes (counted from 0)")]
    NoSuchNode {
        /// The cell, from 0.
        cell: usize,
        /// What it names.
        node: u32,
        /// Number of nodes.
        nodes: usize,
    },
    /// A cell names a node twice.
    #[error("cell {cell} names node {node} twice")]
    Repeated {
        /// The cell, from 0.
        cell: usize,
        /// The node.
        node: u32,
    },
    /// Cells are inside out.
    #[error(
        "cell {cell} is inside out (measure {measure:.3e}){}; swap two of its nodes, or let the mesher orient the cells", Others(*.count)
    )]
    Inverted {
        /// The first of them, from 0.
        cell: usize,
        /// Its signed length, area or volume.
        measure: f64,
        /// How many there are.
        count: usize,
    },
    /// Cells are flat.
    #[error(
        "cell {cell} is flat: its measure {measure:.3e} is below {limit:.0e} of that of a regular one with its longest edge{}; remove it, or mesh anew", Others(*.count)
    )]
    Flat {
        /// The first of them, from 0.
        cell: usize,
        /// Its signed length, area or volume.
        measure: f64,
        /// Smallest share that is accepted.
        limit: f64,
        /// How many there are.
        count: usize,
    },
}

/// Says how many more there are.
struct Others(usize);

impl std::fmt::Display for Others {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            0 | 1 => Ok(()),
            count => write!(f, ", and so are {} more", count - 1),
        }
    }
}
