//! Names of lengths in headers.

/// Millimetres per unit, `None` for a name that is not known.
pub(super) fn mm_per_unit(name: &str) -> Option<f64> {
    match name {
        "m" | "meter" | "meters" | "metre" | "metres" => Some(1e3),
        "cm" => Some(10.0),
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => Some(1.0),
        "um" | "µm" | "μm" | "micron" | "microns" | "micrometer" | "micrometre" => Some(1e-3),
        "nm" => Some(1e-6),
        _ => None,
    }
}
