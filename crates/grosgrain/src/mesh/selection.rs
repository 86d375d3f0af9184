//! Picking nodes and cells of a body by where they are.

use super::{Blade, Brush, Cell, Cut, Label, VoxelGrid, cut};

mod membership;

use membership::Of;

/// One of the three axes of the body frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// First axis.
    X,
    /// Second axis.
    Y,
    /// Third axis.
    Z,
}

/// Where a plane cuts its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlaneAt {
    /// The body's smallest coordinate: that of the nodes that touch a solid cell.
    Min,
    /// The body's largest coordinate.
    Max,
    /// A coordinate \[m\].
    Coordinate(f64),
}

/// A set of nodes or cells, described by geometry or label. Lengths are in metres in the body frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Selector {
    /// Everything.
    All,
    /// A plane normal to an axis; h is the cell size along it.
    ///
    /// Nodes: within 1e-6 h of the body's end, or within h/2 of a coordinate (a coordinate halfway between two
    /// layers of nodes picks both). Cells: the body's outermost layer, or the layers that touch the coordinate within
    /// 1e-6 h (two if it lies between them).
    Plane {
        /// The plane's normal.
        axis: Axis,
        /// Where it is.
        at: PlaneAt,
    },
    /// The closed box between two corners, grown by 1e-9 of the grid's size.
    Box {
        /// Smallest coordinates.
        low: [f64; 3],
        /// Largest coordinates.
        high: [f64; 3],
    },
    /// The closed ball, its radius grown by 1e-9 of the grid's size.
    Sphere {
        /// Centre.
        centre: [f64; 3],
        /// Radius.
        radius: f64,
    },
    /// Solid cells of a label; nodes that touch one.
    Label(Label),
    /// Cells that a plane takes away; nodes that touch one.
    Cut(Cut),
    /// Cells that a swept blade cuts; nodes that touch one.
    Blade(Blade),
    /// What a ball sweeps over on its path.
    Brush(Brush),
    /// What the selector does not pick.
    Not(Box<Selector>),
    /// What all selectors pick.
    And(Vec<Selector>),
    /// What any selector picks.
    Or(Vec<Selector>),
}

/// The nodes that a selector picks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeSelection {
    /// One entry per node of the lattice, x fastest: inside the selector, whether or not the body reaches there.
    pub mask: Vec<bool>,
    /// How many of them touch a solid cell.
    pub active: usize,
}

/// Why a selector is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SelectionError {
    /// It picks no node of the body.
    #[error(
        "the selection holds no node of the body, which extends over x {:.6}..{:.6}, y {:.6}..{:.6}, z {:.6}..{:.6} m; move or enlarge it",
        low[0], high[0], low[1], high[1], low[2], high[2]
    )]
    Empty {
        /// The body's smallest coordinates \[m\].
        low: [f64; 3],
        /// The body's largest coordinates \[m\].
        high: [f64; 3],
    },
    /// There is no body to pick from.
    #[error("the selection holds no node: every voxel of the body is void")]
    AllVoid,
    /// A box whose corners are swapped or not numbers.
    #[error("the box from {low:?} to {high:?} is empty; each first coordinate must be at most the second")]
    Box {
        /// The smaller corner.
        low: [f64; 3],
        /// The larger corner.
        high: [f64; 3],
    },
    /// A sphere that is not one.
    #[error("the sphere around {centre:?} of radius {radius} m must have finite coordinates and a positive radius")]
    Sphere {
        /// Centre.
        centre: [f64; 3],
        /// Radius.
        radius: f64,
    },
    /// A cut that has no plane.
    #[error(
        "the cut through {:?} along the normal {:?} must have finite coordinates, a normal that is not zero and a positive radius if any",
        _0.point, _0.normal
    )]
    Cut(Cut),
    /// A blade that sweeps no area.
    #[error(
        "the blade with the edge from {:?} to {:?} swept along {:?} spans no area; edge and sweep must be finite, not zero and not parallel",
        _0.edge[0], _0.edge[1], _0.sweep
    )]
    Blade(Blade),
    /// A brush that reaches nothing.
    #[error(
        "the brush of radius {} m along {} points must have a positive radius and a path of at least one point with finite coordinates",
        _0.radius, _0.path.len()
    )]
    Brush(Brush),
    /// A plane that is nowhere.
    #[error("the plane's coordinate {0} must be finite")]
    Plane(f64),
    /// A plane normal to an axis along which a mesh has no extent.
    #[error(
        "a plane normal to {axis:?} cannot divide a mesh of {of}, which has no extent along it; take one normal to {instead}"
    )]
    NoExtent {
        /// The normal.
        axis: Axis,
        /// Of what the mesh is made.
        of: String,
        /// Axes that would do.
        instead: &'static str,
    },
    /// What takes away voxels, asked of a mesh.
    #[error(
        "{what} picks voxels, of which a mesh of {of} has none; pick its nodes by a plane, box, sphere, brush or label"
    )]
    NotOfMeshes {
        /// What the selector is.
        what: &'static str,
        /// Of what the mesh is made.
        of: String,
    },
}

