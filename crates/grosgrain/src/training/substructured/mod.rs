//! Training on the one-ring in substructures: every coarse cell is condensed to a few means per interface, and a ring couples those of its cells.
//!
//! A change of a cell renews that cell's cache and the small coupled problems of the rings that hold it (`he2022fast` §3.2, in the manner of
//! FETI, `farhat1991method`, with exact rigid modes). Without a change the result is the initial global harmonic displacement.

mod bound;
mod cell;
mod dense;
mod forces;
mod interface;
mod pairs;
mod ring;
mod solids;
mod space;
mod topology;

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use rayon::prelude::*;

pub use forces::InterfaceForces;
pub use space::{InterfaceSpace, Means};

use self::cell::{CellAnswer, CellCache, CellSource, CellWorkspace, cell_plan, width};
use self::forces::{CellLoads, active_cells};
use self::interface::{Interface, interfaces, neighbours};
use self::ring::{Groups, RingWorkspace, dual_answers};
use self::solids::{Solids, local_node};
use self::topology::{Member, Ring, RingShape};
use super::local::lock;
use super::rigid::remove_rigid_motion;
use super::{LocalTrainer, RingKind, Training, TrainingError};
use crate::fine::{FineModel, HARMONIC_FIELDS};
use crate::linalg::FrontalPlan;
use crate::mesh::{Cell, Components, Lattice, Neighbourhood, Node, hull};
use crate::partition::{CellBox, CellPart, CoarseCell, CoarseMesh, Partition};
use crate::progress::Progress;

/// The cells of a body, each condensed to its interfaces.
///
/// A cell of degree d with r rows (54 of an interior cell) keeps r² + 12 r + 3 (d + 1)³ (r + 6) numbers and the factor of its 3 (d + 1)³ unknowns: about
/// 0.1, 0.5 and 4 MB at d = 2, 4 and 7. Results do not depend on the number of threads.
pub struct Substructures {
    forces: Arc<InterfaceForces>,
    space: InterfaceSpace,
    solids: Vec<Solids>,
    loads: Vec<CellLoads>,
    cells: Vec<Option<CellCache>>,
    plan: Option<Arc<FrontalPlan>>,
    one_ring: LocalTrainer,
    cell_pool: Mutex<HashMap<usize, Vec<CellWorkspace>>>,
    ring_pool: Mutex<HashMap<RingShape, RingPool>>,
}

struct RingPool {
    plan: Arc<FrontalPlan>,
    /// Those that answer for the centre, and those that answer for all cells.
    idle: [Vec<RingWorkspace>; 2],
}

impl Substructures {
    /// Condenses all cells of `model`, which may differ from the body that the forces were taken from.
    ///
    /// # Panics
    /// Panics when the model's lattice is not that of the forces.
    pub fn new(model: &FineModel, forces: Arc<InterfaceForces>, space: InterfaceSpace) -> Self {
        let partition = forces.partition;
        let all: Vec<CoarseCell> = (0..partition.coarse().cell_count()).map(CoarseCell).collect();
        let mut substructures = Self {
            solids: forces.solids.clone(),
            loads: forces.loads.clone(),
            cells: all.iter().map(|_| None).collect(),
            plan: cell_plan(partition.degree()),
            space,
            forces,
            one_ring: LocalTrainer::new(&partition, RingKind::OneRing),
            cell_pool: Mutex::default(),
            ring_pool: Mutex::default(),
        };
        substructures.renew(model, &all);
        substructures
    }

    /// The partition of the body.
    pub fn partition(&self) -> &Partition {
        &self.forces.partition
    }

    /// Bytes kept for the cells.
    pub fn state_bytes(&self) -> usize {
        self.cells.iter().flatten().map(CellCache::bytes).sum()
    }

