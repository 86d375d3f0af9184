//! Numerical elimination and substitution.

use std::sync::Arc;

use super::front::Elimination;
use super::plan::{Child, Front, FrontalPlan, TILE};

/// What an elimination found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Eliminated {
    /// Pivots that vanished or were pinned.
    pub skipped: usize,
}

/// Eliminates systems of one shape; buffers are kept from one to the next.
///
/// The system is K u = f with K = Σ_e K_e positive semidefinite. Its loads are rows that are eliminated along:
/// with K = L Lᵀ they become (L⁻¹ f)ᵀ, see [`FrontalSolver::forward`]. Of two loads f and g the product (L⁻¹ f)·(L⁻¹ g) is f·K⁺ g.
#[derive(Debug)]
pub struct FrontalSolver {
    plan: Arc<FrontalPlan>,
    extra: usize,
    front: Vec<f64>,
    panel: Vec<f64>,
    slots: Vec<Vec<f64>>,
    scale: Vec<f64>,
    local: Vec<f64>,
    result: FrontalFactors,
}

/// What an elimination leaves: the loads after elimination and the factors of the last groups.
///
/// Without the workspace of a solver, so that many systems of one shape are kept and share the workspace of one
/// ([`FrontalSolver::exchange`]).
#[derive(Clone, Debug)]
pub struct FrontalFactors {
    plan: Arc<FrontalPlan>,
    extra: usize,
    kept: usize,
    /// Per kept front its pivots' columns, without the extra rows.
    factors: Vec<Vec<f64>>,
    inverse: Vec<f64>,
    forward: Vec<f64>,
}

/// Columns of a substitution backwards, one vector register.
const LANES: usize = 8;

impl FrontalSolver {
    /// A solver for systems with `extra` loads; the factors of the last `kept_groups` groups are kept for the substitution backwards.
    pub fn new(plan: Arc<FrontalPlan>, extra: usize, kept_groups: usize) -> Self {
        let size = |f: &Front| f.stride(extra) * f.padded_columns();
        let panel = |f: &Front| f.stride(extra) * f.padded;
        Self {
            extra,
            front: vec![0.0; plan.fronts.iter().map(size).max().unwrap_or(0)],
            panel: vec![0.0; plan.fronts.iter().map(panel).max().unwrap_or(0)],
            slots: plan.slots.iter().map(|n| vec![0.0; n * (n + extra)]).collect(),
            scale: vec![0.0; plan.order()],
            local: Vec::new(),
            result: FrontalFactors::new(plan.clone(), extra, kept_groups),
            plan,
        }
    }

    /// Swaps the result of the last elimination against `other`, whose place the next elimination takes.
    ///
    /// # Panics
    /// Panics when `other` was made for another number of loads or of groups, or for a plan of another size.
    pub fn exchange(&mut self, other: &mut FrontalFactors) {
        let size = |f: &FrontalFactors| (f.extra, f.kept, f.plan.order());
        assert_eq!(size(&self.result), size(other), "factors of the same loads, groups and plan");
        std::mem::swap(&mut self.result, other);
    }

    /// The plan.
    pub fn plan(&self) -> &Arc<FrontalPlan> {
        &self.plan
    }

    /// Eliminates all unknowns. `element(e)` gives a factor and the matrix of element e (row-major, symmetric, nodes in the
    /// order of the plan), `None` if it is absent; `load(node, values)` writes the loads of a node: `extra` values for each of its unknowns.
    /// The unknowns at the places `pinned` are skipped whatever their pivot: six determinate ones hold a floating part.
    ///
    /// # Panics
    /// Panics when a matrix is too short or a place does not exist.
    pub fn eliminate<'m>(
        &mut self,
        element: &dyn Fn(usize) -> Option<(f64, &'m [f64])>,
        load: &mut dyn FnMut(usize, &mut [f64]),
        pinned: &[usize],
    ) -> Eliminated {
        let plan = self.plan.clone();
        self.measure_diagonal(&plan, element);
        pinned.iter().for_each(|place| self.scale[*place] = f64::INFINITY);
        for node in 0..plan.position.len() {
            let place = plan.place(node);
            let size = plan.block * self.extra;
            load(node, &mut self.result.forward[place * self.extra..][..size]);
        }
        let mut skipped = 0;
        let first_kept = plan.fronts.len() - self.result.kept;
        for (f, front) in plan.fronts.iter().enumerate() {
            self.assemble(&plan, front, element);
            skipped += self.eliminate_front(front);
            self.store(front, f.checked_sub(first_kept));
        }
        Eliminated { skipped }
    }

