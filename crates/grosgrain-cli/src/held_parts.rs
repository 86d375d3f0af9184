//! The held parts of a scene on its body, and whether they can be as they are asked to.

use grosgrain::dynamics::{Hold, Holds, Motion, Twist};
use grosgrain::mesh::{Node, VoxelGrid};

use crate::failure::Failure;
use crate::scene::{Fix, Ground, Scene, SceneChange, SceneMotion};

/// Depth below the ground, relative to the size of the body, that counts as none.
const SAME_HEIGHT: f64 = 1e-9;

/// The parts that a scene's `[[fix]]` tables hold.
///
/// # Errors
/// A selection that holds no node of the body.
pub fn held_parts(scene: &Scene, grid: &VoxelGrid) -> Result<Holds, Failure> {
    let held = |fix: &Fix| {
        let refuse =
            |error: &dyn std::fmt::Display| Failure::from(scene.unusable(&format!("{}.where", fix.key), error));
        let nodes = fix.selection.nodes(grid).map_err(|error| refuse(&error))?.mask;
        let positions: Vec<[f64; 3]> =
            body_nodes(grid).into_iter().filter(|node| nodes[node.0]).map(|node| position_of(grid, node)).collect();
        Ok(hold_of(fix, nodes, &positions))
    };
    scene.fixes.iter().map(held).collect::<Result<_, _>>().map(Holds)
}

/// The hold of a `[[fix]]` table on the marked nodes, which lie at `positions` \[m\] in the undeformed body.
pub fn hold_of(fix: &Fix, nodes: Vec<bool>, positions: &[[f64; 3]]) -> Hold {
    let motion = fix.motion.map_or(Motion::default(), |motion| motion_of(&motion, positions));
    Hold { name: fix.key.clone(), nodes, motion, ramp: fix.span.ramp(), until: fix.span.until }
}

fn motion_of(motion: &SceneMotion, positions: &[[f64; 3]]) -> Motion {
    let twist = motion.twist.and_then(|twist| {
        let centre = twist.centre.unwrap_or_else(|| centre_of_box(positions));
        Twist::about(twist.axis, centre, twist.angle.to_radians())
    });
    Motion { twist, translation: motion.translate }
}

/// The centre of the box around points.
fn centre_of_box(positions: &[[f64; 3]]) -> [f64; 3] {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (position, a) in positions.iter().flat_map(|position| [0, 1, 2].map(|a| (position, a))) {
        (low[a], high[a]) = (low[a].min(position[a]), high[a].max(position[a]));
    }
    [0, 1, 2].map(|a| 0.5 * (low[a] + high[a]))
}

fn body_nodes(grid: &VoxelGrid) -> Vec<Node> {
    grid.active_nodes().into_iter().enumerate().filter(|(_, active)| *active).map(|(node, _)| Node(node)).collect()
}

fn position_of(grid: &VoxelGrid, node: Node) -> [f64; 3] {
    grid.position(grid.lattice.node_position(node))
}

/// Refuses held parts that disagree with each other or are carried through the ground, and a body that begins below the ground.
///
/// # Errors
/// A sentence with the keys, the place and the time.
pub fn check_held_parts(scene: &Scene, grid: &VoxelGrid, holds: &Holds) -> Result<(), Failure> {
    let position = |node| position_of(grid, Node(node));
    // Where cells are added later, void nodes count as well.
    let adds = scene.edits.iter().any(|edit| matches!(edit.change, SceneChange::Add(_)));
    let relevant: Vec<bool> = grid.active_nodes().into_iter().map(|active| active || adds).collect();
    let body: Vec<[f64; 3]> = body_nodes(grid).into_iter().map(|node| position_of(grid, node)).collect();
    check_holds(scene, holds, (&relevant, &position), &body)
}

/// The same for any body: marks of the nodes that count, the places \[m\] of all nodes by their number, and those of the body's nodes.
///
/// # Errors
/// As [`check_held_parts`].
pub fn check_holds(
    scene: &Scene,
    holds: &Holds,
    (relevant, position): (&[bool], &dyn Fn(usize) -> [f64; 3]),
    body: &[[f64; 3]],
) -> Result<(), Failure> {
    if let Err(conflict) = holds.check_agreement(relevant, position) {
        return Err(scene.unusable(&conflict.names[1], &conflict).into());
    }
    let Some(ground) = scene.contact else { return Ok(()) };
    require_body_above(scene, body, ground)?;
    let passage = holds.check_ground(ground.z, relevant, position);
    passage.map_err(|passage| scene.unusable(&format!("{}.move", passage.name), &passage).into())
}

fn require_body_above(scene: &Scene, positions: &[[f64; 3]], ground: Ground) -> Result<(), Failure> {
    let size = positions.iter().flatten().fold(ground.z.abs(), |size: f64, x| size.max(x.abs()));
    let lowest = positions.iter().min_by(|a, b| a[2].total_cmp(&b[2]));
    let Some(lowest) = lowest.filter(|lowest| lowest[2] < ground.z - SAME_HEIGHT * size) else { return Ok(()) };
    let [x, y, z] = *lowest;
    let sentence = format!(
        "the body begins {:.6} m below the ground z = {} m: its lowest node is at ({x:.6}, {y:.6}, {z:.6}) m; lower the ground to z = {z} m \
         or below",
        ground.z - z,
        ground.z
    );
    Err(scene.unusable("contact.ground.z", sentence).into())
}
