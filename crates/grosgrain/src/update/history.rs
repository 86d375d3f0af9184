//! What can be undone.

use std::collections::VecDeque;

use crate::fine::{CellState, ChangeError, FineModel};
use crate::mesh::Cell;

/// The last changes of a model, each with what was there before; the oldest gives way when there are more than `depth`.
///
/// Buffers are used again, so memory stops growing with the largest change.
#[derive(Clone, Debug, Default)]
pub struct History {
    depth: usize,
    entries: VecDeque<Vec<(Cell, CellState)>>,
    spare: Vec<Vec<(Cell, CellState)>>,
}

impl History {
    /// An empty history of up to `depth` changes.
    pub fn new(depth: usize) -> Self {
        Self { depth, entries: VecDeque::with_capacity(depth + 1), spare: Vec::new() }
    }

    /// Number of changes that can be undone.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether nothing can be undone.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Changes the model as one entry of the history.
    ///
    /// # Errors
    /// As [`FineModel::change`]; model and history are then as they were.
    pub fn change(&mut self, model: &mut FineModel, changes: &[(Cell, CellState)]) -> Result<(), ChangeError> {
        let mut previous = self.spare.pop().unwrap_or_default();
        previous.clear();
        match model.change(changes, &mut previous) {
            Ok(()) => self.entries.push_back(previous),
            Err(error) => {
                self.spare.push(previous);
                return Err(error);
            }
        }
        Ok(())
    }

    /// Changes the model as a part of the newest entry; as an entry of its own where there is none.
    ///
    /// # Errors
    /// As [`change`](Self::change).
    pub fn extend(&mut self, model: &mut FineModel, changes: &[(Cell, CellState)]) -> Result<(), ChangeError> {
        match self.entries.back_mut() {
            Some(newest) => model.change(changes, newest),
            None => self.change(model, changes),
        }
    }

    /// What the newest entry sets back, in the order of its changes; nothing where there is no entry.
    pub fn newest(&self) -> &[(Cell, CellState)] {
        self.entries.back().map_or(&[], Vec::as_slice)
    }

    /// Drops the oldest entries beyond the depth. Until this is called after a change, that change can be undone at any depth.
    pub fn trim(&mut self) {
        while self.entries.len() > self.depth {
            self.spare.extend(self.entries.pop_front());
        }
    }

    /// Undoes the newest entry; `undone` receives the cells that it set back, ascending, each once. Returns whether there was one.
    ///
    /// # Errors
    /// None on the model that was changed; on another one as [`FineModel::restore`], the entry then stays.
    pub fn undo(&mut self, model: &mut FineModel, undone: &mut Vec<Cell>) -> Result<bool, ChangeError> {
        undone.clear();
        let Some(newest) = self.entries.back() else { return Ok(false) };
        model.restore(newest)?;
        undone.extend(newest.iter().map(|(cell, _)| *cell));
        undone.sort_unstable();
        undone.dedup();
        self.spare.extend(self.entries.pop_back());
        Ok(true)
    }
}
