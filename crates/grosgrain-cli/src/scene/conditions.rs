//! What holds the body and what loads it: `[[fix]]` and `[[load]]`.

use grosgrain::mesh::Selector;

use super::document::{Item, Reading, read_all};
use super::section::Section;
use super::selector::read_selector;

/// A part of the body that does not move.
#[derive(Clone, Debug, PartialEq)]
pub struct Fix {
    /// The nodes that are held.
    pub selection: Selector,
    /// The scene's line.
    pub key: String,
}

/// What loads the body.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadKind {
    /// Acceleration of gravity \[m/s²\] on the whole body.
    Gravity([f64; 3]),
    /// Force per area \[Pa\] on the selected part of the body's surface.
    Traction(Selector, [f64; 3]),
    /// Total force \[N\], spread evenly over the selected nodes.
    Force(Selector, [f64; 3]),
}

/// A load with the key that it stands under.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// What it does.
    pub kind: LoadKind,
    /// Its key, e.g. `load[0]`.
    pub key: String,
}

/// Reads `[[fix]]`.
pub fn read_fixes(item: &Item) -> Reading<Vec<Fix>> {
    read_all(&item.list("one table [[fix]] for each part that is held")?, |fix| {
        let section = fix.section(&["where", "move"])?;
        let selection = section.required("where", "the selector of the part that is held", read_selector);
        section.optional("move", refuse_motion)?;
        Ok(Fix { selection: selection?, key: fix.key().into() })
    })
}

fn refuse_motion(item: &Item) -> Reading<()> {
    let sentence = "prescribes a motion, which this version cannot do; leave it out to hold the part still";
    Err(item.note(format!("{} {sentence}", item.key())))
}

/// Reads `[[load]]`.
pub fn read_loads(item: &Item) -> Reading<Vec<Load>> {
    read_all(&item.list("one table [[load]] for each load")?, |load| {
        let section = load.section(&["where", "gravity", "traction", "force"])?;
        Ok(Load { kind: read_load(&section)?, key: load.key().into() })
    })
}

fn read_load(section: &Section) -> Reading<LoadKind> {
    section.exclusive(&["gravity", "traction", "force"], "write one [[load]] table for each")?;
    let expected = "the selector of the part that is loaded";
    let selection = || section.required("where", expected, read_selector);
    if let Some(gravity) = section.get("gravity") {
        section.exclusive(&["where", "gravity"], "gravity acts on the whole body")?;
        return gravity.vector().map(LoadKind::Gravity);
    }
    if let Some(traction) = section.get("traction") {
        let (selection, traction) = (selection(), traction.vector());
        return Ok(LoadKind::Traction(selection?, traction?));
    }
    if let Some(force) = section.get("force") {
        let (selection, force) = (selection(), force.vector());
        return Ok(LoadKind::Force(selection?, force?));
    }
    Err(section.note(format!("{} does not load anything; expected gravity, traction or force", section.key())))
}
