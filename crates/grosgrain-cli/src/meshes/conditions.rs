//! What a scene's conditions do to a mesh, in the library's terms.

use grosgrain::contact::Ground;
use grosgrain::dynamics::{Conditions, Holds, NodeSpring, Schedule, TimedLoad};
use grosgrain::homogenization::SimplexModel;
use grosgrain::material::MaterialTable;
use grosgrain::mesh::{Label, Node, Selector};
use grosgrain::simplex::{Boundary, Dimension, SimplexMesh, select_nodes, selected_faces, traction_forces};

use crate::failure::Failure;
use crate::held_parts::{check_holds, hold_of};
use crate::scene::{Fix, Load, LoadKind, Scene, Spring};

/// Holds, loads, springs and ground of a scene on a fine mesh; gravity apart, since every mesh has masses of its own.
#[derive(Clone, Debug)]
pub struct MeshConditions {
    /// All but gravity, three components per node of the fine mesh.
    pub nodal: Conditions,
    /// Accelerations \[m/s²\].
    pub gravity: Vec<([f64; 3], Schedule)>,
}

impl MeshConditions {
    /// Places the conditions of a scene on the mesh of `model`.
    ///
    /// # Errors
    /// Selections without a node, tractions without a face, vectors out of the plane of a mesh, holds that disagree or pass the ground, a body that begins below it.
    pub fn new(scene: &Scene, model: &SimplexModel, materials: &MaterialTable) -> Result<Self, Failure> {
        let mesh = model.mesh();
        refuse_out_of_plane(scene, mesh.dimension())?;
        let boundary = Boundary::of_mesh(mesh).map_err(|error| Failure::from(scene.unusable("body.mesh", error)))?;
        let placer = Placer { scene, mesh, boundary: &boundary };
        let holds = Holds(scene.fixes.iter().map(|fix| placer.hold(fix)).collect::<Result<_, _>>()?);
        let mut placed = Self { nodal: Conditions { holds, ..Conditions::default() }, gravity: Vec::new() };
        for load in &scene.loads {
            placer.place(load, &mut placed)?;
        }
        placed.nodal.ground = ground(scene, mesh, &boundary, materials)?;
        let all = vec![true; mesh.nodes().len()];
        check_holds(scene, &placed.nodal.holds, (&all, &|node| mesh.nodes()[node]), mesh.nodes())?;
        Ok(placed)
    }

    /// Conditions of a mesh with gravity on its nodal masses \[kg\] added.
    pub fn with_gravity(&self, mut conditions: Conditions, mass: &[f64]) -> Conditions {
        conditions.loads.extend(self.gravity.iter().map(|(acceleration, schedule)| TimedLoad {
            forces: mass.iter().flat_map(|m| acceleration.map(|g| m * g)).collect(),
            schedule: *schedule,
        }));
        conditions
    }
}

struct Placer<'a> {
    scene: &'a Scene,
    mesh: &'a SimplexMesh,
    boundary: &'a Boundary,
}

impl Placer<'_> {
    fn select(&self, selector: &Selector, key: &str) -> Result<Vec<bool>, Failure> {
        select_nodes(self.mesh, selector).map_err(|error| self.scene.unusable(&format!("{key}.where"), error).into())
    }

    fn hold(&self, fix: &Fix) -> Result<grosgrain::dynamics::Hold, Failure> {
        let nodes = self.select(&fix.selection, &fix.key)?;
        let held = self.mesh.nodes().iter().zip(&nodes).filter(|(_, held)| **held);
        let positions: Vec<[f64; 3]> = held.map(|(at, _)| *at).collect();
        Ok(hold_of(fix, nodes, &positions))
    }

    fn place(&self, load: &Load, placed: &mut MeshConditions) -> Result<(), Failure> {
        let schedule = load.span.schedule();
        match &load.kind {
            LoadKind::Gravity(acceleration) => placed.gravity.push((*acceleration, schedule)),
            LoadKind::Traction(selection, stress) => {
                let nodes = self.select(selection, &load.key)?;
                let faces = selected_faces(self.boundary.faces(), &nodes);
                let (forces, area) = traction_forces(self.mesh, faces, *stress);
                if area == 0.0 {
                    let sentence = "the selection holds no whole face of the body's surface; a traction needs all nodes of a face, enlarge it";
                    return Err(self.scene.unusable(&load.key, sentence).into());
                }
                placed.nodal.loads.push(TimedLoad { forces, schedule });
            }
            LoadKind::Force(selection, force) => {
                let shares = self.shares(&self.select(selection, &load.key)?);
                let forces = shares.iter().flat_map(|share| force.map(|f| share * f)).collect();
                placed.nodal.loads.push(TimedLoad { forces, schedule });
            }
            LoadKind::Spring(selection, Spring { stiffness, offset }) => {
                let shares = self.shares(&self.select(selection, &load.key)?);
                let springs = shares.iter().enumerate().filter(|(_, share)| **share > 0.0).map(|(node, share)| {
                    let at = self.mesh.nodes()[node];
                    let target = [0, 1, 2].map(|r| at[r] + offset[r]);
                    NodeSpring { node: Node(node), stiffness: share * stiffness, target, schedule }
                });
                placed.nodal.springs.extend(springs);
            }
        }
        Ok(())
    }

    /// The part of a force that every node takes, Σ = 1: that of a constant traction on the faces of the surface between marked nodes; where there is no such face, in proportion to
    /// the measure of the cells around the marked nodes.
    fn shares(&self, nodes: &[bool]) -> Vec<f64> {
        let faces = selected_faces(self.boundary.faces(), nodes);
        let (forces, area) = traction_forces(self.mesh, faces, [1.0, 0.0, 0.0]);
        if area > 0.0 {
            return forces.chunks_exact(3).map(|force| force[0] / area).collect();
        }
        let mut shares = vec![0.0; nodes.len()];
        for cell in 0..self.mesh.cell_count() {
            let measure = self.mesh.measure(cell);
            let marked = self.mesh.cell(cell).iter().filter(|node| nodes[**node as usize]);
            marked.for_each(|node| shares[*node as usize] += measure);
        }
        let sum: f64 = shares.iter().sum();
        shares.iter().map(|share| share / sum).collect()
    }
}

