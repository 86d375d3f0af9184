//! Harmonic displacements of one cell of a box: the box is eliminated from outside in, only the cell is substituted backwards.

use std::sync::Arc;

use super::rigid::remove_rigid_motion;
use crate::assembly::CellStiffness;
use crate::element::CellMatrix;
use crate::fine::HARMONIC_FIELDS;
use crate::linalg::{FrontalPlan, FrontalPlanError, FrontalSolver, box_tree, box_tree_around};
use crate::mesh::{Cell, Components, Lattice, Neighbourhood, Node, hull};
use crate::solver::six_components;

/// Where the wanted cell lies in the box whose harmonic displacements are asked for: numbers of fine cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct CondensedShape {
    /// Fine cells of the box along x, y, z.
    pub cells: [usize; 3],
    /// First fine cell of the wanted coarse cell in the box.
    pub core: [usize; 3],
    /// Coarsening degree.
    pub degree: usize,
}

/// The symbolic elimination of one shape.
#[derive(Debug)]
pub(super) struct CondensedPlan {
    pub shape: CondensedShape,
    plan: Arc<FrontalPlan>,
    kept: usize,
    /// Nodes of the wanted cell, x fastest, in the box's lattice.
    core_nodes: Vec<Node>,
}

impl CondensedPlan {
    pub(super) fn new(shape: CondensedShape) -> Result<Self, FrontalPlanError> {
        let lattice = Lattice::new(shape.cells);
        let corners = |c: usize| lattice.corners(Cell(c)).map(|n| n.0 as u32).to_vec();
        let elements: Vec<Vec<u32>> = (0..lattice.cell_count()).map(corners).collect();
        let high = shape.core.map(|x| x + shape.degree + 1);
        let local = Lattice::new([shape.degree; 3]);
        let nodes = shape.cells.map(|n| n + 1);
        let alone = shape.cells == [shape.degree; 3];
        let groups = if alone { box_tree(nodes) } else { box_tree_around(nodes, shape.core, high) };
        let (mut kept, mut wanted) = (0, 0);
        while wanted < local.node_count() {
            kept += 1;
            wanted += groups[groups.len() - kept].len();
        }
        let core_nodes = (0..local.node_count()).map(|n| {
            let at = local.node_position(Node(n));
            lattice.node(std::array::from_fn(|a| shape.core[a] + at[a]))
        });
        let core_nodes = core_nodes.collect();
        let plan = FrontalPlan::new(lattice.node_count(), 3, &elements, &groups)?;
        Ok(Self { shape, plan: Arc::new(plan), kept, core_nodes })
    }

    /// The symbolic elimination.
    pub(super) fn frontal(&self) -> &FrontalPlan {
        &self.plan
    }
}

/// Buffers of one shape, used again for every cell.
#[derive(Debug)]
pub(super) struct CondensedSolver {
    plan: Arc<CondensedPlan>,
    solver: FrontalSolver,
    void: Vec<bool>,
    /// Per node the integrals of the gradients of its shape function, in units of a quarter of a voxel's faces.
    faces: Vec<[i8; 3]>,
    values: Vec<[f64; 8]>,
}

/// The wanted cell's nodes: which touch a solid cell of the box, and the six displacements one after the other.
pub(super) struct CoreDisplacements {
    pub active: Vec<bool>,
    pub fields: Vec<f64>,
}

impl CondensedSolver {
    pub(super) fn new(plan: Arc<CondensedPlan>) -> Self {
        let lattice = Lattice::new(plan.shape.cells);
        Self {
            solver: FrontalSolver::new(plan.plan.clone(), HARMONIC_FIELDS, plan.kept),
            void: vec![false; lattice.cell_count()],
            faces: vec![[0; 3]; lattice.node_count()],
            values: vec![[0.0; 8]; 3 * lattice.node_count()],
            plan,
        }
    }

    /// The harmonic displacements of the box in the wanted cell, up to rigid motions of each part; `None` where parts of the box hang
    /// together by an edge or a node, or where double precision does not tell the softest motion from none: a shifted
    /// and refined solve is needed there.
    pub(super) fn solve(&mut self, cells: &dyn CellStiffness, spacing: [f64; 3]) -> Option<CoreDisplacements> {
        let lattice = cells.lattice();
        let matrices: Vec<Option<(f64, &CellMatrix)>> = (0..lattice.cell_count()).map(|c| cells.stiffness(c)).collect();
        self.void.iter_mut().zip(&matrices).for_each(|(void, m)| *void = m.is_none());
        let solid = self.void.iter().all(|v| !v);
        let hull = if solid { None } else { Some(hull(&self.void, &lattice)) };
        let active = self.active_nodes(&lattice);
        let part_of = if solid { None } else { Some(self.parts(&lattice)?) };
        let pinned = self.pins(&lattice, spacing, part_of.as_deref())?;
        self.measure_faces(&lattice, hull.as_deref());
        let area: [f64; 3] = std::array::from_fn(|a| spacing[(a + 1) % 3] * spacing[(a + 2) % 3] / 4.0);
        let faces = &self.faces;
        let found = self.solver.eliminate(
            &|e| matrices[e].map(|(factor, matrix)| (factor, matrix.as_slice())),
            &mut |node, out| node_loads(faces[node].map(f64::from), area, out),
            &pinned,
        );
        let free = 3 * active.iter().filter(|a| !**a).count();
        if found.skipped != free + pinned.len() {
            return None;
        }
        self.substitute();
        let plan = self.plan.clone();
        let core: Vec<bool> = plan.core_nodes.iter().map(|n| active[n.0]).collect();
        let mut fields = vec![0.0; 3 * HARMONIC_FIELDS * core.len()];
        for (local, node) in plan.core_nodes.iter().enumerate() {
            let place = plan.plan.place(node.0);
            for r in 0..3 {
                (0..HARMONIC_FIELDS).for_each(|k| fields[3 * (core.len() * k + local) + r] = self.values[place + r][k]);
            }
        }
        if let Some(part_of) = part_of.filter(|_| pinned.len() > 6) {
            self.centre_parts(&part_of, spacing, &mut fields);
        }
        fields.iter().all(|u| u.is_finite()).then_some(CoreDisplacements { active: core, fields })
    }

