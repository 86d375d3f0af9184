//! Sizes and colours that figures and charts share.

use crate::{
    PictureError,
    colour::Rgb,
    text::{Style, Typeface, Weight},
};

pub(crate) const PAGE: Rgb = [0xf1, 0xf3, 0xf6];
pub(crate) const PAPER: Rgb = [0xff, 0xff, 0xff];
pub(crate) const RULE: Rgb = [0xdf, 0xe3, 0xe9];
pub(crate) const DARK: Rgb = [0x1d, 0x23, 0x2e];
pub(crate) const GREY: Rgb = [0x5b, 0x65, 0x75];

/// Typeface and unit of length: one unit is a pixel of a picture 1800 pixels wide.
pub(crate) struct Theme {
    pub(crate) face: Typeface,
    pub(crate) unit: f32,
}

impl Theme {
    pub(crate) fn new(width: usize) -> Result<Self, PictureError> {
        if !(400..=4000).contains(&width) {
            return Err(PictureError::Width(width));
        }
        Ok(Self { face: Typeface::load()?, unit: width as f32 / 1800.0 })
    }

    /// A theme whose labels have this height in pixels.
    pub(crate) fn with_letters(letters: f32) -> Result<Self, PictureError> {
        if !(8.0..=100.0).contains(&letters) {
            return Err(PictureError::Letters(letters));
        }
        Ok(Self { face: Typeface::load()?, unit: letters / 24.0 })
    }

    pub(crate) fn title(&self) -> Style {
        self.style(Weight::SemiBold, 42.0, DARK)
    }

    pub(crate) fn caption(&self) -> Style {
        self.style(Weight::SemiBold, 29.0, DARK)
    }

    pub(crate) fn detail(&self) -> Style {
        self.style(Weight::Regular, 25.0, GREY)
    }

    pub(crate) fn label(&self) -> Style {
        self.style(Weight::Regular, 24.0, DARK)
    }

    pub(crate) fn small(&self) -> Style {
        self.style(Weight::Regular, 22.0, GREY)
    }

    fn style(&self, weight: Weight, size: f32, ink: Rgb) -> Style {
        Style { weight, size: size * self.unit, ink }
    }
}
