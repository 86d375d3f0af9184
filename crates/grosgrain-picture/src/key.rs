//! The key under a panel: a legend of categories or a colour bar.

use crate::{
    Category, ColourScale, Colouring, Image, Panel,
    colour::{Rgb, category_colour},
    image::Rect,
    theme::{DARK, RULE, Theme},
    ticks::{Ticks, nice_range},
};

const MOST_TICKS: usize = 6;
/// Legends show at most this many categories, then how many more there are.
const MOST_NAMES: usize = 24;

impl ColourScale {
    /// The colour at `t` in [0, 1] along the bar.
    pub fn colour(&self, t: f64) -> Rgb {
        self.map.at(if self.reversed { 1.0 - t } else { t })
    }

    /// The ends of the bar for these values: the given range, or theirs widened to nice numbers.
    pub(crate) fn ends(&self, values: &[f64]) -> [f64; 2] {
        if let Some(range) = self.range {
            return range;
        }
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let low = if low > 0.0 && low < 0.3 * high { 0.0 } else { low };
        let (low, high) = nice_range(low, high, MOST_TICKS);
        [low, high]
    }
}

/// The ends of a panel's colour scale; of no meaning for other colourings.
pub(crate) fn range(panel: &Panel) -> [f64; 2] {
    match &panel.colouring {
        Colouring::Scalar { at_vertex: values, scale } | Colouring::QuadScalar { of_quad: values, scale } => {
            scale.ends(values)
        }
        _ => [0.0, 1.0],
    }
}

/// Height of a panel's key within `width` pixels.
pub(crate) fn height(panel: &Panel, theme: &Theme, width: f32) -> f32 {
    match &panel.colouring {
        Colouring::Plain(_) => 0.0,
        Colouring::Category { legend, .. } => 40.0 * theme.unit * legend_rows(legend, theme, width).len() as f32,
        Colouring::Scalar { .. } | Colouring::QuadScalar { .. } => 96.0 * theme.unit,
    }
}

/// Draws a panel's key, centred at the top of `area`.
pub(crate) fn draw(panel: &Panel, theme: &Theme, image: &mut Image, area: Rect) {
    match &panel.colouring {
        Colouring::Plain(_) => {}
        Colouring::Category { legend, .. } => draw_legend(legend, theme, image, area),
        Colouring::Scalar { scale, .. } | Colouring::QuadScalar { scale, .. } => {
            draw_bar(scale, range(panel), theme, image, area);
        }
    }
}

fn draw_bar(scale: &ColourScale, [low, high]: [f64; 2], theme: &Theme, image: &mut Image, area: Rect) {
    let u = theme.unit;
    let width = (0.74 * area.width).min(640.0 * u);
    let ticks = fitting_ticks([low, high], theme, width);
    let bar = Rect { x: (area.x + 0.5 * (area.width - width)).round(), y: area.y + 34.0 * u, width, height: 20.0 * u };
    let label = theme.face.cut(&ticks.with_exponent(&scale.label), theme.label(), area.width);
    theme.face.draw_centred(image, [bar.x + 0.5 * width, area.y + 20.0 * u], &label, theme.label());
    image.fill(bar, 4.0 * u, |x, _| scale.colour(f64::from((x - bar.x) / width)));
    let bottom = bar.y + bar.height;
    for (value, text) in ticks.values.iter().zip(&ticks.labels) {
        let x = bar.x + width * ((value - low) / (high - low)) as f32;
        image.stroke([x, bottom + 2.0 * u], [x, bottom + 7.0 * u], 1.5 * u, DARK);
        theme.face.draw_centred(image, [x, bottom + 31.0 * u], text, theme.small());
    }
}

/// As many ticks as have room for their labels, at least those of a step of half the range.
fn fitting_ticks([low, high]: [f64; 2], theme: &Theme, width: f32) -> Ticks {
    let room = |ticks: &Ticks| {
        let widest = ticks.labels.iter().map(|l| theme.face.width(l, theme.small())).fold(0.0, f32::max);
        1.35 * widest * ticks.labels.len() as f32 <= 1.15 * width
    };
    let choices = (3..=MOST_TICKS).rev().map(|most| Ticks::linear(low, high, most));
    choices.into_iter().find(room).unwrap_or_else(|| Ticks::linear(low, high, 3))
}

struct Entry {
    name: String,
    colour: Option<Rgb>,
    /// Width with the swatch, without the gap to the next entry.
    width: f32,
}

fn legend_rows(legend: &[Category], theme: &Theme, width: f32) -> Vec<Vec<Entry>> {
    let mut rows: Vec<Vec<Entry>> = Vec::new();
    let mut used = 0.0;
    for entry in legend_entries(legend, theme, width) {
        let end = used + gap(theme) + entry.width;
        match rows.last_mut() {
            Some(row) if end <= width => {
                used = end;
                row.push(entry);
            }
            _ => {
                used = entry.width;
                rows.push(vec![entry]);
            }
        }
    }
    rows
}

fn legend_entries(legend: &[Category], theme: &Theme, width: f32) -> Vec<Entry> {
    let entry = |name: &str, colour: Option<Rgb>| {
        let swatch = if colour.is_some() { 34.0 * theme.unit } else { 0.0 };
        let name = theme.face.cut(name, theme.label(), width - swatch);
        let width = swatch + theme.face.width(&name, theme.label());
        Entry { name, colour, width }
    };
    let colour = |i: usize| legend[i].colour.unwrap_or_else(|| category_colour(i));
    let shown = if legend.len() > MOST_NAMES { MOST_NAMES - 1 } else { legend.len() };
    let mut entries: Vec<Entry> = (0..shown).map(|i| entry(&legend[i].name, Some(colour(i)))).collect();
    if shown < legend.len() {
        entries.push(entry(&format!("and {} more", legend.len() - shown), None));
    }
    let line = entries.iter().map(|e| e.width).sum::<f32>() + gap(theme) * (entries.len().max(1) - 1) as f32;
    if line > width {
        // Entries on several lines stand below each other.
        let widest = entries.iter().map(|e| e.width).fold(0.0, f32::max);
        entries.iter_mut().for_each(|e| e.width = widest);
    }
    entries
}

fn gap(theme: &Theme) -> f32 {
    36.0 * theme.unit
}

fn draw_legend(legend: &[Category], theme: &Theme, image: &mut Image, area: Rect) {
    let u = theme.unit;
    let rows = legend_rows(legend, theme, area.width);
    let end = |row: &Vec<Entry>| row.iter().map(|e| e.width + gap(theme)).sum::<f32>() - gap(theme);
    let total = rows.iter().map(end).fold(0.0, f32::max);
    for (line, row) in rows.iter().enumerate() {
        let mut x = (area.x + 0.5 * (area.width - total)).round();
        let y = (area.y + 40.0 * u * line as f32).round();
        for entry in row {
            let mut text = x;
            if let Some(colour) = entry.colour {
                image.fill(Rect { x, y, width: 24.0 * u, height: 24.0 * u }, 5.0 * u, |_, _| RULE);
                let inner = Rect { x: x + u, y: y + u, width: 22.0 * u, height: 22.0 * u };
                image.fill(inner, 4.0 * u, |_, _| colour);
                text += 34.0 * u;
            }
            theme.face.draw(image, [text, y + 21.0 * u], &entry.name, theme.label());
            x += entry.width + gap(theme);
        }
    }
}
