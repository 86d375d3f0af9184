//! Colour maps, the palette of categories, and the sRGB transfer function.

/// A colour in sRGB, one byte per channel.
pub type Rgb = [u8; 3];

/// A perceptually uniform map from [0, 1] to colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourMap {
    /// Dark violet over green to yellow.
    #[default]
    Viridis,
    /// Deep violet over red and orange to cream; the darkest sixth is left out, since lines would drown in it.
    Magma,
    /// Dark blue over grey to yellow; the same to colour-blind eyes.
    Cividis,
}

impl ColourMap {
    /// The colour at `t`, interpolated in the map's 256 entries; `t` is clamped to [0, 1].
    pub fn at(self, t: f64) -> Rgb {
        let table = self.table();
        let start = if self == Self::Magma { 42.0 } else { 0.0 };
        let x = start + t.clamp(0.0, 1.0) * (255.0 - start);
        let i = (x as usize).min(254);
        let f = x - i as f64;
        std::array::from_fn(|c| {
            let (a, b) = (f64::from(table[3 * i + c]), f64::from(table[3 * i + 3 + c]));
            (a + f * (b - a)).round() as u8
        })
    }

    fn table(self) -> &'static [u8; 768] {
        match self {
            Self::Viridis => include_bytes!("../assets/viridis.rgb"),
            Self::Magma => include_bytes!("../assets/magma.rgb"),
            Self::Cividis => include_bytes!("../assets/cividis.rgb"),
        }
    }
}

/// Colour of category `index`: Paul Tol's "light" scheme, distinct to colour-blind eyes, repeated darker after nine.
pub fn category_colour(index: usize) -> Rgb {
    const LIGHT: [Rgb; 9] = [
        [0x77, 0xaa, 0xdd],
        [0xee, 0x88, 0x66],
        [0xee, 0xdd, 0x88],
        [0x44, 0xbb, 0x99],
        [0xff, 0xaa, 0xbb],
        [0x99, 0xdd, 0xff],
        [0xbb, 0xcc, 0x33],
        [0xaa, 0xaa, 0x00],
        [0xdd, 0xdd, 0xdd],
    ];
    let dimming = 0.75_f64.powi((index / LIGHT.len() % 4) as i32);
    LIGHT[index % LIGHT.len()].map(|c| (f64::from(c) * dimming).round() as u8)
}

/// Light energy of an sRGB colour, per channel in [0, 1].
pub(crate) fn to_linear(colour: Rgb) -> [f32; 3] {
    colour.map(|c| {
        let c = f32::from(c) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    })
}

/// Inverse of [`to_linear`] as a table, since every pixel needs it.
pub(crate) struct SrgbTable(Vec<u8>);

impl SrgbTable {
    const STEPS: f32 = 8191.0;

    pub(crate) fn new() -> Self {
        let encode = |i: u16| {
            let l = f32::from(i) / Self::STEPS;
            let c = if l <= 0.003_130_8 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
            (255.0 * c).round() as u8
        };
        Self((0..=Self::STEPS as u16).map(encode).collect())
    }

    pub(crate) fn encode(&self, linear: [f32; 3]) -> Rgb {
        linear.map(|l| self.0[(l.clamp(0.0, 1.0) * Self::STEPS + 0.5) as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_start_and_end_with_their_published_colours() {
        assert_eq!(ColourMap::Viridis.at(0.0), [68, 1, 84]);
        assert_eq!(ColourMap::Viridis.at(1.0), [253, 231, 37]);
        assert_eq!(ColourMap::Magma.at(1.0), [252, 253, 191]);
        assert_eq!(ColourMap::Magma.at(-3.0), ColourMap::Magma.at(0.0));
        assert_eq!(ColourMap::Cividis.at(7.0), ColourMap::Cividis.at(1.0));
    }

    #[test]
    fn encoding_inverts_linearisation_for_every_byte() {
        let table = SrgbTable::new();
        for c in 0..=255 {
            // Near black the transfer function is steepest: one byte is 1/(12.92·255) of light, 2.5 table steps.
            assert_eq!(table.encode(to_linear([c; 3])), [c; 3]);
        }
    }

    #[test]
    fn the_first_eighteen_categories_differ() {
        let mut colours: Vec<_> = (0..18).map(category_colour).collect();
        colours.sort_unstable();
        colours.dedup();
        assert_eq!(colours.len(), 18);
    }
}