    fn measure_diagonal<'m>(&mut self, plan: &FrontalPlan, element: &dyn Fn(usize) -> Option<(f64, &'m [f64])>) {
        self.scale.fill(0.0);
        let b = plan.block;
        for front in &plan.fronts {
            for &e in &front.elements {
                let Some((factor, matrix)) = element(e as usize) else { continue };
                let rows = &plan.element_rows[e as usize];
                let size = b * rows.len();
                for (a, &row) in rows.iter().enumerate() {
                    for r in 0..b {
                        let diagonal = factor * matrix[(b * a + r) * (size + 1)];
                        self.scale[position_of(front, row as usize + r)] += diagonal;
                    }
                }
            }
        }
    }

    fn assemble<'m>(&mut self, plan: &FrontalPlan, front: &Front, element: &dyn Fn(usize) -> Option<(f64, &'m [f64])>) {
        let (stride, extra) = (front.stride(self.extra), self.extra);
        for c in 0..front.padded_columns() {
            self.front[stride * c + c / TILE * TILE..stride * (c + 1)].fill(0.0);
        }
        for c in 0..front.pivots {
            let loads = &self.result.forward[(front.first + c) * extra..][..extra];
            self.front[stride * c + front.columns()..][..extra].copy_from_slice(loads);
        }
        for &e in &front.elements {
            let Some((factor, matrix)) = element(e as usize) else { continue };
            let rows = &plan.element_rows[e as usize];
            match plan.block {
                3 => add_element::<3>(&mut self.front, stride, rows, factor, matrix),
                9 => add_element::<9>(&mut self.front, stride, rows, factor, matrix),
                block => add_element_of(&mut self.front, (stride, block), rows, factor, matrix),
            }
        }
        for child in &front.children {
            let from = &plan.fronts[child.front as usize];
            let shape = (stride, front.columns(), from.boundary, extra);
            let (target, source) = (&mut self.front, &self.slots[from.slot]);
            pulp::Arch::new().dispatch(|| add_contribution(target, source, child, shape));
        }
    }

    fn eliminate_front(&mut self, front: &Front) -> usize {
        let stride = front.stride(self.extra);
        let mut skipped = 0;
        self.local.resize(front.padded, 0.0);
        pulp::Arch::new().dispatch(Elimination {
            front: &mut self.front,
            panel: &mut self.panel,
            stride,
            rows: front.columns() + self.extra,
            pivots: front.pivots,
            padded: front.padded,
            padded_columns: front.padded_columns(),
            scale: &self.scale[front.first..front.first + front.pivots],
            inverse: &mut self.local,
            skipped: &mut skipped,
        });
        self.result.inverse[front.first..][..front.pivots].copy_from_slice(&self.local[..front.pivots]);
        skipped
    }

    fn store(&mut self, front: &Front, kept: Option<usize>) {
        let (stride, extra) = (front.stride(self.extra), self.extra);
        for c in 0..front.pivots {
            let rows = &self.front[stride * c + front.columns()..][..extra];
            self.result.forward[(front.first + c) * extra..][..extra].copy_from_slice(rows);
        }
        if let Some(kept) = kept {
            let columns = self.result.factors[kept].chunks_exact_mut(front.columns().max(1));
            for (column, from) in columns.zip(self.front.chunks_exact(stride)) {
                column.copy_from_slice(&from[..front.columns()]);
            }
        }
        if front.boundary > 0 {
            let height = front.boundary + extra;
            let slot = &mut self.slots[front.slot];
            for c in 0..front.boundary {
                let column = &self.front[stride * (front.padded + c) + front.padded + c..][..height - c];
                slot[height * c + c..height * (c + 1)].copy_from_slice(column);
            }
        }
    }

    /// [`FrontalFactors::forward`] of the last elimination.
    pub fn forward(&self) -> &[f64] {
        self.result.forward()
    }

    /// [`FrontalFactors::substitute_back`] with the last elimination's factors.
    ///
    /// # Panics
    /// Panics when `y` does not hold eight values per unknown.
    pub fn substitute_back(&self, y: &mut [[f64; LANES]]) {
        self.result.substitute_back(y);
    }
}

impl FrontalFactors {
    /// Room for the result of an elimination with `extra` loads that keeps the factors of the last `kept_groups` groups.
    pub fn new(plan: Arc<FrontalPlan>, extra: usize, kept_groups: usize) -> Self {
        let kept = kept_groups.min(plan.fronts.len());
        let order = plan.order();
        let room = |f: &Front| vec![0.0; f.columns() * f.pivots];
        Self {
            extra,
            kept,
            factors: plan.fronts[plan.fronts.len() - kept..].iter().map(room).collect(),
            inverse: vec![0.0; order],
            forward: vec![0.0; order * extra],
            plan,
        }
    }

    /// Bytes of the numbers held.
    pub fn bytes(&self) -> usize {
        let factors: usize = self.factors.iter().map(Vec::len).sum();
        size_of::<f64>() * (factors + self.inverse.len() + self.forward.len())
    }

    /// The loads after elimination, L⁻¹ f: `extra` values for each unknown in elimination order ([`FrontalPlan::place`]); zero for skipped pivots.
    pub fn forward(&self) -> &[f64] {
        &self.forward
    }

