//! Whether what holds a mesh leaves it, or a part of it, free to move.

use std::fmt;

use grosgrain::simplex::{SimplexMesh, components};

use super::problem::MeshProblem;
use crate::failure::Failure;
use crate::quantities::counted;

/// Larger forces on a node overflow when they are squared \[N\].
const LARGEST_FORCE: f64 = 1e100;
/// Points off a line or plane by less than this share of their distances lie on it.
const IN_LINE: f64 = 1e-6;

/// A mesh and the points at which it is held.
pub struct Support<'a> {
    /// The mesh.
    pub mesh: &'a SimplexMesh,
    /// A cell and a place \[m\] for each point that holds or springs keep in place.
    pub points: Vec<(u32, [f64; 3])>,
}

/// A part of a mesh that can still move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Loose {
    /// How many cells it has.
    pub cells: usize,
    /// The first of them.
    pub cell: usize,
    /// Whether it is all of the mesh.
    pub is_all: bool,
    /// At how many places it is held.
    pub held: usize,
}

impl fmt::Display for Loose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cells, cell, is_all, held } = *self;
        match is_all {
            true => write!(f, "the body")?,
            false => write!(
                f,
                "the part of {} around cell {cell}, which shares no node with the others,",
                counted(cells, "cell")
            )?,
        }
        match held {
            0 => write!(f, " is held nowhere"),
            1 => write!(f, " is held at 1 point, about which it turns"),
            _ => write!(f, " is held at {held} points in line, about which it turns"),
        }
    }
}

impl<'a> Support<'a> {
    /// A mesh that is held at marked nodes and at points of cells.
    pub fn new(mesh: &'a SimplexMesh, marked: impl Fn(usize) -> bool, points: Vec<(u32, [f64; 3])>) -> Self {
        let mut cell_of = vec![None; mesh.nodes().len()];
        for cell in 0..mesh.cell_count() {
            mesh.cell(cell).iter().for_each(|node| cell_of[*node as usize] = Some(cell as u32));
        }
        let nodes = cell_of.iter().enumerate().filter(|(node, _)| marked(*node));
        let held = nodes.filter_map(|(node, cell)| Some(((*cell)?, mesh.nodes()[node])));
        Self { mesh, points: held.chain(points).collect() }
    }

    /// The first part of cells connected by nodes that its points do not keep from moving: in d dimensions they must not lie in a flat of d − 2.
    pub fn loose(&self) -> Option<Loose> {
        let (part_of, count) = components(self.mesh);
        let mut points: Vec<Vec<[f64; 3]>> = vec![Vec::new(); count];
        for (cell, at) in &self.points {
            points[part_of[*cell as usize] as usize].push(*at);
        }
        let part = (0..count).find(|part| !is_held(self.mesh.dimension().axes(), &points[*part]))?;
        let of_part = part_of.iter().enumerate().filter(|(_, p)| **p as usize == part);
        let cell = of_part.clone().next().map_or(0, |(cell, _)| cell);
        Some(Loose { cells: of_part.count(), cell, is_all: count == 1, held: points[part].len() })
    }
}

/// Whether a body in so many dimensions cannot move when it is held at these points: at one on a line, at two places in a plane, at three that are not in line in space.
fn is_held(axes: usize, points: &[[f64; 3]]) -> bool {
    let Some(first) = points.first() else { return false };
    if axes == 1 {
        return true;
    }
    let from_first = points.iter().map(|at| [0, 1, 2].map(|r| at[r] - first[r]));
    let square = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let farthest = from_first.clone().max_by(|a, b| square(a).total_cmp(&square(b))).unwrap_or_default();
    let length = square(&farthest);
    if axes == 2 || length == 0.0 {
        return length > 0.0;
    }
    let off_line = |v: [f64; 3]| {
        let along = (0..3).map(|r| v[r] * farthest[r]).sum::<f64>() / length;
        square(&[0, 1, 2].map(|r| v[r] - along * farthest[r]))
    };
    from_first.map(off_line).fold(0.0, f64::max) > IN_LINE * IN_LINE * length
}

/// Refuses loads beyond arithmetic, and in a static run loads that move nothing and parts of the fine mesh that nothing holds.
///
/// # Errors
/// A sentence with the key and what to do.
pub fn require_support(problem: &MeshProblem) -> Result<(), Failure> {
    let (scene, mesh, nodal) = (&problem.scene, problem.fine.mesh(), &problem.conditions.nodal);
    let mass = grosgrain::dynamics::simplex_mass(&problem.fine);
    let conditions = problem.conditions.with_gravity(nodal.clone(), &mass);
    let mut loads = vec![0.0; 3 * mesh.nodes().len()];
    for load in &conditions.loads {
        loads.iter_mut().zip(&load.forces).for_each(|(sum, force)| *sum += force);
    }
    if let Some(force) = loads.iter().find(|force| !force.is_finite() || force.abs() > LARGEST_FORCE) {
        let sentence = format!("a node bears a force of {force:.1e} N, which no arithmetic survives; check its unit");
        return Err(scene.unusable("load", sentence).into());
    }
    if scene.is_dynamic() {
        return Ok(());
    }
    let fixed = nodal.holds.fixed_at(0.0, mesh.nodes().len());
    let loaded = |node: usize| !fixed[node] && loads[3 * node..3 * node + 3].iter().any(|force| *force != 0.0);
    let driven = !nodal.springs.is_empty() || scene.fixes.iter().any(|fix| fix.motion.is_some());
    if !driven && !(0..fixed.len()).any(loaded) {
        let sentence =
            "the loads are zero wherever the body can move; expected a load, and a density where it is gravity";
        return Err(scene.unusable("load", sentence).into());
    }
    let mut held = fixed;
    nodal.springs.iter().for_each(|spring| held[spring.node.0] = true);
    let support = Support::new(mesh, |node| held[node], Vec::new());
    match support.loose() {
        None => Ok(()),
        Some(loose) => {
            let key = if scene.fixes.is_empty() { "load" } else { "fix" };
            let enough = ["one place", "two places", "three places that are not in line"][mesh.dimension().axes() - 1];
            let sentence = format!("{loose}; hold it by a [[fix]] at {enough}, or make the run dynamic");
            Err(scene.unusable(key, sentence).into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_points_as_the_dimension_hold_a_body_unless_they_are_in_line() {
        let on_line = [[0.0; 3], [1.0, 1.0, 1.0], [3.0, 3.0, 3.0]];
        let off_line = [[0.0; 3], [1.0, 1.0, 1.0], [3.0, 3.0, 3.1]];
        assert_eq!([1, 2, 3].map(|axes| is_held(axes, &[])), [false; 3]);
        assert_eq!([1, 2, 3].map(|axes| is_held(axes, &on_line[..1])), [true, false, false]);
        assert_eq!([2, 3].map(|axes| is_held(axes, &[[1.0; 3]; 4])), [false; 2], "one place four times");
        assert_eq!([2, 3].map(|axes| is_held(axes, &on_line)), [true, false]);
        assert!(is_held(3, &off_line));
    }
}