    /// Condenses the changed cells anew, and where solid fine cells were removed or added also their neighbours.
    ///
    /// # Panics
    /// Panics when the model's lattice is not that of the forces.
    pub fn renew(&mut self, model: &FineModel, changed: &[CoarseCell]) {
        assert_eq!(model.grid().lattice, self.forces.partition.fine(), "a model of the same lattice");
        let partition = self.forces.partition;
        let mut reshaped = Vec::new();
        for &cell in changed {
            let solids = Solids::new(model, &partition, cell);
            if solids == self.solids[cell.0] {
                continue;
            }
            let initial = solids.void == self.forces.solids[cell.0].void;
            self.loads[cell.0] = match initial {
                true => self.forces.loads[cell.0].clone(),
                false => CellLoads::of_own_hull(&solids, &partition.cell_lattice()),
            };
            self.solids[cell.0] = solids;
            // Interfaces at the nodes of this cell may have changed: between it and its neighbours, and between these.
            reshaped.push(cell);
            reshaped.extend(neighbours(&self.forces, cell));
        }
        reshaped.sort_unstable();
        reshaped.dedup();
        let mut stale: Vec<CoarseCell> = changed.iter().chain(&reshaped).copied().collect();
        stale.sort_unstable();
        stale.dedup();
        let known = stale.into_iter().map(|cell| {
            let cache = self.cells[cell.0].take().filter(|_| reshaped.binary_search(&cell).is_err());
            (cell, cache.map(|cache| cache.interfaces))
        });
        let known: Vec<(CoarseCell, Option<Vec<Interface>>)> = known.collect();
        let renewed: Vec<(CoarseCell, Option<CellCache>)> =
            known.into_par_iter().map(|(cell, known)| (cell, self.condense(model, cell, known))).collect();
        for (cell, cache) in renewed {
            self.cells[cell.0] = cache;
        }
    }

    fn condense(&self, model: &FineModel, cell: CoarseCell, known: Option<Vec<Interface>>) -> Option<CellCache> {
        let solids = &self.solids[cell.0];
        if solids.is_empty() || solids.hinged {
            return None;
        }
        let list = known.unwrap_or_else(|| interfaces(&self.forces, &self.solids, self.space, cell));
        let width = width(&list);
        let plan = self.plan.as_ref()?;
        let idle = lock(&self.cell_pool).get_mut(&width).and_then(Vec::pop);
        let mut workspace = idle.unwrap_or_else(|| CellWorkspace::new(plan, width));
        let partition = &self.forces.partition;
        let source = CellSource { model, partition, cell, solids, loads: &self.loads[cell.0] };
        let cache = CellCache::new(&source, list, plan, &mut workspace);
        lock(&self.cell_pool).entry(width).or_default().push(workspace);
        cache
    }

