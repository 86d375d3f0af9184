//! The coupled problem of a ring: unknowns are the means that cells share.

use std::sync::Arc;

use super::cell::{CellAnswer, CellCache, Condensed, RIGID};
use super::dense::solve_semidefinite;
use super::topology::{Member, Ring, RingShape};
use crate::fine::HARMONIC_FIELDS;
use crate::linalg::{DenseFront, FrontalPlan, FrontalSolver};

const F: usize = HARMONIC_FIELDS;

/// Per cell its parts with the group that they belong to and whether they hold it, see [`Ring::groups`].
pub(super) type Groups = [Vec<(usize, bool)>];

/// Buffers of rings of one shape.
pub(super) struct RingWorkspace {
    plan: Arc<FrontalPlan>,
    solver: FrontalSolver,
    /// All fronts are kept, for answers in all cells.
    whole: bool,
    elements: Vec<Vec<f64>>,
    loads: Vec<f64>,
    values: Vec<[f64; 8]>,
    fronts: [DenseFront; 2],
}

impl RingWorkspace {
    pub(super) fn new(shape: &RingShape, plan: Arc<FrontalPlan>, whole: bool) -> Self {
        let kept = if whole { usize::MAX } else { usize::from(!shape.elements[shape.centre].is_empty()) };
        Self {
            solver: FrontalSolver::new(plan.clone(), F, kept),
            whole,
            elements: vec![Vec::new(); shape.elements.len()],
            loads: vec![0.0; plan.order() * F],
            values: vec![[0.0; 8]; plan.order()],
            fronts: Default::default(),
            plan,
        }
    }

    /// Multipliers and rigid motions of the wanted cells, `None` where a cell cannot tell its rows apart.
    ///
    /// Minimising Σ_i ½ u_iᵀ H_i u_i − f_iᵀ u_i under S_i u_i = q gives λ_i = ĝ_i − K̂_i q in every cell and Σ_i λ_i = 0 on every interface, so Σ K̂_i q = Σ ĝ_i.
    /// One part of every connected group keeps its rigid motions in F' instead of losing them to K̂: that holds the group, and as its loads are in
    /// equilibrium it changes nothing but its rigid motion.
    pub(super) fn answers(&mut self, ring: &Ring<'_>, groups: &Groups) -> Option<Vec<Option<CellAnswer>>> {
        let mut condensed = ring.condense();
        for (index, ((member, condensed), groups)) in ring.members.iter().zip(&mut condensed).zip(groups).enumerate() {
            let (Some(member), Some(condensed)) = (member, condensed) else { continue };
            let independent = match self.whole || index == ring.shape.centre {
                true => member.cache.stiffen(condensed, groups),
                false => member.cache.condense_rows(condensed, groups, &mut self.fronts),
            };
            if !independent {
                return None;
            }
        }
        self.gather(ring, &condensed);
        let block = ring.shape.block;
        let (elements, loads) = (&self.elements, &self.loads);
        self.solver.eliminate(
            &|e| (!elements[e].is_empty()).then(|| (1.0, elements[e].as_slice())),
            &mut |node, out| out.copy_from_slice(&loads[F * block * node..][..F * block]),
            &[],
        );
        let forward = self.solver.forward().chunks_exact(F);
        self.values.iter_mut().zip(forward).for_each(|(y, f)| y[..F].copy_from_slice(f));
        self.solver.substitute_back(&mut self.values);
        let of = |(index, condensed): (usize, &Option<Condensed>)| {
            let wanted = self.whole || index == ring.shape.centre;
            let (member, condensed) = (ring.members[index].as_ref()?, condensed.as_ref().filter(|_| wanted)?);
            Some(member.cache.answer(condensed, &self.means(ring, member, index)))
        };
        Some(condensed.iter().enumerate().map(of).collect())
    }

