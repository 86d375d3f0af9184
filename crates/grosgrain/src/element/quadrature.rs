//! Quadrature rules on the unit cube.

/// A point of [0, 1]³ with its weight; the weights of a rule sum to one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint {
    /// Coordinates in [0, 1]³.
    pub at: [f64; 3],
    /// Share of the cube's volume.
    pub weight: f64,
}

/// The 2×2×2 Gauss rule: exact for polynomials of degree 3 in each coordinate.
pub fn gauss_2x2x2() -> [QuadraturePoint; 8] {
    let offset = 0.5 / 3.0f64.sqrt();
    let coordinate = |bit: usize| if bit == 0 { 0.5 - offset } else { 0.5 + offset };
    std::array::from_fn(|q| QuadraturePoint {
        at: [coordinate(q & 1), coordinate(q >> 1 & 1), coordinate(q >> 2)],
        weight: 0.125,
    })
}
