//! Which parts of a body hang on nothing.
//!
//! A face-connected component is taken as a rigid part with six motions u(x) = a + ω × x. Parts share nodes along
//! edges or at corners: there their motions agree, so a part that hangs by one edge can still turn about it (a hinge)
//! and one that hangs by a node can turn about that (a ball joint). What is free is decided by ranks in lattice
//! coordinates, where all numbers are whole; unequal cell sizes scale rows and columns and leave the ranks alone.

use std::collections::{BTreeMap, BTreeSet};

use super::exact_rank::{RowSpan, negate};
use super::{Components, Neighbourhood, Node, VoxelGrid};

/// What a part that can still move is held by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeldBy {
    /// Neither it nor anything it is joined to is held.
    Nothing,
    /// One node.
    Node,
    /// Nodes on one line.
    Edge,
    /// More than that, but not in every direction.
    Partly,
}

/// A part of the body that can move without deforming anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoosePart {
    /// Number of its cells.
    pub cells: usize,
    /// Its first cell, x fastest.
    pub first_cell: [usize; 3],
    /// What it is held by.
    pub held_by: HeldBy,
    /// Number of its independent rigid motions, 1 to 6; an upper bound in clusters of more than 64 loose parts.
    pub free_motions: usize,
    /// True for the body's largest face-connected part.
    pub largest: bool,
}

impl std::fmt::Display for LoosePart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [i, j, k] = self.first_cell;
        let what = if self.largest { "the largest part," } else { "a part of" };
        let plural = if self.cells == 1 { "cell" } else { "cells" };
        let comma = if self.largest { "," } else { "" };
        write!(f, "{what} {} {plural} around cell ({i}, {j}, {k}){comma} ", self.cells)?;
        match self.held_by {
            HeldBy::Nothing => write!(f, "is held by nothing")?,
            HeldBy::Node => write!(f, "is held only by a node and can still turn")?,
            HeldBy::Edge => write!(f, "is held only by an edge and can still turn")?,
            HeldBy::Partly if self.free_motions == 1 => write!(f, "can still move in 1 way")?,
            HeldBy::Partly => write!(f, "can still move in {} ways", self.free_motions)?,
        }
        let remedy = if self.largest { "fix more of it" } else { "fix it or leave it out" };
        write!(f, "; {remedy}")
    }
}

/// The parts that can move when `fixed` holds the displacement components (x, y, z) of every lattice node.
///
/// Parts come in the order of their first cells. An empty list means that the stiffness of the body with these nodes
/// fixed has no rigid motion left. Time is linear in the grid but for clusters of parts that hold each other
/// mutually: those up to 64 parts are decided exactly, larger ones are called loose.
pub fn loose_parts(grid: &VoxelGrid, fixed: &[[bool; 3]]) -> Vec<LoosePart> {
    let parts = Components::new(&grid.void, &grid.lattice, Neighbourhood::Faces);
    let mut support = Support::new(grid, &parts, |node| fixed[node.0]);
    support.ground();
    support.loose(grid, &parts)
}

/// The parts that can move against the largest one, whatever is fixed: hinged and floating pieces.
///
/// Empty for a body whose only motions without supports are the six rigid ones.
pub fn parts_loose_from_largest(grid: &VoxelGrid) -> Vec<LoosePart> {
    let parts = Components::new(&grid.void, &grid.lattice, Neighbourhood::Faces);
    let Some(largest) = parts.largest() else { return Vec::new() };
    let mut support = Support::new(grid, &parts, |_| [false; 3]);
    support.settle(largest);
    support.ground();
    support.loose(grid, &parts)
}

/// Parts in a cluster up to which mutual support is decided.
const CLUSTER_LIMIT: usize = 64;

/// A node where parts meet or something is fixed.
struct Joint {
    at: [i64; 3],
    parts: Vec<usize>,
    fixed: [bool; 3],
}