    fn gather(&mut self, ring: &Ring<'_>, condensed: &[Option<Condensed>]) {
        let block = ring.shape.block;
        self.loads.fill(0.0);
        for (index, condensed) in condensed.iter().enumerate() {
            let element = &mut self.elements[index];
            element.clear();
            let (Some(condensed), Some(member)) = (condensed, &ring.members[index]) else { continue };
            let size = block * member.inner.len();
            element.resize(size * size, 0.0);
            let places = member.places(block);
            let n = places.len();
            for (row, values) in places.iter().zip(condensed.stiffness.chunks_exact(n.max(1))) {
                places.iter().zip(values).for_each(|(column, k)| element[size * row + column] = *k);
            }
            for (place, load) in places.iter().zip(condensed.load.chunks_exact(F)) {
                let id = ring.shape.elements[index][place / block] as usize;
                let to = &mut self.loads[F * (block * id + place % block)..][..F];
                to.iter_mut().zip(load).for_each(|(t, g)| *t += g);
            }
        }
    }

    /// The means q on the inner rows of a cell.
    fn means(&self, ring: &Ring<'_>, member: &Member<'_>, index: usize) -> Vec<[f64; 8]> {
        let block = ring.shape.block;
        let value = |place: &usize| {
            let id = ring.shape.elements[index][place / block] as usize;
            self.values[self.plan.place(id) + place % block]
        };
        member.places(block).iter().map(value).collect()
    }
}

impl Member<'_> {
    /// Places of the inner rows in the cell's element, `block` per interface.
    fn places(&self, block: usize) -> Vec<usize> {
        let of = |(at, number): (usize, &usize)| {
            (0..self.cache.interfaces[*number].tied(self.turns)).map(move |r| block * at + r)
        };
        self.inner.iter().enumerate().flat_map(of).collect()
    }

    /// The inner rows among all of the cell's.
    fn rows(&self) -> Vec<usize> {
        let of = |number: &usize| {
            let first = self.cache.offsets[*number];
            first..first + self.cache.interfaces[*number].tied(self.turns)
        };
        self.inner.iter().flat_map(of).collect()
    }

    /// Multipliers of the interfaces to cells outside of the ring: the initial forces, −S t on the first cell of a pair.
    fn known(&self, ring: &Ring<'_>) -> Vec<f64> {
        let cache: &CellCache = self.cache;
        let mut known = vec![0.0; F * cache.rows()];
        if !ring.unchanged {
            return known;
        }
        let inside = |i: &super::interface::Interface| {
            i.cells.iter().all(|c| ring.members.iter().flatten().any(|m| m.cell == *c))
        };
        for (number, interface) in cache.interfaces.iter().enumerate() {
            let Some(force) = interface.force.as_ref().filter(|_| !inside(interface)) else { continue };
            let sign = interface.sign(self.cell);
            let out = &mut known[F * cache.offsets[number]..][..force.len()];
            out.iter_mut().zip(force).for_each(|(out, t)| *out = -sign * t);
        }
        known
    }
}

impl Ring<'_> {
    /// Every cell with the forces from outside of the ring taken over to its loads.
    pub(super) fn condense(&self) -> Vec<Option<Condensed>> {
        let of = |m: &Member<'_>| m.cache.with_known(m.known(self), m.rows());
        self.members.iter().map(|m| m.as_ref().map(of)).collect()
    }
}

