//! A tree of boxes around cells: which of them meet a box, and which is nearest to a point.

use super::SimplexMesh;

/// Items in a leaf at most.
const LEAF: usize = 4;
/// Each level halves the items, and there are fewer than 2³² of them.
const DEEPEST: usize = 64;

/// A box with faces normal to the axes \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// Least coordinates.
    pub lower: [f64; 3],
    /// Greatest coordinates.
    pub upper: [f64; 3],
}

impl BoundingBox {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { lower: [f64::INFINITY; 3], upper: [f64::NEG_INFINITY; 3] };

    /// The smallest box that holds all points.
    pub fn of_points(points: impl IntoIterator<Item = [f64; 3]>) -> Self {
        points.into_iter().fold(Self::EMPTY, |all, point| all.joined(&Self { lower: point, upper: point }))
    }

    /// The smallest box that holds a cell of a mesh.
    pub fn of_cell(mesh: &SimplexMesh, cell: usize) -> Self {
        Self::of_points(mesh.cell(cell).iter().map(|node| mesh.nodes()[*node as usize]))
    }

    /// The smallest box that holds both.
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        Self {
            lower: std::array::from_fn(|r| self.lower[r].min(other.lower[r])),
            upper: std::array::from_fn(|r| self.upper[r].max(other.upper[r])),
        }
    }

    /// The box moved outwards by `margin` \[m\] on every side.
    #[must_use]
    pub fn grown(&self, margin: f64) -> Self {
        Self { lower: self.lower.map(|x| x - margin), upper: self.upper.map(|x| x + margin) }
    }

    /// Length \[m\] of the diagonal.
    pub fn diagonal(&self) -> f64 {
        (0..3).map(|r| (self.upper[r] - self.lower[r]).powi(2)).sum::<f64>().sqrt()
    }

    /// Whether the closed boxes share a point.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|r| self.lower[r] <= other.upper[r] && other.lower[r] <= self.upper[r])
    }

    /// Square of the distance \[m²\] of a point from the box, zero inside.
    pub fn squared_distance(&self, point: [f64; 3]) -> f64 {
        (0..3).map(|r| (self.lower[r] - point[r]).max(point[r] - self.upper[r]).max(0.0).powi(2)).sum()
    }

    fn centre(&self, axis: usize) -> f64 {
        0.5 * self.lower[axis] + 0.5 * self.upper[axis]
    }
}

/// The box of a subtree: a leaf with `count` items from `first`, or (`count` 0) the next branch and branch `first`.
#[derive(Clone, Copy, Debug)]
struct Branch {
    around: BoundingBox,
    first: u32,
    count: u32,
}

/// Boxes, halved again and again at the median of their centres along the longest axis of these: a search takes a time that grows like the logarithm of their number.
///
/// The tree depends on the boxes and their order only.
#[derive(Clone, Debug)]
pub struct BoundingTree {
    branches: Vec<Branch>,
    items: Vec<u32>,
    boxes: Vec<BoundingBox>,
}

impl BoundingTree {
    /// The tree of boxes, which are named by their places in the list, fewer than 2³².
    pub fn new(boxes: Vec<BoundingBox>) -> Self {
        let mut items: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut branches = Vec::with_capacity(boxes.len());
        if !boxes.is_empty() {
            grow(&boxes, &mut items, 0, &mut branches);
        }
        Self { branches, items, boxes }
    }

    /// The tree of the cells of a mesh.
    pub fn of_cells(mesh: &SimplexMesh) -> Self {
        Self::new((0..mesh.cell_count()).map(|cell| BoundingBox::of_cell(mesh, cell)).collect())
    }

    /// The box around everything.
    pub fn around(&self) -> BoundingBox {
        self.branches.first().map_or(BoundingBox::EMPTY, |root| root.around)
    }

    /// Visits every item whose box meets `with`, in an order that depends on the tree only.
    pub fn visit(&self, with: &BoundingBox, visit: impl FnMut(u32)) {
        self.walk(|around| around.meets(with), visit);
    }

    /// Visits every item whose box is no farther from a point than the square root of `squared` \[m²\].
    pub fn visit_within(&self, point: [f64; 3], squared: f64, visit: impl FnMut(u32)) {
        self.walk(|around| around.squared_distance(point) <= squared, visit);
    }

    fn walk(&self, enters: impl Fn(&BoundingBox) -> bool, mut visit: impl FnMut(u32)) {
        let mut waiting = Stack::of_root(&self.branches);
        while let Some(at) = waiting.pop() {
            let branch = &self.branches[at as usize];
            if !enters(&branch.around) {
                continue;
            }
            if branch.count == 0 {
                waiting.push(branch.first);
                waiting.push(at + 1);
            } else {
                self.leaf(branch).iter().filter(|item| enters(&self.boxes[**item as usize])).for_each(|i| visit(*i));
            }
        }
    }

