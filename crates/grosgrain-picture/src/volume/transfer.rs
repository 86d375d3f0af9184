//! What a value looks like: colour and extinction, piecewise linear in the value.

use crate::{
    PictureError,
    colour::{Rgb, to_linear},
};

/// A corner of a transfer function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferNode {
    /// The value, such as a CT number \[HU\].
    pub value: f64,
    /// Colour of what has this value.
    pub colour: Rgb,
    /// Extinction κ \[1/m\]: a thickness L of it lets the share exp(−κ L) of the light through; 0 is transparent.
    pub extinction: f64,
}

/// Colour and extinction over the value, linear between nodes (colours in linear light), constant beyond the ends.
///
/// ```
/// use grosgrain_picture::{TransferFunction, TransferNode};
/// let air = TransferNode { value: 0.0, colour: [255; 3], extinction: 0.0 };
/// let iron = TransferNode { value: 1.0, colour: [90, 96, 110], extinction: 4000.0 };
/// let transfer = TransferFunction { nodes: vec![air, iron] };
/// assert_eq!(transfer.extinction(0.25), 1000.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    /// The nodes, by increasing value.
    pub nodes: Vec<TransferNode>,
}

impl TransferFunction {
    /// For CT numbers \[HU\] of a person: air transparent, skin a warm veil, fat and muscle translucent, bone ivory and opaque.
    pub fn ct() -> Self {
        let node = |value, colour, extinction| TransferNode { value, colour, extinction };
        Self {
            nodes: vec![
                node(-650.0, [0xf6, 0xd6, 0xbd], 0.0),
                node(-420.0, [0xf6, 0xd2, 0xb6], 95.0),
                node(-220.0, [0xf2, 0xc0, 0x9c], 75.0),
                node(-120.0, [0xf0, 0xbe, 0x90], 1.5),
                node(-40.0, [0xe0, 0x88, 0x68], 3.0),
                node(30.0, [0xbc, 0x40, 0x36], 8.0),
                node(90.0, [0xb4, 0x38, 0x32], 13.0),
                node(130.0, [0xd0, 0x70, 0x54], 40.0),
                node(180.0, [0xf6, 0xea, 0xcc], 420.0),
                node(420.0, [0xfa, 0xf2, 0xe0], 900.0),
                node(1500.0, [0xff, 0xfc, 0xf4], 1600.0),
            ],
        }
    }

    /// For CT numbers of a person, as [`TransferFunction::ct`] with an opaque skin: what is inside shows on cuts only.
    pub fn ct_opaque() -> Self {
        let node = |value, colour, extinction| TransferNode { value, colour, extinction };
        Self {
            nodes: vec![
                node(-600.0, [0xf0, 0xc8, 0xa8], 0.0),
                node(-400.0, [0xf0, 0xc8, 0xa8], 900.0),
                node(-200.0, [0xf0, 0xc6, 0x9c], 900.0),
                node(-70.0, [0xee, 0xc2, 0x8a], 900.0),
                node(-10.0, [0xc0, 0x5a, 0x48], 900.0),
                node(60.0, [0xa8, 0x32, 0x2e], 900.0),
                node(140.0, [0xc0, 0x60, 0x48], 900.0),
                node(220.0, [0xf2, 0xe4, 0xc6], 1200.0),
                node(600.0, [0xff, 0xfa, 0xee], 1600.0),
            ],
        }
    }

    /// Extinction \[1/m\] at a value.
    pub fn extinction(&self, value: f64) -> f64 {
        self.at(value)[3]
    }

    /// Linear colour and extinction at a value.
    fn at(&self, value: f64) -> [f64; 4] {
        let entry = |n: &TransferNode| {
            let [r, g, b] = to_linear(n.colour).map(f64::from);
            [r, g, b, n.extinction]
        };
        let after = self.nodes.partition_point(|n| n.value <= value);
        match (after.checked_sub(1).map(|i| &self.nodes[i]), self.nodes.get(after)) {
            (Some(a), Some(b)) => {
                let t = (value - a.value) / (b.value - a.value);
                let (p, q) = (entry(a), entry(b));
                std::array::from_fn(|c| p[c] + t * (q[c] - p[c]))
            }
            (Some(end), None) | (None, Some(end)) => entry(end),
            (None, None) => [0.0; 4],
        }
    }

    pub(crate) fn validate(&self) -> Result<(), PictureError> {
        let refuse = |index: usize| {
            let TransferNode { value, extinction, .. } = self.nodes[index];
            Err(PictureError::TransferNode { index, value, extinction })
        };
        if self.nodes.is_empty() {
            return Err(PictureError::EmptyTransfer);
        }
        for (i, node) in self.nodes.iter().enumerate() {
            let finite = node.value.abs() < 1e30 && (0.0..1e30).contains(&node.extinction);
            if !finite || i > 0 && self.nodes[i - 1].value >= node.value {
                return refuse(i);
            }
        }
        Ok(())
    }
}

/// Intervals of the table.
const STEPS: usize = 4096;

/// A transfer function as a table of antiderivatives, so that the mean along a segment costs two look-ups.
///
/// With values linear along the segment from v₀ to v₁ the mean extinction is (A(v₁) − A(v₀))/(v₁ − v₀), A' = κ, and
/// the same for κ times colour: pre-integration without self-attenuation within the segment (`engel2001preintegrated`).
pub(crate) struct TransferTable {
    low: f64,
    per_value: f64,
    /// κ r, κ g, κ b, κ.
    at: Vec<[f64; 4]>,
    /// Their antiderivatives in units of table steps.
    sum: Vec<[f64; 4]>,
    /// Number of entries before this one with extinction.
    visible: Vec<u32>,
}