/// The answers of the centre or of all cells with the forces as unknowns, which also serves where a cell's rows are dependent: then some forces are
/// not determined, what they do is.
///
/// With signs σ = ±1 for the first and second cell of an interface and λ_i = σ λ the cells agree where A λ = Σ σ b_i + Γ α and Γᵀλ = e, A = Σ σ F'_i σ,
/// Γ_i = σ G_i, b_i = S H⁺ f + ρ G e. So (Γᵀ A⁻¹ Γ) α = e − Γᵀ A⁻¹ Σ σ b_i; the motions of one part of every connected group are held.
pub(super) fn dual_answers(
    ring: &Ring<'_>,
    plan: &Arc<FrontalPlan>,
    groups: &Groups,
    whole: bool,
) -> Option<Vec<Option<CellAnswer>>> {
    if ring.members.iter().flatten().any(|m| m.inner.iter().any(|n| m.cache.interfaces[*n].cells.len() != 2)) {
        return None;
    }
    let condensed = ring.condense();
    let block = ring.shape.block;
    let mut first = vec![0];
    for member in &ring.members {
        first.push(first[first.len() - 1] + member.as_ref().map_or(0, |m| RIGID * m.cache.parts));
    }
    let motions = first[first.len() - 1];
    let extra = F + motions;
    let mut loads = vec![0.0; plan.order() * extra];
    let mut elements = vec![Vec::new(); ring.members.len()];
    let mut resultant = vec![0.0; motions * F];
    for (index, (member, condensed)) in ring.members.iter().zip(&condensed).enumerate() {
        let (Some(member), Some(condensed)) = (member, condensed) else { continue };
        let (places, rows, all) = (member.places(block), &condensed.rows, member.cache.rows());
        let own = RIGID * member.cache.parts;
        resultant[F * first[index]..][..F * own].copy_from_slice(&condensed.resultant);
        let sign = |place: usize| member.cache.interfaces[member.inner[place / block]].sign(member.cell);
        let size = block * member.inner.len();
        elements[index] = vec![0.0; size * size];
        for (&place, &row) in places.iter().zip(rows) {
            let of = places.iter().zip(rows);
            of.for_each(|(&to, &column)| {
                let value = sign(place) * sign(to) * member.cache.flexibility[all * row + column];
                elements[index][size * place + to] = value;
            });
            let id = ring.shape.elements[index][place / block] as usize;
            let out = &mut loads[extra * (block * id + place % block)..][..extra];
            (0..F).for_each(|k| out[k] += sign(place) * condensed.answer[F * row + k]);
            let g = &member.cache.rigid[own * row..][..own];
            let free = (0..own).filter(|m| !groups[index][m / RIGID].1);
            free.for_each(|m| out[F + first[index] + m] += sign(place) * g[m]);
        }
    }
    let kept = if whole { usize::MAX } else { usize::from(!ring.shape.elements[ring.shape.centre].is_empty()) };
    let mut solver = FrontalSolver::new(plan.clone(), extra, kept);
    solver.eliminate(
        &|e| (!elements[e].is_empty()).then(|| (1.0, elements[e].as_slice())),
        &mut |node, out| out.copy_from_slice(&loads[extra * block * node..][..extra * block]),
        &[],
    );
    let mut matrix = vec![0.0; motions * motions];
    let mut alpha = resultant;
    for row in solver.forward().chunks_exact(extra) {
        let (load, rigid) = row.split_at(F);
        for m in (0..motions).filter(|m| rigid[*m] != 0.0) {
            (0..F).for_each(|k| alpha[F * m + k] -= rigid[m] * load[k]);
            let out = &mut matrix[motions * m..][..motions];
            out.iter_mut().zip(rigid).for_each(|(a, r)| *a += rigid[m] * r);
        }
    }
    solve_semidefinite(motions, &mut matrix, &mut alpha, F);
    let mut values = vec![[0.0; 8]; plan.order()];
    for (value, row) in values.iter_mut().zip(solver.forward().chunks_exact(extra)) {
        value[..F].copy_from_slice(&row[..F]);
        for (y, alpha) in row[F..].iter().zip(alpha.chunks_exact(F)) {
            (0..F).for_each(|k| value[k] += y * alpha[k]);
        }
    }
    solver.substitute_back(&mut values);
    let of = |(index, member): (usize, &Option<Member<'_>>)| {
        let (member, condensed) = (member.as_ref()?, condensed[index].as_ref()?);
        if !whole && index != ring.shape.centre {
            return None;
        }
        let mut multipliers = condensed.known.clone();
        for (&place, &row) in member.places(block).iter().zip(&condensed.rows) {
            let sign = member.cache.interfaces[member.inner[place / block]].sign(member.cell);
            let id = ring.shape.elements[index][place / block] as usize;
            let value = &values[plan.place(id) + place % block];
            (0..F).for_each(|k| multipliers[F * row + k] = sign * value[k]);
        }
        let motions = alpha[F * first[index]..F * first[index + 1]].to_vec();
        Some(CellAnswer { multipliers, motions })
    };
    Some(ring.members.iter().enumerate().map(of).collect())
}
