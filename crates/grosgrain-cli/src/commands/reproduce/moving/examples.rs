//! What the paper says of the figures, and how we draw them.

use grosgrain_picture::{Rgb, View};

/// A figure of `he2022fast` whose body is edited in motion.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// The figure's name.
    pub name: &'static str,
    /// As the reader knows it.
    pub title: &'static str,
    /// The file in the folder of scenes.
    pub scene: &'static str,
    /// What an edit is called.
    pub edit: &'static str,
    /// Published errors with and without update in percent.
    pub errors: [Option<f64>; 2],
    /// What is published where there are no numbers.
    pub words: Option<[&'static str; 2]>,
    /// Published cost of an update.
    pub update: Option<PublishedUpdate>,
    /// Colours of materials by name; others get one of their own.
    pub colours: &'static [(&'static str, Rgb)],
    /// The view; `None` for a three-quarter view from above.
    pub view: Option<View>,
    /// Whether the scan that the body comes from is drawn too.
    pub scan: bool,
}

/// Published cost of an update on one thread.
#[derive(Clone, Copy, Debug)]
pub struct PublishedUpdate {
    /// Milliseconds for training data and for shape functions.
    pub milliseconds: [f64; 2],
    /// Coarse cells updated.
    pub cells: usize,
}

/// Soft material: light green; stiff material: dark magenta. The paper's colours, told apart by lightness as well.
const SOFT: Rgb = [0xa6, 0xd9, 0x9a];
const STIFF: Rgb = [0xa0, 0x1f, 0x7a];

/// The beam whose stiff cells are erased.
pub const FIG1: Example = Example {
    name: "fig1",
    title: "a beam of soft and stiff layers, stiff cells erased",
    scene: "fig1-beam.toml",
    edit: "erased",
    errors: [Some(24.0), Some(55.0)],
    words: None,
    update: Some(PublishedUpdate { milliseconds: [204.0, 257.0], cells: 24 }),
    colours: &[("soft", SOFT), ("stiff", STIFF)],
    view: None,
    scan: false,
};

/// The trunk from a CT that is cut.
pub const FIG4: Example = Example {
    name: "fig4",
    title: "a trunk from a CT, cut by a blade",
    scene: "fig4-abdomen.toml",
    edit: "cut",
    errors: [Some(28.0), None],
    words: None,
    update: Some(PublishedUpdate { milliseconds: [218.0, 605.0], cells: 216 }),
    colours: &[("soft-tissue", [0xe4, 0xa5, 0x8f]), ("bone", [0x4d, 0x3a, 0x2c])],
    view: Some(View { toward: [-0.62, -0.75, -0.2], up: [0.0, 0.0, 1.0], perspective: 0.2 }),
    scan: true,
};

/// The plate with active material that is twisted.
pub const FIG5: Example = Example {
    name: "fig5",
    title: "a plate with a grid of active material, twisted",
    scene: "fig5-plate.toml",
    edit: "softer",
    errors: [None, None],
    words: Some(["close match", "large error due to artificial stiffening"]),
    update: None,
    colours: &[
        ("substrate", SOFT),
        ("active-stiff", STIFF),
        ("active-medium", [0xde, 0x6a, 0x3a]),
        ("active-soft", [0xf5, 0xcf, 0x52]),
    ],
    view: None,
    scan: false,
};