    /// The ring of a cell; `None` if one of its cells is not condensed, or its loads are not known without the whole ring.
    fn ring(&self, model: &FineModel, centre: CoarseCell) -> Option<Ring<'_>> {
        let (partition, d) = (self.forces.partition, self.forces.partition.degree());
        let ring = partition.one_ring(centre);
        let size = ring.cells.map(|n| n / d);
        let lattice = Lattice::new(size);
        let coarse = |c: usize| {
            let at = lattice.cell_position(Cell(c));
            CoarseCell(partition.coarse().cell(std::array::from_fn(|a| ring.start[a] / d + at[a])).0)
        };
        let mut caches = Vec::with_capacity(lattice.cell_count());
        let mut unchanged = true;
        for cell in (0..lattice.cell_count()).map(coarse) {
            unchanged &= self.solids[cell.0].void == self.forces.solids[cell.0].void;
            match &self.cells[cell.0] {
                Some(cache) => caches.push(Some((cell, cache))),
                None if self.solids[cell.0].is_empty() => caches.push(None),
                None => return None,
            }
        }
        let index = (0..lattice.cell_count()).find(|c| coarse(*c) == centre)?;
        caches[index]?;
        unchanged &= self.space != InterfaceSpace::Full;
        if !unchanged && !self.loads_add_up(model, &caches, ring) {
            return None;
        }
        // In a cell with voids neighbours may move nodes, and parts each other: their relative rotation must not be free.
        Some(Ring::new(size, index, &caches, (unchanged, !self.solids[centre.0].is_full())))
    }

    /// Whether the cells' own loads are those of the ring's hull.
    fn loads_add_up(&self, model: &FineModel, caches: &[Option<(CoarseCell, &CellCache)>], ring: CellBox) -> bool {
        if caches.iter().flatten().any(|(_, cache)| cache.corrected) {
            return false;
        }
        let lattice = Lattice::new(ring.cells);
        let void = voids(model, ring);
        if void.iter().all(|v| !v) {
            return true;
        }
        let (partition, d) = (&self.forces.partition, self.forces.partition.degree());
        let (coarse, local) = (partition.coarse(), partition.cell_lattice());
        let hulls: HashMap<CoarseCell, Vec<bool>> =
            caches.iter().flatten().map(|(c, _)| (*c, self.solids[c.0].own_hull(&local))).collect();
        hull(&void, &lattice).into_iter().enumerate().all(|(c, inside)| {
            let position = lattice.cell_position(Cell(c));
            let at: [usize; 3] = std::array::from_fn(|a| ring.start[a] + position[a]);
            let cell = CoarseCell(coarse.cell(at.map(|x| x / d)).0);
            hulls.get(&cell).is_some_and(|own| own[local.cell(at.map(|x| x % d)).0]) == inside
        })
    }

    fn ring_plan(&self, shape: &RingShape) -> Option<Arc<FrontalPlan>> {
        let mut pools = lock(&self.ring_pool);
        if let Some(pool) = pools.get(shape) {
            return Some(pool.plan.clone());
        }
        let plan = shape.plan()?;
        pools.insert(shape.clone(), RingPool { plan: plan.clone(), idle: Default::default() });
        Some(plan)
    }

    /// Runs `work` with a workspace for the ring.
    fn with_workspace<T>(
        &self,
        shape: &RingShape,
        whole: bool,
        work: impl FnOnce(&mut RingWorkspace) -> T,
    ) -> Option<T> {
        let pooled = lock(&self.ring_pool).get_mut(shape).and_then(|pool| pool.idle[usize::from(whole)].pop());
        let mut workspace = match pooled {
            Some(workspace) => workspace,
            None => RingWorkspace::new(shape, self.ring_plan(shape)?, whole),
        };
        let outcome = work(&mut workspace);
        if let Some(pool) = lock(&self.ring_pool).get_mut(shape) {
            pool.idle[usize::from(whole)].push(workspace);
        }
        Some(outcome)
    }

    /// Multipliers and rigid motions of the centre, or of all cells.
    fn answers(&self, ring: &Ring<'_>, groups: &Groups, whole: bool) -> Option<Vec<Option<CellAnswer>>> {
        let found = self.with_workspace(&ring.shape, whole, |workspace| workspace.answers(ring, groups))?;
        // Remains of cells next to voids have forces that are nearly but not quite undetermined: one-ring training keeps more digits there.
        if found.is_none() && !ring.members.iter().flatten().all(|m| self.solids[m.cell.0].is_full()) {
            return None;
        }
        found.or_else(|| dual_answers(ring, &self.ring_plan(&ring.shape)?, groups, whole))
    }

    fn displacements_of(&self, member: &Member<'_>, answer: &CellAnswer) -> Option<Vec<f64>> {
        let place = (&self.forces.partition, self.forces.spacing, &self.solids[member.cell.0]);
        Some(member.cache.displacements(answer, self.plan.as_ref()?, place))
    }

    /// The six displacements of the cell's nodes, one after the other, and which nodes have one; each group of parts that the ring
    /// does not join moves independently and is free of rigid motion.
    fn displacements(&self, model: &FineModel, ring: &Ring<'_>) -> Option<(Vec<f64>, Vec<bool>)> {
        let (partition, centre) = (&self.forces.partition, ring.shape.centre);
        let member = ring.members[centre].as_ref()?;
        let groups = ring.groups();
        let solids = &self.solids[member.cell.0];
        let mut group_of: Vec<Option<usize>> =
            (0..partition.nodes_per_cell()).map(|n| Some(groups[centre][solids.part(n)?].0)).collect();
        // Nodes that only other cells of the ring move.
        let mut lent: Vec<(usize, Vec<usize>)> = Vec::new();
        for (n, node) in partition.fine_nodes(member.cell).enumerate().filter(|(n, _)| solids.part(*n).is_none()) {
            let place = |c: CoarseCell| ring.members.iter().position(|m| m.as_ref().is_some_and(|m| m.cell == c));
            let lenders: Vec<usize> =
                active_cells(partition, &self.solids, node).into_iter().filter_map(place).collect();
            if let Some(&first) = lenders.first() {
                let cell = ring.members[first].as_ref()?.cell;
                group_of[n] = Some(groups[first][self.solids[cell.0].part(local_node(partition, cell, node))?].0);
                lent.push((n, lenders));
            }
        }
        let whole = !lent.is_empty();
        if (whole || solids.parts > 1) && has_hinges(model, partition.one_ring(member.cell)) {
            return None;
        }
        let answers = self.answers(ring, &groups, whole)?;
        let mut fields = self.displacements_of(member, answers[centre].as_ref()?)?;
        let stride = fields.len() / F;
        let mut others: HashMap<usize, Vec<f64>> = HashMap::new();
        for (n, lenders) in lent {
            let node = partition.fine_nodes(member.cell).nth(n)?;
            for lender in &lenders {
                let other = ring.members[*lender].as_ref()?;
                if !others.contains_key(lender) {
                    others.insert(*lender, self.displacements_of(other, answers[*lender].as_ref()?)?);
                }
                let (from, local) = (&others[lender], local_node(partition, other.cell, node));
                for i in 0..3 * F {
                    fields[stride * (i / 3) + 3 * n + i % 3] +=
                        from[stride * (i / 3) + 3 * local + i % 3] / lenders.len() as f64;
                }
            }
        }
        self.centre_groups(&group_of, &mut fields);
        let active = group_of.iter().map(Option::is_some).collect();
        fields.iter().all(|u| u.is_finite()).then_some((fields, active))
    }

    /// Takes the rigid motion of each group of nodes out if there are several.
    fn centre_groups(&self, group_of: &[Option<usize>], fields: &mut [f64]) {
        let local = self.forces.partition.cell_lattice();
        let mut distinct: Vec<usize> = group_of.iter().flatten().copied().collect();
        distinct.sort_unstable();
        distinct.dedup();
        if distinct.len() < 2 {
            return;
        }
        for group in distinct {
            let here: Vec<bool> = group_of.iter().map(|g| *g == Some(group)).collect();
            for column in fields.chunks_exact_mut(3 * here.len()) {
                remove_rigid_motion(local, self.forces.spacing, &here, column);
            }
        }
    }

    /// Training matrices of some parts of one coarse cell, `3 (d + 1)³ × 6` row-major each, on the calling thread.
    ///
    /// `None` where the ring is not solved in substructures: a coarse cell of it holds parts that hang together by edges or nodes; several parts meet in the cell and
    /// some parts of the ring hang together so; a cell with voids has nearly dependent
    /// means; or solid fine cells were removed or added and a void in the ring reaches through several coarse
    /// cells without reaching its outside. One-ring training serves there.
    pub fn train_cell(&self, model: &FineModel, mesh: &CoarseMesh, parts: &[CellPart]) -> Option<Vec<Box<[f64]>>> {
        let Some(cell) = parts.first().map(|part| part.cell) else { return Some(Vec::new()) };
        let (fields, active) = self.displacements(model, &self.ring(model, cell)?)?;
        let nodes: Vec<Node> = (0..active.len()).map(Node).collect();
        Some(self.one_ring.cut(mesh, parts, (&nodes, &active, &fields), self.forces.spacing))
    }

    /// Training data of the listed elements of `mesh`, in parallel over coarse cells; by one-ring training where [`Self::train_cell`] gives none.
    ///
    /// # Errors
    /// When a one-ring problem is not solved, or the callback interrupts.
    pub fn train(
        &self,
        model: &FineModel,
        mesh: &CoarseMesh,
        elements: &[CellPart],
        progress: Progress<'_>,
    ) -> Result<Training, TrainingError> {
        self.train_within(model, mesh, elements, f64::INFINITY, progress)
    }

    /// The same, and by one-ring training too where the [bound](Self::error_bound) of the error of a ring exceeds `tolerance` in any of the six fields.
    ///
    /// # Errors
    /// As [`Substructures::train`].
    pub fn train_within(
        &self,
        model: &FineModel,
        mesh: &CoarseMesh,
        elements: &[CellPart],
        tolerance: f64,
        progress: Progress<'_>,
    ) -> Result<Training, TrainingError> {
        let is_within = |cell: CoarseCell| {
            let within = |bounds: [f64; F]| bounds.iter().all(|bound| *bound <= tolerance);
            tolerance == f64::INFINITY || self.error_bound(model, cell).is_some_and(within)
        };
        self.one_ring.train_by(elements, progress, &|parts| {
            let bounded = parts.first().is_some_and(|part| is_within(part.cell));
            let data = if bounded { self.train_cell(model, mesh, parts) } else { None };
            data.map_or_else(|| self.one_ring.train_cell(model, mesh, parts), Ok)
        })
    }
}

const F: usize = HARMONIC_FIELDS;

/// The voids of a box of fine cells.
fn voids(model: &FineModel, window: CellBox) -> Vec<bool> {
    let lattice = Lattice::new(window.cells);
    let outer = |c: usize| {
        let at = lattice.cell_position(Cell(c));
        model.grid().lattice.cell(std::array::from_fn(|a| window.start[a] + at[a]))
    };
    (0..lattice.cell_count()).map(|c| model.is_void(outer(c))).collect()
}

/// Whether parts of a box hang together by edges or nodes only: their relative motion is not determined.
fn has_hinges(model: &FineModel, window: CellBox) -> bool {
    let (void, lattice) = (voids(model, window), Lattice::new(window.cells));
    let parts = |by| Components::new(&void, &lattice, by).count();
    parts(Neighbourhood::Faces) != parts(Neighbourhood::Nodes)
}
