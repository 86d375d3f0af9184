//! Shape functions by one small constrained optimisation per fine node, as published: the baseline of the closed form.

use std::hint::black_box;

use super::{BaseFunctions, COLUMNS, FIELDS};
use crate::mesh::Node;
use crate::partition::Partition;

const COEFFICIENTS: usize = 3 * COLUMNS;
const GEOMETRIC: usize = 18;
const FREE: usize = COEFFICIENTS - GEOMETRIC;
const DATA: usize = 3 * FIELDS;

type Projected = [[f64; FREE]; DATA];
type Triangle = [[f64; DATA]; DATA];

/// How often the 18 × 18 multiplier system is formed and factored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Systems {
    /// At every fine node, as published.
    EveryNode,
    /// Once per cell, as it is the same at all nodes: a stronger baseline.
    OncePerCell,
}

/// The decoupled optimisation of `he2022fast`, §4.2: what of it does not depend on the training data.
///
/// The 72 coefficients of a node are m = Q̄ z + m₀ with Q̄ a basis of the null space of its 18 geometric constraints
/// (full QR) and m₀ the trilinear functions. z minimises ½‖z − z̄‖² under the 18 data constraints
/// D Q̄ z = d − D m₀, solved by multipliers: B Bᵀ λ = d − D m₀ − B z̄, z = z̄ + Bᵀ λ, B = D Q̄. The smoothest
/// coefficients z̄ do not depend on the data and are given. The result is that of [`Fitter`](super::Fitter), which is faster; this is
/// kept to compare with.
#[derive(Clone, Debug)]
pub struct PerNode {
    corners: [usize; 8],
    null_space: Vec<[f64; FREE]>,
    /// The same by columns.
    null_columns: Vec<[f64; COEFFICIENTS]>,
    trilinear: Vec<f64>,
    smoothest: Vec<[f64; FREE]>,
}

impl PerNode {
    /// A fitter for the coarse cells of `partition` with fine cells of edge lengths `spacing` \[m\]. `smoothest` holds the smoothest
    /// functions under the geometric constraints ([`Fitter::base`](super::Fitter::base)), `3 (d + 1)³ × 24` row-major.
    pub fn new(partition: &Partition, spacing: [f64; 3], smoothest: &[f64]) -> Self {
        let corners = partition.local_corners();
        let offsets = corners.map(|n| {
            let at = partition.cell_lattice().node_position(Node(n));
            std::array::from_fn(|a| (at[a] as f64 - 0.5 * partition.degree() as f64) * spacing[a])
        });
        let null_space = null_space(&offsets);
        let trilinear = BaseFunctions::trilinear(partition.degree()).functions().to_vec();
        let differences = smoothest.chunks_exact(COEFFICIENTS).zip(trilinear.chunks_exact(COEFFICIENTS));
        let project = |(m, start): (&[f64], &[f64])| -> [f64; FREE] {
            std::array::from_fn(|z| (0..COEFFICIENTS).map(|c| null_space[c][z] * (m[c] - start[c])).sum())
        };
        let smoothest = differences.map(project).collect();
        let null_columns = (0..FREE).map(|z| std::array::from_fn(|c| null_space[c][z])).collect();
        Self { corners, null_space, null_columns, trilinear, smoothest }
    }

    /// Fits one cell: `training` is its `3 (d + 1)³ × 6` matrix, `functions` receives W (`3 (d + 1)³ × 24`), both row-major.
    /// False if a multiplier system is not positive definite, as with training fields that depend on each other at the corners.
    ///
    /// # Panics
    /// Panics when `training` has the wrong length.
    pub fn fit_into(&self, training: &[f64], systems: Systems, functions: &mut [f64]) -> bool {
        let corner = |k: usize, c: usize| training[FIELDS * (3 * self.corners[c / 3] + c % 3) + k];
        let at_corners = std::array::from_fn(|k| std::array::from_fn(|c| corner(k, c)));
        pulp::Arch::new().dispatch(Optimisation { cell: self, at_corners, training, systems, functions })
    }
}

/// The last 54 columns of the orthogonal factor of Gᵀ, G the 18 × 72 constraints of one node.
fn null_space(offsets: &[[f64; 3]; 8]) -> Vec<[f64; FREE]> {
    let constraints = faer::Mat::from_fn(COEFFICIENTS, GEOMETRIC, |coefficient, constraint| {
        let (row, column) = (coefficient / COLUMNS, coefficient % COLUMNS);
        if constraint / 6 != row {
            return 0.0;
        }
        rigid_motion(constraint % 6, &offsets[column / 3])[column % 3]
    });
    let orthogonal = constraints.qr().compute_Q();
    (0..COEFFICIENTS).map(|c| std::array::from_fn(|z| orthogonal[(c, GEOMETRIC + z)])).collect()
}