impl Selector {
    /// The nodes inside the selector.
    ///
    /// # Errors
    /// A selector that makes no sense (see [`validate`](Self::validate)) or that picks no node touching a solid cell.
    pub fn nodes(&self, grid: &VoxelGrid) -> Result<NodeSelection, SelectionError> {
        self.validate()?;
        let mask = self.mask_of(grid, Of::Nodes);
        let active = grid.active_nodes().iter().zip(&mask).filter(|(a, m)| **a && **m).count();
        if active > 0 {
            return Ok(NodeSelection { mask, active });
        }
        let [low, high] = grid.body_box().ok_or(SelectionError::AllVoid)?.map(|at| grid.position(at));
        Err(SelectionError::Empty { low, high })
    }

    /// The cells whose centres are inside the selector, one entry per cell, void or not; for planes, labels, cuts and blades see
    /// there.
    pub fn cells(&self, grid: &VoxelGrid) -> Vec<bool> {
        self.mask_of(grid, Of::Cells)
    }

    /// Fills `picked` with the cells that [`cells`](Self::cells) marks, ascending; for a small region at the price of the region, see
    /// [`pick_cells_of`](Self::pick_cells_of).
    pub fn pick_cells(&self, grid: &VoxelGrid, picked: &mut Vec<Cell>) {
        self.pick_cells_of(grid, &|cell| (!grid.void[cell.0]).then(|| grid.labels[cell.0]), picked);
    }

    /// Whether geometry alone decides what is inside: no label, no plane at the body's end.
    pub fn is_geometric(&self) -> bool {
        match self {
            Self::Label(_) | Self::Plane { at: PlaneAt::Min | PlaneAt::Max, .. } => false,
            Self::Not(part) => part.is_geometric(),
            Self::And(parts) | Self::Or(parts) => parts.iter().all(Self::is_geometric),
            _ => true,
        }
    }

    /// The selector moved by a vector \[m\]; labels, everything, and planes at the body's ends stay what they are.
    pub fn moved(&self, by: [f64; 3]) -> Self {
        let plus = |x: [f64; 3]| cut::plus(x, by);
        let all = |parts: &[Self]| parts.iter().map(|part| part.moved(by)).collect();
        match self {
            Self::All | Self::Label(_) | Self::Plane { at: PlaneAt::Min | PlaneAt::Max, .. } => self.clone(),
            Self::Plane { axis, at: PlaneAt::Coordinate(x) } => {
                Self::Plane { axis: *axis, at: PlaneAt::Coordinate(x + by[*axis as usize]) }
            }
            Self::Box { low, high } => Self::Box { low: plus(*low), high: plus(*high) },
            Self::Sphere { centre, radius } => Self::Sphere { centre: plus(*centre), radius: *radius },
            Self::Cut(cut) => Self::Cut(Cut { point: plus(cut.point), ..cut.clone() }),
            Self::Blade(blade) => Self::Blade(Blade { edge: blade.edge.map(plus), sweep: blade.sweep }),
            Self::Brush(brush) => {
                Self::Brush(Brush { path: brush.path.iter().map(|x| plus(*x)).collect(), radius: brush.radius })
            }
            Self::Not(part) => Self::Not(Box::new(part.moved(by))),
            Self::And(parts) => Self::And(all(parts)),
            Self::Or(parts) => Self::Or(all(parts)),
        }
    }

    /// What any of the blades of a path cuts: an edge swept along one vector after the other.
    ///
    /// The two sides of each blade share no node; where two blades meet at an angle, an edge or a node may stay common.
    pub fn blade_path(edge: [[f64; 3]; 2], sweeps: &[[f64; 3]]) -> Self {
        Self::Or(Blade::path(edge, sweeps).into_iter().map(Self::Blade).collect())
    }

    /// Refuses boxes with swapped corners, radii that are not positive, coordinates that are not finite, cuts without a normal,
    /// blades without an area, brushes without a path.
    ///
    /// Boxes may be unbounded.
    ///
    /// # Errors
    /// As said, for the selector or one of its parts.
    pub fn validate(&self) -> Result<(), SelectionError> {
        match self {
            Self::All | Self::Label(_) => Ok(()),
            Self::Plane { at: PlaneAt::Coordinate(x), .. } if !x.is_finite() => Err(SelectionError::Plane(*x)),
            Self::Plane { .. } => Ok(()),
            Self::Box { low, high } => match (0..3).all(|a| low[a] <= high[a]) {
                true => Ok(()),
                false => Err(SelectionError::Box { low: *low, high: *high }),
            },
            Self::Sphere { centre, radius } => {
                let good = centre.iter().all(|x| x.is_finite()) && radius.is_finite() && *radius > 0.0;
                if good { Ok(()) } else { Err(SelectionError::Sphere { centre: *centre, radius: *radius }) }
            }
            Self::Cut(cut) if !cut.is_usable() => Err(SelectionError::Cut(cut.clone())),
            Self::Blade(blade) if !blade.is_usable() => Err(SelectionError::Blade(blade.clone())),
            Self::Brush(brush) if !brush.is_usable() => Err(SelectionError::Brush(brush.clone())),
            Self::Cut(_) | Self::Blade(_) | Self::Brush(_) => Ok(()),
            Self::Not(part) => part.validate(),
            Self::And(parts) | Self::Or(parts) => parts.iter().try_for_each(Self::validate),
        }
    }
}

#[cfg(test)]
mod tests;
