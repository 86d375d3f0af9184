//! The three ways to the shape functions of one cell: closed form, a system per node, one coupled system.

use std::sync::Arc;

use grosgrain::coarsening::{BaseFunctions, Fitter, PerNode, Systems, fit_coupled};
use grosgrain::fine::FineModel;
use grosgrain::partition::{CellPart, CoarseCell, CoarseMesh, Partition};
use grosgrain::training::{LocalTrainer, RingKind};

use crate::failure::Failure;

/// A way to shape functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// Ours.
    ClosedForm,
    /// The paper's decoupled optimisation.
    PerNode,
    /// The optimisation of `chen2018numerical`.
    Coupled,
}

impl Fit {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::ClosedForm, Self::PerNode, Self::Coupled];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed form",
            Self::PerNode => "per node",
            Self::Coupled => "coupled",
        }
    }
}

/// Two fits that are compared, the first relative to the second.
pub const PAIRS: [(Fit, Fit); 3] =
    [(Fit::PerNode, Fit::Coupled), (Fit::ClosedForm, Fit::Coupled), (Fit::ClosedForm, Fit::PerNode)];
/// The paper's bound on the difference of its fit from the coupled one, in percent.
pub const PUBLISHED_DIFFERENCE: f64 = 1e-3;

/// What is told of [`PUBLISHED_DIFFERENCE`].
pub const BOUND: &str = "the paper says that its decoupled fit differs by less than 0.001 %";

/// `per node – coupled`.
pub fn pair_name((a, b): (Fit, Fit)) -> &'static str {
    match (a, b) {
        (Fit::PerNode, _) => "per node against coupled",
        (_, Fit::Coupled) => "closed form against coupled",
        _ => "closed form against per node",
    }
}

/// The published bound, for the pair that it is about.
pub fn published(pair: (Fit, Fit)) -> Option<f64> {
    (pair == (Fit::PerNode, Fit::Coupled)).then_some(PUBLISHED_DIFFERENCE)
}

/// A coarse cell with its training data, ready to be fitted.
pub struct FitCase {
    partition: Partition,
    spacing: [f64; 3],
    fitter: Fitter,
    per_node: PerNode,
    training: Vec<f64>,
}

impl FitCase {
    /// Trains `cell` of the model on its one-ring or alone.
    pub fn new(model: &FineModel, degree: usize, cell: CoarseCell, ring: RingKind) -> Result<Self, Failure> {
        let failed = |error: &dyn std::fmt::Display| Failure::Failed(error.to_string());
        let spacing = model.grid().spacing;
        let partition = Partition::new(model.grid().lattice, degree).map_err(|error| failed(&error))?;
        let mesh = CoarseMesh::new(&model.grid().void, &partition);
        let data = LocalTrainer::new(&partition, ring).train_cell(model, &mesh, &[CellPart::whole(cell)]);
        let training = data.map_err(|error| failed(&error))?.concat();
        let base = BaseFunctions::harmonic(degree, spacing).map_err(|error| failed(&error))?;
        let fitter = Fitter::new(&partition, spacing, &Arc::new(base));
        let per_node = PerNode::new(&partition, spacing, fitter.base());
        Ok(Self { partition, spacing, fitter, per_node, training })
    }

    /// Fits into `functions`, which has the length of [`FitCase::room`].
    pub fn fit_into(&self, fit: Fit, functions: &mut Vec<f64>) -> Result<(), Failure> {
        match fit {
            Fit::ClosedForm => {
                self.fitter.fit_into(&self.training, functions);
                Ok(())
            }
            Fit::PerNode => match self.per_node.fit_into(&self.training, Systems::EveryNode, functions) {
                true => Ok(()),
                false => Err(Failure::Failed(
                    "the multiplier system of a node is singular: training fields depend on each other".into(),
                )),
            },
            Fit::Coupled => {
                *functions = fit_coupled(&self.partition, self.spacing, &self.training)
                    .map_err(|error| Failure::Failed(error.to_string()))?
                    .0;
                Ok(())
            }
        }
    }

    /// Room for the functions of the cell.
    pub fn room(&self) -> Vec<f64> {
        vec![0.0; self.fitter.len()]
    }

    /// The functions of every fit, in the order of [`Fit::ALL`].
    pub fn functions(&self) -> Result<[Vec<f64>; 3], Failure> {
        let mut all = Fit::ALL.map(|_| self.room());
        for (fit, functions) in Fit::ALL.into_iter().zip(&mut all) {
            self.fit_into(fit, functions)?;
        }
        Ok(all)
    }
}

/// 100 ‖m_a − m_b‖ / ‖m_b‖ over all coefficients of the pair, in percent.
pub fn difference(functions: &[Vec<f64>; 3], (a, b): (Fit, Fit)) -> f64 {
    let of = |fit: Fit| &functions[fit as usize];
    100.0 * grosgrain::dynamics::relative_error(of(a), of(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_relative_to_the_second_of_a_pair_and_in_percent() {
        let functions = [vec![1.0, 0.0], vec![1.0, 0.02], vec![2.0, 0.0]];
        let found = PAIRS.map(|pair| difference(&functions, pair));
        let exact = [(1.0f64 + 4e-4).sqrt() / 2.0, 0.5, 0.02 / (1.0f64 + 4e-4).sqrt()];
        for (found, exact) in found.into_iter().zip(exact) {
            assert!((found - 100.0 * exact).abs() < 1e-12, "{found}, {exact}");
        }
    }
}