/// Refuses vectors that leave the line of segments or the plane of triangles, which those cannot follow.
fn refuse_out_of_plane(scene: &Scene, dimension: Dimension) -> Result<(), Failure> {
    let mut vectors: Vec<(String, [f64; 3])> = Vec::new();
    // A body turns about the axes normal to its plane only.
    let mut turns: Vec<(String, [f64; 3])> = Vec::new();
    for fix in &scene.fixes {
        let Some(motion) = fix.motion else { continue };
        vectors.push((format!("{}.move.translate", fix.key), motion.translate));
        turns.extend(motion.twist.map(|twist| (format!("{}.move.twist.axis", fix.key), twist.axis)));
    }
    for load in &scene.loads {
        let (name, vector) = match &load.kind {
            LoadKind::Gravity(vector) => ("gravity", *vector),
            LoadKind::Traction(_, vector) => ("traction", *vector),
            LoadKind::Force(_, vector) => ("force", *vector),
            LoadKind::Spring(_, spring) => ("spring.offset", spring.offset),
        };
        vectors.push((format!("{}.{name}", load.key), vector));
    }
    vectors.push(("start.velocity".into(), scene.start.velocity));
    turns.push(("start.spin".into(), scene.start.spin));
    let axes = dimension.axes();
    let plane = if dimension == Dimension::One { "along x" } else { "in the plane of x and y" };
    for (key, vector) in vectors {
        if vector[axes..].iter().any(|x| *x != 0.0) {
            let [x, y, z] = vector;
            let sentence = format!(
                "({x}, {y}, {z}) points out of a body of {dimension}, which lies {plane}; expected zero across it"
            );
            return Err(scene.unusable(&key, sentence).into());
        }
    }
    let may_turn: &[usize] = [&[][..], &[2], &[0, 1, 2]][axes - 1];
    for (key, axis) in turns {
        if (0..3).any(|r| axis[r] != 0.0 && !may_turn.contains(&r)) {
            let [x, y, z] = axis;
            let advice = if dimension == Dimension::One { "segments do not turn" } else { "expected the axis z" };
            let sentence =
                format!("({x}, {y}, {z}) turns a body of {dimension} out of where it lies, {plane}; {advice}");
            return Err(scene.unusable(&key, sentence).into());
        }
    }
    Ok(())
}

/// The ground of a scene; its stiffness, where the scene gives none, is that at which a pressure sinks in as deep as it presses one cell of the surface together: the mean, by area, of
/// Young's modulus at the surface over the mean of the longest and shortest edge.
fn ground(
    scene: &Scene,
    mesh: &SimplexMesh,
    boundary: &Boundary,
    materials: &MaterialTable,
) -> Result<Option<Ground>, Failure> {
    let Some(contact) = scene.contact else { return Ok(None) };
    if mesh.dimension() != Dimension::Three {
        let sentence = format!(
            "a horizontal ground cannot hold {}, which keep z = 0; leave it out, or take tetrahedra",
            mesh.dimension()
        );
        return Err(scene.unusable("contact.ground", sentence).into());
    }
    let of_face = |face: &grosgrain::simplex::BoundaryFace| {
        let (cell, area) = (face.cell as usize, face.measure());
        let young = materials.get(Label(mesh.tags()[cell])).map_or(0.0, |m| m.elasticity.tensor().young_along_x());
        let [shortest, longest] = mesh.edge_range(cell);
        (area, area * young / (0.5 * (shortest + longest)))
    };
    let (area, sum) = boundary.faces().iter().map(of_face).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let stiffness = contact.stiffness.unwrap_or(sum / area);
    Ok(Some(Ground { height: contact.z, friction: contact.friction, stiffness }))
}
