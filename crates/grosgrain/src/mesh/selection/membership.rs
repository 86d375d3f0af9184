//! What is inside a selector: one rule for single nodes and cells, from which masks and lists are made.

use std::cell::OnceCell;
use std::ops::Range;

use super::{PlaneAt, Selector};
use crate::mesh::{Cell, Label, Node, VoxelGrid};

/// What a selector is asked about.
#[derive(Clone, Copy, Debug)]
pub enum Of {
    Nodes,
    Cells,
}

/// A body with what selectors ask of all of it found once.
pub struct Body<'g> {
    grid: &'g VoxelGrid,
    /// The label of a solid cell, `None` for a void.
    solid: &'g dyn Fn(Cell) -> Option<Label>,
    extent: OnceCell<Option<[[usize; 3]; 2]>>,
    /// 1e-9 of the grid's largest extent \[m\].
    slack: f64,
}

/// Cells from the first lattice position up to the second, which is excluded.
type CellBox = [[usize; 3]; 2];

impl<'g> Body<'g> {
    pub fn new(grid: &'g VoxelGrid, solid: &'g dyn Fn(Cell) -> Option<Label>) -> Self {
        let largest = (0..3).map(|a| grid.spacing[a] * grid.lattice.cells[a] as f64).fold(0.0, f64::max);
        Self { grid, solid, extent: OnceCell::new(), slack: 1e-9 * largest }
    }

    /// First and last node of the solid cells along every axis.
    fn extent(&self) -> Option<[[usize; 3]; 2]> {
        let find = || {
            let solid = (0..self.grid.lattice.cell_count()).map(Cell).filter(|c| (self.solid)(*c).is_some());
            solid.map(|c| self.grid.lattice.cell_position(c)).fold(None, |range, at| {
                let [low, high] = range.unwrap_or([at, at]);
                Some([
                    std::array::from_fn(|a| at[a].min(low[a])),
                    std::array::from_fn(|a: usize| (at[a] + 1).max(high[a])),
                ])
            })
        };
        *self.extent.get_or_init(find)
    }

    fn place(&self, of: Of, at: [usize; 3]) -> [f64; 3] {
        match of {
            Of::Nodes => self.grid.position(at),
            Of::Cells => self.grid.centre(at),
        }
    }

    /// A cell passes if it is one of the kind, a node if one of the cells around it is.
    fn touches(&self, of: Of, at: [usize; 3], is_one: impl Fn(Cell) -> bool) -> bool {
        let lattice = &self.grid.lattice;
        match of {
            Of::Cells => is_one(lattice.cell(at)),
            Of::Nodes => lattice.cells_at(lattice.node(at)).any(is_one),
        }
    }

    /// Whether a plane picks the layer. Positions are in cells from the grid's origin, so h = 1.
    fn is_layer(&self, of: Of, layer: usize, (axis, at): (usize, PlaneAt)) -> bool {
        let Some([low, high]) = self.extent() else { return false };
        let (low, high) = (low[axis] as f64, high[axis] as f64);
        let coordinate = |x: f64| (x - self.grid.origin[axis]) / self.grid.spacing[axis];
        let i = layer as f64;
        match (of, at) {
            (Of::Nodes, PlaneAt::Min) => (i - low).abs() <= 1e-6,
            (Of::Nodes, PlaneAt::Max) => (i - high).abs() <= 1e-6,
            (Of::Nodes, PlaneAt::Coordinate(x)) => (i - coordinate(x)).abs() <= 0.5 + 1e-9,
            (Of::Cells, PlaneAt::Min) => (i - low).abs() <= 1e-6,
            (Of::Cells, PlaneAt::Max) => (i + 1.0 - high).abs() <= 1e-6,
            (Of::Cells, PlaneAt::Coordinate(x)) => (i + 0.5 - coordinate(x)).abs() <= 0.5 + 1e-6,
        }
    }

    /// The cells whose centres may lie in the closed box, grown by a cell against rounding.
    fn cells_within(&self, [low, high]: [[f64; 3]; 2]) -> CellBox {
        let range: [Range<usize>; 3] = std::array::from_fn(|a| self.layers(a, low[a], high[a]));
        [range.each_ref().map(|r| r.start), range.map(|r| r.end)]
    }

    fn layers(&self, axis: usize, low: f64, high: f64) -> Range<usize> {
        let cells = self.grid.lattice.cells[axis];
        let layer = |x: f64| (x - self.grid.origin[axis]) / self.grid.spacing[axis] - 0.5;
        // Casts saturate: unbounded ends become the ends of the lattice.
        let (first, end) = ((layer(low) - 1.0).floor().max(0.0), (layer(high) + 2.0).ceil().max(0.0));
        let end = (end as usize).min(cells);
        (first as usize).min(end)..end
    }
}

impl Selector {
    pub(super) fn mask_of(&self, grid: &VoxelGrid, of: Of) -> Vec<bool> {
        let solid = |cell: Cell| (!grid.void[cell.0]).then(|| grid.labels[cell.0]);
        let body = Body::new(grid, &solid);
        let lattice = grid.lattice;
        match of {
            Of::Nodes => {
                (0..lattice.node_count()).map(|n| self.holds(&body, of, lattice.node_position(Node(n)))).collect()
            }
            Of::Cells => {
                (0..lattice.cell_count()).map(|c| self.holds(&body, of, lattice.cell_position(Cell(c)))).collect()
            }
        }
    }

