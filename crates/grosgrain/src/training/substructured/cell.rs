//! One coarse cell on its own: its answer to its loads and to forces on its interfaces.

use std::sync::Arc;

use super::dense::{VANISHING, add_product, combine, gram, invert, solve_semidefinite};
use super::forces::{CellLoads, NODE_COLUMNS, quarter_areas};
use super::interface::Interface;
use super::solids::{Solids, local_node};
use crate::assembly::{CellStiffness, Window};
use crate::fine::{FineModel, HARMONIC_FIELDS};
use crate::linalg::{DenseFront, FrontalFactors, FrontalPlan, FrontalSolver, box_tree};
use crate::mesh::{Cell, Lattice, Node};
use crate::partition::{CoarseCell, Partition};
use crate::solver::six_components;

/// Rigid motions of a part.
pub(super) const RIGID: usize = 6;
const F: usize = HARMONIC_FIELDS;

/// A pivot of F' below this share of its diagonal: rows that the cell cannot tell apart. K̂ grows like the inverse of the share.
const DEPENDENT: f64 = 1e-6;
/// The same for what is left of a cell next to voids, where rows of several interfaces are nearly dependent together. A cell that is whole keeps eight digits
/// down to the share above; in bodies with random voids remains kept two there, five at a tenth of the
/// share below, and seven here.
const DEPENDENT_REMAINS: f64 = 1e-3;

/// The elimination of a coarse cell.
pub(super) fn cell_plan(degree: usize) -> Option<Arc<FrontalPlan>> {
    let lattice = Lattice::new([degree; 3]);
    let corners = |c: usize| lattice.corners(Cell(c)).map(|n| n.0 as u32).to_vec();
    let elements: Vec<Vec<u32>> = (0..lattice.cell_count()).map(corners).collect();
    FrontalPlan::new(lattice.node_count(), 3, &elements, &box_tree(lattice.nodes())).ok().map(Arc::new)
}

/// A workspace for cells with one number of loads and rows.
pub(super) struct CellWorkspace {
    solver: FrontalSolver,
    /// Loads and rows at every unknown: `width` values each.
    columns: Vec<f64>,
    gram: Vec<f64>,
}

impl CellWorkspace {
    pub(super) fn new(plan: &Arc<FrontalPlan>, width: usize) -> Self {
        let solver = FrontalSolver::new(plan.clone(), width, usize::MAX);
        Self { solver, columns: vec![0.0; plan.order() * width], gram: Vec::new() }
    }
}

/// A cell's own elimination with its interface rows S and loads f.
///
/// H u = f − Sᵀλ has the solutions u = H⁺(f − Sᵀλ) + R α where Rᵀ(f − Sᵀλ) = 0; H⁺ holds six unknowns of every part, R are the parts'
/// rigid motions. With F = S H⁺ Sᵀ and G = S R the displacement of the interfaces is S u = S H⁺ f − F λ + G α, and Gᵀλ = e = Rᵀ f.
/// Kept is F' = F + ρ G Gᵀ, which is definite where the rows are independent; Gᵀλ = e makes up for ρ.
pub(super) struct CellCache {
    pub interfaces: Vec<Interface>,
    /// First row of each interface, and the number of rows.
    pub offsets: Vec<usize>,
    pub parts: usize,
    /// F', rows × rows.
    pub flexibility: Vec<f64>,
    /// G, rows × 6 per part.
    pub rigid: Vec<f64>,
    /// S H⁺ f + ρ G e, rows × 6.
    pub answer: Vec<f64>,
    /// e, 6 per part × 6.
    pub resultant: Vec<f64>,
    /// The loads are not those of the cell's own hull.
    pub corrected: bool,
    factors: FrontalFactors,
    width: usize,
    /// Rows are dependent where a pivot of F' is below this share of its diagonal.
    dependent: f64,
}

/// What a cell is made from.
pub(super) struct CellSource<'a> {
    pub model: &'a FineModel,
    pub partition: &'a Partition,
    pub cell: CoarseCell,
    pub solids: &'a Solids,
    pub loads: &'a CellLoads,
}

/// Values per unknown: loads and rows, in whole registers.
pub(super) fn width(interfaces: &[Interface]) -> usize {
    (F + interfaces.iter().map(|i| i.rows.count()).sum::<usize>()).next_multiple_of(8)
}

