//! Rigid motions that are prescribed to held parts: twists about an axis and translations, reached over a time.

use crate::linalg::matrix3::{Matrix3, apply, cross, dot};

/// Relative slack by which a time may exceed an end and still count as not later.
const SAME_TIME: f64 = 1e-9;

/// Whether what ends at `until` \[s\] is still there at a time \[s\]: at its end it is; `None` never ends.
pub fn lasts(until: Option<f64>, time: f64) -> bool {
    until.is_none_or(|until| time <= until + SAME_TIME * until.abs())
}

/// A linear growth from 0 at one time to 1 at another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ramp {
    /// Where it begins \[s\].
    pub from: f64,
    /// Where it is complete \[s\]; no later than `from`: it is complete at once then.
    pub to: f64,
}

impl Ramp {
    /// Progress s ∈ \[0, 1\] at a time \[s\].
    pub fn progress(&self, time: f64) -> f64 {
        match time >= self.to {
            true => 1.0,
            false => ((time - self.from) / (self.to - self.from)).clamp(0.0, 1.0),
        }
    }

    /// ds/dt \[1/s\], from the right where it jumps; 0 for a ramp that is complete at once.
    pub fn rate(&self, time: f64) -> f64 {
        match self.from <= time && time < self.to {
            true => 1.0 / (self.to - self.from),
            false => 0.0,
        }
    }
}

/// A rotation about an axis in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// Direction of the axis, of unit length.
    pub axis: [f64; 3],
    /// A point on the axis \[m\].
    pub centre: [f64; 3],
    /// The whole angle \[rad\], right-handed about the direction; may exceed a turn.
    pub angle: f64,
}

impl Twist {
    /// A twist about a direction of any length; `None` where it has none.
    pub fn about(direction: [f64; 3], centre: [f64; 3], angle: f64) -> Option<Self> {
        let largest = direction.iter().fold(0.0, |largest: f64, d| largest.max(d.abs()));
        if !(largest > 0.0 && largest.is_finite()) {
            return None;
        }
        // Dividing twice keeps the squares of very small and very large directions in range.
        let scaled = direction.map(|d| d / largest);
        let length = dot(&scaled, &scaled).sqrt();
        Some(Self { axis: scaled.map(|d| d / length), centre, angle })
    }

    /// R(sθ) − I after the share s of the angle, by Rodrigues' formula in a form that keeps its digits for small angles:
    /// sin(sθ) \[a\]× + 2 sin²(sθ/2) (a aᵀ − I).
    fn rotation_less_identity(&self, s: f64) -> Matrix3 {
        let (a, angle) = (self.axis, s * self.angle);
        let (sine, versine) = (angle.sin(), 2.0 * (0.5 * angle).sin().powi(2));
        let turned = [[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]];
        let entry = |i: usize, j: usize| sine * turned[i][j] + versine * (a[i] * a[j] - if i == j { 1.0 } else { 0.0 });
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }
}

/// A rigid motion: twisted first, then translated. At progress s the angle is sθ and the translation s t, so that points of a twist
/// move on arcs: u(X, s) = (R(sθ) − I)(X − c) + s t. The default does not move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// The rotation, if any.
    pub twist: Option<Twist>,
    /// The whole translation t \[m\].
    pub translation: [f64; 3],
}

impl Motion {
    /// A translation \[m\].
    pub const fn translate(translation: [f64; 3]) -> Self {
        Self { twist: None, translation }
    }

    /// Whether no point ever moves.
    pub fn is_still(&self) -> bool {
        self.translation == [0.0; 3] && self.twist.is_none_or(|twist| twist.angle == 0.0)
    }

    /// The motion at a progress, to be applied to many points.
    pub fn at(&self, progress: f64) -> MotionAt {
        let (turn, centre) = match &self.twist {
            Some(twist) => (twist.rotation_less_identity(progress), twist.centre),
            None => ([[0.0; 3]; 3], [0.0; 3]),
        };
        MotionAt { motion: *self, turn, centre, translation: self.translation.map(|t| progress * t) }
    }
}

/// A [`Motion`] at one progress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionAt {
    motion: Motion,
    /// R − I.
    turn: Matrix3,
    centre: [f64; 3],
    translation: [f64; 3],
}

impl MotionAt {
    /// Displacement \[m\] of the point that was at `position` before the motion.
    pub fn displacement(&self, position: [f64; 3]) -> [f64; 3] {
        let turned = apply(&self.turn, &minus(position, self.centre));
        [0, 1, 2].map(|r| turned[r] + self.translation[r])
    }

    /// ∂u/∂s \[m\] of the point that was at `position`: θ a × R(X − c) + t. Times ds/dt it is the velocity.
    pub fn slope(&self, position: [f64; 3]) -> [f64; 3] {
        let Some(twist) = &self.motion.twist else { return self.motion.translation };
        let arm = minus(position, self.centre);
        let turned = apply(&self.turn, &arm);
        let around = cross(&twist.axis, &[0, 1, 2].map(|r| arm[r] + turned[r]));
        [0, 1, 2].map(|r| twist.angle * around[r] + self.motion.translation[r])
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 3] = [0.3, -0.2, 0.5];

