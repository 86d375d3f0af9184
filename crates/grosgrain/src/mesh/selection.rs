//! Picking nodes and cells of a body by where they are.

use super::{Cell, Label, Node, VoxelGrid};

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
    /// A plane that is nowhere.
    #[error("the plane's coordinate {0} must be finite")]
    Plane(f64),
}

impl Selector {
    /// The nodes inside the selector.
    ///
    /// # Errors
    /// A selector that makes no sense (see [`validate`](Self::validate)) or that picks no node touching a solid cell.
    pub fn nodes(&self, grid: &VoxelGrid) -> Result<NodeSelection, SelectionError> {
        self.validate()?;
        let mask = self.mask(grid, Of::Nodes);
        let active = grid.active_nodes().iter().zip(&mask).filter(|(a, m)| **a && **m).count();
        if active > 0 {
            return Ok(NodeSelection { mask, active });
        }
        let [low, high] = grid.body_box().ok_or(SelectionError::AllVoid)?.map(|at| grid.position(at));
        Err(SelectionError::Empty { low, high })
    }

    /// The cells whose centres are inside the selector, one entry per cell, void or not; for planes and labels see there.
    pub fn cells(&self, grid: &VoxelGrid) -> Vec<bool> {
        self.mask(grid, Of::Cells)
    }

    /// Refuses boxes with swapped corners, radii that are not positive, coordinates that are not finite.
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
            Self::Not(part) => part.validate(),
            Self::And(parts) | Self::Or(parts) => parts.iter().try_for_each(Self::validate),
        }
    }

    fn mask(&self, grid: &VoxelGrid, of: Of) -> Vec<bool> {
        match self {
            Self::All => vec![true; of.count(grid)],
            Self::Plane { axis, at } => plane(grid, of, *axis as usize, *at),
            Self::Box { low, high } => {
                let slack = tolerance(grid);
                of.filter(grid, |x| (0..3).all(|a| x[a] >= low[a] - slack && x[a] <= high[a] + slack))
            }
            Self::Sphere { centre, radius } => {
                let reach = radius + tolerance(grid);
                let square = |x: [f64; 3]| (0..3).map(|a| (x[a] - centre[a]).powi(2)).sum::<f64>();
                of.filter(grid, |x| square(x) <= reach * reach)
            }
            Self::Label(label) => labelled(grid, of, *label),
            Self::Not(part) => part.mask(grid, of).into_iter().map(|m| !m).collect(),
            Self::And(parts) => {
                combine(parts.iter().map(|p| p.mask(grid, of)), vec![true; of.count(grid)], |a, b| a & b)
            }
            Self::Or(parts) => {
                combine(parts.iter().map(|p| p.mask(grid, of)), vec![false; of.count(grid)], |a, b| a | b)
            }
        }
    }
}

/// What a mask is of.
#[derive(Clone, Copy)]
enum Of {
    Nodes,
    Cells,
}

impl Of {
    fn count(self, grid: &VoxelGrid) -> usize {
        match self {
            Self::Nodes => grid.lattice.node_count(),
            Self::Cells => grid.lattice.cell_count(),
        }
    }

    fn lattice_position(self, grid: &VoxelGrid, index: usize) -> [usize; 3] {
        match self {
            Self::Nodes => grid.lattice.node_position(Node(index)),
            Self::Cells => grid.lattice.cell_position(Cell(index)),
        }
    }

    /// The nodes whose position, or the cells whose centre, passes `keep`.
    fn filter(self, grid: &VoxelGrid, keep: impl Fn([f64; 3]) -> bool) -> Vec<bool> {
        let place = |index| match self {
            Self::Nodes => grid.position(self.lattice_position(grid, index)),
            Self::Cells => grid.centre(self.lattice_position(grid, index)),
        };
        (0..self.count(grid)).map(|index| keep(place(index))).collect()
    }
}

/// 1e-9 of the grid's largest extent \[m\].
fn tolerance(grid: &VoxelGrid) -> f64 {
    (0..3).map(|a| grid.spacing[a] * grid.lattice.cells[a] as f64).fold(0.0, f64::max) * 1e-9
}

fn combine(masks: impl Iterator<Item = Vec<bool>>, start: Vec<bool>, join: fn(bool, bool) -> bool) -> Vec<bool> {
    masks.fold(start, |left, right| left.into_iter().zip(right).map(|(l, r)| join(l, r)).collect())
}

fn labelled(grid: &VoxelGrid, of: Of, label: Label) -> Vec<bool> {
    let cells: Vec<bool> = grid.labels.iter().zip(&grid.void).map(|(l, void)| *l == label && !void).collect();
    match of {
        Of::Cells => cells,
        Of::Nodes => (0..of.count(grid)).map(|n| grid.lattice.cells_at(Node(n)).any(|c| cells[c.0])).collect(),
    }
}

/// Which layers along `axis` a plane picks. Positions are in cells from the grid's origin, so h = 1.
fn plane(grid: &VoxelGrid, of: Of, axis: usize, at: PlaneAt) -> Vec<bool> {
    let Some([low, high]) = grid.body_box() else { return vec![false; of.count(grid)] };
    let (low, high) = (low[axis] as f64, high[axis] as f64);
    let coordinate = |x: f64| (x - grid.origin[axis]) / grid.spacing[axis];
    let picks = |layer: usize| {
        let i = layer as f64;
        match (of, at) {
            (Of::Nodes, PlaneAt::Min) => (i - low).abs() <= 1e-6,
            (Of::Nodes, PlaneAt::Max) => (i - high).abs() <= 1e-6,
            (Of::Nodes, PlaneAt::Coordinate(x)) => (i - coordinate(x)).abs() <= 0.5 + 1e-9,
            (Of::Cells, PlaneAt::Min) => (i - low).abs() <= 1e-6,
            (Of::Cells, PlaneAt::Max) => (i + 1.0 - high).abs() <= 1e-6,
            (Of::Cells, PlaneAt::Coordinate(x)) => (i + 0.5 - coordinate(x)).abs() <= 0.5 + 1e-6,
        }
    };
    (0..of.count(grid)).map(|index| picks(of.lattice_position(grid, index)[axis])).collect()
}

#[cfg(test)]
mod tests;
