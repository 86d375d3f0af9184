//! From a figure to a picture: where title, panels, keys and footer go.

use crate::{
    Figure, Image, Panel, PictureError,
    body::{self, Placement, View},
    camera::Camera,
    image::Rect,
    key,
    text::Style,
    theme::{PAGE, PAPER, RULE, Theme},
};
use rayon::prelude::*;

/// Height of a line of text in em.
const LEADING: f32 = 1.32;

impl Figure {
    /// Draws the figure.
    ///
    /// All panels share one camera, fitted to everything they show, and one scale. The same input gives the same
    /// pixels, whatever the machine's number of cores.
    ///
    /// # Errors
    /// No panels, an empty surface, numbers that are not finite, indices or lists that do not fit, an empty colour
    /// range, a width outside 400 to 4000 pixels, a view without direction.
    pub fn render(&self) -> Result<Image, PictureError> {
        let theme = Theme::new(self.width)?;
        self.validate()?;
        let points: Vec<[f64; 3]> = self.panels.iter().flat_map(Panel::points).collect();
        let camera = Camera::new(self.view, &points)?;
        let layout = Layout::new(self, &theme, &camera);
        let mut image = Image::new(self.width, layout.height as usize, PAGE);
        layout.draw(self, &camera, &mut image);
        Ok(image)
    }
}

impl Panel {
    /// Everything the camera must see. A vertex that no quad uses is not drawn, but may say how much room to leave.
    pub(crate) fn points(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let lines = self.grid.iter().chain(&self.ghost);
        let vertices = self.surface.positions.iter().chain(&self.wires.positions).copied();
        vertices.chain(lines.flat_map(|line| *line))
    }
}

/// Where everything goes, in pixels.
struct Layout<'a> {
    theme: &'a Theme,
    title: Vec<String>,
    footer: Vec<String>,
    columns: usize,
    margin: f32,
    gap: f32,
    /// Width of a card, and of what it holds.
    card: f32,
    inner: f32,
    /// Size of a view in whole pixels.
    view: [usize; 2],
    scale: f64,
    rows: Vec<Row>,
    height: f32,
}

/// A row of panels: heights that its cards share.
struct Row {
    top: f32,
    heading: f32,
    key: f32,
    card: f32,
}

impl<'a> Layout<'a> {
    fn new(figure: &Figure, theme: &'a Theme, camera: &Camera) -> Self {
        let u = theme.unit;
        let count = figure.panels.len();
        let columns = figure.columns.unwrap_or_else(|| default_columns(count)).clamp(1, count);
        let (margin, gap, padding) = (48.0 * u, 28.0 * u, 26.0 * u);
        let width = figure.width as f32;
        let card = ((width - 2.0 * margin - gap * (columns - 1) as f32) / columns as f32).floor();
        let inner = (card - 2.0 * padding).floor();
        let (view, scale) = fit(camera, inner, 0.48 * width);
        let title = theme.face.wrap(&figure.title, theme.title(), width - 2.0 * margin);
        let footer =
            figure.footer.iter().flat_map(|f| theme.face.wrap(f, theme.small(), width - 2.0 * margin)).collect();
        let mut layout =
            Self { theme, title, footer, columns, margin, gap, card, inner, view, scale, rows: vec![], height: 0.0 };
        layout.stack(figure);
        layout
    }

    /// Places the rows under the title and finds the picture's height.
    fn stack(&mut self, figure: &Figure) {
        let u = self.theme.unit;
        let mut y = self.margin + lines_height(&self.title, self.theme.title());
        y += if self.title.is_empty() { 0.0 } else { 20.0 * u };
        for panels in figure.panels.chunks(self.columns) {
            let heading = panels.iter().map(|p| self.heading(p).iter().map(|h| h.2).sum()).fold(0.0, f32::max);
            let heading = if heading > 0.0 { heading + 14.0 * u } else { 0.0 };
            let key = panels.iter().map(|p| key::height(p, self.theme, self.inner)).fold(0.0, f32::max);
            let space = if key > 0.0 { 22.0 * u } else { 0.0 };
            let card = (24.0 * u + heading + self.view[1] as f32 + space + key + 22.0 * u).ceil();
            self.rows.push(Row { top: y.round(), heading, key, card });
            y += card + self.gap;
        }
        y += lines_height(&self.footer, self.theme.small()) + if self.footer.is_empty() { 0.0 } else { 6.0 * u };
        self.height =
            (y - self.gap + if self.footer.is_empty() { self.margin } else { 0.72 * self.margin + self.gap }).ceil();
    }