impl TransferTable {
    pub(crate) fn new(transfer: &TransferFunction) -> Self {
        let (first, last) = (transfer.nodes[0].value, transfer.nodes[transfer.nodes.len() - 1].value);
        let width = (last - first).max(1e-6 * first.abs().max(1e-6)) / STEPS as f64;
        let emitted = |value: f64| {
            let [r, g, b, k] = transfer.at(value);
            [k * r, k * g, k * b, k]
        };
        let value = |i: f64| first + width * i;
        let at: Vec<[f64; 4]> = (0..=STEPS).map(|i| emitted(value(i as f64))).collect();
        let mut sum = vec![[0.0; 4]];
        for i in 0..STEPS {
            // Simpson's rule, exact for the quadratic κ times colour within a piece.
            let (a, m, b) = (at[i], emitted(value(i as f64 + 0.5)), at[i + 1]);
            let before = sum[i];
            sum.push(std::array::from_fn(|c| before[c] + (a[c] + 4.0 * m[c] + b[c]) / 6.0));
        }
        let mut visible = vec![0];
        at.iter().enumerate().for_each(|(i, entry)| visible.push(visible[i] + u32::from(entry[3] > 0.0)));
        Self { low: first, per_value: 1.0 / width, at, sum, visible }
    }

    /// Place of a value in table steps; beyond the ends outside 0..=STEPS.
    fn place(&self, value: f32) -> f64 {
        (f64::from(value) - self.low) * self.per_value
    }

    /// Whether a value in this range is seen at all.
    pub(crate) fn is_visible(&self, low: f32, high: f32) -> bool {
        let clamp = |x: f64| x.clamp(0.0, STEPS as f64);
        let first = clamp(self.place(low).floor()) as usize;
        let last = clamp(self.place(high).ceil()) as usize;
        self.visible[last + 1] > self.visible[first]
    }

    /// Mean of κ r, κ g, κ b, κ over the values from `a` to `b`.
    pub(crate) fn mean(&self, a: f32, b: f32) -> [f64; 4] {
        let (p, q) = (self.place(a), self.place(b));
        if (p - q).abs() < 1.0 {
            return lerp(&self.at, 0.5 * (p + q));
        }
        let (s, t) = (self.antiderivative(p), self.antiderivative(q));
        std::array::from_fn(|c| (t[c] - s[c]) / (q - p))
    }

    fn antiderivative(&self, place: f64) -> [f64; 4] {
        let end = if place < 0.0 { 0 } else { STEPS };
        let beyond = if place < 0.0 { place } else { (place - STEPS as f64).max(0.0) };
        let inside = lerp(&self.sum, place);
        std::array::from_fn(|c| inside[c] + beyond * self.at[end][c])
    }
}

fn lerp(table: &[[f64; 4]], place: f64) -> [f64; 4] {
    let x = place.clamp(0.0, STEPS as f64);
    let i = (x as usize).min(STEPS - 1);
    let t = x - i as f64;
    let (a, b) = (&table[i], &table[i + 1]);
    std::array::from_fn(|c| a[c] + t * (b[c] - a[c]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hat() -> TransferFunction {
        let node = |value, extinction| TransferNode { value, colour: [255, 0, 0], extinction };
        TransferFunction { nodes: vec![node(-1.0, 0.0), node(1.0, 10.0), node(2.0, 0.0)] }
    }

    #[test]
    fn means_are_those_of_a_fine_sum() {
        let (transfer, table) = (hat(), TransferTable::new(&hat()));
        for (a, b) in [(-3.0, 4.0), (0.3, 0.9), (1.7, -0.5), (0.5, 0.5), (1.0, 9.0)] {
            let parts = 20_000;
            let value = |i: usize| a + (b - a) * (i as f64 + 0.5) / parts as f64;
            let mean = (0..parts).map(|i| transfer.extinction(value(i))).sum::<f64>() / parts as f64;
            let found = table.mean(a as f32, b as f32);
            assert!((found[3] - mean).abs() < 3e-3, "{a} to {b}: {} for {mean}", found[3]);
            assert!((found[0] - found[3]).abs() < 1e-9 && found[1] == 0.0, "{found:?}");
        }
    }

    #[test]
    fn a_range_is_visible_where_some_value_in_it_is() {
        let table = TransferTable::new(&hat());
        assert!(!table.is_visible(-9.0, -1.01) && !table.is_visible(2.01, 7.0));
        assert!(table.is_visible(-9.0, 9.0) && table.is_visible(0.2, 0.2) && table.is_visible(-5.0, -0.9));
    }

    #[test]
    fn nodes_out_of_order_are_refused() {
        let mut transfer = hat();
        transfer.nodes.swap(0, 1);
        assert!(matches!(transfer.validate(), Err(PictureError::TransferNode { index: 1, .. })));
        assert!(matches!(TransferFunction { nodes: vec![] }.validate(), Err(PictureError::EmptyTransfer)));
        assert!(TransferFunction::ct().validate().is_ok() && TransferFunction::ct_opaque().validate().is_ok());
    }
}
