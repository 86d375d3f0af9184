//! Held parts of a body over time: what they prescribe to their nodes, and when they let go.

use super::motion::{Motion, MotionAt, Ramp, lasts};

/// A part of the body whose displacement is prescribed from the beginning until it is released.
#[derive(Clone, Debug, PartialEq)]
pub struct Hold {
    /// What messages call it, e.g. `fix[0]`.
    pub name: String,
    /// The held nodes, one entry per fine lattice node.
    pub nodes: Vec<bool>,
    /// How they move.
    pub motion: Motion,
    /// When they move; before it they are held where they were, after it where they came to.
    pub ramp: Ramp,
    /// The last time \[s\] at which they are held; `None`: for ever.
    pub until: Option<f64>,
}

impl Hold {
    /// Nodes that never move and are never released.
    pub fn still(name: impl Into<String>, nodes: Vec<bool>) -> Self {
        Self { name: name.into(), nodes, motion: Motion::default(), ramp: Ramp::default(), until: None }
    }

    /// Whether the nodes are held at a time \[s\]; at the time of the release they still are.
    pub fn is_active(&self, time: f64) -> bool {
        lasts(self.until, time)
    }

    /// The motion at a time \[s\].
    pub fn motion_at(&self, time: f64) -> MotionAt {
        self.motion.at(self.ramp.progress(time))
    }

    /// Displacement \[m\] at a time of the point that was at `position`, held or not.
    pub fn displacement(&self, position: [f64; 3], time: f64) -> [f64; 3] {
        self.motion_at(time).displacement(position)
    }

    /// Velocity \[m/s\] at a time of the point that was at `position`, from the right where it jumps.
    pub fn velocity(&self, position: [f64; 3], time: f64) -> [f64; 3] {
        let rate = self.ramp.rate(time);
        self.motion_at(time).slope(position).map(|slope| rate * slope)
    }
}

/// All held parts of a body. Where several hold a node they must agree, see [`check_agreement`](Self::check_agreement); the first counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Holds(pub Vec<Hold>);

impl Holds {
    /// The held parts at a time \[s\].
    fn active(&self, time: f64) -> impl Iterator<Item = &Hold> {
        self.0.iter().filter(move |hold| hold.is_active(time))
    }

    /// Which parts are held at a time \[s\].
    pub fn acting_at(&self, time: f64) -> impl Iterator<Item = bool> {
        self.0.iter().map(move |hold| hold.is_active(time))
    }

    /// Which of `nodes` lattice nodes are held at a time \[s\].
    pub fn fixed_at(&self, time: f64, nodes: usize) -> Vec<bool> {
        let mut fixed = vec![false; nodes];
        for hold in self.active(time) {
            fixed.iter_mut().zip(&hold.nodes).for_each(|(fixed, held)| *fixed |= held);
        }
        fixed
    }

    /// Whether no node ever moves and none is ever released: the held nodes are simply fixed.
    pub fn are_still(&self) -> bool {
        self.0.iter().all(|hold| hold.motion.is_still() && hold.until.is_none())
    }

    /// Whether other nodes are held at `after` than at `before`, because parts were released between the two times \[s\].
    pub fn change_between(&self, before: f64, after: f64) -> bool {
        self.0.iter().any(|hold| hold.is_active(before) != hold.is_active(after))
    }

    /// Prescribed displacement \[m\] at a time of a node that was at `position`; `None` where nothing holds it.
    pub fn displacement_at(&self, node: usize, position: [f64; 3], time: f64) -> Option<[f64; 3]> {
        self.active(time).find(|hold| hold.nodes[node]).map(|hold| hold.displacement(position, time))
    }

    /// Prescribed velocity \[m/s\] at a time of a node that was at `position`, from the right where it jumps; `None` where nothing
    /// holds it.
    pub fn velocity_at(&self, node: usize, position: [f64; 3], time: f64) -> Option<[f64; 3]> {
        self.active(time).find(|hold| hold.nodes[node]).map(|hold| hold.velocity(position, time))
    }

    /// Writes the prescribed displacements \[m\] at a time into `displacement`, three entries per lattice node; others stay. `position`
    /// gives the place of a node in the undeformed body.
    ///
    /// # Panics
    /// If a hold marks a node beyond the end of `displacement`.
    pub fn prescribe(&self, time: f64, position: impl Fn(usize) -> [f64; 3], displacement: &mut [f64]) {
        // Backwards, so that the first of several counts.
        for hold in self.0.iter().rev().filter(|hold| hold.is_active(time)) {
            let motion = hold.motion_at(time);
            for node in marked(&hold.nodes) {
                displacement[3 * node..3 * node + 3].copy_from_slice(&motion.displacement(position(node)));
            }
        }
    }

