//! Trilinear prolongation between a lattice and the next coarser one, and its transpose.

use rayon::prelude::*;

use super::grid::{Coarsening, Layout};

/// P and Pᵀ; rows of P that belong to components which are no unknowns are zero.
pub(super) struct Transfer {
    pub coarsening: Coarsening,
    pub fine: Layout,
    pub coarse: Layout,
    /// Bit r of entry n: component r of fine node n is an unknown. `None`: all are.
    pub free: Option<Vec<u8>>,
}

impl Transfer {
    /// coarse = Pᵀ fine.
    pub fn restrict(&self, fine: &[f64], coarse: &mut [f64]) {
        let layout = self.coarse;
        coarse.par_chunks_mut(layout.strides[2]).skip(layout.ghost).take(layout.nodes[2]).enumerate().for_each(
            |(k, layer)| {
                for j in 0..layout.nodes[1] {
                    for i in 0..layout.nodes[0] {
                        let sum = self.gather_children(fine, [i, j, k]);
                        let at = layout.origin + i * layout.strides[0] + j * layout.strides[1];
                        (0..3).for_each(|r| layer[at + r * layout.component] = sum[r]);
                    }
                }
            },
        );
    }

    fn gather_children(&self, fine: &[f64], at: [usize; 3]) -> [f64; 3] {
        let children: [_; 3] = std::array::from_fn(|a| self.coarsening.children(a, at[a]));
        let mut sum = [0.0; 3];
        for (k, wz) in children[2].into_iter().filter(|c| c.1 > 0.0) {
            for (j, wy) in children[1].into_iter().filter(|c| c.1 > 0.0) {
                for (i, wx) in children[0].into_iter().filter(|c| c.1 > 0.0) {
                    let index = self.fine.index([i, j, k]);
                    let free = self.free([i, j, k]);
                    for (r, sum) in sum.iter_mut().enumerate() {
                        if free >> r & 1 == 1 {
                            *sum += wx * wy * wz * fine[index + r * self.fine.component];
                        }
                    }
                }
            }
        }
        sum
    }

    /// fine += P coarse.
    pub fn prolong(&self, coarse: &[f64], fine: &mut [f64]) {
        let layout = self.fine;
        fine.par_chunks_mut(layout.strides[2]).skip(layout.ghost).take(layout.nodes[2]).enumerate().for_each(
            |(k, layer)| {
                for j in 0..layout.nodes[1] {
                    for i in 0..layout.nodes[0] {
                        let value = self.interpolate(coarse, [i, j, k]);
                        let free = self.free([i, j, k]);
                        let at = layout.origin + i * layout.strides[0] + j * layout.strides[1];
                        for r in (0..3).filter(|r| free >> r & 1 == 1) {
                            layer[at + r * layout.component] += value[r];
                        }
                    }
                }
            },
        );
    }

    fn interpolate(&self, coarse: &[f64], at: [usize; 3]) -> [f64; 3] {
        let parents: [_; 3] = std::array::from_fn(|a| self.coarsening.parents(a, at[a]));
        let mut value = [0.0; 3];
        for (k, wz) in parents[2].into_iter().filter(|c| c.1 > 0.0) {
            for (j, wy) in parents[1].into_iter().filter(|c| c.1 > 0.0) {
                for (i, wx) in parents[0].into_iter().filter(|c| c.1 > 0.0) {
                    let index = self.coarse.index([i, j, k]);
                    for (r, value) in value.iter_mut().enumerate() {
                        *value += wx * wy * wz * coarse[index + r * self.coarse.component];
                    }
                }
            }
        }
        value
    }

    fn free(&self, at: [usize; 3]) -> u8 {
        self.free.as_ref().map_or(7, |free| free[self.coarsening.fine.node(at).0])
    }
}
