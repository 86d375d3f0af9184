//! What acts on the body of a scene, in the library's terms.

use grosgrain::contact::{Ground, surface_areas};
use grosgrain::dynamics::{Conditions, NodeSpring};
use grosgrain::fine::FineModel;
use grosgrain::mesh::{Cell, Node};

use crate::problem::Problem;
use crate::scene::Scene;

/// Holds, loads, springs and ground of a scene on its body as it is now.
pub fn conditions(problem: &Problem) -> Conditions {
    let model = &problem.model;
    let springs = problem.springs.iter().flat_map(|springs| {
        springs.nodes.iter().map(|node| NodeSpring {
            node: *node,
            stiffness: springs.stiffness,
            target: springs.anchor(*node, model),
            schedule: springs.span.schedule(),
        })
    });
    let (holds, loads) = (problem.holds.clone(), problem.placed.timed(model));
    Conditions { holds, loads, springs: springs.collect(), ground: problem.ground }
}

/// The ground of a scene under its body as it is at the beginning; edits do not make it softer or stiffer.
pub fn ground(scene: &Scene, model: &FineModel) -> Option<Ground> {
    scene.contact.map(|ground| Ground {
        height: ground.z,
        friction: ground.friction,
        stiffness: ground.stiffness.unwrap_or_else(|| stiffness_of_ground(model)),
    })
}

/// Pressure per depth \[Pa/m\] at which a pressure sinks in as deep as it presses one fine cell of the surface together: the mean Young
/// modulus of the cells at the surface over their height.
fn stiffness_of_ground(model: &FineModel) -> f64 {
    let (areas, lattice) = (surface_areas(model), model.grid().lattice);
    let (mut sum, mut count) = (0.0, 0.0);
    for node in (0..areas.len()).filter(|n| areas[*n] > 0.0) {
        for cell in lattice.cells_at(Node(node)).filter(|cell: &Cell| !model.is_void(*cell)) {
            sum += model.young(cell);
            count += 1.0;
        }
    }
    sum / f64::max(count, 1.0) / model.grid().spacing[2]
}
