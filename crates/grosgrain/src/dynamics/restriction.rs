//! What acts on a fine mesh, for a coarse mesh that carries it.

use super::{Conditions, EmbeddedSpring, Hold, Holds, SurfacePoint, TimedLoad};
use crate::homogenization::SimplexEmbedding;
use crate::simplex::{BoundaryError, SimplexMesh};

/// Weights that differ by less than this are equally large: coordinates come rounded.
const EQUAL: f64 = 1e-9;

/// What acts on a coarse mesh: conditions on its nodes, and on points that move with its cells. For
/// [`SimplexBody::new`](super::SimplexBody::new), [`with_springs`](super::SimplexBody::with_springs) and [`with_surface`](super::SimplexBody::with_surface).
#[derive(Clone, Debug, PartialEq)]
pub struct RestrictedConditions {
    /// Holds, loads and ground; no springs.
    pub conditions: Conditions,
    /// The springs.
    pub springs: Vec<EmbeddedSpring>,
    /// Where the ground acts; empty without ground.
    pub surface: Vec<SurfacePoint>,
}

/// The conditions of a fine mesh on a coarse one in which it is embedded.
///
/// * A coarse node is held where it has the largest weight in the place of a held fine node, and moves as the hold says for its own place. Of coarse nodes with equal weights one is held, one
///   that is held anyway if there is one. Where the meshes are nested, coarse and fine nodes of the same faces are held.
/// * Loads do the same work: f̄ = Wᵀ f. Their sum and moment stay.
/// * A spring pulls at the place of its fine node; outside of all coarse cells each that the node follows carries its share of the stiffness. So does the ground, see
///   [`SurfacePoint::embedded`].
///
/// # Errors
/// A ground below a fine mesh whose faces do not divide inside from outside.
///
/// # Panics
/// Panics when conditions, embedding and meshes do not belong together.
pub fn restrict_conditions(
    conditions: &Conditions,
    fine: &SimplexMesh,
    embedding: &SimplexEmbedding,
    coarse: &SimplexMesh,
) -> Result<RestrictedConditions, BoundaryError> {
    let hold = |hold: &Hold| Hold { nodes: held_nodes(embedding, &hold.nodes), ..hold.clone() };
    let load = |load: &TimedLoad| TimedLoad { forces: embedding.restrict(&load.forces), schedule: load.schedule };
    let mut springs = Vec::new();
    for spring in &conditions.springs {
        let homes = embedding.place(spring.node.0).cells().iter();
        springs.extend(homes.map(|home| EmbeddedSpring {
            cell: home.cell,
            weights: home.weights,
            stiffness: home.share * spring.stiffness,
            target: spring.target,
            schedule: spring.schedule,
        }));
    }
    let surface = match conditions.ground {
        Some(_) => SurfacePoint::embedded(fine, coarse)?,
        None => Vec::new(),
    };
    let conditions = Conditions {
        holds: Holds(conditions.holds.0.iter().map(hold).collect()),
        loads: conditions.loads.iter().map(load).collect(),
        springs: Vec::new(),
        ground: conditions.ground,
    };
    Ok(RestrictedConditions { conditions, springs, surface })
}

/// Which coarse nodes have the largest weight in the place of a held fine node.
fn held_nodes(embedding: &SimplexEmbedding, held: &[bool]) -> Vec<bool> {
    let mut nodes = vec![false; embedding.coarse_nodes()];
    let mut undecided = Vec::new();
    assert_eq!(held.len(), embedding.fine_nodes(), "one mark per fine node");
    for node in (0..held.len()).filter(|node| held[*node]) {
        let largest = largest(embedding.weights(node));
        match largest.as_slice() {
            [only] => nodes[*only] = true,
            _ => undecided.push(largest),
        }
    }
    for equal in undecided {
        if !equal.iter().any(|node| nodes[*node]) {
            equal.first().into_iter().for_each(|node| nodes[*node] = true);
        }
    }
    nodes
}

/// The coarse nodes with the largest weight, ascending.
fn largest(weights: &[(u32, f64)]) -> Vec<usize> {
    let most = weights.iter().map(|(_, weight)| *weight).fold(f64::NEG_INFINITY, f64::max);
    let mut nodes: Vec<usize> =
        weights.iter().filter(|(_, weight)| *weight >= most - EQUAL).map(|(node, _)| *node as usize).collect();
    nodes.sort_unstable();
    nodes
}
