//! Held parts that cannot be as they are asked to: two that disagree about a node, and one that is pushed through the ground.

use super::hold::{Hold, Holds, marked};
use crate::linalg::matrix3::{cross, dot};

/// Displacements that differ by no more than this share of the lengths involved are the same.
const SAME_LENGTH: f64 = 1e-9;
/// Where an interval between two events is looked at, from 0 to 1. Twists about one axis whose angles differ by whole turns meet again
/// at fractions of the interval, hence one that is no fraction.
const SAMPLES: [f64; 4] = [0.0, 0.381_966_011_250_105, 0.5, 1.0];
/// Halvings of an interval in search of the moment when a point passes the ground: to the last digit.
const HALVINGS: usize = 60;

/// Two held parts that ask different displacements of the same node.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{} and {} both hold the node at ({:.6}, {:.6}, {:.6}) m, but at {time:.6} s one moves it by ({:.9}, {:.9}, {:.9}) m and \
     the other by ({:.9}, {:.9}, {:.9}) m; let only one of them hold it, or give both the same motion",
    names[0], names[1], position[0], position[1], position[2], displacements[0][0], displacements[0][1], displacements[0][2],
    displacements[1][0], displacements[1][1], displacements[1][2]
)]
pub struct HoldConflict {
    /// The two parts.
    pub names: [String; 2],
    /// The lattice node.
    pub node: usize,
    /// Where it is in the undeformed body \[m\].
    pub position: [f64; 3],
    /// When they disagree \[s\].
    pub time: f64,
    /// What each asks \[m\].
    pub displacements: [[f64; 3]; 2],
}

/// A held part that is pushed through the ground.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{name} carries the node at ({:.6}, {:.6}, {:.6}) m through the ground z = {ground} m at {time:.6} s and down to z = {lowest:.6} m; \
     lower the ground or change the motion",
    position[0], position[1], position[2]
)]
pub struct GroundPassage {
    /// The part.
    pub name: String,
    /// The lattice node.
    pub node: usize,
    /// Where it is in the undeformed body \[m\].
    pub position: [f64; 3],
    /// Height of the ground \[m\].
    pub ground: f64,
    /// When the node passes it \[s\].
    pub time: f64,
    /// How low the node comes \[m\].
    pub lowest: f64,
}

impl Holds {
    /// Refuses two parts that hold a common node at the same time and move it differently.
    ///
    /// Between two events (beginning and end of a motion, release) every node moves on a line, an arc or a helix; each such interval is
    /// looked at at its ends, its middle and one irrational share of it. Only nodes that are marked in `relevant` count; `position` gives
    /// the place of a node in the undeformed body.
    ///
    /// # Errors
    /// The first disagreement of the first two parts that disagree.
    pub fn check_agreement(
        &self,
        relevant: &[bool],
        position: impl Fn(usize) -> [f64; 3],
    ) -> Result<(), Box<HoldConflict>> {
        for (n, second) in self.0.iter().enumerate() {
            for first in &self.0[..n] {
                let common = marked(&first.nodes).filter(|&node| relevant[node] && second.nodes[node]);
                check_pair([first, second], &common.map(|node| (node, position(node))).collect::<Vec<_>>())?;
            }
        }
        Ok(())
    }

    /// Refuses parts that are carried below the plane z = `ground` \[m\] while they are held. Only nodes that are marked in `relevant`
    /// count; `position` gives the place of a node in the undeformed body. Nodes that begin below the ground pass it at time zero.
    ///
    /// # Errors
    /// The passage that comes first.
    pub fn check_ground(
        &self,
        ground: f64,
        relevant: &[bool],
        position: impl Fn(usize) -> [f64; 3],
    ) -> Result<(), GroundPassage> {
        let mut earliest: Option<GroundPassage> = None;
        for hold in &self.0 {
            for node in marked(&hold.nodes).filter(|&node| relevant[node]) {
                let Some((time, lowest)) = passage(hold, position(node), ground) else { continue };
                if earliest.as_ref().is_none_or(|known| time < known.time) {
                    let (name, position) = (hold.name.clone(), position(node));
                    earliest = Some(GroundPassage { name, node, position, ground, time, lowest });
                }
            }
        }
        earliest.map_or(Ok(()), Err)
    }
}

