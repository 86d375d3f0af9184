//! The six rigid motions of a free body: the kernel of its stiffness.

use rayon::prelude::*;

use crate::linalg::{DenseCholesky, DenseCholeskyError, Projector, sum_of_blocks};
use crate::mesh::{Lattice, Node};

/// Removes the rigid motions of the active nodes of a lattice: v ← v − Q (QᵀQ)⁻¹ Qᵀ v.
///
/// The columns of Q are three translations and three linearised rotations about the mean position,
/// in units of cells times `spacing`; other nodes are left alone. The body must be one piece: each further
/// piece that hangs free adds six motions that are not removed.
#[derive(Clone, Debug)]
pub struct RigidMotions {
    lattice: Lattice,
    spacing: [f64; 3],
    centre: [f64; 3],
    scale: f64,
    active: Vec<bool>,
    gram: DenseCholesky,
}

impl RigidMotions {
    /// The rigid motions of the nodes marked in `active` of a lattice with edge lengths `spacing` \[m\].
    ///
    /// # Errors
    /// The active nodes lie on a line, so that the six motions are dependent.
    pub fn new(lattice: Lattice, spacing: [f64; 3], active: &[bool]) -> Result<Self, DenseCholeskyError> {
        let count = active.iter().filter(|a| **a).count() as f64;
        let extent = std::array::from_fn::<f64, 3, _>(|a| spacing[a] * lattice.cells[a] as f64);
        let scale = 1.0 / extent.iter().fold(0.0, |m: f64, e| m.max(*e));
        let mut motions =
            Self { lattice, spacing, centre: [0.0; 3], scale, active: active.to_vec(), gram: DenseCholesky::default() };
        motions.centre = motions.sum(&|n| motions.position(n)).map(|sum| sum / count);
        let gram: [f64; 36] = motions.sum(&|n| {
            let q = motions.motions(n);
            std::array::from_fn(|e| (0..3).map(|r| q[e / 6][r] * q[e % 6][r]).sum())
        });
        motions.gram = DenseCholesky::new(6, gram.to_vec())?;
        Ok(motions)
    }

    /// Σ over the active nodes.
    fn sum<const N: usize>(&self, term: &(dyn Fn(usize) -> [f64; N] + Sync)) -> [f64; N] {
        sum_of_blocks(self.active.len(), &|from, to| {
            let mut sum = [0.0; N];
            for n in (from..to).filter(|n| self.active[*n]) {
                sum.iter_mut().zip(term(n)).for_each(|(sum, term)| *sum += term);
            }
            sum
        })
    }

    fn position(&self, node: usize) -> [f64; 3] {
        let at = self.lattice.node_position(Node(node));
        std::array::from_fn(|a| self.spacing[a] * at[a] as f64 * self.scale - self.centre[a])
    }

    /// The rows of Qᵀ at a node.
    fn motions(&self, node: usize) -> [[f64; 3]; 6] {
        let [x, y, z] = self.position(node);
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    }
}

impl Projector for RigidMotions {
    fn project(&self, v: &mut [f64]) {
        let mut share: [f64; 6] = self.sum(&|n| self.motions(n).map(|q| (0..3).map(|r| q[r] * v[3 * n + r]).sum()));
        self.gram.solve_in_place(&mut share);
        v.par_chunks_mut(3).enumerate().with_min_len(4096).filter(|(n, _)| self.active[*n]).for_each(|(n, value)| {
            let q = self.motions(n);
            for (r, value) in value.iter_mut().enumerate() {
                *value -= (0..6).map(|m| share[m] * q[m][r]).sum::<f64>();
            }
        });
    }
}