impl CellCache {
    /// Eliminates the cell; `None` where double precision does not tell its softest motion from none.
    pub(super) fn new(
        source: &CellSource<'_>,
        interfaces: Vec<Interface>,
        plan: &Arc<FrontalPlan>,
        workspace: &mut CellWorkspace,
    ) -> Option<Self> {
        let width = width(&interfaces);
        let mut offsets = vec![0];
        interfaces.iter().for_each(|i| offsets.push(offsets[offsets.len() - 1] + i.rows.count()));
        source.columns(&interfaces, &offsets, width, &mut workspace.columns);
        let own = source.partition.cell_box(source.cell);
        let window = Window::new(source.model, own.start, own.cells);
        let pins = source.pins(plan)?;
        let columns = &workspace.columns;
        let found = workspace.solver.eliminate(
            &|e| window.stiffness(e).map(|(factor, matrix)| (factor, matrix.as_slice())),
            &mut |node, out| out.copy_from_slice(&columns[3 * width * node..][..3 * width]),
            &pins,
        );
        let inactive = source.solids.active().iter().filter(|a| !**a).count();
        if found.skipped != 3 * inactive + pins.len() {
            return None;
        }
        gram(workspace.solver.forward(), width, &mut workspace.gram);
        let mut factors = FrontalFactors::new(plan.clone(), width, usize::MAX);
        workspace.solver.exchange(&mut factors);
        let mut cache = Self {
            parts: source.solids.parts,
            flexibility: Vec::new(),
            rigid: Vec::new(),
            answer: Vec::new(),
            resultant: Vec::new(),
            corrected: source.loads.corrected,
            interfaces,
            offsets,
            factors,
            width,
            dependent: if source.solids.is_full() { DEPENDENT } else { DEPENDENT_REMAINS },
        };
        cache.condense(source, columns, &workspace.gram);
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
        (finite(&cache.flexibility) && finite(&cache.answer)).then_some(cache)
    }

    pub(super) fn rows(&self) -> usize {
        self.offsets[self.offsets.len() - 1]
    }

    /// Bytes of the numbers kept.
    pub(super) fn bytes(&self) -> usize {
        let numbers = self.flexibility.len() + self.rigid.len() + self.answer.len() + self.resultant.len();
        let rows: usize = self.interfaces.iter().map(|i| i.rows.count() * 3 * i.nodes.len()).sum();
        self.factors.bytes() + size_of::<f64>() * (numbers + rows)
    }

    fn condense(&mut self, source: &CellSource<'_>, columns: &[f64], gram: &[f64]) {
        let (rows, motions, width) = (self.rows(), RIGID * self.parts, self.width);
        let products = source.rigid_products(columns, width);
        let product = |column: usize| &products[motions * column..][..motions];
        self.rigid = (0..rows).flat_map(|s| product(F + s).to_vec()).collect();
        self.resultant = (0..motions * F).map(|n| product(n % F)[n / F]).collect();
        let entry = |i: usize, j: usize| gram[width * i.max(j) + i.min(j)];
        let trace: f64 = (0..rows).map(|s| entry(F + s, F + s)).sum();
        let stiffest = source.stiffest();
        let rigid_trace: f64 = self.rigid.iter().map(|g| g * g).sum();
        let rho = if rigid_trace > 0.0 { (trace + rows as f64 / stiffest) / rigid_trace } else { 0.0 };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        self.flexibility = Vec::with_capacity(rows * rows);
        for s in 0..rows {
            let of = (0..rows).map(|r| entry(F + s, F + r) + rho * dot(product(F + s), product(F + r)));
            self.flexibility.extend(of);
        }
        for s in 0..rows {
            let g = product(F + s);
            let resultant = |k: usize| (0..motions).map(|m| g[m] * self.resultant[F * m + k]).sum::<f64>();
            let of: Vec<f64> = (0..F).map(|k| entry(F + s, k) + rho * resultant(k)).collect();
            self.answer.extend(of);
        }
    }

    /// u = H⁺(f − Sᵀλ) + R α at the nodes of the cell, six fields one after the other.
    pub(super) fn displacements(
        &self,
        answer: &CellAnswer,
        plan: &FrontalPlan,
        (partition, spacing, solids): (&Partition, [f64; 3], &Solids),
    ) -> Vec<f64> {
        let nodes = plan.order() / 3;
        let mut values = vec![[0.0; 8]; plan.order()];
        let mut weights = vec![[0.0; 8]; F + self.rows()];
        (0..F).for_each(|k| weights[k][k] = 1.0);
        for (weight, lambda) in weights[F..].iter_mut().zip(answer.multipliers.chunks_exact(F)) {
            (0..F).for_each(|k| weight[k] = -lambda[k]);
        }
        combine(self.factors.forward(), self.width, &weights, &mut values);
        self.factors.substitute_back(&mut values);
        let mut fields = vec![0.0; 3 * F * nodes];
        for node in 0..nodes {
            let place = plan.place(node);
            for r in 0..3 {
                (0..F).for_each(|k| fields[3 * (nodes * k + node) + r] = values[place + r][k]);
            }
            let Some(part) = solids.part(node) else { continue };
            let alpha = &answer.motions[RIGID * F * part..][..RIGID * F];
            if alpha.iter().any(|a| *a != 0.0) {
                for (r, alpha) in rigid_motions(partition, spacing, node).iter().zip(alpha.chunks_exact(F)) {
                    (0..3 * F).for_each(|n| fields[3 * (nodes * (n / 3) + node) + n % 3] += r[n % 3] * alpha[n / 3]);
                }
            }
        }
        fields
    }
}

