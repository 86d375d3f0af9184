//! Prescribed fine nodes on the coarse model.

use std::collections::{BTreeSet, HashMap};

use super::{CoarseLattice, CoarseModel, EmbeddedPoint, Embedding};
use crate::assembly::Constraints;
use crate::coarsening::COLUMNS;
use crate::element::{CellMatrix, trilinear};
use crate::mesh::{Cell, Node};
use crate::solver::SolverError;

/// Stiffness of the penalty on uncovered fixed nodes, relative to the largest diagonal entry of the cell.
const PENALTY: f64 = 1e4;
/// A fine node is covered when the trilinear weights of fixed corners sum to one within this.
const COVERED: f64 = 1e-9;

/// A trilinear moment of fixed fine nodes in an element, held by a spring of the same stiffness along all axes.
#[derive(Clone, Debug, PartialEq)]
pub struct PenaltyPoint {
    /// The weighted mean of the nodes as the element moves them.
    pub point: EmbeddedPoint,
    /// Stiffness of the spring \[N/m\].
    pub stiffness: f64,
    /// Fine lattice nodes and their weights, which add up to one: the spring pulls to the same mean of their prescribed positions.
    pub nodes: Vec<(u32, f64)>,
}

impl PenaltyPoint {
    fn new(coarse: &CoarseModel, element: usize, nodes: Vec<(u32, f64)>, stiffness: f64) -> Self {
        let weighted: Vec<(Node, f64)> = nodes.iter().map(|(node, weight)| (Node(*node as usize), *weight)).collect();
        Self { point: EmbeddedPoint::in_element(coarse, element, &weighted, 1.0), stiffness, nodes }
    }

    /// Adds the spring to the stiffness of an element that does not rotate.
    fn stiffen(&self, matrix: &mut CellMatrix) {
        for moment in &self.point.functions {
            for (a, b) in (0..COLUMNS * COLUMNS).map(|n| (n / COLUMNS, n % COLUMNS)) {
                matrix[COLUMNS * a + b] += self.stiffness * moment[a] * moment[b];
            }
        }
    }
}

/// A coarse model held where fine nodes are held.
///
/// A vertex is fixed when the fine node at its place is; one whose elements do not touch that node only if the nearest node of
/// each of them is fixed too. Fixed fine nodes that lie on no face, edge or corner between fixed corners are
/// held on average: in each such element a stiff penalty acts on the trilinear moments Σ_j N_i(x_j) W_j ū of those nodes j, for
/// the corners i. On a face between fixed corners trilinear functions hold every fine node; fitted functions let the inner ones
/// move with the far corners of the cell.
#[derive(Clone, Debug)]
pub struct SupportedCoarse<'a> {
    coarse: &'a CoarseModel,
    /// Prescribed components of the vertices.
    pub constraints: Constraints,
    /// Number of fixed fine nodes held by penalty.
    pub held_by_penalty: usize,
    by_penalty: BTreeSet<u32>,
    points: Vec<PenaltyPoint>,
    stiffened: HashMap<usize, CellMatrix>,
}

impl<'a> SupportedCoarse<'a> {
    /// Holds `coarse` where `fixed` marks nodes of the fine lattice, void ones included.
    pub fn new(coarse: &'a CoarseModel, embedding: &Embedding<'_>, fixed: &[bool]) -> Self {
        let mask = held_vertices(coarse, embedding, fixed);
        let constraints = Constraints::nodes(&mask);
        let mut this = Self {
            coarse,
            constraints,
            held_by_penalty: 0,
            by_penalty: BTreeSet::new(),
            points: Vec::new(),
            stiffened: HashMap::new(),
        };
        for index in 0..coarse.elements().len() {
            this.hold_uncovered(index, embedding, (fixed, &mask));
        }
        this.held_by_penalty = this.by_penalty.len();
        this
    }

    fn hold_uncovered(&mut self, index: usize, embedding: &Embedding<'_>, (fixed, mask): (&[bool], &[bool])) {
        let partition = self.coarse.partition();
        let corners = self.coarse.mesh().corners()[index];
        let d = partition.degree() as f64;
        let weights =
            |local: u32| trilinear(partition.cell_lattice().node_position(Node(local as usize)).map(|x| x as f64 / d));
        let covered = |local: u32| {
            let sum: f64 = (0..8).filter(|&i| mask[corners[i] as usize]).map(|i| weights(local)[i]).sum();
            sum >= 1.0 - COVERED
        };
        let is_uncovered = |(local, node): &(u32, u32)| fixed[*node as usize] && !covered(*local);
        let found: Vec<(u32, u32)> = embedding.members(index).iter().copied().filter(is_uncovered).collect();
        let uncovered: Vec<u32> = found.iter().map(|(local, _)| *local).collect();
        if uncovered.is_empty() {
            return;
        }
        self.by_penalty.extend(found.iter().map(|(_, node)| *node));
        let mut stiffness = *self.coarse.stiffness(index);
        let largest = (0..COLUMNS).fold(0.0f64, |m, i| m.max(stiffness[COLUMNS * i + i]));
        for i in 0..8 {
            let total: f64 = uncovered.iter().map(|&local| weights(local)[i]).sum();
            if total <= COVERED {
                continue;
            }
            let weighted = |(local, node): &(u32, u32)| (*node, weights(*local)[i] / total);
            let penalty =
                PenaltyPoint::new(self.coarse, index, found.iter().map(weighted).collect(), PENALTY * largest);
            penalty.stiffen(&mut stiffness);
            self.points.push(penalty);
        }
        self.stiffened.insert(index, stiffness);
    }

