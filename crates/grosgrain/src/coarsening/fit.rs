//! The closed form of the constrained smoothest shape functions.

use std::sync::Arc;

use super::data_constraints::rigid_displacement;
use super::{BaseFunctions, COLUMNS, DataConstraints, FIELDS};
use crate::mesh::{Lattice, Node};
use crate::partition::Partition;

/// Columns of the mismatch of one fine node: three components times six fields.
const NODE_COLUMNS: usize = 3 * FIELDS;
/// Entries that determine the base's mismatch at a node: eight weights, one, and the node's offset.
const GEOMETRY: usize = 12;

/// What a fit has to say about its data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedCell {
    /// Number of independent training fields, at most 6.
    pub rank: usize,
    /// Condition number estimate of the data constraints (ratio of the pivots of the unit rows).
    pub condition: f64,
}

/// Fits cells of one shape to their training data.
///
/// Among all W (3(d+1)³ × 24) with partition of unity, rotation invariance and W ũ_k = u_k for the training fields
/// the one closest to the base W⁰ in Σ_i ∫ |∇N_i|² is W = W⁰ − (W⁰ Cᵀ − R) (Cᵀ)⁺, because the constraint matrix C is the same for every
/// fine node. The geometric constraints are met by the base once and for all; with P the pseudo-inverse of the data constraints that remain
/// ([`DataConstraints`]) the fit is a correction of rank six, W = W⁰ − E P.
#[derive(Clone, Debug)]
pub struct Fitter {
    corner_nodes: [usize; 8],
    corner_offsets: [[f64; 3]; 8],
    node_offsets: Vec<[f64; 3]>,
    geometry: Vec<[f64; GEOMETRY]>,
    base: Vec<f64>,
}

impl Fitter {
    /// A fitter for the coarse cells of `partition` with fine cells of edge lengths `spacing`.
    pub fn new(partition: &Partition, spacing: [f64; 3], base: &Arc<BaseFunctions>) -> Self {
        let local = partition.cell_lattice();
        let node_offsets = offsets(local, spacing);
        let corner_nodes = partition.local_corners();
        let corner_offsets = corner_nodes.map(|n| node_offsets[n]);
        let geometry = base.weights().iter().zip(&node_offsets).map(|(w, x)| {
            let mut row = [0.0; GEOMETRY];
            row[..8].copy_from_slice(w);
            row[8] = 1.0;
            row[9..].copy_from_slice(x);
            row
        });
        let geometry = geometry.collect();
        let mut fitter = Self { corner_nodes, corner_offsets, node_offsets, geometry, base: base.functions().to_vec() };
        fitter.make_rigid_motions_exact();
        fitter
    }

    /// Number of entries of one cell's functions, 3 (d + 1)³ · 24.
    pub fn len(&self) -> usize {
        self.base.len()
    }

    /// Whether there is nothing to fit; never, as a cell has at least its corners.
    pub fn is_empty(&self) -> bool {
        self.base.is_empty()
    }

    /// The base with exact rigid motions, which is the fit to no data at all.
    pub fn base(&self) -> &[f64] {
        &self.base
    }

    /// Fits one cell: `training` is its 3(d+1)³ × 6 matrix, `functions` receives W (3(d+1)³ × 24), both row-major.
    ///
    /// # Panics
    /// Panics when a slice has the wrong length.
    pub fn fit_into(&self, training: &[f64], functions: &mut [f64]) -> FittedCell {
        assert!(
            training.len() * COLUMNS == self.len() * FIELDS && functions.len() == self.len(),
            "matrix of the wrong shape"
        );
        let data = self.data_constraints(training);
        let mismatch = mismatch_matrix(&data);
        pulp::Arch::new().dispatch(Kernel {
            geometry: &self.geometry,
            mismatch: &mismatch,
            inverse: &data.inverse,
            base: &self.base,
            training,
            functions,
        });
        self.set_corners(functions);
        FittedCell { rank: data.rank, condition: data.condition }
    }

    /// Fits one cell that has base functions of its own (exact for rigid motions, deltas at the corners): `functions` holds them
    /// on entry and the fit on return.
    ///
    /// # Panics
    /// Panics when a slice has the wrong length.
    pub fn fit_own_base(&self, training: &[f64], functions: &mut [f64]) -> FittedCell {
        assert!(
            training.len() * COLUMNS == self.len() * FIELDS && functions.len() == self.len(),
            "matrix of the wrong shape"
        );
        let data = self.data_constraints(training);
        for (row, function) in functions.chunks_exact_mut(COLUMNS).enumerate() {
            let rigid = data.rigid.map(|motion| rigid_displacement(&motion, &self.node_offsets[row / 3])[row % 3]);
            let error: [f64; FIELDS] = std::array::from_fn(|k| {
                let value: f64 = (0..COLUMNS).map(|c| function[c] * data.corners[k][c]).sum();
                value + rigid[k] - training[FIELDS * row + k]
            });
            for (k, e) in error.iter().enumerate() {
                (0..COLUMNS).for_each(|c| function[c] -= e * data.inverse[k][c]);
            }
        }
        self.set_corners(functions);
        FittedCell { rank: data.rank, condition: data.condition }
    }