impl CellSource<'_> {
    /// Loads and rows at every unknown of the cell.
    fn columns(&self, interfaces: &[Interface], offsets: &[usize], width: usize, out: &mut [f64]) {
        out.fill(0.0);
        let area = quarter_areas(self.model.grid().spacing);
        for node in 0..self.loads.faces.len() {
            if self.loads.faces[node] != [0.0; 3] {
                let loads: [f64; NODE_COLUMNS] = self.loads.at(node, area);
                (0..NODE_COLUMNS).for_each(|n| out[width * (3 * node + n / F) + n % F] = loads[n]);
            }
        }
        for (interface, first) in interfaces.iter().zip(offsets) {
            for (n, node) in interface.nodes.iter().enumerate() {
                let local = local_node(self.partition, self.cell, *node);
                for (s, row) in interface.rows.iter().enumerate() {
                    (0..3).for_each(|r| out[width * (3 * local + r) + F + first + s] = row[3 * n + r]);
                }
            }
        }
    }

    /// Places of six determinate unknowns of every part.
    fn pins(&self, plan: &FrontalPlan) -> Option<Vec<usize>> {
        let lattice = self.partition.cell_lattice();
        let mut pins = Vec::with_capacity(RIGID * self.solids.parts);
        for part in 0..self.solids.parts {
            let marked: Vec<bool> = (0..lattice.node_count()).map(|n| self.solids.part(n) == Some(part)).collect();
            let held = six_components(lattice, self.model.grid().spacing, &marked)?;
            pins.extend(held.map(|(node, component)| plan.place(node.0) + component));
        }
        Some(pins)
    }

    /// Rigid motions of the cell at a node about its centre, rotations per half of its longest edge.
    fn motions(&self, node: usize) -> [[f64; 3]; RIGID] {
        rigid_motions(self.partition, self.model.grid().spacing, node)
    }

    /// Columnsᵀ R: per column six values per part.
    fn rigid_products(&self, columns: &[f64], width: usize) -> Vec<f64> {
        let motions = RIGID * self.solids.parts;
        let mut products = vec![0.0; width * motions];
        for node in 0..columns.len() / (3 * width) {
            let Some(part) = self.solids.part(node) else { continue };
            let own = &columns[3 * width * node..][..3 * width];
            if own.iter().all(|v| *v == 0.0) {
                continue;
            }
            let r = self.motions(node);
            for column in 0..width {
                let force = [own[column], own[width + column], own[2 * width + column]];
                for (m, r) in r.iter().enumerate() {
                    products[motions * column + RIGID * part + m] +=
                        force[0] * r[0] + force[1] * r[1] + force[2] * r[2];
                }
            }
        }
        products
    }

    /// The largest diagonal entry of a fine cell's stiffness.
    fn stiffest(&self) -> f64 {
        let own = self.partition.cell_box(self.cell);
        let window = Window::new(self.model, own.start, own.cells);
        let of = |c: usize| window.stiffness(c).map_or(0.0, |(factor, matrix)| factor * matrix[0]);
        (0..window.lattice().cell_count()).map(of).fold(f64::MIN_POSITIVE, f64::max)
    }
}

/// Three translations and three rotations about the cell's centre, per half of its longest edge, at a local node.
fn rigid_motions(partition: &Partition, spacing: [f64; 3], node: usize) -> [[f64; 3]; RIGID] {
    let half = partition.degree() as f64 / 2.0;
    let longest = spacing.iter().fold(0.0f64, |m, h| m.max(*h)) * half;
    let at = partition.cell_lattice().node_position(Node(node));
    let [x, y, z] = [0, 1, 2].map(|a| (at[a] as f64 - half) * spacing[a] / longest);
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
}

