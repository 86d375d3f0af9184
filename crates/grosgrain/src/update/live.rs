//! A coarse model that stays true while its body is edited.

use std::time::Instant;

use super::{Edit, Editor, LiveCoarse, LiveError, LiveOptions, UpdateReport, resolve_all};
use crate::coarse::CoarseModel;
use crate::dynamics::State;
use crate::fine::{CellState, FineModel};
use crate::mesh::Cell;
use crate::partition::CellPart;
use crate::progress::{Progress, silent};
use crate::training::TrainingKind;

/// A body, its coarse model and the motion of that, kept together through edits (`he2022fast`).
///
/// An edit changes fine cells. The coarse cells that hold them are *changed*, those whose training data reach into them *dirty*: only these are
/// trained, fitted and assembled again. The result is that of a build from scratch with the same training.
pub struct LiveModel {
    fine: FineModel,
    coarse: LiveCoarse,
    /// Displacement and velocity of the coarse vertices: yours to step; carried across edits.
    pub state: State,
    editor: Editor,
    held: Vec<bool>,
}

impl LiveModel {
    /// Coarsens a body. `held` marks the nodes of the fine lattice that hold it: parts that an edit cuts loose from them are dropped or
    /// kept as the options say; with no node marked, parts that are loose from the largest one.
    ///
    /// # Errors
    /// A degree that does not divide the lattice, training or fitting that fails, an interruption.
    ///
    /// # Panics
    /// Panics when `held` has not one entry per node of the lattice.
    pub fn new(
        fine: FineModel,
        degree: usize,
        options: &LiveOptions,
        held: Vec<bool>,
        progress: Progress<'_>,
    ) -> Result<Self, LiveError> {
        assert_eq!(held.len(), fine.grid().lattice.node_count(), "one entry per node");
        let coarse = LiveCoarse::new(&fine, degree, options, &mut UpdateReport::default(), progress)?;
        let vertices = coarse.model().mesh().vertices().len();
        let state = State::rest(vertices);
        let editor = Editor::new(options.undo_depth, options.loose);
        Ok(Self { fine, coarse, state, editor, held })
    }

    /// The body.
    pub fn fine(&self) -> &FineModel {
        &self.fine
    }

    /// Its coarse model.
    pub fn coarse(&self) -> &CoarseModel {
        self.coarse.model()
    }

    /// The elements that the first build or the last update has made anew, ascending.
    pub fn renewed(&self) -> &[CellPart] {
        self.coarse.renewed()
    }

    /// Body, coarse model and motion at once, for a step.
    pub(super) fn parts_mut(&mut self) -> (&FineModel, &CoarseModel, &mut State) {
        (&self.fine, self.coarse.model(), &mut self.state)
    }

    /// The training that was chosen.
    pub fn training(&self) -> TrainingKind {
        self.coarse.training()
    }

    /// Number of updates that can be undone.
    pub fn undo_depth(&self) -> usize {
        self.editor.history().len()
    }

    /// Makes an edit and renews what depends on it.
    ///
    /// # Errors
    /// As [`LiveModel::apply_all`].
    pub fn apply(&mut self, edit: &Edit) -> Result<UpdateReport, LiveError> {
        self.apply_all(std::slice::from_ref(edit), &silent)
    }

    /// Makes several edits, one after the other, as one update.
    ///
    /// # Errors
    /// An edit that is refused, training or fitting that fails, an interruption. Body, coarse model and motion are then as they were.
    pub fn apply_all(&mut self, edits: &[Edit], progress: Progress<'_>) -> Result<UpdateReport, LiveError> {
        let start = Instant::now();
        let resolved = resolve_all(edits, &self.fine)?;
        let mut report = UpdateReport::default();
        if resolved.changes.is_empty() {
            report.seconds.total = start.elapsed().as_secs_f64();
            return Ok(report);
        }
        let applied = self.editor.apply(&mut self.fine, &resolved, &self.held).map_err(LiveError::Edit)?;
        let (changed, loose) = (applied.changed.to_vec(), applied.loose);
        report.seconds.edit = start.elapsed().as_secs_f64();
        report.loose = loose;
        let topology = resolved.removed + resolved.added > 0;
        match self.renew(&changed, topology, &mut report, progress) {
            Ok(()) => {
                self.editor.settle();
                report.seconds.total = start.elapsed().as_secs_f64();
                Ok(report)
            }
            Err(failure) => {
                self.editor.undo(&mut self.fine).map_err(LiveError::Edit)?;
                Err(failure)
            }
        }
    }

    /// Undoes the last update; `None` where there is none. The motion stays.
    ///
    /// # Errors
    /// As [`LiveModel::apply_all`]; everything is then as it was.
    pub fn undo(&mut self, progress: Progress<'_>) -> Result<Option<UpdateReport>, LiveError> {
        let start = Instant::now();
        let now: Vec<(Cell, CellState)> =
            self.editor.history().newest().iter().map(|(cell, _)| (*cell, self.fine.state(*cell))).collect();
        let Some(changed) = self.editor.undo(&mut self.fine).map_err(LiveError::Edit)? else { return Ok(None) };
        let changed = changed.to_vec();
        let topology = now.iter().any(|(cell, state)| state.void != self.fine.state(*cell).void);
        let mut report = UpdateReport::default();
        match self.renew(&changed, topology, &mut report, progress) {
            Ok(()) => {
                report.seconds.total = start.elapsed().as_secs_f64();
                Ok(Some(report))
            }
            Err(failure) => {
                self.editor.redo(&mut self.fine, &now).map_err(LiveError::Edit)?;
                Err(failure)
            }
        }
    }

    /// Renews the coarse model and carries the motion over to it.
    fn renew(
        &mut self,
        changed: &[Cell],
        topology: bool,
        report: &mut UpdateReport,
        progress: Progress<'_>,
    ) -> Result<(), LiveError> {
        let old = self.coarse.renew(&self.fine, changed, topology, report, progress)?;
        if let Some(old) = old {
            let mesh = self.coarse.model().mesh();
            self.state.carry_vertices(&old, mesh, self.coarse.model().spacing());
        }
        Ok(())
    }
}
