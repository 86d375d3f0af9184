//! How a held part moves: `move` in `[[fix]]`.

use super::document::{Item, Reading};
use super::section::Section;

/// Larger angles are mistaken for something else \[degrees\]: a hundred turns.
const LARGEST_ANGLE: f64 = 36_000.0;

/// A motion of a held part: twisted first, then translated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneMotion {
    /// The rotation, if any.
    pub twist: Option<SceneTwist>,
    /// The translation \[m\].
    pub translate: [f64; 3],
}

/// A rotation of a held part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneTwist {
    /// Direction of the axis; not zero, of any length.
    pub axis: [f64; 3],
    /// A point of the axis \[m\]; the centre of the box around the held part without it.
    pub centre: Option<[f64; 3]>,
    /// The angle \[degrees\].
    pub angle: f64,
}

/// The keys of `move`.
pub const KEYS: &[&str] = &["translate", "twist", "from", "to"];

/// Reads what a `move` does; its times are read elsewhere.
pub fn read_motion(section: &Section) -> Reading<SceneMotion> {
    let translate = section.optional("translate", Item::vector);
    let twist = section.optional("twist", read_twist);
    let (translate, twist) = (translate?, twist?);
    match translate.is_some() || twist.is_some() {
        true => Ok(SceneMotion { twist, translate: translate.unwrap_or_default() }),
        false => Err(section.note(format!("{} does not move anything; expected translate or twist", section.key()))),
    }
}

fn read_twist(item: &Item) -> Reading<SceneTwist> {
    let section = item.section(&["axis", "angle", "centre"])?;
    let axis = section.required("axis", "\"x\", \"y\", \"z\" or a direction of three numbers", read_axis);
    let expected = format!("degrees, a number from -{LARGEST_ANGLE} to {LARGEST_ANGLE}");
    let angle = section.required("angle", &expected, |a| a.number_where(&expected, |a| a.abs() <= LARGEST_ANGLE));
    let centre = section.optional("centre", Item::vector);
    Ok(SceneTwist { axis: axis?, angle: angle?, centre: centre? })
}

fn read_axis(item: &Item) -> Reading<[f64; 3]> {
    let axes = [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])];
    if let Some((_, axis)) = axes.iter().find(|(name, _)| item.says(name)) {
        return Ok(*axis);
    }
    let expected = "\"x\", \"y\", \"z\" or a direction of three numbers, not all zero";
    match item.is_list() {
        false => Err(item.refuse(expected)),
        true => item.vector().and_then(|axis| if axis == [0.0; 3] { Err(item.refuse(expected)) } else { Ok(axis) }),
    }
}
