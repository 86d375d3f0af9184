//! Bodies in rows and columns under one camera: methods over times.

use crate::{
    Camera, Colouring, Image, Panel, PictureError, Sheet, SheetPicture, View,
    body::{self, Placement},
    key,
    layout::fit,
    sheet::Borders,
    theme::{PAPER, Theme},
};
use rayon::prelude::*;

/// Letters are at least this high \[pixels\].
const SMALLEST_LETTERS: f32 = 15.0;

/// A grid of bodies: a row per method, a column per time, all under one camera, at one scale and in the same colours.
///
/// The legend is that of the first panel with categories, which all panels should share. Panels coloured by value take one
/// range, and their `caption` or `detail` says what they show: the caption stands under the panel.
///
/// ```
/// use grosgrain_picture::{Panel, QuadSurface, Strip};
/// let sheet = |lift: f64| {
///     let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, lift], [0.0, 1.0, lift]];
///     let surface = QuadSurface { positions, quads: vec![[0, 1, 2, 3]] };
///     Some(Panel { surface, ..Panel::default() })
/// };
/// let strip = Strip {
///     rows: vec!["fine".into(), "coarse".into()],
///     columns: vec!["0.0 s".into(), "0.1 s".into()],
///     panels: vec![sheet(0.0), sheet(0.2), sheet(0.0), sheet(0.25)],
///     ..Strip::default()
/// };
/// assert_eq!(strip.render()?.width(), 1800);
/// # Ok::<(), grosgrain_picture::PictureError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Strip {
    /// Heading; empty for none.
    pub title: String,
    /// Label of each row.
    pub rows: Vec<String>,
    /// Label of each column.
    pub columns: Vec<String>,
    /// The bodies, row by row; `None` leaves the place empty.
    pub panels: Vec<Option<Panel>>,
    /// Small lines under the panels.
    pub footer: Vec<String>,
    /// The view; `None` chooses a three-quarter view, z up. Not used where there is a camera.
    pub view: Option<View>,
    /// A camera that several strips share; `None` fits one to all panels.
    pub camera: Option<Camera>,
    /// Width in pixels, 400 to 4000; the height follows.
    pub width: usize,
}

impl Default for Strip {
    fn default() -> Self {
        let (title, rows, columns, panels) = (String::new(), vec![], vec![], vec![]);
        Self { title, rows, columns, panels, footer: vec![], view: None, camera: None, width: 1800 }
    }
}

impl Strip {
    /// Draws the strip. The same input gives the same pixels for any number of threads.
    ///
    /// # Errors
    /// A number of panels that is not rows × columns, no body at all, what [`crate::Figure::render`] refuses.
    pub fn render(&self) -> Result<Image, PictureError> {
        Theme::new(self.width)?;
        let letters = (self.width as f32 / 80.0).max(SMALLEST_LETTERS);
        let theme = Theme::with_letters(letters)?;
        let (rows, columns, found) = (self.rows.len(), self.columns.len(), self.panels.len());
        if found != rows * columns || found == 0 {
            return Err(PictureError::SheetCount { rows, columns, found });
        }
        let panels = || self.panels.iter().enumerate().filter_map(|(at, panel)| Some((at, panel.as_ref()?)));
        panels().try_for_each(|(at, panel)| panel.validate(at))?;
        let camera = self.fitted_camera()?;
        let width = Borders::new(&theme, &self.rows).picture_width(self.width, columns).max(32.0);
        let (size, scale) = fit(&camera, width, 1.05 * width);
        let range = self.range();
        let stroke = f64::from(width / 800.0).clamp(0.45, 1.5);
        let draw = |panel: &Option<Panel>| {
            let place = Placement { camera: &camera, scale, size, range, stroke };
            let image = panel.as_ref().map(|panel| body::draw(panel, &place, PAPER).into_image());
            SheetPicture { image, note: panel.as_ref().map(|p| p.caption.clone()).unwrap_or_default() }
        };
        let pictures = self.panels.par_iter().map(draw).collect();
        let legend = panels().find_map(|(_, panel)| match &panel.colouring {
            Colouring::Category { legend, .. } => Some(legend.clone()),
            _ => None,
        });
        let sheet = Sheet {
            title: self.title.clone(),
            rows: self.rows.clone(),
            columns: self.columns.clone(),
            pictures,
            legend: legend.unwrap_or_default(),
            footer: self.footer.clone(),
            letters,
            width: self.width,
        };
        sheet.render()
    }

    /// The strip's own camera, or one that sees all its panels.
    fn fitted_camera(&self) -> Result<Camera, PictureError> {
        match &self.camera {
            Some(camera) => Ok(camera.clone()),
            None => {
                let points: Vec<[f64; 3]> = self.panels.iter().flatten().flat_map(Panel::points).collect();
                Camera::new(self.view, &points)
            }
        }
    }

    /// The range of values that all panels share.
    fn range(&self) -> [f64; 2] {
        let ranges = self.panels.iter().flatten().map(key::range);
        ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or([0.0, 1.0])
    }
}
