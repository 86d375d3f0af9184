//! Which boundary faces form a closed shell.

use super::boundary::{BoundaryFace, BranchingRidge};
use super::{Dimension, SimplexMesh};
use crate::linalg::DisjointSets;
use crate::linalg::matrix3::{cross, dot};
use rayon::prelude::*;

/// A face at an edge (three dimensions) or node (two dimensions) of the boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Wing {
    /// The ridge, smaller node first; a node twice.
    ridge: [u32; 2],
    face: u32,
    /// The node of the face that is not in the ridge.
    tip: u32,
    /// Whether the void comes after the face on a turn around the ridge: about its direction, or about z.
    void_after: bool,
}

/// The shell of each face, how many there are, and where more than two faces meet.
pub(super) fn shells(mesh: &SimplexMesh, faces: &[BoundaryFace]) -> (Vec<u32>, usize, Vec<BranchingRidge>) {
    if mesh.dimension() == Dimension::One {
        return pieces_of_a_line(mesh, faces);
    }
    let mut wings: Vec<Wing> =
        faces.iter().zip(0..).flat_map(|(face, number)| wings_of(face.nodes(), number)).collect();
    wings.par_sort_unstable();
    let mut sets = DisjointSets::new(faces.len());
    let mut branching = Vec::new();
    for ridge in wings.chunk_by_mut(|a, b| a.ridge == b.ridge) {
        if ridge.len() > 2 {
            branching.push(BranchingRidge { nodes: ridge[0].ridge, faces: ridge.len() });
            sort_around(mesh, ridge);
        }
        // Each void lies between a face that it comes after and the next one around the ridge that it comes before.
        for n in 0..ridge.len() {
            let mut others = (1..ridge.len()).map(|k| ridge[(n + k) % ridge.len()]);
            if let Some(next) =
                others.find(|other| other.void_after != ridge[n].void_after).filter(|_| ridge[n].void_after)
            {
                sets.unite(ridge[n].face, next.face);
            }
        }
    }
    let (numbers, count) = sets.numbered();
    (numbers, count, branching)
}

fn wings_of(nodes: &[u32], face: u32) -> impl Iterator<Item = Wing> {
    let wing = |from: u32, to: u32, tip: u32| {
        let forward = from < to;
        Some(Wing { ridge: if forward { [from, to] } else { [to, from] }, face, tip, void_after: forward })
    };
    let wings = match *nodes {
        [a, b, c] => [wing(a, b, c), wing(b, c, a), wing(c, a, b)],
        // The void lies to the right of the way from a to b: clockwise of it as seen from a, against the clock as seen from b.
        [a, b] => [
            Some(Wing { ridge: [a, a], face, tip: b, void_after: false }),
            Some(Wing { ridge: [b, b], face, tip: a, void_after: true }),
            None,
        ],
        _ => [None; 3],
    };
    wings.into_iter().flatten()
}

/// Sorts the faces at a ridge by their angles; of two at one angle (the lips of a crack) the one before the void comes first.
fn sort_around(mesh: &SimplexMesh, wings: &mut [Wing]) {
    let place = |node: u32| mesh.nodes()[node as usize];
    let minus = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|r| a[r] - b[r]) };
    let origin = place(wings[0].ridge[0]);
    let mut axis = minus(place(wings[0].ridge[1]), origin);
    if axis == [0.0; 3] {
        axis = [0.0, 0.0, 1.0];
    }
    let first = cross(&cross(&axis, &minus(place(wings[0].tip), origin)), &axis);
    let second = cross(&axis, &first);
    let scale = dot(&axis, &axis).sqrt();
    let angle = |wing: &Wing| {
        let out = minus(place(wing.tip), origin);
        dot(&second, &out).atan2(scale * dot(&first, &out))
    };
    wings.sort_by(|a, b| angle(a).total_cmp(&angle(b)).then(b.void_after.cmp(&a.void_after)));
}

/// On a line, each piece of connected segments has two ends.
fn pieces_of_a_line(mesh: &SimplexMesh, faces: &[BoundaryFace]) -> (Vec<u32>, usize, Vec<BranchingRidge>) {
    let mut sets = DisjointSets::new(mesh.nodes().len());
    (0..mesh.cell_count()).for_each(|cell| sets.unite(mesh.cell(cell)[0], mesh.cell(cell)[1]));
    let (pieces, count) = sets.numbered();
    let mut shells = vec![None; count];
    let mut known = 0;
    let shell_of = |face: &BoundaryFace| {
        *shells[pieces[face.nodes()[0] as usize] as usize].get_or_insert_with(|| {
            known += 1;
            known - 1
        })
    };
    let numbers = faces.iter().map(shell_of).collect();
    (numbers, known as usize, Vec::new())
}
