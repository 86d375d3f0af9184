//! Why a body of simplices cannot be made.

use super::{Conditions, EmbeddedSpring, SurfacePoint};
use crate::linalg::GraphOrderError;
use crate::simplex::{BoundaryError, Dimension, SimplexElasticityError, SimplexMesh};
use crate::solver::SolverError;

/// Why a body of simplices cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplexBodyError {
    /// A list has not as many entries as the mesh needs.
    #[error("{what} has {given} entries, but the mesh needs {needed}; make it for this mesh")]
    Length {
        /// What the list is.
        what: String,
        /// Its number of entries.
        given: usize,
        /// The number that is needed.
        needed: usize,
    },
    /// A mass is negative, not a number, or where there is nothing to carry it.
    #[error("node {node} has a mass of {mass} kg{}; masses are finite, not negative, and zero at nodes that no cell uses", if *.is_used { "" } else { ", but no cell uses it" })]
    Mass {
        /// The node, from 0.
        node: usize,
        /// Its mass \[kg\].
        mass: f64,
        /// Whether a cell uses it.
        is_used: bool,
    },
    /// A spring is tied to a node that is not there.
    #[error("spring {spring} is tied to node {node}, but no cell uses such a node (there are {nodes}, counted from 0)")]
    Spring {
        /// The spring, from 0.
        spring: usize,
        /// What it is tied to.
        node: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// A surface point moves with nothing.
    #[error(
        "surface point {point} moves with cell {cell} of {cells} with weights that sum to {sum} and an area of {area}; weights must sum to 1 over the corners and be zero beyond, areas be positive"
    )]
    SurfacePoint {
        /// The point, from 0.
        point: usize,
        /// Its cell.
        cell: u32,
        /// Number of cells.
        cells: usize,
        /// Sum of its weights.
        sum: f64,
        /// Its area.
        area: f64,
    },
    /// An embedded spring moves with nothing, or has no stiffness.
    #[error(
        "spring {spring} moves with cell {cell} of {cells} with weights that sum to {sum}, a stiffness of {stiffness} N/m and the target {target:?}; weights must sum to 1 over the corners and be zero beyond, stiffnesses be finite and not negative, targets be finite"
    )]
    EmbeddedSpring {
        /// The spring, from 0.
        spring: usize,
        /// Its cell.
        cell: u32,
        /// Number of cells.
        cells: usize,
        /// Sum of its weights.
        sum: f64,
        /// Its stiffness.
        stiffness: f64,
        /// Its target \[m\].
        target: [f64; 3],
    },
    /// A ground under what lies in a plane.
    #[error("a horizontal ground cannot hold {dimension}, which keep z = 0; use tetrahedra")]
    Ground {
        /// What the mesh is made of.
        dimension: Dimension,
    },
    /// The cells have no energy.
    #[error(transparent)]
    Elasticity(#[from] SimplexElasticityError),
    /// The mesh has no surface for the ground to act on.
    #[error(transparent)]
    Boundary(#[from] BoundaryError),
    /// The nodes were not ordered.
    #[error(transparent)]
    Order(#[from] GraphOrderError),
    /// There is no linear system.
    #[error(transparent)]
    Solver(#[from] SolverError),
}

/// Refuses a list that is longer or shorter than the mesh needs.
pub(super) fn check_length(what: impl Into<String>, given: usize, needed: usize) -> Result<(), SimplexBodyError> {
    match given == needed {
        true => Ok(()),
        false => Err(SimplexBodyError::Length { what: what.into(), given, needed }),
    }
}

/// Refuses holds and loads that are not those of a mesh's nodes, and a ground under what lies in a plane.
pub(super) fn check_conditions(mesh: &SimplexMesh, conditions: &Conditions) -> Result<(), SimplexBodyError> {
    let (dimension, nodes) = (mesh.dimension(), mesh.nodes().len());
    for hold in &conditions.holds.0 {
        check_length(format!("the mask of {}", hold.name), hold.nodes.len(), nodes)?;
    }
    for (n, load) in conditions.loads.iter().enumerate() {
        check_length(format!("load {n}"), load.forces.len(), 3 * nodes)?;
    }
    match conditions.ground.is_some() && dimension != Dimension::Three {
        true => Err(SimplexBodyError::Ground { dimension }),
        false => Ok(()),
    }
}

/// Not a number where a corner has weight that the dimension does not have.
fn sum_of_weights(dimension: Dimension, weights: [f64; 4]) -> f64 {
    let (of_corners, beyond) = weights.split_at(dimension.corners());
    if beyond.iter().all(|weight| *weight == 0.0) { of_corners.iter().sum() } else { f64::NAN }
}

/// Refuses a surface point that moves with no cell.
pub(super) fn check_point(
    (dimension, cells): (Dimension, usize),
    point: usize,
    surface: &SurfacePoint,
) -> Result<(), SimplexBodyError> {
    let SurfacePoint { cell, weights, area } = *surface;
    let sum = sum_of_weights(dimension, weights);
    match (cell as usize) < cells && (sum - 1.0).abs() < 1e-6 && area > 0.0 && area.is_finite() {
        true => Ok(()),
        false => Err(SimplexBodyError::SurfacePoint { point, cell, cells, sum, area }),
    }
}

/// Refuses an embedded spring that moves with no cell or has no stiffness.
pub(super) fn check_spring(
    (dimension, cells): (Dimension, usize),
    spring: usize,
    embedded: &EmbeddedSpring,
) -> Result<(), SimplexBodyError> {
    let EmbeddedSpring { cell, weights, stiffness, target, .. } = *embedded;
    let sum = sum_of_weights(dimension, weights);
    let is_spring = stiffness >= 0.0 && stiffness.is_finite() && target.iter().all(|x| x.is_finite());
    match (cell as usize) < cells && (sum - 1.0).abs() < 1e-6 && is_spring {
        true => Ok(()),
        false => Err(SimplexBodyError::EmbeddedSpring { spring, cell, cells, sum, stiffness, target }),
    }
}
