//! Symbolic elimination: which unknowns each front holds and where everything goes.

/// Columns are eliminated and updated in strips of this many.
pub(super) const STRIP: usize = 8;
/// Rows are worked on in tiles of this many.
pub(super) const TILE: usize = 24;
const NONE: u32 = u32::MAX;

/// Why there is no plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FrontalPlanError {
    /// A node is in no group or in two.
    #[error("node {node} must be in exactly one of the groups that are eliminated together")]
    Group {
        /// The node.
        node: usize,
    },
    /// An element names a node that does not exist.
    #[error("element {element} names node {node}, but there are only {count} nodes")]
    Element {
        /// The element.
        element: usize,
        /// The node.
        node: usize,
        /// Number of nodes.
        count: usize,
    },
}

/// The dense matrix in which one group of unknowns is eliminated. Columns: the pivots, padded to a multiple of eight, then the
/// boundary, the unknowns that are eliminated later and that the pivots touch. Rows: the same, then the extra rows.
#[derive(Clone, Debug)]
pub(super) struct Front {
    /// Unknowns eliminated here.
    pub pivots: usize,
    /// `pivots` rounded up to a multiple of [`STRIP`].
    pub padded: usize,
    /// Unknowns on the boundary.
    pub boundary: usize,
    /// Position of the first pivot in elimination order.
    pub first: usize,
    /// Elimination positions of the boundary's unknowns, ascending.
    pub rows: Vec<u32>,
    /// Contributions of earlier fronts that are added here.
    pub children: Vec<Child>,
    /// Elements assembled here: the element, and where in `FrontalPlan::element_rows` its nodes' rows stand.
    pub elements: Vec<u32>,
    /// Where the contribution to a later front is kept, in columns-times-rows without extra rows; see [`FrontalPlan::arena`].
    pub slot: usize,
}

impl Front {
    /// Columns of the dense matrix.
    pub fn columns(&self) -> usize {
        self.padded + self.boundary
    }

    /// Leading dimension with `extra` more rows.
    pub fn stride(&self, extra: usize) -> usize {
        (self.columns() + extra).next_multiple_of(TILE)
    }

    /// Columns padded to whole strips.
    pub fn padded_columns(&self) -> usize {
        self.columns().next_multiple_of(STRIP)
    }
}

/// A contribution and where it goes: runs of rows that stay contiguous, (row in the child's boundary, row in the front, length).
#[derive(Clone, Debug)]
pub(super) struct Child {
    pub front: u32,
    pub runs: Vec<(u32, u32, u32)>,
}

/// The symbolic part of an elimination, made once per shape.
#[derive(Clone, Debug)]
pub struct FrontalPlan {
    pub(super) fronts: Vec<Front>,
    pub(super) element_rows: Vec<Vec<u32>>,
    pub(super) position: Vec<u32>,
    /// Unknowns per node.
    pub(super) block: usize,
    /// Number of slots for contributions that are alive together, and the largest boundary that each holds.
    pub(super) slots: Vec<usize>,
}