    fn motion() -> Motion {
        let twist = Twist::about([1.0, 2.0, -2.0], [0.1, 0.2, 0.3], 4.0);
        Motion { twist, translation: [0.01, -0.02, 0.03] }
    }

    fn norm(v: [f64; 3]) -> f64 {
        dot(&v, &v).sqrt()
    }

    fn moved(motion: &Motion, x: [f64; 3], s: f64) -> [f64; 3] {
        let u = motion.at(s).displacement(x);
        [0, 1, 2].map(|r| x[r] + u[r])
    }

    #[test]
    fn a_quarter_turn_about_z_moves_x_to_y() {
        let twist = Twist::about([0.0, 0.0, 1e-200], [1.0, 1.0, 7.0], std::f64::consts::FRAC_PI_2);
        let end = moved(&Motion { twist, translation: [0.0, 0.0, 0.5] }, [2.0, 1.0, 3.0], 1.0);
        assert!(norm(minus(end, [1.0, 2.0, 3.5])) < 1e-15, "{end:?}");
    }

    #[test]
    fn arcs_keep_distances_to_the_axis_and_between_points() {
        let motion = motion();
        let twist = motion.twist.unwrap();
        let to_axis = |x: [f64; 3]| norm(cross(&twist.axis, &minus(x, twist.centre)));
        for s in [0.0, 0.1, 0.5, 0.77, 1.0] {
            let (here, other) = (moved(&motion, X, s), moved(&motion, [-1.0, 0.4, 0.2], s));
            let back = minus(here, motion.translation.map(|t| s * t));
            assert!((to_axis(back) - to_axis(X)).abs() < 1e-15, "s = {s}");
            let along = dot(&twist.axis, &minus(back, X));
            assert!(along.abs() < 1e-15, "s = {s}: {along}");
            let apart = norm(minus(here, other)) - norm(minus(X, [-1.0, 0.4, 0.2]));
            assert!(apart.abs() < 1e-15, "s = {s}: {apart}");
        }
    }

    #[test]
    fn rotations_about_one_axis_add_up() {
        let twist =
            |angle| Motion { twist: Twist::about([3.0, -1.0, 2.0], [0.5, 0.0, 0.0], angle), ..Motion::default() };
        let once = moved(&twist(1.1), X, 1.0);
        let twice = moved(&twist(1.1), once, 1.0);
        assert!(norm(minus(twice, moved(&twist(2.2), X, 1.0))) < 1e-15);
        assert!(norm(minus(moved(&twist(4.4), X, 0.5), twice)) < 1e-15, "half the progress is half the angle");
    }

    #[test]
    fn slopes_are_finite_differences() {
        let (motion, h) = (motion(), 1e-5);
        for s in [0.0, 0.3, 1.0] {
            let (low, high) = (motion.at(s - h).displacement(X), motion.at(s + h).displacement(X));
            let difference = [0, 1, 2].map(|r| (high[r] - low[r]) / (2.0 * h));
            // The error of central differences is h²θ³|X − c|/6 ≈ 6e-10; rounding adds 1e-11.
            assert!(norm(minus(difference, motion.at(s).slope(X))) < 1e-9, "s = {s}");
        }
    }

    #[test]
    fn small_angles_keep_their_digits() {
        let twist = Twist::about([0.0, 0.0, 1.0], [0.0; 3], 1e-9);
        let u = Motion { twist, ..Motion::default() }.at(1.0).displacement([1.0, 0.0, 0.0]);
        assert!((u[0] + 5e-19).abs() < 1e-30 && (u[1] - 1e-9).abs() < 1e-24, "{u:?}");
    }

    #[test]
    fn ramps_grow_linearly_and_stay() {
        let ramp = Ramp { from: 1.0, to: 3.0 };
        assert_eq!([0.0, 1.0, 1.5, 3.0, 9.0].map(|t| ramp.progress(t)), [0.0, 0.0, 0.25, 1.0, 1.0]);
        assert_eq!([0.0, 1.0, 2.9, 3.0].map(|t| ramp.rate(t)), [0.0, 0.5, 0.5, 0.0]);
        assert_eq!(Ramp::default().progress(0.0), 1.0);
        assert_eq!([0.9, 1.0].map(|t| Ramp { from: 1.0, to: 1.0 }.progress(t)), [0.0, 1.0]);
    }

    #[test]
    fn rounding_of_a_step_ends_nothing_early() {
        assert!(3.0 * 0.1 > 0.3 && lasts(Some(0.3), 3.0 * 0.1) && !lasts(Some(0.3), 0.3001) && lasts(None, f64::MAX));
    }

    #[test]
    fn a_direction_of_no_length_is_none() {
        for direction in [[0.0; 3], [f64::NAN, 0.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
            assert_eq!(Twist::about(direction, [0.0; 3], 1.0), None);
        }
    }
}
