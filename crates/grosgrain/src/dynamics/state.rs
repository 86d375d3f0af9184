//! The motion of a body.

use super::new_nodes::spread;
use crate::mesh::{Lattice, Node};
use crate::partition::CoarseMesh;

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

    /// Takes a motion of the nodes of a fine lattice with cells of edges `spacing` \[m\] over to a body with other nodes: those that are none any
    /// more come to rest at zero, new ones move rigidly with the known ones around them, spreading from known to unknown.
    ///
    /// # Panics
    /// Panics when there is not an entry per node.
    pub fn carry(&mut self, (lattice, spacing): (Lattice, [f64; 3]), before: &[bool], after: &[bool]) {
        let mut known: Vec<bool> = before.iter().zip(after).map(|(before, after)| *before && *after).collect();
        for node in (0..known.len()).filter(|n| !known[*n]) {
            self.displacement[3 * node..3 * node + 3].fill(0.0);
            self.velocity[3 * node..3 * node + 3].fill(0.0);
        }
        let unknown: Vec<usize> = (0..known.len()).filter(|n| after[*n] && !known[*n]).collect();
        let around = |node: usize| -> Vec<usize> {
            lattice.cells_at(Node(node)).flat_map(|cell| lattice.corners(cell)).map(|n| n.0).collect()
        };
        spread(self, &mut known, unknown, &around, &|node| place(lattice, spacing, Node(node)));
    }

    /// Takes a motion of the vertices of the mesh `before` over to those of `after` as [`CoarseMesh::carry`] does; where material is new, its vertices
    /// move rigidly with the known ones around them. `spacing` are the edges of coarse cells \[m\].
    ///
    /// # Panics
    /// As [`CoarseMesh::carry`].
    pub fn carry_vertices(&mut self, before: &CoarseMesh, after: &CoarseMesh, spacing: [f64; 3]) {
        self.displacement = after.carry(before, &self.displacement);
        self.velocity = after.carry(before, &self.velocity);
        let mut known: Vec<bool> =
            after.vertices().iter().map(|vertex| before.vertices_at(vertex.node).next().is_some()).collect();
        let unknown: Vec<usize> = (0..known.len()).filter(|n| !known[*n]).collect();
        if unknown.is_empty() {
            return;
        }
        let mut neighbours = vec![Vec::new(); known.len()];
        for corners in after.corners() {
            for vertex in corners {
                neighbours[*vertex as usize].extend(corners.iter().map(|v| *v as usize));
            }
        }
        let lattice = after.partition().coarse();
        let rest = |vertex: usize| place(lattice, spacing, Node(after.vertices()[vertex].node.0));
        spread(self, &mut known, unknown, &|vertex| neighbours[vertex].clone(), &rest);
    }
}

fn place(lattice: Lattice, spacing: [f64; 3], node: Node) -> [f64; 3] {
    let at = lattice.node_position(node);
    std::array::from_fn(|r| spacing[r] * at[r] as f64)
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
        state.carry((lattice, [1.0; 3]), &before, &after);
        for n in 0..nodes {
            let expected = [0.0, 1.0, 2.0, 2.0, 2.0][column(n)];
            assert!((state.displacement[3 * n] - expected).abs() < 1e-14, "column {}", column(n));
            assert_eq!(state.velocity[3 * n + 2], if column(n) == 0 { 0.0 } else { 5.0 });
        }
    }

    /// Displacement and velocity of a rigid motion that has turned by 70° about z and spins.
    fn rigid(x: [f64; 3]) -> [[f64; 3]; 2] {
        let (sine, cosine) = 70f64.to_radians().sin_cos();
        let now = [cosine * x[0] - sine * x[1] + 0.3, sine * x[0] + cosine * x[1] - 0.1, x[2] + 2.0];
        [std::array::from_fn(|r| now[r] - x[r]), [1.0 - 5.0 * now[1], 2.0 + 5.0 * now[0], 3.0]]
    }

    #[test]
    fn new_nodes_of_a_body_that_turns_go_on_with_it() {
        let (lattice, spacing) = (Lattice::new([6, 2, 2]), [0.5, 1.0, 2.0]);
        let nodes = lattice.node_count();
        let column = |n: usize| lattice.node_position(Node(n))[0];
        // A single layer of nodes is known: enough for a rotation.
        for known in [1, 3] {
            let before: Vec<bool> = (0..nodes).map(|n| column(n) < known).collect();
            let mut state = State::rest(nodes);
            for n in (0..nodes).filter(|n| before[*n]) {
                let [u, v] = rigid(place(lattice, spacing, Node(n)));
                state.displacement[3 * n..3 * n + 3].copy_from_slice(&u);
                state.velocity[3 * n..3 * n + 3].copy_from_slice(&v);
            }
            state.carry((lattice, spacing), &before, &vec![true; nodes]);
            for n in 0..nodes {
                let [u, v] = rigid(place(lattice, spacing, Node(n)));
                for r in 0..3 {
                    assert!((state.displacement[3 * n + r] - u[r]).abs() < 1e-12, "{known}: column {}", column(n));
                    assert!((state.velocity[3 * n + r] - v[r]).abs() < 1e-11, "{known}: column {}", column(n));
                }
            }
        }
    }

    #[test]
    fn new_vertices_of_a_mesh_that_turns_go_on_with_it() -> Result<(), crate::partition::PartitionError> {
        let partition = crate::partition::Partition::new(Lattice::new([8, 4, 4]), 2)?;
        let fine = partition.fine();
        let mesh = |most: usize| {
            let void = |c: usize| fine.cell_position(crate::mesh::Cell(c))[0] >= most;
            CoarseMesh::new(&(0..fine.cell_count()).map(void).collect::<Vec<_>>(), &partition)
        };
        let (before, after, spacing) = (mesh(4), mesh(8), [0.5, 1.0, 2.0]);
        let motion = |mesh: &CoarseMesh| -> State {
            let at = |v: &crate::partition::Vertex| rigid(place(partition.coarse(), spacing, Node(v.node.0)));
            let all: Vec<[[f64; 3]; 2]> = mesh.vertices().iter().map(at).collect();
            State {
                displacement: all.iter().flat_map(|[u, _]| *u).collect(),
                velocity: all.iter().flat_map(|[_, v]| *v).collect(),
            }
        };
        let mut state = motion(&before);
        state.carry_vertices(&before, &after, spacing);
        let expected = motion(&after);
        let far = |found: &[f64], expected: &[f64]| found.iter().zip(expected).any(|(f, e)| (f - e).abs() > 1e-11);
        assert!(state.displacement.len() == 3 * 45 && !far(&state.displacement, &expected.displacement));
        assert!(!far(&state.velocity, &expected.velocity));
        Ok(())
    }
}
