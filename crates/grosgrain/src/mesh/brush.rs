//! A ball that is moved along a path.

use super::cut::{dot, is_finite, minus};

/// A ball swept along a polyline: voxels whose centre is no further than `radius` from the path, nodes likewise.
///
/// The radius is grown by 1e-9 of the grid's size. A path of one point is a ball.
#[derive(Clone, Debug, PartialEq)]
pub struct Brush {
    /// The corners of the path \[m\].
    pub path: Vec<[f64; 3]>,
    /// Radius of the ball \[m\].
    pub radius: f64,
}

impl Brush {
    /// Whether the point is within the radius, grown by `slack` \[m\], of the path.
    pub(crate) fn reaches(&self, x: [f64; 3], slack: f64) -> bool {
        let far = self.radius + slack;
        let near = |from, to| square_distance(x, from, to) <= far * far;
        match self.path.as_slice() {
            [] => false,
            [only] => near(*only, *only),
            corners => corners.windows(2).any(|ends| near(ends[0], ends[1])),
        }
    }

    /// Whether there is a path of numbers and a positive radius.
    pub(super) fn is_usable(&self) -> bool {
        let good = self.radius.is_finite() && self.radius > 0.0;
        good && !self.path.is_empty() && self.path.iter().all(|x| is_finite(*x))
    }

    /// The box \[m\] around the ball on its way.
    pub(super) fn bounds(&self) -> [[f64; 3]; 2] {
        let end =
            |axis: usize, start: f64, pick: fn(f64, f64) -> f64| self.path.iter().map(|x| x[axis]).fold(start, pick);
        [
            std::array::from_fn(|axis| end(axis, f64::INFINITY, f64::min) - self.radius),
            std::array::from_fn(|axis| end(axis, f64::NEG_INFINITY, f64::max) + self.radius),
        ]
    }
}

/// Squared distance of `x` from the segment between `from` and `to` \[m²\].
fn square_distance(x: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let (along, away) = (minus(to, from), minus(x, from));
    let length = dot(along, along);
    let share = if length > 0.0 { (dot(away, along) / length).clamp(0.0, 1.0) } else { 0.0 };
    let rest: [f64; 3] = std::array::from_fn(|a| away[a] - share * along[a]);
    dot(rest, rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_distance_from_a_segment_is_the_least_over_its_points(
            x in [-2.0..2.0f64, -2.0..2.0, -2.0..2.0],
            from in [-2.0..2.0f64, -2.0..2.0, -2.0..2.0],
            to in [-2.0..2.0f64, -2.0..2.0, -2.0..2.0],
        ) {
            let points = (0..=2000).map(|n| f64::from(n) / 2000.0);
            let square = |t: f64| (0..3).map(|a| (x[a] - from[a] - t * (to[a] - from[a])).powi(2)).sum::<f64>();
            let sampled = points.map(square).fold(f64::INFINITY, f64::min).sqrt();
            let found = square_distance(x, from, to).sqrt();
            // The nearest sample is no further than half a sample's step along the segment.
            prop_assert!(found <= sampled + 1e-12 && sampled - found <= 7.0 / 4000.0, "{} sampled {}", found, sampled);
        }
    }
}
