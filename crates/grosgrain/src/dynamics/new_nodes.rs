//! Motion of nodes that an edit has added: they go on rigidly with the known nodes around them, so that material that is added to a turned
//! body is not sheared by it.

use super::State;
use crate::linalg::matrix3::{IDENTITY, Matrix3, Svd3, apply, cross, inverse, product, svd, transposed};

/// Second singular value over the first below which nodes lie on a line and tell no rotation.
const ON_A_LINE: f64 = 1e-6;

/// Sets the motion of the nodes that are not `known` layer by layer, spreading from known to unknown: the mean of the known ones among those `around` a node
/// (that share a cell with it), turned as these and those around them have turned and turn. Nodes with nothing known around them stay as they
/// are. `rest` gives the undeformed place of a node \[m\].
pub(super) fn spread(
    state: &mut State,
    known: &mut [bool],
    mut unknown: Vec<usize>,
    around: &dyn Fn(usize) -> Vec<usize>,
    rest: &dyn Fn(usize) -> [f64; 3],
) {
    let known_around = |known: &[bool], node: usize| -> Vec<usize> {
        let mut nodes: Vec<usize> = around(node).into_iter().filter(|n| known[*n]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    };
    while !unknown.is_empty() {
        let mut found = Vec::new();
        for &node in &unknown {
            let near = known_around(known, node);
            if near.is_empty() {
                continue;
            }
            let mut support: Vec<usize> =
                near.iter().flat_map(|n| known_around(known, *n)).chain(near.clone()).collect();
            support.sort_unstable();
            support.dedup();
            found.push((node, rigid_motion(state, (&near, &support), rest, rest(node))));
        }
        if found.is_empty() {
            return;
        }
        for (node, [displacement, velocity]) in &found {
            state.displacement[3 * node..3 * node + 3].copy_from_slice(displacement);
            state.velocity[3 * node..3 * node + 3].copy_from_slice(velocity);
            known[*node] = true;
        }
        unknown.retain(|node| !known[*node]);
    }
}

/// Displacement and velocity at the undeformed place `at` of the rigid motion of `near` nodes that turns as the `support` does.
fn rigid_motion(
    state: &State,
    (near, support): (&[usize], &[usize]),
    rest: &dyn Fn(usize) -> [f64; 3],
    at: [f64; 3],
) -> [[f64; 3]; 2] {
    let displacement = |n: usize| [0, 1, 2].map(|r| state.displacement[3 * n + r]);
    let velocity = |n: usize| [0, 1, 2].map(|r| state.velocity[3 * n + r]);
    let place = |n: usize| sum(rest(n), displacement(n), 1.0);
    let (rotation, spin) = turn(support, rest, &place, &velocity);
    let (rest_centre, shift) = (mean(near, rest), mean(near, &displacement));
    let arm = sum(at, rest_centre, -1.0);
    let turned = apply(&rotation, &arm);
    let u = sum(shift, sum(turned, arm, -1.0), 1.0);
    [u, sum(mean(near, &velocity), cross(&spin, &turned), 1.0)]
}

/// How nodes have turned (the rotation closest to their motion, in the sense of least squares) and turn \[rad/s\].
fn turn(
    nodes: &[usize],
    rest: &dyn Fn(usize) -> [f64; 3],
    place: &dyn Fn(usize) -> [f64; 3],
    velocity: &dyn Fn(usize) -> [f64; 3],
) -> (Matrix3, [f64; 3]) {
    let (rest_centre, centre, drift) = (mean(nodes, rest), mean(nodes, place), mean(nodes, velocity));
    let (mut moved, mut inertia, mut momentum) = ([[0.0; 3]; 3], [[0.0; 3]; 3], [0.0; 3]);
    for &n in nodes {
        let (before, now) = (sum(rest(n), rest_centre, -1.0), sum(place(n), centre, -1.0));
        let square: f64 = now.iter().map(|x| x * x).sum();
        let swirl = cross(&now, &sum(velocity(n), drift, -1.0));
        for (i, j) in (0..9).map(|e| (e / 3, e % 3)) {
            moved[i][j] += now[i] * before[j];
            inertia[i][j] += square * IDENTITY[i][j] - now[i] * now[j];
        }
        (0..3).for_each(|i| momentum[i] += swirl[i]);
    }
    let Svd3 { left, values, right } = svd(&moved);
    if values[1].is_nan() || values[1] <= ON_A_LINE * values[0] {
        return (IDENTITY, [0.0; 3]);
    }
    let spin = inverse(&inertia).map_or([0.0; 3], |inverse| apply(&inverse, &momentum));
    (product(&left, &transposed(&right)), spin)
}

fn mean(nodes: &[usize], value: &dyn Fn(usize) -> [f64; 3]) -> [f64; 3] {
    let total = nodes.iter().fold([0.0; 3], |total, n| sum(total, value(*n), 1.0));
    total.map(|x| x / nodes.len() as f64)
}

fn sum(a: [f64; 3], b: [f64; 3], factor: f64) -> [f64; 3] {
    std::array::from_fn(|r| a[r] + factor * b[r])
}