/// The times between which the parts move smoothly, up to the first release.
fn events(holds: [&Hold; 2]) -> Vec<f64> {
    let released = holds.iter().filter_map(|hold| hold.until).fold(f64::INFINITY, f64::min);
    let mut times = vec![0.0];
    times.extend(holds.iter().flat_map(|hold| [hold.ramp.from, hold.ramp.to]));
    times.extend(Some(released));
    times.retain(|time| (0.0..=released).contains(time) && time.is_finite());
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

fn check_pair(holds: [&Hold; 2], nodes: &[(usize, [f64; 3])]) -> Result<(), Box<HoldConflict>> {
    let events = events(holds);
    let between = events.windows(2).flat_map(|pair| SAMPLES.map(|share| pair[0] + share * (pair[1] - pair[0])));
    for time in events.first().copied().into_iter().chain(between) {
        let motions = holds.map(|hold| hold.motion_at(time));
        for &(node, position) in nodes {
            let displacements = motions.map(|motion| motion.displacement(position));
            let [u, v] = displacements;
            let arms = holds.map(|hold| hold.motion.twist.map_or(0.0, |twist| length(minus(position, twist.centre))));
            let size = length(u) + length(v) + length(position) + arms[0] + arms[1];
            if length(minus(u, v)) > SAME_LENGTH * size {
                let names = holds.map(|hold| hold.name.clone());
                return Err(Box::new(HoldConflict { names, node, position, time, displacements }));
            }
        }
    }
    Ok(())
}

/// When the node goes below the ground \[s\], and how low it comes \[m\]; `None` if it never does.
fn passage(hold: &Hold, position: [f64; 3], ground: f64) -> Option<(f64, f64)> {
    let path = Height::new(hold, position);
    let end = hold.until.map_or(1.0, |until| hold.ramp.progress(until));
    let slack = SAME_LENGTH * (path.level.abs() + path.rise.abs() + path.radius + ground.abs());
    let is_below = |s: f64| path.at(s) < ground - slack;
    let turns = path.turning_points(end);
    let lowest = turns.iter().map(|s| path.at(*s)).fold(f64::INFINITY, f64::min);
    let below = turns.iter().position(|s| is_below(*s))?;
    let Some(before) = below.checked_sub(1) else { return Some((0.0, lowest)) };
    let (mut above, mut under) = (turns[before], turns[below]);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (above + under);
        if is_below(middle) { under = middle } else { above = middle }
    }
    Some((hold.ramp.from + under * (hold.ramp.to - hold.ramp.from).max(0.0), lowest))
}

/// Height of a point over the progress s of its motion: z(s) = level + rise s + radius cos(angle s − phase).
struct Height {
    level: f64,
    rise: f64,
    radius: f64,
    phase: f64,
    angle: f64,
}

impl Height {
    fn new(hold: &Hold, position: [f64; 3]) -> Self {
        let rise = hold.motion.translation[2];
        let Some(twist) = hold.motion.twist else {
            return Self { level: position[2], rise, radius: 0.0, phase: 0.0, angle: 0.0 };
        };
        // R(φ) r = (a·r) a + cos φ (r − (a·r) a) + sin φ (a × r); only the third component counts.
        let arm = minus(position, twist.centre);
        let along = dot(&twist.axis, &arm) * twist.axis[2];
        let (cosine, sine) = (arm[2] - along, cross(&twist.axis, &arm)[2]);
        let (radius, phase) = (cosine.hypot(sine), sine.atan2(cosine));
        Self { level: twist.centre[2] + along, rise, radius, phase, angle: twist.angle }
    }

    fn at(&self, s: f64) -> f64 {
        self.level + self.rise * s + self.radius * (self.angle * s - self.phase).cos()
    }

