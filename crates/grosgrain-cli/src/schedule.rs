//! Which edits of a scene are due at which step.

use grosgrain::mesh::{Label, Selector, VoxelGrid};
use grosgrain::update::{Change, Edit, Region};

use crate::scene::{Repeat, Scene, SceneChange, SceneEdit};

/// The edits of a scene with their steps.
#[derive(Clone, Debug, PartialEq)]
pub struct EditSchedule {
    entries: Vec<(SceneEdit, Change)>,
    /// Seconds per step, where the scene gives them.
    step: Option<f64>,
    steps: usize,
    /// The body's box, to which edits that add cells are confined: the lattice may be padded beyond it.
    extent: Selector,
}

/// An edit that is due.
#[derive(Clone, Debug, PartialEq)]
pub struct Due {
    /// The key of its table, e.g. `edit[0]`.
    pub key: String,
    /// Which repetition, from 0.
    pub repetition: usize,
    /// What it does.
    pub edit: Edit,
}

impl EditSchedule {
    /// The schedule of a scene whose body, before padding, is on `grid`.
    pub fn new(scene: &Scene, grid: &VoxelGrid) -> Self {
        // The scene's reader has refused names that no material has.
        let label = |name: &str| scene.materials.iter().find(|m| m.name == name).map_or(Label(i32::MIN), |m| m.label);
        let change = |edit: &SceneEdit| match &edit.change {
            SceneChange::Material(name) => Change::Material(label(name)),
            SceneChange::Young(young) => Change::Young(*young),
            SceneChange::Remove => Change::Remove,
            SceneChange::Add(name) => Change::Add(label(name)),
        };
        let last = scene.edits.iter().filter_map(|edit| edit.last_step(scene.time.step)).max();
        Self {
            entries: scene.edits.iter().map(|edit| (edit.clone(), change(edit))).collect(),
            step: scene.time.step,
            steps: match scene.edits.is_empty() && !scene.is_dynamic() {
                true => 0,
                false => scene.time.steps.or(last).unwrap_or(0),
            },
            extent: Selector::Box { low: grid.origin, high: grid.position(grid.lattice.cells) },
        }
    }

    /// Number of steps after the first equilibrium: the scene's, else up to the last edit; none in a static run without edits.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Ends the run after `steps` steps at the latest; edits that would come later are not made.
    pub fn end_after(&mut self, steps: usize) {
        self.steps = self.steps.min(steps);
    }

    /// The time of a step \[s\]; a step takes a second where the scene does not say.
    pub fn time(&self, step: usize) -> f64 {
        step as f64 * self.step.unwrap_or(1.0)
    }

    /// The edits of a step from 1 on, in the order of the scene.
    pub fn due(&self, step: usize) -> Vec<Due> {
        let due = |(scheduled, change): &(SceneEdit, Change)| {
            let repetition = self.repetition(scheduled, step)?;
            let by = scheduled.repeat.map_or([0.0; 3], |r| r.advance.map(|x| repetition as f64 * x));
            let moved = scheduled.selection.moved(by);
            let selector = match change {
                Change::Add(_) => Selector::And(vec![self.extent.clone(), moved]),
                _ => moved,
            };
            let edit = Edit { region: Region::Selector(selector), change: *change };
            Some(Due { key: scheduled.key.clone(), repetition, edit })
        };
        self.entries.iter().filter_map(due).collect()
    }

    /// Which repetition of an edit falls on a step: at most one does, since intervals are no shorter than a step.
    fn repetition(&self, edit: &SceneEdit, step: usize) -> Option<usize> {
        let Some(Repeat { every, .. }) = edit.repeat else {
            return (edit.step(0, self.step) == Some(step)).then_some(0);
        };
        let length = self.step.unwrap_or(1.0);
        let near = (self.time(step) - edit.at.seconds(length)) / every.seconds(length);
        let near = near.max(0.0) as usize;
        (near.saturating_sub(1)..=near + 1).find(|n| edit.step(*n, self.step) == Some(step))
    }
}