    /// The part of every node, `None` where no solid cell touches it; nothing if parts hang together by edges or nodes.
    fn parts(&self, lattice: &Lattice) -> Option<Vec<Option<usize>>> {
        let components = Components::new(&self.void, lattice, Neighbourhood::Nodes);
        if components.count() != Components::new(&self.void, lattice, Neighbourhood::Faces).count() {
            return None;
        }
        let mut part_of = vec![None; lattice.node_count()];
        for cell in (0..self.void.len()).map(Cell) {
            if let Some(part) = components.of(cell) {
                lattice.corners(cell).iter().for_each(|n| part_of[n.0] = Some(part));
            }
        }
        Some(part_of)
    }

    /// Six determinate unknowns of every part, in the wanted cell where it holds enough of the part.
    fn pins(&self, lattice: &Lattice, spacing: [f64; 3], part_of: Option<&[Option<usize>]>) -> Option<Vec<usize>> {
        let local = Lattice::new([self.plan.shape.degree; 3]);
        let place = |(node, component): (Node, usize)| self.plan.plan.place(node.0) + component;
        let in_core = |(node, component): (Node, usize)| place((self.plan.core_nodes[node.0], component));
        let Some(part_of) = part_of else {
            return Some(six_components(local, spacing, &vec![true; local.node_count()])?.map(in_core).to_vec());
        };
        let mut pins = Vec::new();
        for part in (0..part_count(part_of)).map(Some) {
            let here: Vec<bool> = self.plan.core_nodes.iter().map(|n| part_of[n.0] == part).collect();
            let held = six_components(local, spacing, &here).map(|held| held.map(in_core));
            let anywhere = || {
                let here: Vec<bool> = part_of.iter().map(|p| *p == part).collect();
                six_components(*lattice, spacing, &here).map(|held| held.map(place))
            };
            pins.extend(held.or_else(anywhere)?);
        }
        Some(pins)
    }

    /// Parts of the box move independently: takes the rigid motion of each out of the wanted cell, so that it does not depend on the pins.
    fn centre_parts(&self, part_of: &[Option<usize>], spacing: [f64; 3], fields: &mut [f64]) {
        let local = Lattice::new([self.plan.shape.degree; 3]);
        for part in (0..part_count(part_of)).map(Some) {
            let here: Vec<bool> = self.plan.core_nodes.iter().map(|n| part_of[n.0] == part).collect();
            for column in fields.chunks_exact_mut(3 * here.len()) {
                remove_rigid_motion(local, spacing, &here, column);
            }
        }
    }

    fn active_nodes(&self, lattice: &Lattice) -> Vec<bool> {
        let mut active = vec![false; lattice.node_count()];
        for cell in (0..self.void.len()).filter(|&c| !self.void[c]) {
            lattice.corners(Cell(cell)).iter().for_each(|n| active[n.0] = true);
        }
        active
    }

    /// ∫ ∂N_n/∂x_β over the hull is a whole number of quarters of a face; inside they cancel exactly.
    fn measure_faces(&mut self, lattice: &Lattice, hull: Option<&[bool]>) {
        self.faces.fill([0; 3]);
        for cell in (0..self.void.len()).filter(|&c| hull.is_none_or(|h| h[c])) {
            for (a, node) in lattice.corners(Cell(cell)).iter().enumerate() {
                (0..3).for_each(|axis| self.faces[node.0][axis] += if a >> axis & 1 == 1 { 1 } else { -1 });
            }
        }
    }

    fn substitute(&mut self) {
        let forward = self.solver.forward().chunks_exact(HARMONIC_FIELDS);
        self.values.iter_mut().zip(forward).for_each(|(y, f)| y[..HARMONIC_FIELDS].copy_from_slice(f));
        self.solver.substitute_back(&mut self.values);
    }
}

fn part_count(part_of: &[Option<usize>]) -> usize {
    part_of.iter().flatten().max().map_or(0, |p| p + 1)
}

/// Loads of the six constant stresses ½(e_α⊗e_β + e_β⊗e_α) at a node whose shape function has the gradient integrals `faces`·`area`.
pub(super) fn node_loads(faces: [f64; 3], area: [f64; 3], out: &mut [f64]) {
    let g: [f64; 3] = std::array::from_fn(|a| faces[a] * area[a]);
    out.fill(0.0);
    for (field, (alpha, beta)) in [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)].into_iter().enumerate() {
        out[HARMONIC_FIELDS * alpha + field] += 0.5 * g[beta];
        out[HARMONIC_FIELDS * beta + field] += 0.5 * g[alpha];
    }
}
