//! A fine mesh that moves with a coarse one.

use rayon::prelude::*;

use crate::simplex::{Locator, Place, SimplexMesh};

/// The barycentric map from coarse to fine: every fine node follows the coarse cell that holds it, u_j = Σ_i W_ji ū_i with the barycentric coordinates W, or up to
/// three closest cells by extrapolation where none does ([`Locator::locate`]).
///
/// Fields that are linear in place are reproduced exactly, so that forces that the transpose takes to the coarse nodes keep their sum and their moment.
#[derive(Clone, Debug, PartialEq)]
pub struct SimplexEmbedding {
    places: Vec<Place>,
    starts: Vec<usize>,
    entries: Vec<(u32, f64)>,
    coarse_nodes: usize,
}

impl SimplexEmbedding {
    /// Finds every node of `fine` in a coarse mesh.
    pub fn new(fine: &SimplexMesh, coarse: &Locator<'_>) -> Self {
        let places: Vec<Place> = fine.nodes().par_iter().map(|at| coarse.locate(*at)).collect();
        let (mut starts, mut entries) = (vec![0], Vec::with_capacity(4 * places.len()));
        for place in &places {
            let start = entries.len();
            for (node, weight) in place.weights(coarse.mesh()) {
                match entries[start..].iter_mut().find(|entry: &&mut (u32, f64)| entry.0 == node) {
                    Some(entry) => entry.1 += weight,
                    None => entries.push((node, weight)),
                }
            }
            starts.push(entries.len());
        }
        Self { places, starts, entries, coarse_nodes: coarse.mesh().nodes().len() }
    }

    /// Number of fine nodes.
    pub fn fine_nodes(&self) -> usize {
        self.places.len()
    }

    /// Number of coarse nodes.
    pub fn coarse_nodes(&self) -> usize {
        self.coarse_nodes
    }

    /// Where a fine node lies in the coarse mesh.
    pub fn place(&self, node: usize) -> &Place {
        &self.places[node]
    }

    /// The coarse cell that a fine node follows, the first where it follows several.
    pub fn cell(&self, node: usize) -> u32 {
        self.places[node].cells()[0].cell
    }

    /// The coarse nodes that a fine node follows, each once, and their weights W, Σ = 1.
    pub fn weights(&self, node: usize) -> &[(u32, f64)] {
        &self.entries[self.starts[node]..self.starts[node + 1]]
    }

    /// Fine nodes that no coarse cell holds, ascending.
    pub fn outside(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.places.len()).filter(|node| self.places[*node].outside)
    }

    /// How many times an error of coarse displacements may grow at a fine node, at most: max Σ share Σ |weight|, 1 where all are inside.
    pub fn worst_amplification(&self) -> f64 {
        self.places.iter().map(Place::amplification).fold(1.0, f64::max)
    }

    /// The fine displacement \[m\] of a coarse one, u = W ū, three entries per node.
    ///
    /// # Panics
    /// Panics when `coarse` has not three entries per coarse node.
    pub fn prolong(&self, coarse: &[f64]) -> Vec<f64> {
        assert_eq!(coarse.len(), 3 * self.coarse_nodes, "three entries per coarse node");
        let mut fine = vec![0.0; 3 * self.places.len()];
        fine.par_chunks_mut(3).enumerate().for_each(|(node, u)| {
            for &(from, weight) in self.weights(node) {
                (0..3).for_each(|r| u[r] += weight * coarse[3 * from as usize + r]);
            }
        });
        fine
    }

    /// The forces \[N\] on coarse nodes that do the work of forces on fine ones, f̄ = Wᵀ f, three entries per node.
    ///
    /// # Panics
    /// Panics when `fine` has not three entries per fine node.
    pub fn restrict(&self, fine: &[f64]) -> Vec<f64> {
        assert_eq!(fine.len(), 3 * self.places.len(), "three entries per fine node");
        let mut coarse = vec![0.0; 3 * self.coarse_nodes];
        for (node, force) in fine.chunks_exact(3).enumerate() {
            for &(to, weight) in self.weights(node) {
                (0..3).for_each(|r| coarse[3 * to as usize + r] += weight * force[r]);
            }
        }
        coarse
    }
}
