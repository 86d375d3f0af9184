//! Line charts of curves: error over unknowns, error over time.

use crate::{
    Image, PictureError,
    colour::Rgb,
    image::Rect,
    theme::{DARK, GREY, PAGE, PAPER, RULE, Theme},
    ticks::{Ticks, nice_range, widen},
};

/// A chart of curves over common axes.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Heading; empty for none.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The curves.
    pub series: Vec<Series>,
    /// What happened along the horizontal axis, such as cuts: dashed lines with labels over the plot.
    pub events: Vec<Event>,
    /// Width in pixels, 400 to 4000; the height is 0.58 of it.
    pub width: usize,
}

/// A place on the horizontal axis where something happened.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Event {
    /// Where on the horizontal axis.
    pub at: f64,
    /// What: `cut 1`; empty for a line alone.
    pub label: String,
}

impl Default for Chart {
    fn default() -> Self {
        Self {
            title: String::new(),
            x: Axis::default(),
            y: Axis::default(),
            series: Vec::new(),
            events: Vec::new(),
            width: 1400,
        }
    }
}

/// An axis of a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Name with the unit in brackets.
    pub label: String,
    /// Logarithmic: all coordinates must then be positive.
    pub logarithmic: bool,
    /// A tick at every whole number between the outermost coordinates and no others, as for a count of a few values; not with
    /// `logarithmic`.
    pub whole: bool,
}

/// A curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Its points, joined in this order.
    pub points: Vec<[f64; 2]>,
}

/// Colours of the curves: Paul Tol's "bright" scheme, distinct to colour-blind eyes.
const CURVES: [Rgb; 7] = [
    [0x44, 0x77, 0xaa],
    [0xee, 0x66, 0x77],
    [0x22, 0x88, 0x33],
    [0xcc, 0xbb, 0x44],
    [0x66, 0xcc, 0xee],
    [0xaa, 0x33, 0x77],
    [0x77, 0x77, 0x77],
];

/// Height of a row of event labels, and how many there are at most.
const EVENT_ROW: f32 = 30.0;
const MOST_EVENT_ROWS: usize = 4;
/// More whole numbers than this have no room for their labels.
const MOST_WHOLE: f64 = 15.0;

impl Chart {
    /// Draws the chart.
    ///
    /// # Errors
    /// No points, a coordinate that is not finite or not positive on a logarithmic axis, a width outside 400 to 4000.
    pub fn render(&self) -> Result<Image, PictureError> {
        let theme = Theme::new(self.width)?;
        self.validate()?;
        // A chart is read at smaller sizes than a figure: its letters are larger for its width.
        let theme = Theme { unit: 1.25 * theme.unit, ..theme };
        let mut image = Image::new(self.width, (0.58 * self.width as f64).round() as usize, PAGE);
        let scales = [
            Scale::new(&self.x, self.coordinates(0).chain(self.events.iter().map(|e| e.at))),
            Scale::new(&self.y, self.coordinates(1)),
        ];
        let plot = self.draw_frame(&theme, &mut image, &scales);
        self.draw_events(&theme, &mut image, &scales[0], plot);
        self.draw_curves(&theme, &mut image, &scales, plot);
        Ok(image)
    }

    fn validate(&self) -> Result<(), PictureError> {
        if self.coordinates(0).next().is_none() {
            return Err(PictureError::EmptyChart(self.title.clone()));
        }
        let placed = |event: &&Event| !(event.at.abs() < 1e150 && (event.at > 0.0 || !self.x.logarithmic));
        if let Some(event) = self.events.iter().find(placed) {
            return Err(PictureError::ChartEvent { label: event.label.clone(), at: event.at });
        }
        for series in &self.series {
            for (index, &[x, y]) in series.points.iter().enumerate() {
                let fits = |axis: &Axis, v: f64| v.abs() < 1e150 && (v > 0.0 || !axis.logarithmic);
                if !(fits(&self.x, x) && fits(&self.y, y)) {
                    return Err(PictureError::ChartPoint { series: series.name.clone(), index, x, y });
                }
            }
        }
        Ok(())
    }