    /// The item with the least `squared` distance \[m²\] and that distance; of several the first in the list. `None` if there are no items.
    ///
    /// `squared` is asked for items whose box is near; it must not be less than the distance from the box.
    pub fn nearest(&self, point: [f64; 3], mut squared: impl FnMut(u32) -> f64) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut waiting = Stack::of_root(&self.branches);
        while let Some(at) = waiting.pop() {
            let branch = &self.branches[at as usize];
            let is_near = |near: &BoundingBox| best.is_none_or(|(_, least)| near.squared_distance(point) <= least);
            if !is_near(&branch.around) {
                continue;
            }
            if branch.count == 0 {
                let distance = |b: u32| self.branches[b as usize].around.squared_distance(point);
                let (mut near, mut far) = (at + 1, branch.first);
                if distance(far) < distance(near) {
                    (near, far) = (far, near);
                }
                waiting.push(far);
                waiting.push(near);
                continue;
            }
            for item in self.leaf(branch) {
                let distance = squared(*item);
                if best.is_none_or(|(first, least)| distance < least || (distance == least && *item < first)) {
                    best = Some((*item, distance));
                }
            }
        }
        best
    }

    fn leaf(&self, branch: &Branch) -> &[u32] {
        &self.items[branch.first as usize..(branch.first + branch.count) as usize]
    }
}

/// Appends the subtree of `items`, which start at `offset` in the whole list.
fn grow(boxes: &[BoundingBox], items: &mut [u32], offset: usize, branches: &mut Vec<Branch>) {
    let around = items.iter().fold(BoundingBox::EMPTY, |all, item| all.joined(&boxes[*item as usize]));
    let own = branches.len();
    branches.push(Branch { around, first: offset as u32, count: items.len() as u32 });
    if items.len() <= LEAF {
        return;
    }
    let centre = |item: u32, axis: usize| boxes[item as usize].centre(axis);
    let extent = |axis: usize| {
        let (least, most) = items.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), item| {
            (least.min(centre(*item, axis)), most.max(centre(*item, axis)))
        });
        most - least
    };
    let axis = (1..3).fold(0, |longest, axis| if extent(axis) > extent(longest) { axis } else { longest });
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| centre(*a, axis).total_cmp(&centre(*b, axis)).then(a.cmp(b)));
    let (before, after) = items.split_at_mut(middle);
    grow(boxes, before, offset, branches);
    (branches[own].first, branches[own].count) = (branches.len() as u32, 0);
    grow(boxes, after, offset + middle, branches);
}

/// Branches that are still to be searched.
struct Stack {
    branches: [u32; DEEPEST],
    height: usize,
}

impl Stack {
    fn of_root(branches: &[Branch]) -> Self {
        Self { branches: [0; DEEPEST], height: usize::from(!branches.is_empty()) }
    }

    fn push(&mut self, branch: u32) {
        self.branches[self.height] = branch;
        self.height += 1;
    }

    fn pop(&mut self) -> Option<u32> {
        self.height = self.height.checked_sub(1)?;
        Some(self.branches[self.height])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_boxes() -> impl Strategy<Value = Vec<BoundingBox>> {
        // Few places, so that centres coincide and boxes touch.
        let one = (prop::array::uniform3(0..6i32), prop::array::uniform3(0..3i32));
        let of = |(lower, size): ([i32; 3], [i32; 3])| BoundingBox {
            lower: lower.map(f64::from),
            upper: std::array::from_fn(|r| f64::from(lower[r] + size[r])),
        };
        prop::collection::vec(one.prop_map(of), 0..80)
    }

    proptest! {
        #[test]
        fn a_search_finds_what_looking_at_every_box_finds(boxes in any_boxes(), at in prop::array::uniform3(-2.0..9.0f64), margin in 0.0..3.0f64) {
            let tree = BoundingTree::new(boxes.clone());
            let with = BoundingBox { lower: at, upper: at }.grown(margin);
            let mut found = Vec::new();
            tree.visit(&with, |item| found.push(item));
            found.sort_unstable();
            let expected: Vec<u32> = (0..boxes.len() as u32).filter(|b| boxes[*b as usize].meets(&with)).collect();
            prop_assert_eq!(found, expected);

            let squared = |item: u32| boxes[item as usize].squared_distance(at);
            let mut within = Vec::new();
            tree.visit_within(at, margin * margin, |item| within.push(item));
            within.sort_unstable();
            let expected: Vec<u32> = (0..boxes.len() as u32).filter(|b| squared(*b) <= margin * margin).collect();
            prop_assert_eq!(within, expected);

            let expected = (0..boxes.len() as u32).map(|b| (b, squared(b))).min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            prop_assert_eq!(tree.nearest(at, squared), expected);
        }
    }

    #[test]
    fn distances_from_a_box_are_those_of_its_faces_edges_and_corners() {
        let cube = BoundingBox::of_points([[0.0; 3], [1.0, 1.0, 1.0]]);
        assert_eq!(cube.squared_distance([0.5, 0.2, 1.0]), 0.0);
        assert_eq!(cube.squared_distance([3.0, 0.2, 0.3]), 4.0);
        assert_eq!(cube.squared_distance([3.0, -1.0, 0.3]), 5.0);
        assert_eq!(cube.squared_distance([3.0, -1.0, 3.0]), 9.0);
        assert_eq!(cube.diagonal(), 3f64.sqrt());
    }

    #[test]
    fn many_boxes_at_one_place_make_a_shallow_tree() {
        let tree = BoundingTree::new(vec![BoundingBox::of_points([[0.0; 3]]); 100_000]);
        let mut seen = 0;
        tree.visit(&tree.around(), |_| seen += 1);
        assert_eq!(seen, 100_000);
    }
}