/// Translation along axis `motion`, or rotation e × x about axis `motion − 3`.
fn rigid_motion(motion: usize, x: &[f64; 3]) -> [f64; 3] {
    let axis = motion % 3;
    let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut value = [0.0; 3];
    if motion < 3 {
        value[axis] = 1.0;
    } else {
        (value[p], value[q]) = (-x[q], x[p]);
    }
    value
}

struct Optimisation<'a> {
    cell: &'a PerNode,
    at_corners: [[f64; COLUMNS]; FIELDS],
    training: &'a [f64],
    systems: Systems,
    functions: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Optimisation<'_> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        let projected = projected_constraints(&self.at_corners, &self.cell.null_space);
        let Some(mut factor) = multiplier_factor(&projected) else { return false };
        for (node, result) in self.functions.as_chunks_mut::<COEFFICIENTS>().0.iter_mut().enumerate() {
            let start = &self.cell.trilinear[COEFFICIENTS * node..][..COEFFICIENTS];
            result.copy_from_slice(start);
            if self.cell.corners.contains(&node) {
                continue;
            }
            if self.systems == Systems::EveryNode {
                // Behind the black box the compiler cannot see that it is the same matrix at every node.
                let Some(own) = multiplier_factor(black_box(&projected)) else { return false };
                factor = own;
            }
            let target = &self.training[DATA * node..][..DATA];
            let mut z = self.cell.smoothest[node];
            let mut multipliers = right_side(&self.at_corners, &projected, (target, start), &z);
            solve(&factor, &mut multipliers);
            for (row, multiplier) in projected.iter().zip(&multipliers) {
                (0..FREE).for_each(|i| z[i] = multiplier.mul_add(row[i], z[i]));
            }
            for (z, column) in z.iter().zip(&self.cell.null_columns) {
                (0..COEFFICIENTS).for_each(|c| result[c] = z.mul_add(column[c], result[c]));
            }
        }
        true
    }
}

/// B = D Q̄: row 6 r + k takes z to Σ_i M_i ũ_i,k in component r.
#[inline(always)]
fn projected_constraints(at_corners: &[[f64; COLUMNS]; FIELDS], null_space: &[[f64; FREE]]) -> Projected {
    let mut projected = [[0.0; FREE]; DATA];
    for (r, k) in (0..DATA).map(|n| (n / FIELDS, n % FIELDS)) {
        for (c, value) in at_corners[k].iter().enumerate() {
            let row = &null_space[COLUMNS * r + c];
            (0..FREE).for_each(|i| projected[FIELDS * r + k][i] += value * row[i]);
        }
    }
    projected
}

/// d − D m₀ − B z̄.
#[inline(always)]
fn right_side(
    at_corners: &[[f64; COLUMNS]; FIELDS],
    projected: &Projected,
    (target, start): (&[f64], &[f64]),
    z: &[f64; FREE],
) -> [f64; DATA] {
    let mut right = [0.0; DATA];
    for (r, k) in (0..DATA).map(|n| (n / FIELDS, n % FIELDS)) {
        let row = &start[COLUMNS * r..][..COLUMNS];
        let reached: f64 = row.iter().zip(&at_corners[k]).map(|(m, u)| m * u).sum();
        right[FIELDS * r + k] = target[FIELDS * r + k] - reached - dot(&projected[FIELDS * r + k], z);
    }
    right
}

/// Lower Cholesky factor of B Bᵀ, `None` if it is not positive definite.
#[inline(always)]
fn multiplier_factor(projected: &Projected) -> Option<Triangle> {
    let mut lower = [[0.0; DATA]; DATA];
    for i in 0..DATA {
        for j in 0..=i {
            let known: f64 = (0..j).map(|m| lower[i][m] * lower[j][m]).sum();
            let entry = dot(&projected[i], &projected[j]) - known;
            lower[i][j] = if i == j { entry.sqrt() } else { entry / lower[j][j] };
        }
        if lower[i][i].is_nan() || lower[i][i] <= 0.0 {
            return None;
        }
    }
    Some(lower)
}

#[inline(always)]
fn solve(lower: &Triangle, x: &mut [f64; DATA]) {
    for i in 0..DATA {
        let known: f64 = (0..i).map(|m| lower[i][m] * x[m]).sum();
        x[i] = (x[i] - known) / lower[i][i];
    }
    for i in (0..DATA).rev() {
        let known: f64 = (i + 1..DATA).map(|m| lower[m][i] * x[m]).sum();
        x[i] = (x[i] - known) / lower[i][i];
    }
}

/// Dot product with six partial sums, which vector units can add in parallel.
#[inline(always)]
fn dot(a: &[f64; FREE], b: &[f64; FREE]) -> f64 {
    let mut sums = [0.0f64; 6];
    for (a, b) in a.chunks_exact(6).zip(b.chunks_exact(6)) {
        (0..6).for_each(|i| sums[i] = a[i].mul_add(b[i], sums[i]));
    }
    sums.iter().sum()
}