/// How far the grounded set has grown.
struct Support {
    joints: Vec<Joint>,
    /// Joints of every part.
    joints_of: Vec<Vec<usize>>,
    /// Per part the rows that fixed nodes and grounded parts impose on its six motions.
    held: Vec<RowSpan>,
    grounded: Vec<bool>,
    /// Grounded parts whose joints have not been looked at.
    front: Vec<usize>,
}

impl Support {
    fn new(grid: &VoxelGrid, parts: &Components, fixed: impl Fn(Node) -> [bool; 3]) -> Self {
        let mut joints = Vec::new();
        let mut joints_of = vec![Vec::new(); parts.count()];
        for node in (0..grid.lattice.node_count()).map(Node) {
            let fixed = fixed(node);
            let meeting: BTreeSet<usize> = grid.lattice.cells_at(node).filter_map(|c| parts.of(c)).collect();
            if meeting.len() > 1 || (meeting.len() == 1 && fixed != [false; 3]) {
                meeting.iter().for_each(|part| joints_of[*part].push(joints.len()));
                let at = grid.lattice.node_position(node).map(|i| i as i64);
                joints.push(Joint { at, parts: meeting.into_iter().collect(), fixed });
            }
        }
        let held = vec![RowSpan::new(6); parts.count()];
        let mut support = Self { joints, joints_of, held, grounded: vec![false; parts.count()], front: Vec::new() };
        (0..support.joints.len()).for_each(|joint| support.hold(joint, support.joints[joint].fixed));
        support
    }

    /// Holds the components of a joint for every part that meets there.
    fn hold(&mut self, joint: usize, components: [bool; 3]) {
        let Joint { at, parts, .. } = &self.joints[joint];
        for &part in parts {
            for c in (0..3).filter(|c| components[*c]) {
                if !self.grounded[part] && self.held[part].rank() < 6 {
                    self.held[part].insert_whole(&motion_row(*at, c));
                }
            }
            if self.held[part].rank() == 6 && !self.grounded[part] {
                self.grounded[part] = true;
                self.front.push(part);
            }
        }
    }

    fn settle(&mut self, part: usize) {
        if !self.grounded[part] {
            self.grounded[part] = true;
            self.front.push(part);
        }
    }

    /// Grows the grounded set over joints, then over clusters whose parts hold each other, until nothing changes.
    fn ground(&mut self) {
        loop {
            while let Some(part) = self.front.pop() {
                for joint in self.joints_of[part].clone() {
                    self.hold(joint, [true; 3]);
                }
            }
            for cluster in self.clusters() {
                let free = self.free_motions(&cluster);
                cluster.iter().zip(free).filter(|(_, free)| *free == 0).for_each(|(part, _)| self.settle(*part));
            }
            if self.front.is_empty() {
                return;
            }
        }
    }

    /// Loose parts that are joined to each other, ordered by their first parts.
    fn clusters(&self) -> Vec<Vec<usize>> {
        let mut seen = self.grounded.clone();
        let mut clusters = Vec::new();
        for first in 0..seen.len() {
            if seen[first] {
                continue;
            }
            seen[first] = true;
            let mut cluster = vec![first];
            let mut next = 0;
            while next < cluster.len() {
                for part in self.joints_of[cluster[next]].iter().flat_map(|j| &self.joints[*j].parts) {
                    if !seen[*part] {
                        seen[*part] = true;
                        cluster.push(*part);
                    }
                }
                next += 1;
            }
            cluster.sort_unstable();
            clusters.push(cluster);
        }
        clusters
    }