    /// Fills `picked` with the cells inside, ascending, where `solid` gives the label of solid cells in place of the grid's.
    ///
    /// Only the cells of the selector's bounding box are looked at, of a [`Cut`](super::Cut) those of the rows it crosses. Only a
    /// plane at the body's end costs a pass over all cells. `picked` is cleared first; nothing else is allocated.
    pub fn pick_cells_of(&self, grid: &VoxelGrid, solid: &dyn Fn(Cell) -> Option<Label>, picked: &mut Vec<Cell>) {
        picked.clear();
        let body = Body::new(grid, solid);
        let [low, high] = self.cell_box(&body);
        for (k, j) in (low[2]..high[2]).flat_map(|k| (low[1]..high[1]).map(move |j| (k, j))) {
            let row = self.row(&body, [j, k]);
            let inside =
                (row.start.max(low[0])..row.end.min(high[0])).filter(|i| self.holds(&body, Of::Cells, [*i, j, k]));
            picked.extend(inside.map(|i| grid.lattice.cell([i, j, k])));
        }
    }

    fn holds(&self, body: &Body, of: Of, at: [usize; 3]) -> bool {
        let place = || body.place(of, at);
        match self {
            Self::All => true,
            Self::Plane { axis, at: plane } => body.is_layer(of, at[*axis as usize], (*axis as usize, *plane)),
            Self::Box { low, high } => {
                let x = place();
                (0..3).all(|a| x[a] >= low[a] - body.slack && x[a] <= high[a] + body.slack)
            }
            Self::Sphere { centre, radius } => {
                let (x, reach) = (place(), radius + body.slack);
                (0..3).map(|a| (x[a] - centre[a]).powi(2)).sum::<f64>() <= reach * reach
            }
            Self::Brush(brush) => brush.reaches(place(), body.slack),
            Self::Label(label) => body.touches(of, at, |cell| (body.solid)(cell) == Some(*label)),
            Self::Cut(cut) => {
                body.touches(of, at, |cell| cut.removes(body.grid, body.grid.lattice.cell_position(cell)))
            }
            Self::Blade(blade) => {
                body.touches(of, at, |cell| blade.cuts(body.grid, body.grid.lattice.cell_position(cell)))
            }
            Self::Not(part) => !part.holds(body, of, at),
            Self::And(parts) => parts.iter().all(|part| part.holds(body, of, at)),
            Self::Or(parts) => parts.iter().any(|part| part.holds(body, of, at)),
        }
    }

    /// A box that holds every cell inside.
    fn cell_box(&self, body: &Body) -> CellBox {
        let all = [[0; 3], body.grid.lattice.cells];
        let slack = body.slack;
        match self {
            Self::All | Self::Label(_) | Self::Not(_) | Self::Plane { at: PlaneAt::Min | PlaneAt::Max, .. } => all,
            Self::Plane { axis, at: PlaneAt::Coordinate(x) } => {
                let (mut cells, axis) = (all, *axis as usize);
                let layers = body.layers(axis, x - body.grid.spacing[axis], x + body.grid.spacing[axis]);
                (cells[0][axis], cells[1][axis]) = (layers.start, layers.end);
                cells
            }
            Self::Box { low, high } => body.cells_within([low.map(|x| x - slack), high.map(|x| x + slack)]),
            Self::Sphere { centre, radius } => {
                let far = radius + slack;
                body.cells_within([centre.map(|x| x - far), centre.map(|x| x + far)])
            }
            Self::Cut(cut) => body.cells_within(cut.bounds(body.grid)),
            Self::Blade(blade) => body.cells_within(blade.bounds(body.grid)),
            Self::Brush(brush) => {
                let [low, high] = brush.bounds();
                body.cells_within([low.map(|x| x - slack), high.map(|x| x + slack)])
            }
            Self::And(parts) => parts.iter().map(|part| part.cell_box(body)).fold(all, common),
            Self::Or(parts) => parts.iter().map(|part| part.cell_box(body)).reduce(around).unwrap_or([[0; 3]; 2]),
        }
    }

    /// A range along x that holds every cell inside of the row (j, k); bounds of boxes are left to `cell_box`.
    fn row(&self, body: &Body, [j, k]: [usize; 2]) -> Range<usize> {
        let all = 0..body.grid.lattice.cells[0];
        match self {
            Self::Cut(cut) => {
                let [_, y, z] = body.grid.centre([0, j, k]);
                let [low, high] = cut.row(body.grid, [y, z]);
                body.layers(0, low, high)
            }
            Self::And(parts) => parts.iter().fold(all, |range, part| {
                let row = part.row(body, [j, k]);
                let end = range.end.min(row.end);
                range.start.max(row.start).min(end)..end
            }),
            Self::Or(parts) => {
                let rows = parts.iter().map(|part| part.row(body, [j, k])).filter(|row| !row.is_empty());
                rows.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
            }
            _ => all,
        }
    }
}

/// What two boxes share; empty ones have no extent.
fn common(a: CellBox, b: CellBox) -> CellBox {
    let high: [usize; 3] = std::array::from_fn(|x| a[1][x].min(b[1][x]));
    [std::array::from_fn(|x| a[0][x].max(b[0][x]).min(high[x])), high]
}

/// The box around two boxes, of which empty ones do not count.
fn around(a: CellBox, b: CellBox) -> CellBox {
    let is_empty = |c: CellBox| (0..3).any(|x| c[0][x] >= c[1][x]);
    match (is_empty(a), is_empty(b)) {
        (true, _) => b,
        (_, true) => a,
        _ => [std::array::from_fn(|x| a[0][x].min(b[0][x])), std::array::from_fn(|x| a[1][x].max(b[1][x]))],
    }
}
