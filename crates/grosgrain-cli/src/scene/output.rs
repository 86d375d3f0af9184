//! What a run writes: `[output]`.

use grosgrain::mesh::Selector;

use super::document::{Item, Reading};
use super::selector::read_selector;

/// The `[output]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Every how many steps a frame is written.
    pub frames: usize,
    /// Whether a picture is written.
    pub picture: bool,
    /// Whether an animated picture is written.
    pub animation: bool,
    /// Whether the deformed volume is written.
    pub volume: bool,
    /// Whether the fine model runs too, for comparison.
    pub compare_with_fine: bool,
    /// Cells that pictures leave out, to show the inside.
    pub hide: Option<Selector>,
}

impl Default for Output {
    fn default() -> Self {
        Self { frames: 1, picture: false, animation: false, volume: false, compare_with_fine: false, hide: None }
    }
}

/// Reads `[output]`.
pub fn read_output(item: &Item) -> Reading<Output> {
    let section = item.section(&["frames", "picture", "animation", "volume", "compare", "hide"])?;
    let default = Output::default();
    let frames = section.optional("frames", Item::count);
    let picture = section.optional("picture", Item::boolean);
    let animation = section.optional("animation", Item::boolean);
    let volume = section.optional("volume", Item::boolean);
    let compare = section.optional("compare", |c| c.choice(&[("fine", true)]));
    let hide = section.optional("hide", read_selector);
    Ok(Output {
        frames: frames?.unwrap_or(default.frames),
        picture: picture?.unwrap_or(default.picture),
        animation: animation?.unwrap_or(default.animation),
        volume: volume?.unwrap_or(default.volume),
        compare_with_fine: compare?.unwrap_or(default.compare_with_fine),
        hide: hide?,
    })
}
