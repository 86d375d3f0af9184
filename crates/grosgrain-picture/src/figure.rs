//! What a figure shows: panels with a surface, its colours and lines.

use crate::{
    PictureError, View,
    colour::{ColourMap, Rgb},
};

/// A line list: pairs of end points.
pub type Lines = Vec<[[f64; 3]; 2]>;

/// A picture of one or more bodies, all seen by the same camera at the same scale.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Heading; empty for none.
    pub title: String,
    /// The panels, in reading order.
    pub panels: Vec<Panel>,
    /// Small lines under the panels.
    pub footer: Vec<String>,
    /// The view; `None` chooses a three-quarter view from the bodies' extent, z up.
    pub view: Option<View>,
    /// Width in pixels, 400 to 4000; the height follows.
    pub width: usize,
    /// Panels per row; `None` puts up to three in a row.
    pub columns: Option<usize>,
}

impl Default for Figure {
    fn default() -> Self {
        Self { title: String::new(), panels: Vec::new(), footer: Vec::new(), view: None, width: 1800, columns: None }
    }
}

/// One body with its caption and its key.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Heading of the panel.
    pub caption: String,
    /// A second, lighter line under the caption; empty for none.
    pub detail: String,
    /// The body's surface.
    pub surface: QuadSurface,
    /// How the surface is coloured.
    pub colouring: Colouring,
    /// Lines on the surface, such as coarse cell edges; hidden where the surface hides them.
    pub grid: Lines,
    /// A surface of which only the edges of faces turned to the eye are drawn, such as that of a coarse mesh in or around the body; hidden only where the body's surface lies far
    /// in front of it.
    pub wires: QuadSurface,
    /// Faint lines, such as the outline of the undeformed body; drawn on the background only.
    pub ghost: Lines,
}

/// A surface of quadrilaterals and triangles, corners in order around each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadSurface {
    /// Deformed positions, any unit.
    pub positions: Vec<[f64; 3]>,
    /// Four vertices each; a triangle names its last one twice. Either orientation is drawn.
    pub quads: Vec<[u32; 4]>,
}

impl QuadSurface {
    /// A surface of triangles alone.
    ///
    /// ```
    /// use grosgrain_picture::QuadSurface;
    /// let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// assert_eq!(QuadSurface::of_triangles(positions, &[[0, 1, 2]]).quads, [[0, 1, 2, 2]]);
    /// ```
    pub fn of_triangles(positions: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Self {
        Self { positions, quads: triangles.iter().map(|[a, b, c]| [*a, *b, *c, *c]).collect() }
    }
}

impl QuadSurface {
    fn validate(&self, panel: usize, what: &'static str) -> Result<(), PictureError> {
        let count = self.positions.len();
        for (quad, corners) in self.quads.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|v| **v as usize >= count) {
                return Err(PictureError::Index { panel, quad, what, index, count });
            }
        }
        Ok(())
    }
}

/// How a surface is coloured.
#[derive(Clone, Debug, PartialEq)]
pub enum Colouring {
    /// One colour, no key.
    Plain(Rgb),
    /// A colour per category, with a legend.
    Category {
        /// Category of each quad, an index into `legend`.
        of_quad: Vec<u32>,
        /// The categories.
        legend: Vec<Category>,
    },
    /// A colour by value, with a colour bar.
    Scalar {
        /// Value at each vertex.
        at_vertex: Vec<f64>,
        /// What the values mean and how they become colours.
        scale: ColourScale,
    },
    /// A colour by value that jumps from quad to quad, with a colour bar.
    QuadScalar {
        /// Value of each quad.
        of_quad: Vec<f64>,
        /// What the values mean and how they become colours.
        scale: ColourScale,
    },
}

impl Default for Colouring {
    fn default() -> Self {
        Self::Plain([0xc9, 0xcf, 0xd8])
    }
}