    /// Number of free motions of each part of a cluster.
    fn free_motions(&self, cluster: &[usize]) -> Vec<usize> {
        if cluster.len() > CLUSTER_LIMIT || cluster.len() == 1 {
            return cluster.iter().map(|part| 6 - self.held[*part].rank()).collect();
        }
        let mut span = RowSpan::new(6 * cluster.len());
        for (p, part) in cluster.iter().enumerate() {
            self.held[*part].basis().for_each(|row| span.insert(placed(row, cluster.len(), p)));
        }
        for ((a, b), relative) in self.relative_rows(cluster) {
            for row in relative.basis() {
                let mut difference = placed(row, cluster.len(), a);
                (0..6).for_each(|c| difference[6 * b + c] = negate(row[c]));
                span.insert(difference);
            }
        }
        let null = span.null_space();
        let motions = |p: usize| {
            let mut own = RowSpan::new(6);
            null.iter().for_each(|vector| own.insert(vector[6 * p..6 * p + 6].to_vec()));
            own.rank()
        };
        (0..cluster.len()).map(motions).collect()
    }

    /// For every two parts of a cluster that meet, numbered within it, the rows that hold their relative motion.
    fn relative_rows(&self, cluster: &[usize]) -> BTreeMap<(usize, usize), RowSpan> {
        let mut relative = BTreeMap::new();
        for (a, part) in cluster.iter().enumerate() {
            for joint in self.joints_of[*part].iter().map(|j| &self.joints[*j]) {
                for b in joint.parts.iter().filter_map(|p| cluster.binary_search(p).ok()).filter(|b| *b > a) {
                    let span = relative.entry((a, b)).or_insert_with(|| RowSpan::new(6));
                    if span.rank() < 6 {
                        (0..3).for_each(|c| span.insert_whole(&motion_row(joint.at, c)));
                    }
                }
            }
        }
        relative
    }

    fn loose(&self, grid: &VoxelGrid, parts: &Components) -> Vec<LoosePart> {
        let largest = parts.largest();
        let mut loose = BTreeMap::new();
        for cluster in self.clusters() {
            let floats = cluster.iter().all(|part| self.held[*part].rank() == 0);
            for (&part, free_motions) in cluster.iter().zip(self.free_motions(&cluster)) {
                let described = LoosePart {
                    cells: parts.sizes()[part],
                    first_cell: grid.lattice.cell_position(parts.first_cells()[part]),
                    held_by: if floats { HeldBy::Nothing } else { self.held_by(part) },
                    free_motions,
                    largest: largest == Some(part),
                };
                loose.insert(part, described);
            }
        }
        loose.into_values().collect()
    }

    /// What the nodes span at which a part meets grounded parts or is fixed; if there are none, where it meets loose ones.
    fn held_by(&self, part: usize) -> HeldBy {
        let all = || self.joints_of[part].iter().map(|j| &self.joints[*j]);
        let firm = |j: &&Joint| j.fixed != [false; 3] || j.parts.iter().any(|p| self.grounded[*p]);
        let mut joints: Vec<&Joint> = all().filter(firm).collect();
        if joints.is_empty() {
            joints = all().collect();
        }
        let Some(first) = joints.first() else { return HeldBy::Nothing };
        let sliding = |joint: &&Joint| joint.parts.len() == 1 && joint.fixed != [true; 3];
        if joints.iter().any(sliding) {
            return HeldBy::Partly;
        }
        let mut directions = RowSpan::new(3);
        for joint in &joints {
            let direction: Vec<i64> = (0..3).map(|a| joint.at[a] - first.at[a]).collect();
            directions.insert_whole(&direction);
        }
        match directions.rank() {
            0 => HeldBy::Node,
            1 => HeldBy::Edge,
            _ => HeldBy::Partly,
        }
    }
}

/// A row on the motions of part `p` as one on those of `count` parts.
fn placed(row: &[u64], count: usize, p: usize) -> Vec<u64> {
    let mut wide = vec![0; 6 * count];
    wide[6 * p..6 * p + 6].copy_from_slice(row);
    wide
}

/// Component `c` of u(x) = a + ω × x as a row on (a, ω).
fn motion_row(x: [i64; 3], c: usize) -> [i64; 6] {
    let (next, last) = ((c + 1) % 3, (c + 2) % 3);
    let mut row = [0; 6];
    row[c] = 1;
    row[3 + next] = x[last];
    row[3 + last] = -x[next];
    row
}

#[cfg(test)]
mod tests;