    /// Solves Lᵀ u = y backwards through the kept groups, in place: eight columns per unknown in elimination order, of which only the
    /// unknowns of the kept groups are read and written. At a skipped pivot y is the value that the unknown takes.
    ///
    /// # Panics
    /// Panics when `y` does not hold eight values per unknown.
    pub fn substitute_back(&self, y: &mut [[f64; LANES]]) {
        let plan = &self.plan;
        assert_eq!(y.len(), plan.order(), "eight values per unknown");
        let first_kept = plan.fronts.len() - self.kept;
        let mut boundary = Vec::new();
        for (front, factor) in plan.fronts[first_kept..].iter().zip(&self.factors).rev() {
            let stride = front.columns();
            boundary.clear();
            boundary.extend(front.rows.iter().map(|row| y[*row as usize]));
            let pivots = &mut y[front.first..][..front.pivots];
            for c in (0..front.pivots).rev() {
                let inverse = self.inverse[front.first + c];
                if inverse == 0.0 {
                    continue;
                }
                let column = &factor[stride * c..][..front.columns()];
                let mut sum = weighted(&column[c + 1..front.pivots], &pivots[c + 1..]);
                let rest = weighted(&column[front.padded..], &boundary);
                for (k, s) in sum.iter_mut().enumerate() {
                    *s = (pivots[c][k] - *s - rest[k]) * inverse;
                }
                pivots[c] = sum;
            }
        }
    }
}

/// Σ_i factor_i row_i.
fn weighted(factors: &[f64], rows: &[[f64; LANES]]) -> [f64; LANES] {
    struct Sum<'a>(&'a [f64], &'a [[f64; LANES]]);
    impl pulp::WithSimd for Sum<'_> {
        type Output = [f64; LANES];
        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _: S) -> [f64; LANES] {
            let mut sums = [[0.0; LANES]; 4];
            for (factors, rows) in self.0.chunks(4).zip(self.1.chunks(4)) {
                for ((factor, row), sum) in factors.iter().zip(rows).zip(&mut sums) {
                    (0..LANES).for_each(|k| sum[k] = factor.mul_add(row[k], sum[k]));
                }
            }
            std::array::from_fn(|k| sums[0][k] + sums[1][k] + (sums[2][k] + sums[3][k]))
        }
    }
    pulp::Arch::new().dispatch(Sum(factors, rows))
}

/// Elimination position of a row of a front.
fn position_of(front: &Front, row: usize) -> usize {
    if row < front.padded { front.first + row } else { front.rows[row - front.padded] as usize }
}

fn add_element<const B: usize>(front: &mut [f64], stride: usize, rows: &[u32], factor: f64, matrix: &[f64]) {
    let size = B * rows.len();
    for (a, &column) in rows.iter().enumerate() {
        for c in 0..B {
            let (from, _) = matrix[(B * a + c) * size..][..size].as_chunks::<B>();
            let to = &mut front[stride * (column as usize + c)..][..stride];
            for (&row, from) in rows.iter().zip(from).filter(|(row, _)| **row >= column) {
                to[row as usize..][..B].iter_mut().zip(from).for_each(|(t, k)| *t += factor * k);
            }
        }
    }
}

fn add_element_of(front: &mut [f64], (stride, block): (usize, usize), rows: &[u32], factor: f64, matrix: &[f64]) {
    let size = block * rows.len();
    for (a, &column) in rows.iter().enumerate() {
        for c in 0..block {
            let from = matrix[(block * a + c) * size..][..size].chunks_exact(block);
            let to = &mut front[stride * (column as usize + c)..][..stride];
            for (&row, from) in rows.iter().zip(from).filter(|(row, _)| **row >= column) {
                to[row as usize..][..block].iter_mut().zip(from).for_each(|(t, k)| *t += factor * k);
            }
        }
    }
}

/// Adds the lower triangle and the extra rows of a contribution, run by run.
#[inline(always)]
fn add_contribution(
    front: &mut [f64],
    source: &[f64],
    child: &Child,
    (stride, extra_row, boundary, extra): (usize, usize, usize, usize),
) {
    let height = boundary + extra;
    for (index, &(first, place, length)) in child.runs.iter().enumerate() {
        let (first, place, length) = (first as usize, place as usize, length as usize);
        for c in 0..length {
            let column = &source[height * (first + c)..][..height];
            let target = &mut front[stride * (place + c)..][..stride];
            // The part of this run below the diagonal, then the later runs and the extra rows.
            add(&mut target[place + c..place + length], &column[first + c..first + length]);
            for &(row, place, length) in &child.runs[index + 1..] {
                let (row, place, length) = (row as usize, place as usize, length as usize);
                add(&mut target[place..place + length], &column[row..row + length]);
            }
            add(&mut target[extra_row..extra_row + extra], &column[boundary..]);
        }
    }
}

#[inline(always)]
fn add(target: &mut [f64], source: &[f64]) {
    target.iter_mut().zip(source).for_each(|(t, s)| *t += s);
}