    /// Values of s from 0 to `end` between which the height only rises or only falls, ascending, the ends among them: the zeros of
    /// z′(s) = rise − angle radius sin(angle s − phase).
    fn turning_points(&self, end: f64) -> Vec<f64> {
        let mut points = vec![0.0, end];
        let sine = self.rise / (self.angle * self.radius);
        if sine.abs() < 1.0 {
            let turn = std::f64::consts::TAU;
            for root in [sine.asin(), std::f64::consts::PI - sine.asin()] {
                // (root + turn k + phase) / angle lies in [0, end].
                let ends = [-self.phase - root, self.angle * end - self.phase - root].map(|x| x / turn);
                let (first, last) = (ends[0].min(ends[1]).ceil() as i64, ends[0].max(ends[1]).floor() as i64);
                points.extend((first..=last).map(|k| (root + turn * k as f64 + self.phase) / self.angle));
            }
        }
        points.iter_mut().for_each(|s| *s = s.clamp(0.0, end));
        points.sort_by(f64::total_cmp);
        points
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn length(v: [f64; 3]) -> f64 {
    dot(&v, &v).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{Motion, Ramp, Twist};
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    fn hold(name: &str, motion: Motion, [from, to]: [f64; 2]) -> Hold {
        Hold { motion, ramp: Ramp { from, to }, ..Hold::still(name, vec![true, true]) }
    }

    fn twist(axis: [f64; 3], centre: [f64; 3], angle: f64) -> Motion {
        Motion { twist: Twist::about(axis, centre, angle), ..Motion::default() }
    }

    fn agree(holds: Vec<Hold>) -> Result<(), Box<HoldConflict>> {
        Holds(holds).check_agreement(&[true, true], |node| [0.2, 0.1 * node as f64, 0.3])
    }

    const PULL: Motion = Motion::translate([0.0, 0.0, 0.1]);

    #[test]
    fn parts_that_move_alike_agree() {
        assert_eq!(agree(vec![hold("a", PULL, [0.0, 1.0]), hold("b", PULL, [0.0, 1.0])]), Ok(()));
        let half = Motion::translate([0.0, 0.0, 0.05]);
        let early = Hold { until: Some(0.5), ..hold("b", half, [0.0, 0.5]) };
        assert_eq!(agree(vec![hold("a", PULL, [0.0, 1.0]), early]), Ok(()), "the second lets go before they part");
        let about = |angle| twist([0.0, 0.0, 1.0], [0.5, 0.5, 0.0], angle);
        assert_eq!(agree(vec![hold("a", about(2.0), [0.0, 1.0]), hold("b", about(2.0), [0.0, 1.0])]), Ok(()));
        let other = Hold { nodes: vec![false, true], ..hold("a", PULL, [0.0, 1.0]) };
        assert_eq!(agree(vec![other, Hold::still("b", vec![true, false])]), Ok(()), "no common node");
    }

    #[test]
    fn parts_that_disagree_are_told_with_time_place_and_displacements() {
        let error =
            agree(vec![hold("fix[0]", PULL, [0.0, 1.0]), Hold::still("fix[1]", vec![false, true])]).unwrap_err();
        assert_eq!((error.node, error.position), (1, [0.2, 0.1, 0.3]));
        let share = SAMPLES[1];
        assert_eq!((error.time, error.displacements), (share, [[0.0, 0.0, 0.1 * share], [0.0; 3]]));
        let said = error.to_string();
        let expected = "fix[0] and fix[1] both hold the node at (0.200000, 0.100000, 0.300000) m, but at 0.381966 s one moves it by \
                        (0.000000000, 0.000000000, 0.038196601) m and the other by (0.000000000, 0.000000000, 0.000000000) m; ";
        assert!(said.starts_with(expected), "{said}");
    }

    #[test]
    fn disagreement_is_found_wherever_it_begins() {
        let late = hold("b", PULL, [2.0, 3.0]);
        let error = agree(vec![Hold::still("a", vec![true, true]), late.clone()]).unwrap_err();
        assert!((2.0..3.0).contains(&error.time), "{error}");
        assert!(agree(vec![Hold { until: Some(2.0), ..Hold::still("a", vec![true, true]) }, late]).is_ok());
        // They meet at the ends and in the middle: a full turn more, and two.
        let about = |angle| hold("t", twist([1.0, 0.0, 0.0], [0.0; 3], angle), [0.0, 1.0]);
        assert!(
            agree(vec![about(0.5), about(0.5 + TAU)]).is_err()
                && agree(vec![about(0.5), about(0.5 + 2.0 * TAU)]).is_err()
        );
        assert!(agree(vec![hold("a", PULL, [0.0, 0.0]), Hold::still("b", vec![true, true])]).is_err(), "at once");
    }

    #[test]
    fn nodes_without_material_do_not_count() {
        let holds = Holds(vec![hold("a", PULL, [0.0, 1.0]), Hold::still("b", vec![false, true])]);
        assert!(holds.check_agreement(&[true, false], |_| [0.0; 3]).is_ok());
        assert!(holds.check_ground(5.0, &[false, false], |_| [0.0; 3]).is_ok());
    }

    fn ground(hold: Hold, ground: f64, position: [f64; 3]) -> Result<(), GroundPassage> {
        Holds(vec![hold]).check_ground(ground, &[true, false], |_| position)
    }

    #[test]
    fn a_push_reaches_the_ground_in_proportion() {
        let push = || hold("fix[0]", Motion::translate([0.1, 0.0, -0.4]), [1.0, 3.0]);
        let passage = ground(push(), 0.0, [0.0, 0.0, 0.1]).unwrap_err();
        assert!((passage.time - 1.5).abs() < 1e-8 && (passage.lowest + 0.3).abs() < 1e-15, "{passage:?}");
        assert!(
            passage
                .to_string()
                .starts_with("fix[0] carries the node at (0.000000, 0.000000, 0.100000) m through the ground z = 0 m")
        );
        assert!(ground(push(), -0.3, [0.0, 0.0, 0.1]).is_ok(), "it comes to rest on the ground");
        assert!(ground(Hold { until: Some(1.4), ..push() }, 0.0, [0.0, 0.0, 0.1]).is_ok(), "released above the ground");
        assert!(ground(Hold { until: Some(1.6), ..push() }, 0.0, [0.0, 0.0, 0.1]).is_err());
    }

    #[test]
    fn an_arc_that_dips_below_and_ends_above_is_found() {
        // From the side over the lowest point to the other side: z = −sin(πs) about the centre's height 0.5, radius 1.
        let swing = hold("a", twist([0.0, 1.0, 0.0], [0.0, 0.0, 0.5], PI), [0.0, 2.0]);
        let passage = ground(swing.clone(), 0.0, [1.0, 0.0, 0.5]).unwrap_err();
        assert!((passage.time - 2.0 / 6.0).abs() < 1e-8 && (passage.lowest + 0.5).abs() < 1e-15, "{passage:?}");
        assert!(ground(swing, 0.0, [-1.0, 0.0, 0.5]).is_ok(), "the other way round it stays above");
        let back = hold("a", twist([0.0, -1.0, 0.0], [0.0, 0.0, 0.5], 4.0 * PI), [0.0, 1.0]);
        let passage = ground(back, 0.0, [1.0, 0.0, 0.5]).unwrap_err();
        assert!((passage.time - 7.0 / 24.0).abs() < 1e-8, "after 210 of 720 degrees: {passage:?}");
    }

    #[test]
    fn a_helix_is_followed_and_the_first_node_is_told() {
        let motion = Motion { translation: [0.0, 0.0, -0.3], ..twist([0.0, 1.0, 0.0], [0.0; 3], -3.0 * TAU) };
        let (holds, both) = (Holds(vec![hold("a", motion, [0.0, 1.0])]), [true, true]);
        let position = |node: usize| [0.1 + 0.05 * node as f64, 0.0, 0.0];
        let passage = holds.check_ground(-0.2, &both, position).unwrap_err();
        let heights = (0..=100_000).map(|n| n as f64 * 1e-5).map(|t| (t, holds.0[0].displacement(position(1), t)[2]));
        let (first, _) = heights.clone().find(|(_, z)| *z < -0.2).unwrap();
        let lowest = heights.map(|(_, z)| z).fold(f64::INFINITY, f64::min);
        assert_eq!(passage.node, 1);
        assert!(
            (passage.time - first).abs() < 1.1e-5 && (passage.lowest - lowest).abs() < 1e-7,
            "{passage:?}, {first}"
        );
    }

    #[test]
    fn heights_are_those_of_the_motion_and_turn_where_they_are_told_to() {
        let motion = Motion { translation: [0.3, 0.1, 0.2], ..twist([1.0, 2.0, 0.5], [0.1, -0.2, 0.4], 9.0) };
        let (hold, x) = (hold("a", motion, [0.0, 1.0]), [0.7, 0.2, -0.3]);
        let path = Height::new(&hold, x);
        for s in [0.0, 0.2, 0.9, 1.0] {
            assert!((path.at(s) - x[2] - hold.displacement(x, s)[2]).abs() < 1e-14, "s = {s}");
        }
        let turns = path.turning_points(1.0);
        assert!(turns.len() >= 4, "{turns:?}");
        for pair in turns.windows(2) {
            let heights: Vec<f64> =
                (0..=20).map(|n| path.at(pair[0] + (pair[1] - pair[0]) * n as f64 / 20.0)).collect();
            let rising = heights[20] > heights[0];
            assert!(heights.windows(2).all(|h| (h[1] > h[0]) == rising || h[0] == h[1]), "{pair:?}");
        }
    }

    #[test]
    fn what_begins_below_passes_at_once_and_what_rests_on_the_ground_does_not() {
        assert_eq!(ground(Hold::still("a", vec![true, true]), 0.1, [0.0; 3]).unwrap_err().time, 0.0);
        assert!(ground(Hold::still("a", vec![true, true]), 0.1, [0.0, 0.0, 0.1]).is_ok());
        let tilt = hold("a", twist([1.0, 0.0, 0.0], [0.0, 1.0, 0.1], FRAC_PI_2), [0.0, 1.0]);
        assert!(ground(tilt, 0.1, [0.0, 2.0, 0.1]).is_ok(), "it rises");
    }
}
