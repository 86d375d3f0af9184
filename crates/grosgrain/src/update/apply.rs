//! Resolved edits on a model, with what they cut loose and with their undoing.

use super::{EditError, History, LooseParts, LooseReport, LooseSearch, Resolved};
use crate::fine::{CellState, FineModel};
use crate::mesh::Cell;

/// Changes models and can undo it.
#[derive(Clone, Debug)]
pub struct Editor {
    /// What happens to parts that are cut loose.
    pub policy: LooseParts,
    history: History,
    search: LooseSearch,
    dropped: Vec<(Cell, CellState)>,
    changed: Vec<Cell>,
}

/// What an update has changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Applied<'a> {
    /// The cells that are something else than before, ascending.
    pub changed: &'a [Cell],
    /// What was cut loose.
    pub loose: LooseReport,
}

impl Editor {
    /// An editor that can undo the last `depth` updates.
    pub fn new(depth: usize, policy: LooseParts) -> Self {
        Self {
            policy,
            history: History::new(depth),
            search: LooseSearch::new(),
            dropped: Vec::new(),
            changed: Vec::new(),
        }
    }

    /// Changes the model as resolved; `held` marks the nodes of the lattice that hold the body.
    ///
    /// The change can be undone whatever the depth, until it is [settled](Self::settle) or the next one is made. Where cells were removed or added, parts that hang on nothing are searched, and dropped where that is the policy, as a part of
    /// the same update. Nothing to change is no update: it cannot be undone.
    ///
    /// # Errors
    /// Changes that the model refuses, or that leave nothing that is held while loose parts are dropped. The model is then as
    /// it was.
    pub fn apply(
        &mut self,
        model: &mut FineModel,
        resolved: &Resolved,
        held: &[bool],
    ) -> Result<Applied<'_>, EditError> {
        self.history.trim();
        self.changed.clear();
        let mut loose = LooseReport::default();
        if resolved.changes.is_empty() {
            return Ok(Applied { changed: &self.changed, loose });
        }
        self.history.change(model, &resolved.changes)?;
        self.changed.extend(resolved.changes.iter().map(|(cell, _)| *cell));
        if resolved.removed + resolved.added > 0 {
            loose = self.search.find(model, held);
            if loose.parts > 0 && self.policy == LooseParts::Drop {
                self.drop_loose(model)?;
                loose.dropped = true;
            }
        }
        Ok(Applied { changed: &self.changed, loose })
    }

    /// Tells that the last change stays: the oldest one beyond the depth can no longer be undone.
    pub fn settle(&mut self) {
        self.history.trim();
    }

    fn drop_loose(&mut self, model: &mut FineModel) -> Result<(), EditError> {
        let cells = model.solid_count();
        if self.search.cells().len() == cells {
            self.history.undo(model, &mut self.changed)?;
            self.changed.clear();
            return Err(EditError::NothingHeld { cells });
        }
        self.dropped.clear();
        let void = |cell: &Cell| (*cell, CellState { void: true, ..model.state(*cell) });
        self.dropped.extend(self.search.cells().iter().map(void));
        self.history.extend(model, &self.dropped)?;
        self.changed.extend(self.search.cells());
        self.changed.sort_unstable();
        self.changed.dedup();
        Ok(())
    }

    /// Undoes the last update; the cells that it set back, ascending, or `None` where there is nothing to undo.
    ///
    /// # Errors
    /// A model other than the one that was changed, to which the states do not fit.
    pub fn undo(&mut self, model: &mut FineModel) -> Result<Option<&[Cell]>, EditError> {
        let done = self.history.undo(model, &mut self.changed)?;
        Ok(done.then_some(&self.changed))
    }

    /// Makes the model again what it was before an undoing: `states` of the cells that were set back. It can be undone like an update.
    ///
    /// # Errors
    /// As [`History::change`].
    pub fn redo(&mut self, model: &mut FineModel, states: &[(Cell, CellState)]) -> Result<(), EditError> {
        Ok(self.history.change(model, states)?)
    }

    /// What can be undone.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// The parts of the model that hang on nothing, as [`LooseSearch::find`], and their cells.
    pub fn loose(&mut self, model: &FineModel, held: &[bool]) -> (LooseReport, &[Cell]) {
        (self.search.find(model, held), self.search.cells())
    }
}
