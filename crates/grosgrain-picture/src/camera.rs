//! Where the eye stands, and the map from the body's space to the picture plane.

use crate::PictureError;

/// A point or direction in space.
pub(crate) type Vec3 = [f64; 3];

/// The view of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Direction in which the eye looks, from the eye to the body.
    pub toward: [f64; 3],
    /// The direction that points upwards in the picture.
    pub up: [f64; 3],
    /// Reciprocal of the eye's distance in radii of the body: 0 is orthographic, 0.25 a weak perspective.
    pub perspective: f64,
}

impl View {
    /// A three-quarter view from above with z up; the longer horizontal extent runs across the picture.
    pub fn three_quarter(extent: [f64; 3]) -> Self {
        let azimuth = if extent[0] >= extent[1] { -62f64 } else { -28f64 }.to_radians();
        let elevation = 24f64.to_radians();
        let eye = [azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin()];
        Self { toward: eye.map(|x| -x), up: [0.0, 0.0, 1.0], perspective: 0.12 }
    }
}

/// A view fitted to a set of points, which several pictures can share.
///
/// ```
/// use grosgrain_picture::Camera;
/// let camera = Camera::new(None, &[[0.0; 3], [1.0, 0.5, 0.2]])?;
/// # Ok::<(), grosgrain_picture::PictureError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Unit vectors to the right, up, and to the eye.
    axes: [Vec3; 3],
    centre: Vec3,
    /// Distance of the eye from the centre; infinite if orthographic.
    distance: f64,
    pub(crate) radius: f64,
    /// Smallest and largest projected coordinates, right and up.
    pub(crate) bounds: [[f64; 2]; 2],
}

impl Camera {
    /// A camera that sees all `points`; `None` chooses a three-quarter view from their extent, z up.
    ///
    /// # Errors
    /// No points, a point that is not finite, a view without direction.
    pub fn new(view: Option<View>, points: &[Vec3]) -> Result<Self, PictureError> {
        Self::around(view, points.iter().copied())
    }

    /// As [`Camera::new`], for points that are made as they are needed.
    ///
    /// # Errors
    /// As [`Camera::new`].
    pub fn around(view: Option<View>, points: impl Iterator<Item = [f64; 3]> + Clone) -> Result<Self, PictureError> {
        let usable = |p: &Vec3| p.iter().all(|x| x.abs() < 1e150);
        let unusable = points.clone().position(|p| !usable(&p));
        if unusable.is_some() || points.clone().next().is_none() {
            return Err(PictureError::CameraPoints(unusable));
        }
        let (low, high) = bounds(points.clone());
        let extent: Vec3 = std::array::from_fn(|a| high[a] - low[a]);
        let view = view.unwrap_or_else(|| View::three_quarter(extent));
        let radius = (0.5 * norm(extent)).max(1e-150);
        let centre = std::array::from_fn(|a| 0.5 * (low[a] + high[a]));
        let distance = radius / view.perspective.clamp(0.0, 0.6);
        let mut camera = Self { axes: view_axes(view)?, centre, distance, radius, bounds: [[0.0; 2]; 2] };
        let (low, high) = bounds(points.map(|p| camera.project(p)));
        camera.bounds = [[low[0], low[1]], [high[0], high[1]]];
        Ok(camera)
    }

    /// Right, up, and closeness to the eye, in the body's unit of length near the centre.
    ///
    /// With depth z and eye distance D the scale is D/(D−z) and the closeness z·D/(D−z),
    /// which is linear over the picture of a plane.
    pub(crate) fn project(&self, p: Vec3) -> Vec3 {
        let v = self.turn(std::array::from_fn(|a| p[a] - self.centre[a]));
        let scale = 1.0 / (1.0 - v[2] / self.distance);
        v.map(|x| x * scale)
    }