    fn coordinates(&self, axis: usize) -> impl Iterator<Item = f64> + '_ {
        self.series.iter().flat_map(move |s| s.points.iter().map(move |p| p[axis]))
    }

    /// Draws everything but the curves; returns the rectangle they go into.
    fn draw_frame(&self, theme: &Theme, image: &mut Image, [x, y]: &[Scale; 2]) -> Rect {
        let u = theme.unit;
        let (width, height) = (image.width() as f32, image.height() as f32);
        let style = theme.title();
        theme.face.draw(image, [34.0 * u, 66.0 * u], &theme.face.cut(&self.title, style, width - 68.0 * u), style);
        let top = if self.title.is_empty() { 32.0 } else { 92.0 } * u;
        let card = Rect { x: 32.0 * u, y: top, width: width - 64.0 * u, height: height - top - 32.0 * u };
        image.fill(card, 14.0 * u, |_, _| PAPER);
        let legend = self.draw_legend(theme, image, card);
        let widest = y.ticks.labels.iter().map(|l| theme.face.width(l, theme.small())).fold(0.0, f32::max);
        let left = card.x + 44.0 * u + widest;
        let width = card.x + card.width - 48.0 * u - left;
        let rows = self.event_rows(theme, x, left, width);
        let lowest = rows.iter().map(|row| row + 1).max().unwrap_or(0);
        let top = legend + 74.0 * u + EVENT_ROW * u * lowest as f32;
        let plot = Rect { x: left, y: top, width, height: card.y + card.height - 100.0 * u - top };
        let label = y.ticks.with_exponent(&self.y.label);
        theme.face.draw(image, [card.x + 28.0 * u, legend + 52.0 * u], &label, theme.label());
        let below = [plot.x + 0.5 * plot.width, plot.y + plot.height + 76.0 * u];
        theme.face.draw_centred(image, below, &x.ticks.with_exponent(&self.x.label), theme.label());
        draw_grid(theme, image, [x, y], plot);
        plot
    }

    /// The row of each event's label over the plot, 0 the lowest, so that none covers another.
    fn event_rows(&self, theme: &Theme, x: &Scale, left: f32, width: f32) -> Vec<usize> {
        let mut ends: Vec<f32> = Vec::new();
        let mut order: Vec<usize> = (0..self.events.len()).collect();
        order.sort_by(|a, b| self.events[*a].at.total_cmp(&self.events[*b].at));
        let mut rows = vec![0; self.events.len()];
        for event in order.into_iter().filter(|event| !self.events[*event].label.is_empty()) {
            let [start, end] = self.event_span(theme, x, (left, width), event);
            let free = ends.iter().position(|e| *e < start).unwrap_or(ends.len()).min(MOST_EVENT_ROWS - 1);
            ends.resize(ends.len().max(free + 1), f32::NEG_INFINITY);
            (rows[event], ends[free]) = (free, end + 12.0 * theme.unit);
        }
        rows
    }

    /// Where an event's label begins and ends: around its line, within the plot.
    fn event_span(&self, theme: &Theme, x: &Scale, (left, width): (f32, f32), event: usize) -> [f32; 2] {
        let Event { at, label } = &self.events[event];
        let long = theme.face.width(label, theme.small());
        let start = (left + width * x.place(*at) - 0.5 * long).min(left + width - long).max(left);
        [start, start + long]
    }

    fn draw_events(&self, theme: &Theme, image: &mut Image, x: &Scale, plot: Rect) {
        let u = theme.unit;
        let rows = self.event_rows(theme, x, plot.x, plot.width);
        for (event, row) in rows.iter().enumerate() {
            let at = plot.x + plot.width * x.place(self.events[event].at);
            let label = plot.y - 10.0 * u - EVENT_ROW * u * *row as f32;
            let (bottom, mut y) = (plot.y + plot.height, label + 6.0 * u);
            while y < bottom {
                image.stroke([at, y], [at, (y + 7.0 * u).min(bottom)], 1.8 * u, GREY);
                y += 13.0 * u;
            }
            let [start, _] = self.event_span(theme, x, (plot.x, plot.width), event);
            theme.face.draw(image, [start, label], &self.events[event].label, theme.small());
        }
    }

    /// Draws the legend in rows at the card's top; returns the bottom of it.
    fn draw_legend(&self, theme: &Theme, image: &mut Image, card: Rect) -> f32 {
        let u = theme.unit;
        let (left, right) = (card.x + 28.0 * u, card.x + card.width - 28.0 * u);
        let (mut x, mut y) = (left, card.y + 42.0 * u);
        for (at, series) in self.series.iter().enumerate() {
            let name = theme.face.cut(&series.name, theme.label(), right - left - 56.0 * u);
            let width = 56.0 * u + theme.face.width(&name, theme.label());
            if x > left && x + width > right {
                (x, y) = (left, y + 38.0 * u);
            }
            let middle = y - 8.0 * u;
            image.stroke([x, middle], [x + 40.0 * u, middle], 4.0 * u, CURVES[at % CURVES.len()]);
            image.stroke([x + 20.0 * u, middle], [x + 20.0 * u, middle], 12.0 * u, CURVES[at % CURVES.len()]);
            theme.face.draw(image, [x + 52.0 * u, y], &name, theme.label());
            x += width + 30.0 * u;
        }
        y
    }

    fn draw_curves(&self, theme: &Theme, image: &mut Image, [x, y]: &[Scale; 2], plot: Rect) {
        let u = theme.unit;
        for (at, series) in self.series.iter().enumerate() {
            let colour = CURVES[at % CURVES.len()];
            let place =
                |p: &[f64; 2]| [plot.x + plot.width * x.place(p[0]), plot.y + plot.height * (1.0 - y.place(p[1]))];
            let points: Vec<[f32; 2]> = series.points.iter().map(place).collect();
            for pair in points.windows(2) {
                image.stroke(pair[0], pair[1], 4.0 * u, colour);
            }
            // Markers would run into each other on a dense curve.
            for point in points.iter().filter(|_| points.len() <= 40) {
                image.stroke(*point, *point, 15.0 * u, PAPER);
                image.stroke(*point, *point, 12.0 * u, colour);
            }
        }
    }
}