    /// The data constraints of one cell.
    pub fn data_constraints(&self, training: &[f64]) -> DataConstraints {
        let corner = |k: usize, c: usize| training[FIELDS * (3 * self.corner_nodes[c / 3] + c % 3) + k];
        let corners = std::array::from_fn(|k| std::array::from_fn(|c| corner(k, c)));
        DataConstraints::new(corners, &self.corner_offsets)
    }

    fn set_corners(&self, functions: &mut [f64]) {
        for (i, &node) in self.corner_nodes.iter().enumerate() {
            for r in 0..3 {
                let row = &mut functions[(3 * node + r) * COLUMNS..][..COLUMNS];
                row.fill(0.0);
                row[3 * i + r] = 1.0;
            }
        }
    }

    /// W⁰ ← W⁰ − (W⁰ Q̂ᵀ − R) Q̂ over the three rotations Q̂ of the corners (translations are exact already).
    fn make_rigid_motions_exact(&mut self) {
        for axis in 0..3 {
            let mut motion = [0.0; 6];
            motion[3 + axis] = 1.0;
            let turn: [f64; COLUMNS] =
                std::array::from_fn(|c| rigid_displacement(&motion, &self.corner_offsets[c / 3])[c % 3]);
            let square: f64 = turn.iter().map(|v| v * v).sum();
            for (row, function) in self.base.chunks_exact_mut(COLUMNS).enumerate() {
                let exact = rigid_displacement(&motion, &self.node_offsets[row / 3])[row % 3];
                let error = (0..COLUMNS).map(|c| function[c] * turn[c]).sum::<f64>() - exact;
                (0..COLUMNS).for_each(|c| function[c] -= error / square * turn[c]);
            }
        }
        let mut base = std::mem::take(&mut self.base);
        self.set_corners(&mut base);
        self.base = base;
    }
}

/// Offsets of the nodes of a lattice from its centre \[m\].
fn offsets(lattice: Lattice, spacing: [f64; 3]) -> Vec<[f64; 3]> {
    let offset = |n: usize| -> [f64; 3] {
        let at = lattice.node_position(Node(n));
        std::array::from_fn(|a| (at[a] as f64 - 0.5 * lattice.cells[a] as f64) * spacing[a])
    };
    (0..lattice.node_count()).map(offset).collect()
}

/// The 12×18 matrix that takes (φ_1…φ_8, 1, x, y, z) of a node to W⁰ ũ_k + rigid_k there, padded to 24 columns.
fn mismatch_matrix(data: &DataConstraints) -> [[f64; COLUMNS]; GEOMETRY] {
    let mut matrix = [[0.0; COLUMNS]; GEOMETRY];
    for (r, k) in (0..NODE_COLUMNS).map(|n| (n / FIELDS, n % FIELDS)) {
        let column = r * FIELDS + k;
        (0..8).for_each(|i| matrix[i][column] = data.corners[k][3 * i + r]);
        let at_centre = rigid_displacement(&data.rigid[k], &[0.0; 3])[r];
        matrix[8][column] = at_centre;
        for a in 0..3 {
            let mut unit = [0.0; 3];
            unit[a] = 1.0;
            matrix[9 + a][column] = rigid_displacement(&data.rigid[k], &unit)[r] - at_centre;
        }
    }
    matrix
}

/// The fused loop over fine nodes: E = geometry · mismatch − training, then W = W⁰ − E P, all in registers.
///
/// Inlined into a function compiled for the widest vectors of the machine it runs on.
struct Kernel<'a> {
    geometry: &'a [[f64; GEOMETRY]],
    mismatch: &'a [[f64; COLUMNS]; GEOMETRY],
    inverse: &'a [[f64; COLUMNS]; FIELDS],
    base: &'a [f64],
    training: &'a [f64],
    functions: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let nodes = self
            .base
            .as_chunks::<{ 3 * COLUMNS }>()
            .0
            .iter()
            .zip(self.training.as_chunks::<NODE_COLUMNS>().0)
            .zip(self.functions.as_chunks_mut::<{ 3 * COLUMNS }>().0)
            .zip(self.geometry);
        for (((base, training), functions), geometry) in nodes {
            let mut error = [0.0; COLUMNS];
            for c in 0..NODE_COLUMNS {
                error[c] = -training[c];
            }
            for g in 0..GEOMETRY {
                add_scaled(&mut error, geometry[g], &self.mismatch[g]);
            }
            for r in 0..3 {
                let mut sum = [0.0; COLUMNS];
                sum.copy_from_slice(&base[COLUMNS * r..COLUMNS * (r + 1)]);
                for k in 0..FIELDS {
                    add_scaled(&mut sum, -error[r * FIELDS + k], &self.inverse[k]);
                }
                functions[COLUMNS * r..COLUMNS * (r + 1)].copy_from_slice(&sum);
            }
        }
    }
}

#[inline(always)]
fn add_scaled(sum: &mut [f64; COLUMNS], factor: f64, row: &[f64; COLUMNS]) {
    for c in 0..COLUMNS {
        sum[c] = factor.mul_add(row[c], sum[c]);
    }
}
