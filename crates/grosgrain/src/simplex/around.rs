//! Which cells of a mesh meet at each node.

use super::SimplexMesh;

/// The cells around each node of a mesh, ascending, in compressed rows.
#[derive(Clone, Debug)]
pub(crate) struct CellsAround {
    starts: Vec<usize>,
    cells: Vec<u32>,
}

impl CellsAround {
    pub(crate) fn new(mesh: &SimplexMesh) -> Self {
        let mut starts = vec![0; mesh.nodes().len() + 1];
        (0..mesh.cell_count()).flat_map(|cell| mesh.cell(cell)).for_each(|node| starts[*node as usize + 1] += 1);
        (1..starts.len()).for_each(|n| starts[n] += starts[n - 1]);
        let (mut next, mut cells) = (starts.clone(), vec![0; starts[starts.len() - 1]]);
        for (cell, node) in (0..mesh.cell_count()).flat_map(|cell| mesh.cell(cell).iter().map(move |node| (cell, node)))
        {
            cells[next[*node as usize]] = cell as u32;
            next[*node as usize] += 1;
        }
        Self { starts, cells }
    }

    /// Number of nodes.
    pub(crate) fn nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// None around a node that no cell uses.
    pub(crate) fn of(&self, node: usize) -> &[u32] {
        &self.cells[self.starts[node]..self.starts[node + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Dimension, SimplexMesh};
    use super::*;

    #[test]
    fn cells_stand_around_each_of_their_nodes_in_order() {
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0, 5.0, 0.0], [1.0, 1.0, 0.0]];
        let mesh = SimplexMesh::new(Dimension::Two, nodes, vec![[0, 1, 2, 0], [1, 4, 2, 0]], vec![0; 2]).unwrap();
        let around = CellsAround::new(&mesh);
        let found: Vec<&[u32]> = (0..around.nodes()).map(|node| around.of(node)).collect();
        assert_eq!(found, [&[0][..], &[0, 1], &[0, 1], &[], &[1]]);
    }
}
