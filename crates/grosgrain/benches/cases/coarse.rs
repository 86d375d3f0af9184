//! The coarse model: stiffness of one cell, and the maps between coarse and fine nodes.

use grosgrain::coarse::{BuildOptions, CoarseModel, Embedding, Method, build, galerkin_stiffness};
use grosgrain::coarsening::COLUMNS;
use grosgrain::element::CellMatrix;
use grosgrain::fine::FineModel;
use grosgrain::progress::silent;
use grosgrain::training::TrainingKind;

use super::{Outcome, RATIO, layered};

/// A layered body of 4 × 2 × 2 coarse cells with its coarse model.
pub struct CoarseCase {
    model: FineModel,
    coarse: CoarseModel,
    coarse_vector: Vec<f64>,
    fine_vector: Vec<f64>,
}

impl CoarseCase {
    pub fn new(degree: usize) -> Outcome<Self> {
        let model = layered([4 * degree, 2 * degree, 2 * degree], RATIO)?;
        let options = BuildOptions { method: Method::Trained(TrainingKind::SingleCell), ..BuildOptions::default() };
        let coarse = build(&model, degree, &options, &silent)?.model;
        let entry = |i: usize| (0.1 * i as f64).sin();
        let coarse_vector = (0..3 * coarse.mesh().vertices().len()).map(entry).collect();
        let fine_vector = (0..3 * model.grid().lattice.node_count()).map(entry).collect();
        Ok(Self { model, coarse, coarse_vector, fine_vector })
    }

    /// K̄ of the first coarse cell.
    pub fn galerkin(&self) -> CellMatrix {
        let first = self.coarse.elements()[0];
        galerkin_stiffness(&self.coarse.mesh().window(&self.model, first), self.coarse.functions().of(0))
    }

    /// Multiplications and additions of K W (24³) and of one triangle of Wᵀ (K W), per fine cell of one coarse cell.
    pub fn galerkin_flops(&self) -> f64 {
        let triangle = COLUMNS * (COLUMNS + 1) / 2;
        let per_cell = 2 * COLUMNS.pow(3) + 2 * COLUMNS * triangle;
        (per_cell * self.coarse.partition().degree().pow(3)) as f64
    }

    pub fn embedding(&self) -> Embedding<'_> {
        Embedding::new(&self.coarse)
    }

    /// Coarse displacements on the fine nodes.
    pub fn prolong(&self, embedding: &Embedding<'_>) -> Vec<f64> {
        embedding.prolong(&self.coarse_vector)
    }

    /// Fine loads on the coarse nodes.
    pub fn restrict(&self, embedding: &Embedding<'_>) -> Vec<f64> {
        embedding.restrict(&self.fine_vector)
    }

    /// Bytes of all shape functions, each of which is read once.
    pub fn embedding_bytes(&self) -> f64 {
        8.0 * self.coarse.functions().iter().map(<[f64]>::len).sum::<usize>() as f64
    }

    pub fn fine_unknowns(&self) -> usize {
        3 * self.model.active_count()
    }
}