/// The relation of a cell's multipliers and its interfaces' displacement, on some of its rows: λ = load − stiffness q.
pub(super) struct Condensed {
    /// Which rows.
    pub rows: Vec<usize>,
    /// K̂, rows × rows.
    pub stiffness: Vec<f64>,
    /// ĝ, rows × 6.
    pub load: Vec<f64>,
    /// Six multipliers of every row of the cell: known ones, zero for `rows`.
    pub known: Vec<f64>,
    /// S H⁺ f − F' λ of the known multipliers + ρ G e on `rows`, among all rows × 6.
    pub answer: Vec<f64>,
    /// e − Gᵀ λ of the known multipliers, 6 per part × 6.
    pub resultant: Vec<f64>,
    /// Per rigid motion that is free (Gᵀ F'⁻¹ G)⁻¹ \[Gᵀ F'⁻¹, e\] on the inner rows.
    free: Vec<(usize, Vec<f64>)>,
}

/// Multipliers of every row and rigid motions of every part, six values each.
pub(super) struct CellAnswer {
    pub multipliers: Vec<f64>,
    pub motions: Vec<f64>,
}

impl CellCache {
    /// Takes the known multipliers over to the loads.
    pub(super) fn with_known(&self, known: Vec<f64>, rows: Vec<usize>) -> Condensed {
        let (all, motions) = (self.rows(), RIGID * self.parts);
        let (mut answer, mut resultant) = (self.answer.clone(), self.resultant.clone());
        for s in (0..all).filter(|s| known[F * s..][..F].iter().any(|v| *v != 0.0)) {
            let lambda = &known[F * s..][..F];
            for &r in &rows {
                let f = self.flexibility[all * s + r];
                let answer = &mut answer[F * r..][..F];
                answer.iter_mut().zip(lambda).for_each(|(a, l)| *a -= f * l);
            }
            for (m, e) in resultant.chunks_exact_mut(F).enumerate() {
                let g = self.rigid[motions * s + m];
                (0..F).for_each(|k| e[k] -= g * lambda[k]);
            }
        }
        Condensed { rows, stiffness: Vec::new(), load: Vec::new(), known, answer, resultant, free: Vec::new() }
    }

    /// K̂ = F'⁻¹ − F'⁻¹ G (Gᵀ F'⁻¹ G)⁻¹ Gᵀ F'⁻¹ and ĝ = K̂ (S H⁺ f + ρ G e) + F'⁻¹ G (Gᵀ F'⁻¹ G)⁻¹ e on the rows of `condensed`, with the rigid motions of the parts that do not
    /// hold their group; false where rows are dependent.
    pub(super) fn stiffen(&self, condensed: &mut Condensed, parts: &[(usize, bool)]) -> bool {
        let (all, n, motions) = (self.rows(), condensed.rows.len(), RIGID * self.parts);
        let rows = &condensed.rows;
        let mut k: Vec<f64> = Vec::with_capacity(n * n);
        rows.iter().for_each(|s| k.extend(rows.iter().map(|r| self.flexibility[all * s + r])));
        if !invert(n, &mut k, &mut Vec::new(), self.dependent) {
            return false;
        }
        let free: Vec<usize> = (0..motions).filter(|m| !parts[m / RIGID].1).collect();
        let free_count = free.len();
        // F'⁻¹ G, then Gᵀ F'⁻¹ G and its solutions for [Gᵀ F'⁻¹, e].
        let g = |s: usize, m: usize| self.rigid[motions * rows[s] + free[m]];
        let mut spread = vec![0.0; n * free_count];
        for (row, out) in k.chunks_exact(n.max(1)).zip(spread.chunks_exact_mut(free_count.max(1))) {
            for (s, value) in row.iter().enumerate() {
                (0..free_count).for_each(|m| out[m] += value * g(s, m));
            }
        }
        let columns = n + F;
        let mut matrix = vec![0.0; free_count * free_count];
        let mut right = vec![0.0; free_count * columns];
        for s in 0..n {
            for m in 0..free_count {
                right[columns * m + s] = spread[free_count * s + m];
                (0..free_count).for_each(|l| matrix[free_count * m + l] += g(s, m) * spread[free_count * s + l]);
            }
        }
        for m in 0..free_count {
            right[columns * m + n..][..F].copy_from_slice(&condensed.resultant[F * free[m]..][..F]);
        }
        solve_semidefinite(free_count, &mut matrix, &mut right, columns);
        add_product(n, (&spread, &right), columns, -1.0, &mut k);
        condensed.load = vec![0.0; n * F];
        for s in 0..n {
            let row = &k[n * s..][..n];
            let load = &mut condensed.load[F * s..][..F];
            for m in 0..free_count {
                let (part, factor) = (&right[columns * m + n..][..F], spread[free_count * s + m]);
                load.iter_mut().zip(part).for_each(|(g, p)| *g += factor * p);
            }
            for (value, r) in row.iter().zip(rows) {
                load.iter_mut().zip(&condensed.answer[F * r..][..F]).for_each(|(g, b)| *g += value * b);
            }
        }
        condensed.stiffness = k;
        let of = |(m, motion): (usize, &usize)| (*motion, right[columns * m..][..columns].to_vec());
        condensed.free = free.iter().enumerate().map(of).collect();
        true
    }

