//! How to hold a free body so that only the rigid part of its solution is chosen.

use super::Support;
use crate::assembly::Constraints;
use crate::mesh::{Components, Lattice, Neighbourhood, Node};

/// A support for a free body under loads in equilibrium: six statically determinate components when the solid cells are
/// one face-connected part, else [`Support::Free`].
pub fn free_support(lattice: Lattice, spacing: [f64; 3], void: &[bool], active: &[bool]) -> Support {
    let one_part = void.iter().all(|v| !v) || Components::new(void, &lattice, Neighbourhood::Faces).count() == 1;
    if one_part {
        {
            let mut constraints = Constraints::none(active.len());
            for (node, component) in six_components(lattice, spacing, active).into_iter().flatten() {
                constraints.fix(node.0, component);
            }
            Support::Constraints(constraints)
        }
    } else {
        Support::Free
    }
}

/// Six components that exclude every rigid motion of the marked nodes and nothing else: all of a node A, two of the node B farthest
/// from it, one of the node C farthest from their line. `None` if all nodes lie on one line.
pub fn six_components(lattice: Lattice, spacing: [f64; 3], marked: &[bool]) -> Option<[(Node, usize); 6]> {
    let position = |n: usize| -> [f64; 3] {
        let at = lattice.node_position(Node(n));
        std::array::from_fn(|a| at[a] as f64 * spacing[a])
    };
    let marked: Vec<usize> = (0..marked.len()).filter(|&n| marked[n]).collect();
    Some(six_components_among(&marked, position)?.map(|(node, component)| (Node(node), component)))
}

/// [`six_components`] of any nodes with these positions.
pub fn six_components_among(nodes: &[usize], position: impl Fn(usize) -> [f64; 3]) -> Option<[(usize, usize); 6]> {
    let farthest = |measure: &dyn Fn([f64; 3]) -> f64| {
        nodes.iter().fold((0, f64::NEG_INFINITY), |best, &n| {
            let value = measure(position(n));
            if value > best.1 { (n, value) } else { best }
        })
    };
    let a = *nodes.first()?;
    let from_a = |x: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| x[i] - position(a)[i]) };
    let (b, _) = farthest(&|x| square(from_a(x)));
    let line = from_a(position(b));
    let (c, _) = farthest(&|x| square(cross(line, from_a(x))));
    let turn = cross(line, from_a(position(c)));
    if square(turn) <= 1e-18 * square(line).powi(2) {
        return None;
    }
    let [first, second] = [[1, 2], [0, 2], [0, 1]][largest(line)];
    let of_a = [0, 1, 2].map(|r| (a, r));
    Some([of_a[0], of_a[1], of_a[2], (b, first), (b, second), (c, largest(turn))])
}

fn square(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum()
}

fn largest(v: [f64; 3]) -> usize {
    (1..3).fold(0, |best, i| if v[i].abs() > v[best].abs() { i } else { best })
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