impl FrontalPlan {
    /// Plans the elimination of `nodes` nodes of `block` unknowns each, group after group, for `elements` given by their nodes.
    ///
    /// # Errors
    /// Groups that do not hold every node once; elements with nodes that do not exist.
    pub fn new(
        nodes: usize,
        block: usize,
        elements: &[Vec<u32>],
        groups: &[Vec<u32>],
    ) -> Result<Self, FrontalPlanError> {
        let (position, front_of) = places(nodes, groups)?;
        check_elements(nodes, elements)?;
        let mut touching: Vec<Vec<u32>> = vec![Vec::new(); groups.len()];
        for (index, element) in elements.iter().enumerate() {
            if let Some(front) = element.iter().map(|n| front_of[*n as usize]).min() {
                touching[front as usize].push(index as u32);
            }
        }
        let mut node_at = vec![0; nodes];
        position.iter().enumerate().for_each(|(node, at)| node_at[*at as usize] = node as u32);
        let mut boundaries: Vec<Vec<u32>> = Vec::with_capacity(groups.len());
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); groups.len()];
        let mut end = 0;
        for (f, group) in groups.iter().enumerate() {
            end += group.len();
            let own = touching[f].iter().flat_map(|e| &elements[*e as usize]).map(|n| position[*n as usize]);
            let inherited = children[f].iter().flat_map(|c| boundaries[*c as usize].iter().copied());
            let mut boundary: Vec<u32> = own.chain(inherited).filter(|at| *at as usize >= end).collect();
            boundary.sort_unstable();
            boundary.dedup();
            if let Some(first) = boundary.first() {
                children[front_of[node_at[*first as usize] as usize] as usize].push(f as u32);
            }
            boundaries.push(boundary);
        }
        let mut plan = Self {
            fronts: Vec::new(),
            element_rows: vec![Vec::new(); elements.len()],
            position,
            block,
            slots: Vec::new(),
        };
        let mut first = 0;
        for (f, group) in groups.iter().enumerate() {
            plan.push_front(first, group.len(), &boundaries, (&children[f], std::mem::take(&mut touching[f])), f);
            for &e in &plan.fronts[f].elements {
                let row = |n: &u32| plan.row_in(f, plan.position[*n as usize], &boundaries[f], first, group.len());
                plan.element_rows[e as usize] = elements[e as usize].iter().map(row).collect();
            }
            first += group.len();
        }
        plan.assign_slots(&children);
        Ok(plan)
    }

    fn push_front(
        &mut self,
        first: usize,
        pivots: usize,
        boundaries: &[Vec<u32>],
        (children, elements): (&[u32], Vec<u32>),
        f: usize,
    ) {
        let b = self.block;
        let boundary = &boundaries[f];
        self.fronts.push(Front {
            pivots: b * pivots,
            padded: (b * pivots).next_multiple_of(STRIP),
            boundary: b * boundary.len(),
            first: b * first,
            rows: boundary.iter().flat_map(|at| (0..b as u32).map(move |r| b as u32 * at + r)).collect(),
            children: Vec::new(),
            elements,
            slot: usize::MAX,
        });
        let list = children.iter().map(|&child| {
            let rows = boundaries[child as usize].iter().map(|at| self.row_in(f, *at, boundary, first, pivots));
            Child { front: child, runs: runs(rows.collect(), b as u32) }
        });
        self.fronts[f].children = list.collect();
    }

    /// Row in front `f` of the first unknown of the node at elimination position `at`.
    fn row_in(&self, f: usize, at: u32, boundary: &[u32], first: usize, pivots: usize) -> u32 {
        let at_node = at as usize;
        let row = if at_node < first + pivots {
            self.block * (at_node - first)
        } else {
            // Every node of an element or of a contribution is a pivot or on the boundary, by construction.
            self.fronts[f].padded + self.block * boundary.partition_point(|b| *b < at)
        };
        row as u32
    }

    /// Contributions that are alive at the same time get different slots; each goes to the smallest free one that is large enough.
    fn assign_slots(&mut self, children: &[Vec<u32>]) {
        let mut free: Vec<usize> = Vec::new();
        for f in 0..self.fronts.len() {
            // The children's slots stay taken until this front has been eliminated.
            let needed = self.fronts[f].boundary;
            if needed > 0 {
                let fits = |s: &usize| self.slots[*s] >= needed;
                let best = free.iter().copied().filter(fits).min_by_key(|s| self.slots[*s]);
                let best = best.or_else(|| free.iter().copied().max_by_key(|s| self.slots[*s]));
                let slot = best.unwrap_or_else(|| {
                    self.slots.push(0);
                    self.slots.len() - 1
                });
                free.retain(|s| *s != slot);
                self.slots[slot] = self.slots[slot].max(needed);
                self.fronts[f].slot = slot;
            }
            free.extend(children[f].iter().map(|c| self.fronts[*c as usize].slot));
        }
    }

    /// Number of unknowns.
    pub fn order(&self) -> usize {
        self.block * self.position.len()
    }

    /// Unknowns per node.
    pub fn block(&self) -> usize {
        self.block
    }

    /// Place of a node's first unknown in the order of elimination.
    pub fn place(&self, node: usize) -> usize {
        self.block * self.position[node] as usize
    }

    /// Number of elements.
    pub fn element_count(&self) -> usize {
        self.element_rows.len()
    }

    /// Floating-point operations of an elimination with `extra` rows of loads, padding not counted.
    pub fn operations(&self, extra: usize) -> f64 {
        let of_front = |front: &Front| {
            let size = front.pivots + front.boundary;
            (0..front.pivots).map(|k| ((size - k) * (size - k) + 2 * extra * (size - k)) as f64).sum::<f64>()
        };
        self.fronts.iter().map(of_front).sum()
    }

    /// Bytes of the workspace of a solver with `extra` rows that keeps `kept` fronts at the end.
    pub fn workspace_bytes(&self, extra: usize, kept: usize) -> usize {
        let dense = |f: &Front| f.stride(extra) * f.padded_columns();
        let largest = self.fronts.iter().map(dense).max().unwrap_or(0);
        let panel = self.fronts.iter().map(|f| f.stride(extra) * f.padded).max().unwrap_or(0);
        let slots: usize = self.slots.iter().map(|n| n * (n + extra)).sum();
        let factors: usize = self.fronts.iter().rev().take(kept).map(|f| f.columns() * f.pivots).sum();
        size_of::<f64>() * (largest + panel + slots + factors + self.order() * (extra + 2))
    }
}

fn places(nodes: usize, groups: &[Vec<u32>]) -> Result<(Vec<u32>, Vec<u32>), FrontalPlanError> {
    let (mut position, mut front_of) = (vec![NONE; nodes], vec![NONE; nodes]);
    let mut next = 0;
    for (f, group) in groups.iter().enumerate() {
        for &node in group {
            match position.get_mut(node as usize) {
                Some(place) if *place == NONE => *place = next,
                _ => return Err(FrontalPlanError::Group { node: node as usize }),
            }
            front_of[node as usize] = f as u32;
            next += 1;
        }
    }
    match position.iter().position(|p| *p == NONE) {
        Some(node) => Err(FrontalPlanError::Group { node }),
        None => Ok((position, front_of)),
    }
}

fn check_elements(nodes: usize, elements: &[Vec<u32>]) -> Result<(), FrontalPlanError> {
    for (element, list) in elements.iter().enumerate() {
        if let Some(&node) = list.iter().find(|n| **n as usize >= nodes) {
            return Err(FrontalPlanError::Element { element, node: node as usize, count: nodes });
        }
    }
    Ok(())
}

/// Joins blocks of `block` rows whose targets follow each other.
fn runs(targets: Vec<u32>, block: u32) -> Vec<(u32, u32, u32)> {
    let mut found: Vec<(u32, u32, u32)> = Vec::new();
    for (i, target) in targets.into_iter().enumerate() {
        match found.last_mut() {
            Some((_, start, length)) if *start + *length == target => *length += block,
            _ => found.push((block * i as u32, target, block)),
        }
    }
    found
}
