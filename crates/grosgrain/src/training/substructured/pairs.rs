//! Which coarse cells are tied to each other at a node.

use crate::mesh::{Cell, Lattice};
use crate::partition::CoarseCell;

/// The ties at a node that the listed cells (ascending, at most eight, all corners of one node of the coarse lattice's dual) share: every pair that
/// shares a face, and where these leave groups of cells apart, the closest pairs that join the groups.
pub(super) fn pairs_at(coarse: &Lattice, cells: &[CoarseCell]) -> Vec<(CoarseCell, CoarseCell)> {
    let position = |c: CoarseCell| coarse.cell_position(Cell(c.0));
    let distance = |a: CoarseCell, b: CoarseCell| {
        let (a, b) = (position(a), position(b));
        (0..3).filter(|&i| a[i] != b[i]).count()
    };
    let mut group: Vec<usize> = (0..cells.len()).collect();
    let mut pairs = Vec::new();
    for steps in 1..=3 {
        for a in 0..cells.len() {
            for b in a + 1..cells.len() {
                let apart = group[a] != group[b];
                if distance(cells[a], cells[b]) == steps && (steps == 1 || apart) {
                    pairs.push((cells[a], cells[b]));
                    let (kept, gone) = (group[a].min(group[b]), group[a].max(group[b]));
                    group.iter_mut().filter(|g| **g == gone).for_each(|g| *g = kept);
                }
            }
        }
    }
    pairs
}

/// Splits forces `r` (one row of `columns` values per cell, summing to zero over the cells) into pairwise forces t_ab = −t_ba with
/// Σ_b t_ab = r_a of least norm: t_ab = φ_a − φ_b with the Laplacian of the graph of the pairs, L φ = r. Returns one row per pair.
pub(super) fn split(cells: &[CoarseCell], pairs: &[(CoarseCell, CoarseCell)], r: &[f64], columns: usize) -> Vec<f64> {
    let place = |c: CoarseCell| cells.iter().position(|x| *x == c).unwrap_or(0);
    let n = cells.len();
    // The graph is connected, so that L with the last cell held is positive definite: φ of that cell is zero.
    let m = n - 1;
    let mut laplacian = [[0.0; 8]; 8];
    for &(a, b) in pairs {
        let (a, b) = (place(a), place(b));
        laplacian[a][a] += 1.0;
        laplacian[b][b] += 1.0;
        laplacian[a][b] -= 1.0;
        laplacian[b][a] -= 1.0;
    }
    let mut phi = r.to_vec();
    for k in 0..m {
        for i in k + 1..m {
            let factor = laplacian[i][k] / laplacian[k][k];
            for j in k..m {
                laplacian[i][j] -= factor * laplacian[k][j];
            }
            (0..columns).for_each(|c| phi[columns * i + c] -= factor * phi[columns * k + c]);
        }
    }
    for k in (0..m).rev() {
        for c in 0..columns {
            let known: f64 = (k + 1..m).map(|j| laplacian[k][j] * phi[columns * j + c]).sum();
            phi[columns * k + c] = (phi[columns * k + c] - known) / laplacian[k][k];
        }
    }
    phi[columns * m..].fill(0.0);
    let row = |&(a, b): &(CoarseCell, CoarseCell)| {
        let (a, b) = (columns * place(a), columns * place(b));
        (0..columns).map(|c| phi[a + c] - phi[b + c]).collect::<Vec<f64>>()
    };
    pairs.iter().flat_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn pairwise_forces_are_the_least_that_add_up(mask in 1u32..256, seed in 0u32..1000) {
            let coarse = Lattice::new([2, 2, 2]);
            let cells: Vec<CoarseCell> = (0..8).filter(|c| mask >> c & 1 == 1).map(CoarseCell).collect();
            let pairs = pairs_at(&coarse, &cells);
            let mut r: Vec<f64> = (0..cells.len()).map(|i| f64::from(seed + 7).powi(i as i32 + 1).sin()).collect();
            let mean = r.iter().sum::<f64>() / r.len() as f64;
            r.iter_mut().for_each(|x| *x -= mean);
            let t = split(&cells, &pairs, &r, 1);
            for (i, cell) in cells.iter().enumerate() {
                let sum: f64 = pairs.iter().zip(&t).map(|((a, b), t)| if a == cell { *t } else if b == cell { -t } else { 0.0 }).sum();
                prop_assert!((sum - r[i]).abs() < 1e-12);
            }
            // Least norm: no circulation. Around every square of four cells the forces add to zero.
            let force = |a: CoarseCell, b: CoarseCell| pairs.iter().zip(&t).find_map(|(p, t)| {
                if *p == (a, b) { Some(*t) } else if *p == (b, a) { Some(-t) } else { None }
            });
            for (u, v) in [(1, 2), (1, 4), (2, 4)] {
                for start in 0..8 {
                    let loop_ = [start, start ^ u, start ^ u ^ v, start ^ v, start].map(CoarseCell);
                    let sides: Option<Vec<f64>> = loop_.windows(2).map(|w| force(w[0], w[1])).collect();
                    if let Some(sides) = sides {
                        prop_assert!(sides.iter().sum::<f64>().abs() < 1e-12);
                    }
                }
            }
        }
    }
}