fn draw_grid(theme: &Theme, image: &mut Image, [x, y]: [&Scale; 2], plot: Rect) {
    let u = theme.unit;
    let (right, bottom) = (plot.x + plot.width, plot.y + plot.height);
    for (value, text) in x.ticks.values.iter().zip(&x.ticks.labels) {
        let at = plot.x + plot.width * x.place(*value);
        image.stroke([at, plot.y], [at, bottom], 1.2 * u, RULE);
        theme.face.draw_centred(image, [at, bottom + 36.0 * u], text, theme.small());
    }
    for (value, text) in y.ticks.values.iter().zip(&y.ticks.labels) {
        let at = plot.y + plot.height * (1.0 - y.place(*value));
        image.stroke([plot.x, at], [right, at], 1.2 * u, RULE);
        let width = theme.face.width(text, theme.small());
        theme.face.draw(image, [plot.x - 14.0 * u - width, at + 8.0 * u], text, theme.small());
    }
    image.stroke([plot.x, bottom], [right, bottom], 2.0 * u, GREY);
    image.stroke([plot.x, plot.y], [plot.x, bottom], 2.0 * u, DARK);
}

/// An axis fitted to its data.
struct Scale {
    low: f64,
    high: f64,
    logarithmic: bool,
    ticks: Ticks,
}

impl Scale {
    fn new(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if axis.logarithmic {
            let (low, high) = widen(low.log10(), high.log10());
            let (low, high) = (10f64.powf(low - 0.05 * (high - low)), 10f64.powf(high + 0.05 * (high - low)));
            return Self { low, high, logarithmic: true, ticks: logarithmic_ticks(low, high) };
        }
        if axis.whole && high - low <= MOST_WHOLE {
            let (low, high) = (low.floor(), high.ceil());
            return Self { low: low - 0.25, high: high + 0.25, logarithmic: false, ticks: Ticks::whole(low, high) };
        }
        let low = if low > 0.0 && low < 0.5 * high { 0.0 } else { low };
        let (low, high) = nice_range(low, high, 7);
        Self { low, high, logarithmic: false, ticks: Ticks::linear(low, high, 7) }
    }

    fn place(&self, value: f64) -> f32 {
        let share = match self.logarithmic {
            true => (value / self.low).log10() / (self.high / self.low).log10(),
            false => (value - self.low) / (self.high - self.low),
        };
        share as f32
    }
}

/// Powers of ten and their multiples, or nice numbers where fewer than two of those lie in the range.
fn logarithmic_ticks(low: f64, high: f64) -> Ticks {
    let ticks = Ticks::logarithmic(low, high, 7);
    if ticks.values.len() >= 2 { ticks } else { Ticks::linear(low, high, 6) }
}
