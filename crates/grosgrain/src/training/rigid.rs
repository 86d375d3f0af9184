//! Rigid motions of a box of nodes.

use crate::mesh::{Lattice, Node};

/// Removes the rigid part (least squares over the marked nodes) from a displacement of 3 entries per lattice node.
///
/// With x̄ the mean position, the rotation solves the 3×3 system Σ (|r|² I − r rᵀ) ω = Σ r × u, r = x − x̄; a direction
/// without inertia (nodes on a line) is left alone.
pub fn remove_rigid_motion(lattice: Lattice, spacing: [f64; 3], active: &[bool], u: &mut [f64]) {
    let nodes: Vec<(usize, [f64; 3])> = (0..lattice.node_count())
        .filter(|&n| active[n])
        .map(|n| {
            let at = lattice.node_position(Node(n));
            (n, std::array::from_fn(|a| at[a] as f64 * spacing[a]))
        })
        .collect();
    if nodes.is_empty() {
        return;
    }
    let count = nodes.len() as f64;
    let mean: [f64; 3] = std::array::from_fn(|a| nodes.iter().map(|(_, x)| x[a]).sum::<f64>() / count);
    let shift: [f64; 3] = std::array::from_fn(|a| nodes.iter().map(|(n, _)| u[3 * n + a]).sum::<f64>() / count);
    let (mut inertia, mut moment) = ([[0.0; 3]; 3], [0.0; 3]);
    for (n, x) in &nodes {
        let r: [f64; 3] = std::array::from_fn(|a| x[a] - mean[a]);
        let square: f64 = r.iter().map(|v| v * v).sum();
        for a in 0..3 {
            inertia[a][a] += square;
            (0..3).for_each(|b| inertia[a][b] -= r[a] * r[b]);
        }
        let turn = cross(r, std::array::from_fn(|a| u[3 * n + a] - shift[a]));
        (0..3).for_each(|a| moment[a] += turn[a]);
    }
    let omega = solve_symmetric(inertia, moment);
    for (n, x) in &nodes {
        let turn = cross(omega, std::array::from_fn(|a| x[a] - mean[a]));
        (0..3).for_each(|a| u[3 * n + a] -= shift[a] + turn[a]);
    }
}

/// a × b.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Solves a positive semidefinite 3×3 system by elimination with diagonal pivots; directions without a pivot get zero.
pub fn solve_symmetric(mut a: [[f64; 3]; 3], mut b: [f64; 3]) -> [f64; 3] {
    let scale = (0..3).fold(0.0f64, |m, i| m.max(a[i][i]));
    let mut pivots = Vec::with_capacity(3);
    while pivots.len() < 3 {
        let free = (0..3).filter(|i| !pivots.contains(i));
        let Some(p) = free.max_by(|&i, &j| a[i][i].total_cmp(&a[j][j])) else { break };
        if a[p][p] <= 1e-12 * scale {
            break;
        }
        pivots.push(p);
        for i in (0..3).filter(|i| !pivots.contains(i)) {
            let factor = a[i][p] / a[p][p];
            (0..3).for_each(|j| a[i][j] -= factor * a[p][j]);
            b[i] -= factor * b[p];
        }
    }
    let mut x = [0.0; 3];
    for (k, &p) in pivots.iter().enumerate().rev() {
        let known: f64 = pivots[k + 1..].iter().map(|&q| a[p][q] * x[q]).sum();
        x[p] = (b[p] - known) / a[p][p];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rigid_motion_is_removed_entirely_and_twice_removing_changes_nothing() {
        let lattice = Lattice::new([2, 3, 1]);
        let active: Vec<bool> = (0..lattice.node_count()).map(|n| n % 4 != 1).collect();
        let spacing = [0.1, 0.2, 0.7];
        let mut u = vec![0.0; 3 * lattice.node_count()];
        for n in 0..lattice.node_count() {
            let at = lattice.node_position(Node(n));
            let turn = cross([0.3, -0.2, 0.5], std::array::from_fn(|a| at[a] as f64 * spacing[a]));
            (0..3).for_each(|a| u[3 * n + a] = turn[a] + [1.0, 2.0, 3.0][a]);
        }
        remove_rigid_motion(lattice, spacing, &active, &mut u);
        for n in (0..lattice.node_count()).filter(|&n| active[n]) {
            (0..3).for_each(|a| assert!(u[3 * n + a].abs() < 1e-14, "{}", u[3 * n + a]));
        }
    }
}
