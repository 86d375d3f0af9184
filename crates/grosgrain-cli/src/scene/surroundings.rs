//! How a dynamic run begins and what it meets: `[start]` and `[contact]`.

use super::document::{Item, Reading};

/// The `[start]` table: how the body moves at time zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// Velocity of the whole body \[m/s\].
    pub velocity: [f64; 3],
    /// Angular velocity about the centre of mass \[rad/s\].
    pub spin: [f64; 3],
}

impl Start {
    /// Whether the body is at rest.
    pub fn is_at_rest(&self) -> bool {
        *self == Self::default()
    }
}

/// The plane z = const on which the body lands: `ground` in `[contact]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Its height \[m\].
    pub z: f64,
    /// Coefficient of Coulomb friction.
    pub friction: f64,
    /// Pressure per depth \[Pa/m\]; chosen from the body without it.
    pub stiffness: Option<f64>,
}

/// Reads `[start]`.
pub fn read_start(item: &Item) -> Reading<Start> {
    let section = item.section(&["velocity", "spin"])?;
    let velocity = section.optional("velocity", Item::vector);
    let spin = section.optional("spin", Item::vector);
    match (velocity?, spin?) {
        (None, None) => Err(item.note("start holds nothing; expected velocity or spin".into())),
        (velocity, spin) => Ok(Start { velocity: velocity.unwrap_or_default(), spin: spin.unwrap_or_default() }),
    }
}

/// Reads `[contact]`.
pub fn read_contact(item: &Item) -> Reading<Ground> {
    let section = item.section(&["ground"])?;
    section.required("ground", "{ z = .., friction = .. }", |ground| {
        let section = ground.section(&["z", "friction", "stiffness"])?;
        let z = section.required("z", "the height of the ground in metres", Item::number);
        let friction = section.optional("friction", Item::non_negative);
        let stiffness = section.optional("stiffness", |s| s.number_where("a positive number of Pa/m", |s| s > 0.0));
        Ok(Ground { z: z?, friction: friction?.unwrap_or_default(), stiffness: stiffness? })
    })
}
