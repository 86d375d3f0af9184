//! Text in the embedded typeface: measuring, wrapping, drawing.

use crate::{Image, PictureError, colour::Rgb};
use ab_glyph::{Font, FontRef, Glyph, GlyphId, PxScale, ScaleFont, point};

/// Weight of the typeface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    Regular,
    SemiBold,
}

/// How a line of text looks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Style {
    pub(crate) weight: Weight,
    /// Size of the em square in pixels.
    pub(crate) size: f32,
    pub(crate) ink: Rgb,
}

/// The embedded typeface in its two weights.
pub(crate) struct Typeface {
    regular: FontRef<'static>,
    semi_bold: FontRef<'static>,
}

impl Typeface {
    pub(crate) fn load() -> Result<Self, PictureError> {
        Ok(Self {
            regular: FontRef::try_from_slice(include_bytes!("../assets/Inter-Regular.otf"))?,
            semi_bold: FontRef::try_from_slice(include_bytes!("../assets/Inter-SemiBold.otf"))?,
        })
    }

    /// Advance width of a line in pixels.
    pub(crate) fn width(&self, text: &str, style: Style) -> f32 {
        let mut end = 0.0;
        self.lay_out(text, style, |_, after| end = after);
        end
    }

    /// Draws a line with its left end at `x` on the baseline `y`.
    pub(crate) fn draw(&self, image: &mut Image, [x, y]: [f32; 2], text: &str, style: Style) {
        let font = self.font(style.weight);
        self.lay_out(text, style, |mut glyph, _| {
            glyph.position = point(x + glyph.position.x, y);
            let Some(outline) = font.outline_glyph(glyph) else { return };
            let corner = outline.px_bounds().min;
            outline.draw(|i, j, coverage| {
                let (i, j) = (corner.x as i64 + i64::from(i), corner.y as i64 + i64::from(j));
                image.blend(i, j, style.ink, coverage);
            });
        });
    }

    /// Draws a line centred at `x`.
    pub(crate) fn draw_centred(&self, image: &mut Image, [x, y]: [f32; 2], text: &str, style: Style) {
        self.draw(image, [x - 0.5 * self.width(text, style), y], text, style);
    }

    /// Breaks text at spaces so that every line fits `width`; a longer single word is cut with an ellipsis.
    pub(crate) fn wrap(&self, text: &str, style: Style, width: f32) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            let joined = lines.last().map(|line| format!("{line} {word}"));
            match (joined, lines.last_mut()) {
                (Some(joined), Some(line)) if self.width(&joined, style) <= width => *line = joined,
                _ => lines.push(self.cut(word, style, width)),
            }
        }
        lines
    }

    /// The longest start of a line that fits `width`, with an ellipsis if something is missing.
    pub(crate) fn cut(&self, text: &str, style: Style, width: f32) -> String {
        if self.width(text, style) <= width {
            return text.to_owned();
        }
        let mut kept: Vec<char> = text.chars().collect();
        while kept.pop().is_some() {
            let shown: String = kept.iter().chain(['…'].iter()).collect();
            if self.width(&shown, style) <= width {
                return shown;
            }
        }
        String::new()
    }

    fn font(&self, weight: Weight) -> &FontRef<'static> {
        match weight {
            Weight::Regular => &self.regular,
            Weight::SemiBold => &self.semi_bold,
        }
    }

    /// Calls `place` with every glyph (baseline at zero) and the pen position after it.
    fn lay_out(&self, text: &str, style: Style, mut place: impl FnMut(Glyph, f32)) {
        let font = self.font(style.weight);
        let em = font.height_unscaled() / font.units_per_em().unwrap_or(1000.0);
        let scale = PxScale::from(style.size * em);
        let scaled = font.as_scaled(scale);
        let mut pen = 0.0;
        for letter in text.chars().map(|c| if c.is_control() { ' ' } else { c }) {
            let id = match font.glyph_id(letter) {
                GlyphId(0) => font.glyph_id('?'),
                id => id,
            };
            let glyph = id.with_scale_and_position(scale, point(pen, 0.0));
            pen += scaled.h_advance(id);
            place(glyph, pen);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STYLE: Style = Style { weight: Weight::Regular, size: 20.0, ink: [0; 3] };

    #[test]
    fn wrapped_lines_fit_and_keep_every_word() -> Result<(), PictureError> {
        let face = Typeface::load()?;
        let text = "coarse: one-ring, degree 3 (1,275 unknowns), relative error 2.4 % of max |u|";
        let lines = face.wrap(text, STYLE, 250.0);
        assert!(lines.len() > 1);
        assert!(lines.iter().all(|line| face.width(line, STYLE) <= 250.0), "{lines:?}");
        assert_eq!(lines.join(" "), text);
        Ok(())
    }

    #[test]
    fn a_word_that_does_not_fit_ends_in_an_ellipsis() -> Result<(), PictureError> {
        let face = Typeface::load()?;
        let lines = face.wrap(&"m".repeat(300), STYLE, 100.0);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].ends_with('…') && face.width(&lines[0], STYLE) <= 100.0, "{lines:?}");
        Ok(())
    }

    #[test]
    fn the_letters_a_mechanics_figure_needs_are_in_the_typeface() -> Result<(), PictureError> {
        let face = Typeface::load()?;
        for letter in "aZ09%|‖±×−√∂∞≈≠≤≥εσμνλρΔΣΩ⁻⁰¹²³⁴⁵⁶⁷⁸⁹₀₁·…°→–é".chars()
        {
            for weight in [Weight::Regular, Weight::SemiBold] {
                assert_ne!(face.font(weight).glyph_id(letter), GlyphId(0), "{letter}");
            }
        }
        Ok(())
    }
}
