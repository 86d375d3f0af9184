//! What holds the parts of a body.

use super::HarmonicError;
use super::parts::{NO_PART, Parts};
use super::system::Holding;
use crate::linalg::matrix3::{cross, dot};
use crate::simplex::{Dimension, SimplexMesh};
use crate::solver::six_components_among;

/// Held nodes of a part whose distances from one line are below this share of the longest of them leave it to turn.
const ON_A_LINE: f64 = 1e-6;

/// Held components, and which parts nothing holds but the few components that choose a rigid motion.
#[derive(Debug)]
pub(super) struct Supports {
    pub(super) fixed: Vec<[bool; 3]>,
    pub(super) free: Vec<bool>,
    pub(super) holding: Holding,
}

impl Supports {
    /// Holds the marked nodes; a part without marked nodes by as few components as exclude its rigid motions.
    pub(super) fn new(mesh: &SimplexMesh, parts: &Parts, held: &[bool]) -> Result<Self, HarmonicError> {
        let mut nodes_of = vec![Vec::new(); parts.count()];
        for (node, part) in parts.of_node.iter().enumerate().filter(|(_, part)| **part != NO_PART) {
            nodes_of[*part as usize].push(node);
        }
        let is_held = |node: &usize| held.get(*node).copied().unwrap_or(false);
        let mut fixed: Vec<[bool; 3]> = (0..mesh.nodes().len()).map(|node| [is_held(&node); 3]).collect();
        let (mut free, mut holding) = (Vec::with_capacity(parts.count()), Holding::Complete);
        for (nodes, first_cell) in nodes_of.iter().zip(&parts.first_cells) {
            let of_part: Vec<usize> = nodes.iter().copied().filter(is_held).collect();
            free.push(of_part.is_empty());
            match of_part.as_slice() {
                // A mechanism is left to the shift, which disturbs all its motions alike.
                [] if parts.has_hinges => holding = Holding::Incomplete,
                [] => match fewest(mesh, nodes) {
                    Some(components) => components.iter().for_each(|(node, r)| fixed[*node][*r] = true),
                    None => holding = Holding::Incomplete,
                },
                held if excludes_turns(mesh, held) => {}
                held => {
                    return Err(HarmonicError::Turns { held: held.len(), nodes: nodes.len(), cell: *first_cell });
                }
            }
        }
        if parts.has_hinges {
            holding = Holding::Incomplete;
        }
        Ok(Self { fixed, free, holding })
    }
}

/// As few components of nodes of a part as exclude its rigid motions.
fn fewest(mesh: &SimplexMesh, nodes: &[usize]) -> Option<Vec<(usize, usize)>> {
    match mesh.dimension() {
        Dimension::One => nodes.first().map(|node| vec![(*node, 0)]),
        Dimension::Two => {
            let first = *nodes.first()?;
            let last = farthest(mesh, nodes, first);
            let arm = difference(mesh, last, first);
            Some(vec![(first, 0), (first, 1), (last, usize::from(arm[0].abs() > arm[1].abs()))])
        }
        Dimension::Three => six_components_among(nodes, |node| mesh.nodes()[node]).map(|six| six.to_vec()),
    }
}

/// Whether a body whose held nodes these are, at least one, cannot turn.
fn excludes_turns(mesh: &SimplexMesh, held: &[usize]) -> bool {
    let last = farthest(mesh, held, held[0]);
    let line = difference(mesh, last, held[0]);
    match mesh.dimension() {
        Dimension::One => true,
        Dimension::Two => last != held[0],
        Dimension::Three => held.iter().any(|node| {
            let area = cross(&line, &difference(mesh, *node, held[0]));
            dot(&area, &area).sqrt() > ON_A_LINE * dot(&line, &line)
        }),
    }
}

fn farthest(mesh: &SimplexMesh, nodes: &[usize], from: usize) -> usize {
    let mut best = (from, 0.0);
    for node in nodes {
        let arm = difference(mesh, *node, from);
        let square = dot(&arm, &arm);
        if square > best.1 {
            best = (*node, square);
        }
    }
    best.0
}

fn difference(mesh: &SimplexMesh, a: usize, b: usize) -> [f64; 3] {
    std::array::from_fn(|r| mesh.nodes()[a][r] - mesh.nodes()[b][r])
}
