//! What holds and loads a body over time, stated on its fine lattice for the fine and the coarse model alike.

use super::{Holds, Ramp, lasts};
use crate::contact::{Ground, PointPotential, surface_areas};
use crate::fine::FineModel;
use crate::mesh::Node;

/// When something acts: it grows along a ramp, and ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Schedule {
    /// How it grows to its full size.
    pub ramp: Ramp,
    /// The last time at which it acts \[s\]; `None`: for ever.
    pub until: Option<f64>,
}

impl Schedule {
    /// The share that acts at a time \[s\].
    pub fn share(&self, time: f64) -> f64 {
        if lasts(self.until, time) { self.ramp.progress(time) } else { 0.0 }
    }

    /// A potential as it acts at a time: springs by their share, the ground always.
    pub(super) fn acting(&self, potential: PointPotential, time: f64) -> PointPotential {
        match potential {
            PointPotential::Spring { stiffness, target } => {
                PointPotential::Spring { stiffness: self.share(time) * stiffness, target }
            }
            ground => ground,
        }
    }
}

/// Dead loads on the fine lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedLoad {
    /// Force on every node \[N\], three per lattice node.
    pub forces: Vec<f64>,
    /// When it acts.
    pub schedule: Schedule,
}

/// A spring between a node of the fine lattice and a fixed place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeSpring {
    /// The node.
    pub node: Node,
    /// Stiffness \[N/m\].
    pub stiffness: f64,
    /// The place \[m\].
    pub target: [f64; 3],
    /// When it acts; its stiffness grows along the ramp.
    pub schedule: Schedule,
}

/// All that acts on a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conditions {
    /// Held nodes and how they move.
    pub holds: Holds,
    /// Loads.
    pub loads: Vec<TimedLoad>,
    /// Springs.
    pub springs: Vec<NodeSpring>,
    /// The ground.
    pub ground: Option<Ground>,
}

/// A potential on a node of the fine lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NodePotential {
    pub node: Node,
    /// The potential at full share.
    pub potential: PointPotential,
    pub schedule: Schedule,
}

impl Conditions {
    /// Writes the sum of the loads at a time \[N\], three per lattice node.
    pub fn loads_at(&self, time: f64, share: f64, sum: &mut [f64]) {
        sum.fill(0.0);
        for load in &self.loads {
            let factor = share * load.schedule.share(time);
            sum.iter_mut().zip(&load.forces).for_each(|(sum, force)| *sum += factor * force);
        }
    }

    /// Shares of the loads and of the springs at a time, which tell whether anything has changed.
    pub(super) fn shares_at(&self, time: f64, share: f64, shares: &mut Vec<f64>) {
        shares.clear();
        shares.extend(self.loads.iter().map(|load| share * load.schedule.share(time)));
        shares.extend(self.springs.iter().map(|spring| spring.schedule.share(time)));
    }

    /// Springs, and the ground on every node of the body's surface, in the order of the nodes.
    pub(super) fn node_potentials(&self, model: &FineModel) -> Vec<NodePotential> {
        let solid = |spring: &&NodeSpring| model.active()[spring.node.0];
        let spring = |spring: &NodeSpring| NodePotential {
            node: spring.node,
            potential: PointPotential::Spring { stiffness: spring.stiffness, target: spring.target },
            schedule: spring.schedule,
        };
        let mut potentials: Vec<NodePotential> = self.springs.iter().filter(solid).map(spring).collect();
        let Some(ground) = self.ground else { return potentials };
        for (node, area) in surface_areas(model).into_iter().enumerate().filter(|(_, area)| *area > 0.0) {
            let stiffness = ground.stiffness * area;
            let potential = PointPotential::Ground { ground, stiffness, grip: Default::default() };
            potentials.push(NodePotential { node: Node(node), potential, schedule: Schedule::default() });
        }
        potentials
    }
}

impl NodePotential {
    /// The potential as it acts at a time.
    pub fn at(&self, time: f64) -> PointPotential {
        self.schedule.acting(self.potential, time)
    }
}
