//! Dead loads on fine nodes, as constants of an element.

use super::frame::{Columns, Frame, LocalCurvature, LocalForces};
use super::place::Place;
use super::points::add_turning_moment;
use crate::coarse::{CoarseModel, Embedding};
use crate::coarsening::COLUMNS;
use crate::linalg::matrix3::{Matrix3, dot, product};
use crate::mesh::Node;

/// Forces f_j that keep their direction, on fine nodes that move with the element. Their energy is −Σ_j f_j · (t + R z_j − X_j) with the
/// mean displacement t and z_j = X_j + M_j v. It depends on T(v) = Σ_j z_j ⊗ f_j, which is affine in v, so its cost does not depend on the number of nodes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DeadLoad {
    /// Σ_j X_j ⊗ f_j \[N m\].
    moment: Matrix3,
    /// Row 3 r + s: Σ_j (row r of M_j) f_j,s \[N\].
    lever: [Columns; 9],
    /// Σ_j X_j · f_j \[N m\].
    at_rest: f64,
    /// Σ_j f_j \[N\].
    resultant: [f64; 3],
}

impl DeadLoad {
    /// The load of element number `index`; `None` where it has none.
    pub fn new(
        (coarse, place): (&CoarseModel, &Place),
        embedding: &Embedding<'_>,
        index: usize,
        loads: &[f64],
    ) -> Option<Self> {
        let partition = coarse.partition();
        let functions = coarse.functions().of(index);
        let mut load = None;
        for &(local, node) in embedding.members(index) {
            let share = 1.0 / f64::from(embedding.multiplicity()[node as usize]);
            let force: [f64; 3] = std::array::from_fn(|s| share * loads[3 * node as usize + s]);
            if force == [0.0; 3] {
                continue;
            }
            let Self { moment, lever, at_rest, resultant } = load.get_or_insert_with(Self::none);
            let at = place.cell.node(partition.cell_lattice().node_position(Node(local as usize)), partition.degree());
            for (r, s) in (0..9).map(|n| (n / 3, n % 3)) {
                moment[r][s] += at[r] * force[s];
                let row = &functions[COLUMNS * (3 * local as usize + r)..][..COLUMNS];
                lever[3 * r + s].iter_mut().zip(row).for_each(|(sum, w)| *sum += w * force[s]);
            }
            (0..3).for_each(|r| *at_rest += at[r] * force[r]);
            (0..3).for_each(|r| resultant[r] += force[r]);
        }
        load
    }

    fn none() -> Self {
        Self { moment: [[0.0; 3]; 3], lever: [[0.0; COLUMNS]; 9], at_rest: 0.0, resultant: [0.0; 3] }
    }

    /// T(v).
    fn moment(&self, v: &Columns) -> Matrix3 {
        let moved = |n: usize| self.lever[n].iter().zip(v).map(|(l, v)| l * v).sum::<f64>();
        std::array::from_fn(|r| std::array::from_fn(|s| self.moment[r][s] + moved(3 * r + s)))
    }

    /// Energy \[J\], zero at rest.
    pub fn energy(&self, frame: &Frame) -> f64 {
        let moment = self.moment(&frame.local);
        let lifted = dot(&self.resultant, &frame.shift);
        self.at_rest - lifted - (0..9).map(|n| frame.rotation[n % 3][n / 3] * moment[n / 3][n % 3]).sum::<f64>()
    }

    /// Adds to the first derivatives.
    pub fn add_forces(&self, frame: &Frame, forces: &mut LocalForces) {
        for (n, row) in self.lever.iter().enumerate() {
            let cosine = frame.rotation[n % 3][n / 3];
            forces.gradient.iter_mut().zip(row).for_each(|(g, l)| *g -= cosine * l);
        }
        let m = self.local_moment(frame);
        let couple = [m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0]];
        (0..3).for_each(|k| forces.couple[k] += couple[k]);
    }

    /// Adds to the second derivatives: a dead load has some only because the frame turns.
    pub fn add_curvature(&self, frame: &Frame, curvature: &mut LocalCurvature) {
        // B w = Σ_j M_jᵀ (f_j × w) with f_j = −Rᵀ times the force in space.
        for (r, s, q) in (0..27).map(|n| (n / 9, n / 3 % 3, n % 3)).filter(|(r, _, q)| r != q) {
            let k = 3 - r - q;
            let sign = if (r + 1) % 3 == q { 1.0 } else { -1.0 };
            let factor = -sign * frame.rotation[s][q];
            curvature.mixed[k].iter_mut().zip(&self.lever[3 * r + s]).for_each(|(b, l)| *b += factor * l);
        }
        add_turning_moment(&self.local_moment(frame), &mut curvature.rotational);
    }

    /// Σ_j z_j ⊗ f_j with the gradient f_j = −Rᵀ times the force in space.
    fn local_moment(&self, frame: &Frame) -> Matrix3 {
        product(&self.moment(&frame.local), &frame.rotation).map(|row| row.map(|v| -v))
    }
}
