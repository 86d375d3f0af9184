//! Fine cells of small displacement in an element that rotates: they measure the displacement in space.

use super::frame::{Columns, Frame, LocalCurvature};
use super::points::add_turning_force;
use crate::coarse::galerkin::{ROWS, add_congruence};
use crate::coarsening::COLUMNS;
use crate::element::CellMatrix;
use crate::fine::{CellVectors, SingleCell};
use crate::linalg::matrix3::{Matrix3, apply, apply_transposed, cross, product, skew};
use crate::material::Projection;

/// One cell: ½ u·K_e u with u_a = R z_a − X_a at its corners, z_a = X_a + (W v)_a. The translation of the element carries no force, so it is left out.
pub(super) struct LinearCell<'a> {
    /// Stiffness K_e for a factor of one, and the factor.
    pub stiffness: (&'a CellMatrix, f64),
    /// Corners X_a relative to the centre of the coarse cell \[m\].
    pub corners: [[f64; 3]; 8],
    /// (W v)_a \[m\].
    pub moved: CellVectors,
}

impl LinearCell<'_> {
    /// z_a.
    fn place(&self, a: usize) -> [f64; 3] {
        std::array::from_fn(|r| self.corners[a][r] + self.moved[r][a])
    }

    /// Energy \[J\], and its gradients at the corners in the rotated frame.
    pub fn energy(&self, frame: &Frame) -> (f64, CellVectors) {
        let (stiffness, factor) = self.stiffness;
        let mut u = [[0.0; 8]; 3];
        for a in 0..8 {
            let to = apply(&frame.rotation, &self.place(a));
            (0..3).for_each(|r| u[r][a] = to[r] - self.corners[a][r]);
        }
        let (energy, mut forces) = SingleCell::linear(factor, stiffness, &u);
        for a in 0..8 {
            let local = apply_transposed(&frame.rotation, &at_corner(&forces, a));
            (0..3).for_each(|r| forces[r][a] = local[r]);
        }
        (energy, forces)
    }

    /// What the cell's forces on its corners (rotated frame) add to θ; they add to g through Wᵀ.
    pub fn couple(&self, forces: &CellVectors) -> [f64; 3] {
        let mut couple = [0.0; 3];
        for a in 0..8 {
            let part = cross(&self.place(a), &at_corner(forces, a));
            (0..3).for_each(|k| couple[k] += part[k]);
        }
        couple
    }

    /// Adds to the second derivatives; `rows` are the 24 rows of W at the corners.
    pub fn add_curvature(
        &self,
        frame: &Frame,
        rows: &[Columns; COLUMNS],
        (forces, projection): (&CellVectors, Projection),
        curvature: &mut LocalCurvature,
    ) {
        let (stiffness, factor) = self.stiffness;
        // In space the corners move by R (W δv)_a and by −R [z_a]× w.
        let mut moving = [[0.0; COLUMNS]; COLUMNS];
        let mut turning = [[0.0; COLUMNS]; 3];
        for a in 0..8 {
            let lever = product(&frame.rotation, &skew(&self.place(a)));
            for (r, s) in (0..9).map(|n| (n / 3, n % 3)) {
                let cosine = frame.rotation[r][s];
                moving[3 * a + r].iter_mut().zip(&rows[3 * a + s]).for_each(|(m, w)| *m += cosine * w);
                turning[s][3 * a + r] = -lever[r][s];
            }
        }
        add_congruence::<COLUMNS, ROWS>(factor, stiffness, &moving, &mut curvature.stiffness);
        let pushed: [Columns; 3] = std::array::from_fn(|k| {
            std::array::from_fn(|n| {
                factor * (0..COLUMNS).map(|m| stiffness[COLUMNS * n + m] * turning[k][m]).sum::<f64>()
            })
        });
        for k in 0..3 {
            for (row, f) in moving.iter().zip(&pushed[k]) {
                curvature.mixed[k].iter_mut().zip(row).for_each(|(b, m)| *b += f * m);
            }
        }
        let entry = |k: usize, l: usize| turning[k].iter().zip(&pushed[l]).map(|(t, p)| t * p).sum::<f64>();
        let square: Matrix3 = std::array::from_fn(|k| std::array::from_fn(|l| entry(k.min(l), k.max(l))));
        (0..9).for_each(|n| curvature.rotational[n / 3][n % 3] += square[n / 3][n % 3]);
        if projection == Projection::Exact {
            for a in 0..8 {
                let functions = [rows[3 * a], rows[3 * a + 1], rows[3 * a + 2]];
                add_turning_force(&functions, self.place(a), &at_corner(forces, a), curvature);
            }
        }
    }
}

fn at_corner(vectors: &CellVectors, a: usize) -> [f64; 3] {
    [vectors[0][a], vectors[1][a], vectors[2][a]]
}