    /// K̂ and ĝ as [`CellCache::stiffen`], where neither multipliers nor motions of the cell will be asked for; false where rows are dependent.
    ///
    /// The elimination of λ from F' λ − G α + q = S H⁺ f + ρ G e, Gᵀ λ = e leaves a positive semidefinite system in α and q, that of α leaves K̂ q.
    pub(super) fn condense_rows(
        &self,
        condensed: &mut Condensed,
        parts: &[(usize, bool)],
        [forces, motions]: &mut [DenseFront; 2],
    ) -> bool {
        let (all, n, width) = (self.rows(), condensed.rows.len(), RIGID * self.parts);
        let rows = &condensed.rows;
        let free: Vec<usize> = (0..width).filter(|m| !parts[m / RIGID].1).collect();
        let m = free.len();
        forces.reset(n, m + n, F);
        for (c, &row) in rows.iter().enumerate() {
            let flexibility = &self.flexibility[all * row..][..all];
            let (own, below, load) = forces.pivot_column(c);
            own.iter_mut().zip(&rows[c..]).for_each(|(x, r)| *x = flexibility[*r]);
            below.iter_mut().zip(&free).for_each(|(x, motion)| *x = -self.rigid[width * row + motion]);
            below[m + c] = 1.0;
            load.copy_from_slice(&condensed.answer[F * row..][..F]);
        }
        if forces.eliminate(self.dependent) > 0 {
            return false;
        }
        motions.reset(m, n, F);
        for (c, motion) in free.iter().enumerate() {
            let (from, loads) = forces.boundary_column(c);
            let (own, below, load) = motions.pivot_column(c);
            own.iter_mut().chain(below).zip(from).for_each(|(x, z)| *x = -*z);
            let resultant = &condensed.resultant[F * motion..][..F];
            load.iter_mut().zip(resultant.iter().zip(loads)).for_each(|(x, (e, l))| *x = e - *l);
        }
        for c in 0..n {
            let (from, loads) = forces.boundary_column(m + c);
            let (below, load) = motions.boundary_column(c);
            below.iter_mut().zip(from).for_each(|(x, z)| *x = -*z);
            load.iter_mut().zip(loads).for_each(|(x, l)| *x = -*l);
        }
        motions.eliminate(VANISHING);
        condensed.stiffness.resize(n * n, 0.0);
        condensed.load.resize(n * F, 0.0);
        for c in 0..n {
            let (below, load) = motions.boundary_column(c);
            condensed.load[F * c..][..F].copy_from_slice(load);
            for (r, value) in below.iter().enumerate() {
                condensed.stiffness[n * (c + r) + c] = *value;
                condensed.stiffness[n * c + c + r] = *value;
            }
        }
        true
    }

    /// λ = ĝ − K̂ q on the inner rows, and α = (Gᵀ F'⁻¹ G)⁻¹ (e − Gᵀ F'⁻¹ (S H⁺ f + ρ G e − q)); zero for held parts.
    pub(super) fn answer(&self, condensed: &Condensed, q: &[[f64; 8]]) -> CellAnswer {
        let n = condensed.rows.len();
        let (mut multipliers, mut motions) = (condensed.known.clone(), vec![0.0; RIGID * self.parts * F]);
        for (s, &row) in condensed.rows.iter().enumerate() {
            let out = &mut multipliers[F * row..][..F];
            out.copy_from_slice(&condensed.load[F * s..][..F]);
            for (k, q) in condensed.stiffness[n * s..][..n].iter().zip(q) {
                (0..F).for_each(|c| out[c] -= k * q[c]);
            }
        }
        for (motion, weights) in &condensed.free {
            let out = &mut motions[F * motion..][..F];
            out.copy_from_slice(&weights[n..]);
            for ((weight, q), row) in weights.iter().zip(q).zip(&condensed.rows) {
                let answer = &condensed.answer[F * row..][..F];
                (0..F).for_each(|k| out[k] -= weight * (answer[k] - q[k]));
            }
        }
        CellAnswer { multipliers, motions }
    }
}
