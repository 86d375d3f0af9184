//! What holds the body and what loads it: `[[fix]]` and `[[load]]`.

use grosgrain::mesh::Selector;

use super::document::{Item, Reading, read_all};
use super::motion::{self, SceneMotion};
use super::section::Section;
use super::selector::read_selector;
use super::span::{Span, read_span};

/// A part of the body whose displacement is prescribed.
#[derive(Clone, Debug, PartialEq)]
pub struct Fix {
    /// The nodes that are held.
    pub selection: Selector,
    /// How they move; without it they stand still.
    pub motion: Option<SceneMotion>,
    /// When they move, and until when they are held.
    pub span: Span,
    /// Its key, e.g. `fix[0]`.
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
    /// Springs from the selected nodes to where they were.
    Spring(Selector, Spring),
}

/// Springs that tie nodes to points in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Force per length of all springs together \[N/m\], spread evenly over the nodes.
    pub stiffness: f64,
    /// From the undeformed place of a node to the point that it is tied to \[m\].
    pub offset: [f64; 3],
}

/// A load with the key that it stands under.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// What it does.
    pub kind: LoadKind,
    /// When it acts.
    pub span: Span,
    /// Its key, e.g. `load[0]`.
    pub key: String,
}

impl Load {
    /// Where it acts, if not on the whole body.
    pub fn selection(&self) -> Option<&Selector> {
        match &self.kind {
            LoadKind::Gravity(_) => None,
            LoadKind::Traction(selection, _) | LoadKind::Force(selection, _) | LoadKind::Spring(selection, _) => {
                Some(selection)
            }
        }
    }

    /// Whether it acts through springs.
    pub fn is_spring(&self) -> bool {
        matches!(self.kind, LoadKind::Spring(..))
    }

    /// Whether it acts on a body that does not move; springs without an offset do not.
    pub fn acts_at_rest(&self) -> bool {
        !matches!(self.kind, LoadKind::Spring(_, Spring { offset: [0.0, 0.0, 0.0], .. }))
    }
}

/// Reads `[[fix]]`.
pub fn read_fixes(item: &Item) -> Reading<Vec<Fix>> {
    read_all(&item.list("one table [[fix]] for each part that is held")?, |fix| {
        let section = fix.section(&["where", "move", "from", "to", "until"])?;
        let misplaced = refuse_times_beside_move(&section);
        let selection = section.required("where", "the selector of the part that is held", read_selector);
        let moving = section.optional("move", |item| item.section(motion::KEYS));
        let moving = moving?;
        misplaced?;
        let motion = moving.as_ref().map(motion::read_motion).transpose();
        let span = read_span(moving.as_ref(), &section);
        Ok(Fix { selection: selection?, motion: motion?, span: span?, key: fix.key().into() })
    })
}

/// The times of a motion stand with it; beside it they could be taken for those of the hold.
fn refuse_times_beside_move(section: &Section) -> Reading<()> {
    let misplaced = ["from", "to"].into_iter().filter_map(|name| Some((name, section.get(name)?)));
    let refuse = |(name, item): (&str, Item)| {
        Err(item.note(format!("{} stands beside move; expected it inside, move = {{ .., {name} = .. }}", item.key())))
    };
    misplaced.map(refuse).collect::<Vec<_>>().into_iter().collect()
}

const LOAD_KEYS: &[&str] = &["where", "gravity", "traction", "force", "spring", "from", "to", "until"];

/// Reads `[[load]]`.
pub fn read_loads(item: &Item) -> Reading<Vec<Load>> {
    read_all(&item.list("one table [[load]] for each load")?, |load| {
        let section = load.section(LOAD_KEYS)?;
        let span = read_span(Some(&section), &section);
        Ok(Load { kind: read_load(&section)?, span: span?, key: load.key().into() })
    })
}

fn read_load(section: &Section) -> Reading<LoadKind> {
    section.exclusive(&["gravity", "traction", "force", "spring"], "write one [[load]] table for each")?;
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
    if let Some(spring) = section.get("spring") {
        let (selection, spring) = (selection(), read_spring(&spring));
        return Ok(LoadKind::Spring(selection?, spring?));
    }
    Err(section.note(format!("{} does not load anything; expected gravity, traction, force or spring", section.key())))
}

fn read_spring(item: &Item) -> Reading<Spring> {
    let section = item.section(&["stiffness", "offset"])?;
    let expected = "a positive number of N/m, that of all springs together";
    let stiffness = section.required("stiffness", expected, |k| k.number_where(expected, |k| k > 0.0));
    let offset = section.optional("offset", Item::vector);
    Ok(Spring { stiffness: stiffness?, offset: offset?.unwrap_or_default() })
}
