//! Pictures of harmonic displacements.

use std::sync::Arc;

use grosgrain::homogenization::HarmonicDisplacements;
use grosgrain_picture::Panel;

use super::{Paint, Posed, SimplexLook, SimplexSkin};
use crate::picture::largest_displacement;
use crate::quantities::number;

/// The largest displacement is drawn about as long as this share of the body's size.
const DRAWN_SHARE: f64 = 0.15;
/// Columns of the fields in the order of the panels, and the indices of their stresses.
const PLANE: [(usize, &str); 3] = [(0, "₁₁"), (1, "₂₂"), (2, "₁₂")];
const SPACE: [(usize, &str); 6] = [(0, "₁₁"), (1, "₂₂"), (2, "₃₃"), (5, "₁₂"), (3, "₂₃"), (4, "₁₃")];

/// A panel per harmonic displacement h_αβ of a mesh (`kharevych2009numerical`, fig. 3): h₁₁, h₂₂, h₃₃, h₁₂, h₂₃, h₁₃, or h₁₁, h₂₂, h₁₂ in the plane.
///
/// All are drawn `scale` times \[Pa\], which is the stress on the boundary that would displace the body so far; `None` takes one of two digits with which the largest
/// displacement is 15 % of the body's size. Other displacements are not drawn to the scale of `look`.
///
/// # Panics
/// Fields that are not those of the skin's mesh.
pub fn harmonic_panels(
    skin: &Arc<SimplexSkin>,
    fields: &HarmonicDisplacements,
    scale: Option<f64>,
    look: &SimplexLook,
) -> Vec<Panel> {
    let order = if skin.dimension().axes() == 2 { &PLANE[..] } else { &SPACE[..] };
    let column = |n: usize| -> Vec<f64> {
        fields.fields.iter().flat_map(|field| [field[0][n], field[1][n], field[2][n]]).collect()
    };
    let columns: Vec<Vec<f64>> = order.iter().map(|(n, _)| column(*n)).collect();
    let stress = scale.unwrap_or_else(|| {
        let largest = columns.iter().map(|u| largest_displacement(u)).fold(0.0, f64::max);
        if largest > 0.0 { two_digits(DRAWN_SHARE * skin.size() / largest) } else { 1.0 }
    });
    let look = SimplexLook { scale: stress, ..look.clone() };
    let panel = |(displacement, (_, indices)): (&Vec<f64>, &(usize, &str))| Panel {
        caption: format!("h{indices}"),
        detail: format!("under a stress σ{indices} of {}", pressure(stress)),
        ..look.panel(Posed { skin, displacement }, &Paint::Tags, None)
    };
    columns.iter().zip(order).map(panel).collect()
}

/// The largest number of two digits times a power of ten that is not above this positive one.
fn two_digits(x: f64) -> f64 {
    let unit = 10f64.powf(x.log10().floor() - 1.0);
    (x / unit).floor() * unit
}

/// `20 kPa`, `1 MPa`.
fn pressure(stress: f64) -> String {
    match stress {
        s if s >= 1e9 => format!("{} GPa", number(s / 1e9)),
        s if s >= 1e6 => format!("{} MPa", number(s / 1e6)),
        s if s >= 1e3 => format!("{} kPa", number(s / 1e3)),
        s => format!("{} Pa", number(s)),
    }
}
