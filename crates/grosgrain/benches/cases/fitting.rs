//! Shape functions of one coarse cell from given training data.

use std::sync::Arc;

use grosgrain::coarsening::{BaseFunctions, COLUMNS, CoupledError, FIELDS, Fitter, fit_coupled};
use grosgrain::partition::{CellPart, CoarseMesh, Partition};
use grosgrain::training::{LocalTrainer, RingKind};

use super::{CENTRE, Outcome, RATIO, SPACING, layered};
use crate::per_node::{PerNode, Systems};

/// The cell in the middle of a layered body, trained on its one-ring.
pub struct FitCase {
    partition: Partition,
    fitter: Fitter,
    per_node: PerNode,
    training: Vec<f64>,
    /// The last fit, `3 (d + 1)³ × 24`.
    pub functions: Vec<f64>,
}

impl FitCase {
    pub fn new(degree: usize) -> Outcome<Self> {
        let model = layered([3 * degree; 3], RATIO)?;
        let partition = Partition::new(model.grid().lattice, degree)?;
        let mesh = CoarseMesh::new(&model.grid().void, &partition);
        let trainer = LocalTrainer::new(&partition, RingKind::OneRing);
        let training = trainer.train_cell(&model, &mesh, &[CellPart::whole(CENTRE)])?.concat();
        let base = Arc::new(BaseFunctions::harmonic(degree, SPACING)?);
        let fitter = Fitter::new(&partition, SPACING, &base);
        let per_node = PerNode::new(&partition, SPACING, fitter.base());
        let functions = vec![0.0; fitter.len()];
        Ok(Self { partition, fitter, per_node, training, functions })
    }

    /// The closed form.
    pub fn closed_form(&mut self) {
        self.fitter.fit_into(&self.training, &mut self.functions);
    }

    /// One multiplier system per fine node; false if one is singular.
    pub fn per_node(&mut self, systems: Systems) -> bool {
        self.per_node.fit_into(&self.training, systems, &mut self.functions)
    }

    /// One saddle-point system for the whole cell.
    pub fn coupled(&mut self) -> Result<(), CoupledError> {
        self.functions = fit_coupled(&self.partition, SPACING, &self.training)?.0;
        Ok(())
    }

    /// Largest difference of the last fit from `other`, relative to the largest entry; infinite if an entry is not finite.
    pub fn difference(&self, other: &[f64]) -> f64 {
        if !self.functions.iter().all(|v| v.is_finite()) {
            return f64::INFINITY;
        }
        let size = other.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        self.functions.iter().zip(other).fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / size
    }

    pub fn nodes(&self) -> usize {
        self.partition.nodes_per_cell()
    }

    /// Multiplications and additions of the two products per cell: E = [φ 1 x] M − U with 12 × 18 and W = W⁰ − E P with
    /// 18 × 24 multiply-adds per fine node. The twelve rows of M and the pseudo-inverse P are not counted.
    pub fn flops(&self) -> f64 {
        let mismatch = 2 * 12 * 3 * FIELDS;
        let correction = 2 * 3 * FIELDS * COLUMNS;
        (self.nodes() * (mismatch + correction)) as f64
    }

    /// Bytes read (base, geometry, training) and written (functions) per cell.
    pub fn bytes(&self) -> f64 {
        (8 * self.nodes() * (3 * COLUMNS + 12 + 3 * FIELDS + 3 * COLUMNS)) as f64
    }
}
