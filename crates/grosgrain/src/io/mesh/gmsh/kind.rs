//! The kinds of elements that Gmsh numbers.

/// A kind of element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of its own dimensions.
    pub dimension: usize,
    /// Its name.
    pub plural: &'static str,
}

impl Kind {
    /// Nodes of the largest kind.
    pub const MOST_NODES: usize = 35;

    /// The kind with this number (element type) in Gmsh; `None` for exotic ones.
    pub const fn of_number(number: i32) -> Option<Self> {
        let (nodes, dimension, plural) = match number {
            1 => (2, 1, "segments"),
            2 => (3, 2, "triangles"),
            3 => (4, 2, "quadrilaterals"),
            4 => (4, 3, "tetrahedra"),
            5 => (8, 3, "hexahedra"),
            6 => (6, 3, "prisms"),
            7 => (5, 3, "pyramids"),
            8 => (3, 1, "segments of second order"),
            9 => (6, 2, "triangles of second order"),
            10 => (9, 2, "quadrilaterals of second order"),
            11 => (10, 3, "tetrahedra of second order"),
            12 => (27, 3, "hexahedra of second order"),
            13 => (18, 3, "prisms of second order"),
            14 => (14, 3, "pyramids of second order"),
            15 => (1, 0, "points"),
            16 => (8, 2, "quadrilaterals of second order"),
            17 => (20, 3, "hexahedra of second order"),
            18 => (15, 3, "prisms of second order"),
            19 => (13, 3, "pyramids of second order"),
            20 => (9, 2, "triangles of third order"),
            21 => (10, 2, "triangles of third order"),
            23 => (15, 2, "triangles of fourth order"),
            26 => (4, 1, "segments of third order"),
            27 => (5, 1, "segments of fourth order"),
            29 => (20, 3, "tetrahedra of third order"),
            30 => (35, 3, "tetrahedra of fourth order"),
            _ => return None,
        };
        Some(Self { nodes, dimension, plural })
    }

    /// Whether it is a segment, triangle or tetrahedron of first order.
    pub const fn is_simplex(self) -> bool {
        self.dimension > 0 && self.nodes == self.dimension + 1
    }
}