    /// The lines over a panel's view, each with its style and height.
    fn heading(&self, panel: &Panel) -> Vec<(String, Style, f32)> {
        let lines = |text: &str, style: Style| {
            let wrapped = self.theme.face.wrap(text, style, self.inner);
            wrapped.into_iter().map(move |line| (line, style, LEADING * style.size)).collect::<Vec<_>>()
        };
        [lines(&panel.caption, self.theme.caption()), lines(&panel.detail, self.theme.detail())].concat()
    }

    fn draw(&self, figure: &Figure, camera: &Camera, image: &mut Image) {
        let mut y = self.margin;
        for line in &self.title {
            self.theme.face.draw(image, [self.margin, y + 0.95 * self.theme.title().size], line, self.theme.title());
            y += LEADING * self.theme.title().size;
        }
        let views: Vec<View> = figure.panels.par_iter().map(|panel| self.view(panel, camera)).collect();
        for (at, (panel, view)) in figure.panels.iter().zip(&views).enumerate() {
            self.draw_panel(panel, at, view, image);
        }
        let style = self.theme.small();
        let mut y = self.rows.last().map_or(0.0, |row| row.top + row.card + self.gap);
        for line in &self.footer {
            self.theme.face.draw(image, [self.margin, y + 0.95 * style.size], line, style);
            y += LEADING * style.size;
        }
    }

    /// Draws a panel's body; bodies are independent of each other.
    fn view(&self, panel: &Panel, camera: &Camera) -> View {
        let stroke = f64::from(self.theme.unit).max(0.6);
        let placement = Placement { camera, scale: self.scale, size: self.view, range: key::range(panel), stroke };
        body::draw(panel, &placement, PAPER)
    }

    fn draw_panel(&self, panel: &Panel, at: usize, view: &View, image: &mut Image) {
        let u = self.theme.unit;
        let row = &self.rows[at / self.columns];
        let x = (self.margin + (self.card + self.gap) * (at % self.columns) as f32).round();
        let card = Rect { x, y: row.top, width: self.card, height: row.card };
        image.fill(card, 14.0 * u, |_, _| RULE);
        image.fill(card.inset((1.25 * u).max(1.0)), 13.0 * u, |_, _| PAPER);
        let left = (x + 0.5 * (self.card - self.inner)).round();
        let mut y = row.top + 24.0 * u;
        for (line, style, height) in self.heading(panel) {
            self.theme.face.draw(image, [left, y + 0.95 * style.size], &line, style);
            y += height;
        }
        view.paste(image, [left as usize, (row.top + 24.0 * u + row.heading).round() as usize]);
        let key = key::height(panel, self.theme, self.inner);
        // A smaller key is centred beside a larger one, unless that is a long legend.
        let key_top = row.top + row.card - 22.0 * u - row.key + (0.5 * (row.key - key)).min(30.0 * u);
        key::draw(panel, self.theme, image, Rect { x: left, y: key_top, width: self.inner, height: key });
    }
}

fn default_columns(panels: usize) -> usize {
    match panels {
        1..=3 => panels,
        4 => 2,
        _ => 3,
    }
}

fn lines_height(lines: &[String], style: Style) -> f32 {
    LEADING * style.size * lines.len() as f32
}

/// The view's size in pixels and its scale, so that the body fills the width or, if it is tall, the height.
pub(crate) fn fit(camera: &Camera, width: f32, tallest: f32) -> ([usize; 2], f64) {
    let [[left, bottom], [right, top]] = camera.bounds;
    let smallest = 1e-3 * camera.radius;
    let (across, high) = ((right - left).max(smallest), (top - bottom).max(smallest));
    // Room around the body for lines that straddle its rim.
    let (width, border) = (f64::from(width), 0.04 * f64::from(width));
    let shape = (high / across).clamp(0.3, 1.05);
    let height = (width * shape).min(f64::from(tallest)).round();
    let scale = ((width - border) / across).min((height - border) / high);
    ([width as usize, height as usize], scale)
}
