//! A coarse model that follows a changing body.

use std::time::Instant;

use super::{LiveError, LiveOptions, UpdateReport};
use crate::coarse::CoarseModel;
use crate::coarsening::{ElementFitter, Objective};
use crate::fine::FineModel;
use crate::mesh::Cell;
use crate::partition::{CellPart, CoarseCell, CoarseMesh, Partition};
use crate::progress::Progress;
use crate::training::{Trainer, TrainingKind, run_time_training};

/// A coarse model with all that it takes to renew it where its body has changed; the body itself is elsewhere.
///
/// [`super::LiveModel`] keeps both together; this is for programs that keep the body themselves.
pub struct LiveCoarse {
    model: CoarseModel,
    trainer: Trainer,
    training: TrainingKind,
    fitter: ElementFitter,
    /// Whether edits train and fit anew.
    renews_functions: bool,
    /// The elements that the last renewal has made anew.
    renewed: Vec<CellPart>,
}

impl LiveCoarse {
    /// Coarsens a body; `report` tells how long the stages took, and counts every element as dirty.
    ///
    /// # Errors
    /// A degree that does not divide the lattice, training or fitting that fails, an interruption.
    pub fn new(
        fine: &FineModel,
        degree: usize,
        options: &LiveOptions,
        report: &mut UpdateReport,
        progress: Progress<'_>,
    ) -> Result<Self, LiveError> {
        let partition = Partition::new(fine.grid().lattice, degree)?;
        let void = &fine.grid().void;
        let mesh = match options.split && options.renew_functions {
            true => CoarseMesh::new(void, &partition),
            false => CoarseMesh::unsplit(void, &partition),
        };
        let mut clock = Instant::now();
        let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
        let training = run_time_training(&partition, options.training);
        let mut trainer = Trainer::new(fine, &partition, training, progress)?;
        trainer.limit_error(options.data_tolerance.unwrap_or(f64::INFINITY));
        let fitter = ElementFitter::new(&partition, fine.grid().spacing, (options.base, Objective::ClosedForm))?;
        let data = trainer.train(fine, &mesh, (&[], mesh.elements()), progress)?;
        report.seconds.training = lap();
        let functions = fitter.fit(fine, &mesh, &data, progress)?;
        report.seconds.fitting = lap();
        report.dirty = mesh.elements().len();
        let model = CoarseModel::galerkin(fine, mesh, functions);
        report.seconds.assembly = lap();
        let renewed = model.elements().to_vec();
        Ok(Self { model, trainer, training, fitter, renews_functions: options.renew_functions, renewed })
    }

    /// The coarse model.
    pub fn model(&self) -> &CoarseModel {
        &self.model
    }

    /// The training that was chosen.
    pub fn training(&self) -> TrainingKind {
        self.training
    }

    /// The elements that the first build or the last renewal has made anew, ascending.
    pub fn renewed(&self) -> &[CellPart] {
        &self.renewed
    }

    /// Trains, fits and assembles again what depends on the `changed` cells of `fine`, which has changed there and nowhere else since the last
    /// time; `topology` tells whether any of them became void or solid. Returns the mesh before where there is a new one.
    ///
    /// # Errors
    /// Training or fitting that fails, an interruption. The coarse model is then as it was.
    pub fn renew(
        &mut self,
        fine: &FineModel,
        changed: &[Cell],
        topology: bool,
        report: &mut UpdateReport,
        progress: Progress<'_>,
    ) -> Result<Option<CoarseMesh>, LiveError> {
        let mut clock = Instant::now();
        let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
        let changed_cells = self.coarse_cells_of(changed);
        let mut mesh = self.model.mesh().clone();
        if topology {
            mesh.update(&fine.grid().void, &changed_cells);
        }
        let of_cell = |cell: &CoarseCell| mesh.elements()[mesh.elements_of(*cell)].iter().copied();
        let reach = match self.renews_functions {
            true => self.trainer.reach(&changed_cells),
            false => changed_cells.clone(),
        };
        let dirty: Vec<CellPart> = reach.iter().flat_map(of_cell).collect();
        report.seconds.topology = lap();
        let functions = match self.renews_functions {
            true => {
                let data = self.trainer.train(fine, &mesh, (&changed_cells, &dirty), progress)?;
                report.seconds.training = lap();
                self.fitter.fit(fine, &mesh, &data, progress)?
            }
            false => self.model.functions().of_elements(mesh.partition(), &dirty),
        };
        report.seconds.fitting = lap();
        if self.renews_functions {
            self.trainer.settle();
        }
        let old = topology.then(|| self.model.mesh().clone());
        self.model.replace(fine, mesh, functions);
        report.seconds.assembly = lap();
        self.renewed = dirty;
        (report.changed_fine, report.changed, report.dirty) = (changed.len(), changed_cells.len(), self.renewed.len());
        Ok(old)
    }

    /// The coarse cells that hold fine cells, ascending.
    fn coarse_cells_of(&self, fine: &[Cell]) -> Vec<CoarseCell> {
        let mut cells: Vec<CoarseCell> = fine.iter().map(|cell| self.model.partition().coarse_cell_of(*cell)).collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}