    /// The time \[s\] at which the last motion is complete; 0 where nothing moves.
    pub fn end_of_motion(&self) -> f64 {
        let moving = self.0.iter().filter(|hold| !hold.motion.is_still());
        moving.map(|hold| hold.ramp.to.max(hold.ramp.from)).fold(0.0, f64::max)
    }
}

/// The places of the marks.
pub(super) fn marked(nodes: &[bool]) -> impl Iterator<Item = usize> {
    nodes.iter().enumerate().filter(|(_, marked)| **marked).map(|(node, _)| node)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::Twist;

    const X: [f64; 3] = [0.3, -0.2, 0.5];

    fn moving(nodes: Vec<bool>) -> Hold {
        let motion = Motion { twist: Twist::about([1.0, 0.0, 1.0], [0.0; 3], 2.0), translation: [0.1, 0.0, 0.0] };
        Hold { motion, ramp: Ramp { from: 1.0, to: 3.0 }, until: Some(4.0), ..Hold::still("moving", nodes) }
    }

    #[test]
    fn velocities_are_finite_differences_of_displacements() {
        let (hold, h) = (moving(vec![true]), 1e-5);
        for time in [0.5, 1.7, 2.9, 3.5] {
            let (low, high) = (hold.displacement(X, time - h), hold.displacement(X, time + h));
            let velocity = hold.velocity(X, time);
            for r in 0..3 {
                let difference = (high[r] - low[r]) / (2.0 * h);
                assert!((difference - velocity[r]).abs() < 1e-9, "t = {time}: {difference} against {velocity:?}");
            }
        }
        assert_eq!(hold.velocity(X, 3.0), [0.0; 3], "the motion is complete");
        assert!(hold.velocity(X, 1.0) != [0.0; 3], "the motion begins");
    }

    #[test]
    fn a_part_is_held_before_its_motion_and_after_it_until_its_release() {
        let holds = Holds(vec![moving(vec![true, false, true]), Hold::still("still", vec![false, false, true])]);
        assert_eq!(holds.displacement_at(0, X, 0.0), Some([0.0; 3]));
        assert_eq!(holds.displacement_at(0, X, 3.0), holds.displacement_at(0, X, 4.0));
        assert_eq!(holds.displacement_at(1, X, 2.0), None);
        assert_eq!(holds.fixed_at(4.0, 3), [true, false, true]);
        assert_eq!(holds.fixed_at(4.1, 3), [false, false, true]);
        assert_eq!((holds.displacement_at(0, X, 4.1), holds.velocity_at(0, X, 4.1)), (None, None));
        assert_eq!(holds.displacement_at(2, X, 4.1), Some([0.0; 3]), "another part takes over");
        assert!(!holds.change_between(0.0, 4.0) && holds.change_between(4.0, 4.1) && !holds.change_between(4.1, 9.0));
        assert!(holds.change_between(9.0, 0.0), "going back, too");
        assert_eq!(holds.end_of_motion(), 3.0);
    }

    #[test]
    fn prescribed_fields_hold_what_single_nodes_get() {
        let holds =
            Holds(vec![moving(vec![true, false, true, false]), Hold::still("still", vec![false, true, true, false])]);
        let position = |node: usize| [node as f64, 0.5, -0.25];
        for time in [2.0, 5.0] {
            let mut field = vec![7.0; 12];
            holds.prescribe(time, position, &mut field);
            for node in 0..4 {
                let expected = holds.displacement_at(node, position(node), time).unwrap_or([7.0; 3]);
                assert_eq!(field[3 * node..3 * node + 3], expected, "node {node} at {time} s");
            }
        }
    }

    #[test]
    fn only_still_parts_that_stay_are_simply_fixed() {
        let still = Hold::still("still", vec![true]);
        assert!(Holds(vec![still.clone()]).are_still() && Holds::default().are_still());
        assert!(!Holds(vec![still.clone(), moving(vec![true])]).are_still());
        assert!(!Holds(vec![Hold { until: Some(1.0), ..still }]).are_still());
    }
}