    /// Pixels per unit of length near the centre, so that a picture of this size holds everything with a small border.
    pub(crate) fn scale(&self, size: [usize; 2]) -> f64 {
        let [[left, bottom], [right, top]] = self.bounds;
        let smallest = 1e-3 * self.radius;
        let [width, height] = size.map(|n| n as f64);
        let border = 0.04 * width.min(height);
        ((width - border) / (right - left).max(smallest)).min((height - border) / (top - bottom).max(smallest))
    }

    /// The ray through a point of the picture plane: a point on it, its unit direction, and the parameter of the eye.
    pub(crate) fn ray(&self, x: f64, y: f64) -> (Vec3, Vec3, f64) {
        let [right, up, back] = self.axes;
        let point = std::array::from_fn(|a| self.centre[a] + x * right[a] + y * up[a]);
        if self.distance.is_infinite() {
            return (point, back.map(|b| -b), f64::NEG_INFINITY);
        }
        let from_eye: Vec3 = std::array::from_fn(|a| x * right[a] + y * up[a] - self.distance * back[a]);
        let length = norm(from_eye);
        (point, from_eye.map(|d| d / length), -length)
    }

    /// A direction in the axes right, up, to the eye.
    pub(crate) fn turn(&self, d: Vec3) -> Vec3 {
        self.axes.map(|axis| dot(axis, d))
    }

    /// Direction from a point to the eye, not normalised.
    pub(crate) fn to_eye(&self, p: Vec3) -> Vec3 {
        let back = 1.0 / self.distance;
        std::array::from_fn(|a| self.axes[2][a] - back * (p[a] - self.centre[a]))
    }
}

fn view_axes(view: View) -> Result<[Vec3; 3], PictureError> {
    let refused = || PictureError::View { toward: view.toward, up: view.up };
    let back = unit(view.toward.map(|x| -x)).ok_or_else(refused)?;
    let up = unit(view.up).ok_or_else(refused)?;
    let across = cross(up, back);
    let right = unit(across).filter(|_| norm(across) > 1e-6).ok_or_else(refused)?;
    Ok([right, cross(back, right), back])
}

fn bounds(points: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    points.fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), p| {
        (std::array::from_fn(|a| low[a].min(p[a])), std::array::from_fn(|a| high[a].max(p[a])))
    })
}

pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// The vector divided by its length, `None` if that is zero or not finite.
pub(crate) fn unit(a: Vec3) -> Option<Vec3> {
    let length = norm(a);
    (length > 0.0 && length.is_finite()).then(|| a.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn z_points_up_and_the_long_axis_runs_across() -> Result<(), PictureError> {
        let corners = [[0.0; 3], [4.0, 1.0, 1.0]];
        let camera = Camera::new(None, &corners)?;
        let z = camera.turn([0.0, 0.0, 1.0]);
        assert!(z[0].abs() < 1e-12 && z[1] > 0.8, "{z:?}");
        let x = camera.turn([1.0, 0.0, 0.0]);
        assert!(x[0] > 0.8, "{x:?}");
        Ok(())
    }

    #[test]
    fn nearer_points_are_closer_and_larger() -> Result<(), PictureError> {
        let view = View { toward: [0.0, 1.0, 0.0], up: [0.0, 0.0, 1.0], perspective: 0.25 };
        let camera = Camera::new(Some(view), &[[-1.0; 3], [1.0; 3]])?;
        let (near, far) = (camera.project([1.0, -1.0, 0.0]), camera.project([1.0, 1.0, 0.0]));
        assert!(near[2] > far[2] && near[0] > far[0], "{near:?} {far:?}");
        Ok(())
    }

    #[test]
    fn a_view_along_the_upward_direction_is_refused() {
        let view = View { toward: [0.0, 0.0, -1.0], up: [0.0, 0.0, 1.0], perspective: 0.0 };
        assert!(matches!(Camera::new(Some(view), &[[0.0; 3]]), Err(PictureError::View { .. })));
    }
}
