//! The state of a coarse model after its mesh has changed.

use std::collections::BTreeMap;

use super::CoarseMesh;

impl CoarseMesh {
    /// A state of three numbers per vertex of the mesh `old` on the vertices of this one, which has the same partition.
    ///
    /// A vertex takes the state of the vertex that stood at its place and belonged to a part of one of the same coarse cells: the one
    /// whose parts share most fine cells with its own, the first of several. Without such it takes the first one at its place; without any,
    /// which is where material is new, the mean of the known vertices of its elements, spreading from known to unknown; and zero where
    /// nothing is known around.
    ///
    /// # Panics
    /// Panics when the partitions differ or `state` has not three entries per old vertex.
    pub fn carry(&self, old: &Self, state: &[f64]) -> Vec<f64> {
        let same = self.partition() == old.partition() && state.len() == 3 * old.vertices().len();
        assert!(same, "a state of another mesh");
        let mut source = self.first_sources(old);
        for (vertex, candidates) in self.candidates(old) {
            let best = candidates.iter().max_by_key(|(from, shared)| (**shared, std::cmp::Reverse(**from)));
            source[vertex] = best.map(|(from, _)| *from).or(source[vertex]);
        }
        let mut carried = vec![0.0; 3 * source.len()];
        for (vertex, from) in source.iter().enumerate() {
            let Some(from) = *from else { continue };
            carried[3 * vertex..3 * vertex + 3].copy_from_slice(&state[3 * from..3 * from + 3]);
        }
        self.spread(source.iter().map(Option::is_some).collect(), &mut carried);
        carried
    }

    /// Per vertex the first old vertex at its place.
    fn first_sources(&self, old: &Self) -> Vec<Option<usize>> {
        self.vertices().iter().map(|vertex| old.vertices_at(vertex.node).next()).collect()
    }

    /// For vertices with a choice: the old vertices at the place that belonged to the same coarse cells, and how many fine cells their parts share
    /// with the vertex's own.
    fn candidates(&self, old: &Self) -> BTreeMap<usize, BTreeMap<usize, usize>> {
        let mut candidates: BTreeMap<usize, BTreeMap<usize, usize>> = BTreeMap::new();
        for (&element, corners) in self.elements().iter().zip(self.corners()) {
            let nodes = self.partition().corners(element.cell);
            let has_choice = |i: &usize| old.vertices_at(nodes[*i]).len() > 1;
            if !(0..8).any(|i| has_choice(&i)) {
                continue;
            }
            let old_elements = old.elements_of(element.cell);
            let mut shared = vec![0; old_elements.len()];
            for from in self.fine_cells(element).filter_map(|(_, fine)| old.element_at(fine)) {
                shared[from - old_elements.start] += 1;
            }
            for (from, count) in old_elements.zip(shared) {
                for corner in (0..8).filter(has_choice) {
                    let of_vertex = candidates.entry(corners[corner] as usize).or_default();
                    *of_vertex.entry(old.corners()[from][corner] as usize).or_default() += count;
                }
            }
        }
        candidates
    }

    /// Gives vertices that are not `known` the mean of the known vertices of their elements, until nothing changes.
    fn spread(&self, mut known: Vec<bool>, state: &mut [f64]) {
        if known.iter().all(|k| *k) {
            return;
        }
        loop {
            let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
            for corners in self.corners() {
                for &vertex in corners.iter().filter(|v| !known[**v as usize]) {
                    around.entry(vertex).or_default().extend(corners.iter().filter(|v| known[**v as usize]));
                }
            }
            around.retain(|_, neighbours| !neighbours.is_empty());
            if around.is_empty() {
                return;
            }
            for (vertex, mut neighbours) in around {
                neighbours.sort_unstable();
                neighbours.dedup();
                for r in 0..3 {
                    let sum: f64 = neighbours.iter().map(|n| state[3 * *n as usize + r]).sum();
                    state[3 * vertex as usize + r] = sum / neighbours.len() as f64;
                }
                // Its neighbours of this round were known before it, so the order of vertices does not matter.
                known[vertex as usize] = true;
            }
        }
    }
}
