//! The springs of a scene where the unedited body has them.

use grosgrain::fine::FineModel;
use grosgrain::mesh::Node;

use crate::failure::Failure;
use crate::scene::{LoadKind, Scene, Span, Spring};

/// Springs of one `[[load]]`: each ties a node to a point in space.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedSprings {
    /// The nodes of the unedited body, ascending.
    pub nodes: Vec<Node>,
    /// Force per length \[N/m\] of the spring of one node.
    pub stiffness: f64,
    /// From the undeformed place of a node to the point that it is tied to \[m\].
    pub offset: [f64; 3],
    /// Which share of the stiffness acts when.
    pub span: Span,
}

impl PlacedSprings {
    /// The springs of every `[[load]]` that has some.
    ///
    /// # Errors
    /// A selector without a node of the body.
    pub fn of(scene: &Scene, model: &FineModel) -> Result<Vec<Self>, Failure> {
        let springs = scene.loads.iter().filter_map(|load| match &load.kind {
            LoadKind::Spring(selection, spring) => Some((load, selection, spring)),
            LoadKind::Gravity(_) | LoadKind::Traction(..) | LoadKind::Force(..) => None,
        });
        let place = |(load, selection, spring): (_, &grosgrain::mesh::Selector, &Spring)| {
            let load: &crate::scene::Load = load;
            let refuse = |error| Failure::from(scene.unusable(&format!("{}.where", load.key), error));
            let mask = selection.nodes(model.grid()).map_err(refuse)?.mask;
            let marked = mask.iter().zip(model.active()).enumerate().filter(|(_, (mask, active))| **mask && **active);
            let nodes: Vec<Node> = marked.map(|(node, _)| Node(node)).collect();
            let stiffness = spring.stiffness / nodes.len() as f64;
            Ok(Self { nodes, stiffness, offset: spring.offset, span: load.span })
        };
        springs.map(place).collect()
    }

    /// Force per length \[N/m\] of the spring of one node at a time \[s\].
    pub fn stiffness_at(&self, time: f64) -> f64 {
        self.stiffness * self.span.factor(time)
    }

    /// The point that the spring of a node is tied to \[m\].
    pub fn anchor(&self, node: Node, model: &FineModel) -> [f64; 3] {
        let position = model.node_position(node);
        [0, 1, 2].map(|r| position[r] + self.offset[r])
    }
}