/// A category of quads, such as a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Category {
    /// Name in the legend.
    pub name: String,
    /// Colour; `None` takes the palette's.
    pub colour: Option<Rgb>,
}

impl Category {
    /// A category in the palette's colour.
    pub fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), colour: None }
    }
}

/// What values mean and how they become colours.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColourScale {
    /// Name with the unit in brackets: `|u| [m]`, `error [% of max |u|]`.
    pub label: String,
    /// The colour map.
    pub map: ColourMap,
    /// Runs the colour map backwards: the lowest value takes its last colour.
    pub reversed: bool,
    /// Values at the ends of the bar; `None` takes the panel's own, widened to nice numbers and to zero when near.
    pub range: Option<[f64; 2]>,
}

impl Figure {
    pub(crate) fn validate(&self) -> Result<(), PictureError> {
        if self.panels.is_empty() {
            return Err(PictureError::NoPanels);
        }
        self.panels.iter().enumerate().try_for_each(|(at, panel)| panel.validate(at))
    }
}

impl Panel {
    pub(crate) fn validate(&self, at: usize) -> Result<(), PictureError> {
        let surface = &self.surface;
        if surface.quads.is_empty() {
            return Err(PictureError::EmptySurface { panel: at, caption: self.caption.clone() });
        }
        finite(at, "a coordinate of vertex", &surface.positions, |p| p)?;
        finite(at, "a coordinate of grid line", &self.grid, |line| line.as_flattened())?;
        finite(at, "a coordinate of ghost line", &self.ghost, |line| line.as_flattened())?;
        finite(at, "a coordinate of wire vertex", &self.wires.positions, |p| p)?;
        surface.validate(at, "vertex")?;
        self.wires.validate(at, "wire vertex")?;
        self.validate_colouring(at)
    }

    fn validate_colouring(&self, at: usize) -> Result<(), PictureError> {
        match &self.colouring {
            Colouring::Plain(_) => Ok(()),
            Colouring::Category { of_quad, legend } => {
                length(at, "categories", of_quad.len(), (self.surface.quads.len(), "quads"))?;
                let count = legend.len();
                match of_quad.iter().enumerate().find(|(_, c)| **c as usize >= count) {
                    None => Ok(()),
                    Some((quad, &index)) => {
                        Err(PictureError::Index { panel: at, quad, what: "category", index, count })
                    }
                }
            }
            Colouring::Scalar { at_vertex, scale } => {
                length(at, "values", at_vertex.len(), (self.surface.positions.len(), "vertices"))?;
                finite(at, "the value at vertex", at_vertex, std::slice::from_ref)?;
                scale.validate(at)
            }
            Colouring::QuadScalar { of_quad, scale } => {
                length(at, "values", of_quad.len(), (self.surface.quads.len(), "quads"))?;
                finite(at, "the value of quad", of_quad, std::slice::from_ref)?;
                scale.validate(at)
            }
        }
    }
}

impl ColourScale {
    fn validate(&self, panel: usize) -> Result<(), PictureError> {
        match self.range {
            Some([low, high]) if !(low < high && (high - low).is_finite()) => {
                Err(PictureError::Range { panel, low, high })
            }
            _ => Ok(()),
        }
    }
}

fn finite<T>(panel: usize, what: &'static str, items: &[T], numbers: fn(&T) -> &[f64]) -> Result<(), PictureError> {
    for (index, item) in items.iter().enumerate() {
        // Squares of coordinates are summed later: what overflows there is as unusable as an infinity.
        if let Some(&value) = numbers(item).iter().find(|x| x.is_nan() || x.abs() > 1e150) {
            return Err(PictureError::NotFinite { panel, what, index, value });
        }
    }
    Ok(())
}

fn length(
    panel: usize,
    what: &'static str,
    found: usize,
    (expected, per): (usize, &'static str),
) -> Result<(), PictureError> {
    match found == expected {
        true => Ok(()),
        false => Err(PictureError::Length { panel, what, found, expected, per }),
    }
}