    /// The penalties as springs between points that move with elements and the same means of prescribed positions, ordered by element. Elements have
    /// their own stiffness beside them, without the penalty.
    pub fn penalty_points(&self) -> &[PenaltyPoint] {
        &self.points
    }

    /// Stiffness \[N/m\] of element number `index`, with the penalty where there is one.
    pub fn stiffness(&self, index: usize) -> &CellMatrix {
        self.stiffened.get(&index).unwrap_or_else(|| self.coarse.stiffness(index))
    }

    /// The model as a lattice, where its mesh is one.
    pub fn as_lattice(&self) -> Option<CoarseLattice<'_>> {
        let elements = 0..self.coarse.elements().len();
        CoarseLattice::new(self.coarse.mesh(), elements.map(|index| self.stiffness(index)).collect())
    }

    /// Refuses a model with elements that hang together and are held by no vertex and no penalty.
    ///
    /// # Errors
    /// [`SolverError::Unheld`] with the first such part.
    pub fn require_held(&self) -> Result<(), SolverError> {
        let mesh = self.coarse.mesh();
        let smallest = smallest_connected(mesh.vertices().len(), mesh.corners());
        let mut held = vec![false; smallest.len()];
        for (vertex, first) in smallest.iter().enumerate() {
            held[*first as usize] |= !self.constraints.is_free(vertex);
        }
        self.stiffened.keys().for_each(|index| held[smallest[mesh.corners()[*index][0] as usize] as usize] = true);
        let part_of = |index: usize| smallest[mesh.corners()[index][0] as usize];
        let Some(first) = (0..mesh.elements().len()).find(|&index| !held[part_of(index) as usize]) else {
            return Ok(());
        };
        let elements = (0..mesh.elements().len()).filter(|&index| part_of(index) == part_of(first)).count();
        let at = mesh.partition().coarse().cell_position(Cell(mesh.elements()[first].cell.0));
        Err(SolverError::Unheld { elements, at })
    }
}

/// Per vertex the smallest one that elements connect it with.
fn smallest_connected(vertices: usize, corners: &[[u32; 8]]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..vertices as u32).collect();
    let root = |parent: &mut [u32], mut vertex: u32| {
        while parent[vertex as usize] != vertex {
            parent[vertex as usize] = parent[parent[vertex as usize] as usize];
            vertex = parent[vertex as usize];
        }
        vertex
    };
    for element in corners {
        for &vertex in &element[1..] {
            let (a, b) = (root(&mut parent, element[0]), root(&mut parent, vertex));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    (0..vertices as u32).map(|vertex| root(&mut parent, vertex)).collect()
}

/// Which vertices are fixed.
fn held_vertices(coarse: &CoarseModel, embedding: &Embedding<'_>, fixed: &[bool]) -> Vec<bool> {
    let (mesh, partition) = (coarse.mesh(), coarse.partition());
    let mut held: Vec<bool> = mesh.vertices().iter().map(|v| fixed[partition.coincident_node(v.node).0]).collect();
    for (index, corners) in mesh.corners().iter().enumerate() {
        for (vertex, local) in corners.iter().zip(partition.local_corners()) {
            held[*vertex as usize] &= nearest_is_fixed(coarse, embedding.members(index), local, fixed);
        }
    }
    held
}

/// Whether any of the element's own nodes that are nearest (in fine cells) to node `local` of its coarse cell is fixed.
fn nearest_is_fixed(coarse: &CoarseModel, members: &[(u32, u32)], local: usize, fixed: &[bool]) -> bool {
    let lattice = coarse.partition().cell_lattice();
    let corner = lattice.node_position(Node(local));
    let distance = |member: u32| -> usize {
        let at = lattice.node_position(Node(member as usize));
        (0..3).map(|a| at[a].abs_diff(corner[a]).pow(2)).sum()
    };
    let nearest = members.iter().map(|(member, _)| distance(*member)).min();
    members.iter().any(|(member, node)| Some(distance(*member)) == nearest && fixed[*node as usize])
}
