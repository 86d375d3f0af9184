//! The motion of a body.

use crate::mesh::{Lattice, Node};

/// Motion of the nodes of a body, three numbers each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Displacement \[m\].
    pub displacement: Vec<f64>,
    /// Velocity \[m/s\].
    pub velocity: Vec<f64>,
}

impl State {
    /// Rest, for this many nodes.
    pub fn rest(nodes: usize) -> Self {
        Self { displacement: vec![0.0; 3 * nodes], velocity: vec![0.0; 3 * nodes] }
    }

    /// ½ Σ m ‖v‖² \[J\].
    pub fn kinetic_energy(&self, mass: &[f64]) -> f64 {
        self.velocity.chunks_exact(3).zip(mass).map(|(v, m)| 0.5 * m * v.iter().map(|v| v * v).sum::<f64>()).sum()
    }

    /// Momentum Σ m v \[N s\], and angular momentum Σ m (X + u) × v \[N m s\] about the origin, of nodes at `rest_position` X.
    pub fn momenta(&self, mass: &[f64], rest_position: impl Fn(usize) -> [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let (mut linear, mut angular) = ([0.0; 3], [0.0; 3]);
        for (n, m) in mass.iter().enumerate().filter(|(_, m)| **m > 0.0) {
            let (rest, at) = (rest_position(n), 3 * n);
            let x: [f64; 3] = std::array::from_fn(|r| rest[r] + self.displacement[at + r]);
            let v: [f64; 3] = std::array::from_fn(|r| self.velocity[at + r]);
            let spin = crate::linalg::matrix3::cross(&x, &v);
            for r in 0..3 {
                linear[r] += m * v[r];
                angular[r] += m * spin[r];
            }
        }
        (linear, angular)
    }

    /// Takes a motion of the nodes of a fine lattice over to a body with other nodes: those that are none any more come to rest at zero, new
    /// ones move as the mean of the known ones around them, spreading from known to unknown.
    ///
    /// # Panics
    /// Panics when there is not an entry per node.
    pub fn carry(&mut self, lattice: Lattice, before: &[bool], after: &[bool]) {
        let mut known: Vec<bool> = before.iter().zip(after).map(|(before, after)| *before && *after).collect();
        for node in (0..known.len()).filter(|n| !known[*n]) {
            self.displacement[3 * node..3 * node + 3].fill(0.0);
            self.velocity[3 * node..3 * node + 3].fill(0.0);
        }
        let mut unknown: Vec<usize> = (0..known.len()).filter(|n| after[*n] && !known[*n]).collect();
        while !unknown.is_empty() {
            let near = |node: usize| -> Vec<usize> {
                let corners = lattice.cells_at(Node(node)).flat_map(|cell| lattice.corners(cell));
                corners.map(|n| n.0).filter(|n| known[*n]).collect()
            };
            let found: Vec<(usize, Vec<usize>)> =
                unknown.iter().map(|n| (*n, near(*n))).filter(|(_, near)| !near.is_empty()).collect();
            if found.is_empty() {
                return;
            }
            for (node, near) in &found {
                for field in [&mut self.displacement, &mut self.velocity] {
                    for r in 0..3 {
                        field[3 * node + r] = near.iter().map(|n| field[3 * n + r]).sum::<f64>() / near.len() as f64;
                    }
                }
            }
            found.iter().for_each(|(node, _)| known[*node] = true);
            unknown.retain(|node| !known[*node]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_nodes_move_with_their_neighbours_and_old_ones_are_forgotten() {
        let lattice = Lattice::new([4, 1, 1]);
        let column = |n: usize| lattice.node_position(Node(n))[0];
        let nodes = lattice.node_count();
        let before: Vec<bool> = (0..nodes).map(|n| column(n) <= 2).collect();
        let after: Vec<bool> = (0..nodes).map(|n| column(n) >= 1).collect();
        let mut state = State::rest(nodes);
        for n in (0..nodes).filter(|n| before[*n]) {
            state.displacement[3 * n] = column(n) as f64;
            state.velocity[3 * n + 2] = 5.0;
        }
        state.carry(lattice, &before, &after);
        for n in 0..nodes {
            let expected = [0.0, 1.0, 2.0, 2.0, 2.0][column(n)];
            assert_eq!(state.displacement[3 * n], expected, "column {}", column(n));
            assert_eq!(state.velocity[3 * n + 2], if column(n) == 0 { 0.0 } else { 5.0 });
        }
    }
}
