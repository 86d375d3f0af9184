//! Several edits as one update: later ones see what earlier ones made.

use std::collections::BTreeMap;

use super::{BatchError, Change, Edit, EditError, Region, Resolved};
use crate::fine::{CellState, ChangeError, FineModel};
use crate::mesh::{Cell, Label};

/// Edits that are gathered into one list of changes; the model itself does not change.
pub struct Batch<'m> {
    model: &'m FineModel,
    states: BTreeMap<Cell, CellState>,
    picked: Vec<Cell>,
}

/// The net changes of edits that are made one after the other: selectors and states of each see what those before it made,
/// and a cell that is changed and changed back does not appear.
///
/// # Errors
/// As [`Edit::resolve`], with the number of the edit; that nothing would be left is told of the last one.
pub fn resolve_all(edits: &[Edit], model: &FineModel) -> Result<Resolved, BatchError> {
    let mut batch = Batch::new(model);
    for (n, edit) in edits.iter().enumerate() {
        batch.add(edit).map_err(|reason| BatchError { edit: n, reason })?;
    }
    batch.finish().map_err(|reason| BatchError { edit: edits.len().saturating_sub(1), reason })
}

impl<'m> Batch<'m> {
    /// No edits yet.
    pub fn new(model: &'m FineModel) -> Self {
        Self { model, states: BTreeMap::new(), picked: Vec::new() }
    }

    fn state(&self, cell: Cell) -> CellState {
        self.states.get(&cell).copied().unwrap_or_else(|| self.model.state(cell))
    }

    /// Adds an edit; one that is refused leaves the batch as it was.
    ///
    /// # Errors
    /// As [`Edit::resolve`], but for a body of which nothing would be left.
    pub fn add(&mut self, edit: &Edit) -> Result<(), EditError> {
        let mut picked = std::mem::take(&mut self.picked);
        let added = self.pick(&edit.region, &mut picked).and_then(|()| self.add_to(&picked, edit.change));
        self.picked = picked;
        added
    }

    /// The cells of a region, ascending, each once.
    fn pick(&self, region: &Region, picked: &mut Vec<Cell>) -> Result<(), EditError> {
        let grid = self.model.grid();
        match region {
            Region::Selector(selector) => {
                selector.validate()?;
                let solid = |cell: Cell| {
                    let state = self.state(cell);
                    (!state.void).then_some(state.label)
                };
                selector.pick_cells_of(grid, &solid, picked);
            }
            Region::Cells(cells) => {
                let outside = cells.iter().find(|cell| cell.0 >= grid.lattice.cell_count());
                if let Some(cell) = outside {
                    return Err(ChangeError::Outside { cell: cell.0, cells: grid.lattice.cells }.into());
                }
                picked.clear();
                picked.extend(cells);
                picked.sort_unstable();
                picked.dedup();
            }
        }
        match picked.is_empty() {
            false => Ok(()),
            true => {
                let [low, high] = grid.body_box().unwrap_or_default().map(|at| grid.position(at));
                Err(EditError::NoCell { low, high })
            }
        }
    }

    fn add_to(&mut self, picked: &[Cell], change: Change) -> Result<(), EditError> {
        let fills = matches!(change, Change::Add(_));
        let fits = |cell: &&Cell| self.state(**cell).void == fills;
        let changed = |cell: &Cell| (*cell, changed(self.state(*cell), change));
        let states: Vec<(Cell, CellState)> = picked.iter().filter(fits).map(changed).collect();
        if states.is_empty() {
            let cells = picked.len();
            return Err(if fills { EditError::NothingVoid { cells } } else { EditError::NothingSolid { cells } });
        }
        for (cell, state) in &states {
            self.model.check(*cell, state)?;
        }
        self.states.extend(states);
        Ok(())
    }

    /// What the edits change together.
    ///
    /// # Errors
    /// No solid cell would be left.
    pub fn finish(self) -> Result<Resolved, EditError> {
        let model = self.model;
        let mut resolved = Resolved::default();
        for (cell, state) in self.states.into_iter().filter(|(cell, state)| differs(model, *cell, state)) {
            let was_void = model.is_void(cell);
            resolved.removed += usize::from(state.void && !was_void);
            resolved.added += usize::from(!state.void && was_void);
            resolved.changes.push((cell, state));
        }
        let cells = model.solid_count();
        match cells + resolved.added == resolved.removed {
            true => Err(EditError::Everything { cells }),
            false => Ok(resolved),
        }
    }
}

fn changed(state: CellState, change: Change) -> CellState {
    let of_material = |label: Label| CellState { label, void: false, young: None, density: None };
    match change {
        Change::Material(label) | Change::Add(label) => of_material(label),
        Change::Young(young) => CellState { young: Some(young), ..state },
        Change::Remove => CellState { void: true, ..state },
    }
}

/// Whether a cell would be something else: voids are all alike, solid cells differ by label, modulus or density.
fn differs(model: &FineModel, cell: Cell, state: &CellState) -> bool {
    let now = model.state(cell);
    let same = now.label == state.label
        && model.young_of(&now) == model.young_of(state)
        && model.density_of(&now) == model.density_of(state);
    now.void != state.void || !(now.void || same)
}
