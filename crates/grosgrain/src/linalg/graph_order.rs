//! A fill-reducing order of any graph.

use feral_metis::{CscPattern, MetisOptions, metis_order_full};

use super::postordered;

/// Why a graph was not ordered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphOrderError {
    /// More vertices or edges than a 32-bit index counts.
    #[error("a graph of {vertices} vertices and {entries} neighbours is too large to be ordered; use a smaller mesh")]
    TooLarge {
        /// Number of vertices.
        vertices: usize,
        /// Sum of their numbers of neighbours.
        entries: usize,
    },
    /// The lists of neighbours are not those of a graph.
    #[error("the lists of neighbours of {vertices} vertices are no graph: {reason}")]
    NoGraph {
        /// Number of vertices.
        vertices: usize,
        /// What is wrong.
        reason: String,
    },
}

/// The vertices of a graph in an order in which eliminating them leaves few entries in the factor: nested dissection of the graph by multilevel bisection, minimum degree in small
/// pieces (`karypis1998fast`).
///
/// Vertex v has the neighbours `neighbours[starts[v]..starts[v + 1]]`, ascending, v itself among them or not; of two neighbours each lists the other. The order has the same bits
/// on every machine. A matrix with several unknowns per vertex takes them one after the other; follow with [`postordered`], or call [`clique_order`].
///
/// # Errors
/// Lists that are not ascending or name vertices that do not exist; more than 2³¹ vertices or neighbours.
pub fn graph_order(starts: &[u32], neighbours: &[u32]) -> Result<Vec<u32>, GraphOrderError> {
    let vertices = starts.len().saturating_sub(1);
    let too_large = || GraphOrderError::TooLarge { vertices, entries: neighbours.len() };
    let no_graph = |reason: &str| GraphOrderError::NoGraph { vertices, reason: reason.to_owned() };
    let signed = |list: &[u32]| -> Result<Vec<i32>, GraphOrderError> {
        list.iter().map(|v| i32::try_from(*v).map_err(|_| too_large())).collect()
    };
    let (starts, neighbours) = (signed(starts)?, signed(neighbours)?);
    let pattern = CscPattern::new(vertices, &starts, &neighbours)
        .ok_or_else(|| no_graph("a list does not ascend, or names a vertex that does not exist"))?;
    let order = metis_order_full(&pattern, &MetisOptions::default()).map_err(|error| no_graph(&error.to_string()))?.0;
    Ok(order.into_iter().map(|v| v as u32).collect())
}

/// The vertices of a matrix that couples all vertices of a clique (an element), numbered from 0, in an order for elimination: [`graph_order`], then [`postordered`].
///
/// # Errors
/// Those of [`graph_order`].
///
/// # Panics
/// When a clique names a vertex that does not exist.
pub fn clique_order<const N: usize>(vertices: usize, cliques: &[[u32; N]]) -> Result<Vec<u32>, GraphOrderError> {
    let (starts, neighbours) = graph_of_cliques(vertices, cliques)?;
    Ok(postordered(&graph_order(&starts, &neighbours)?, cliques))
}

/// Neighbours of each vertex by shared cliques, itself left out, in the form that [`graph_order`] takes; a clique may name a vertex twice.
///
/// # Errors
/// More than 2³² neighbours.
///
/// # Panics
/// When a clique names a vertex that does not exist.
pub fn graph_of_cliques<const N: usize>(
    vertices: usize,
    cliques: &[[u32; N]],
) -> Result<(Vec<u32>, Vec<u32>), GraphOrderError> {
    let mut pairs: Vec<(u32, u32)> = Vec::with_capacity(cliques.len() * N * N.saturating_sub(1));
    for clique in cliques {
        pairs.extend(clique.iter().flat_map(|a| clique.iter().map(|b| (*a, *b))).filter(|(a, b)| a != b));
    }
    pairs.sort_unstable();
    pairs.dedup();
    let entries = pairs.len();
    u32::try_from(entries).map_err(|_| GraphOrderError::TooLarge { vertices, entries })?;
    let mut starts = vec![0u32; vertices + 1];
    pairs.iter().for_each(|(a, _)| starts[*a as usize + 1] += 1);
    (0..vertices).for_each(|v| starts[v + 1] += starts[v]);
    Ok((starts, pairs.into_iter().map(|(_, b)| b).collect()))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::linalg::{SparsePattern, SymbolicCholesky};

    /// Neighbours of the nodes of a box that is cut into six tetrahedra per cube, nodes shuffled by a fixed stride.
    fn tetrahedra(cubes: [usize; 3]) -> (Vec<u32>, Vec<u32>) {
        let counts = cubes.map(|n| n + 1);
        let total: usize = counts.iter().product();
        let name = |n: usize| (n * 7919 % total) as u32;
        let mut lists = vec![Vec::new(); total];
        for n in 0..total {
            let at = [n % counts[0], n / counts[0] % counts[1], n / (counts[0] * counts[1])];
            for other in 1..8 {
                // Edges of the six tetrahedra around the diagonal of a cube: all sums of axes.
                let to: [usize; 3] = std::array::from_fn(|a| at[a] + (other >> a & 1));
                if (0..3).all(|a| to[a] < counts[a]) {
                    let m = to[0] + counts[0] * (to[1] + counts[1] * to[2]);
                    lists[name(n) as usize].push(name(m));
                    lists[name(m) as usize].push(name(n));
                }
            }
        }
        lists.iter_mut().for_each(|list: &mut Vec<u32>| list.sort_unstable());
        let mut starts = vec![0];
        lists.iter().for_each(|list| starts.push(starts.last().unwrap_or(&0) + list.len() as u32));
        (starts, lists.concat())
    }

    /// Entries of the factor and operations of the elimination in this order.
    fn cost(order: &[u32], starts: &[u32], neighbours: &[u32]) -> (usize, f64) {
        let mut rank = vec![0u32; order.len()];
        order.iter().enumerate().for_each(|(r, v)| rank[*v as usize] = r as u32);
        let (mut column_starts, mut rows) = (vec![0], Vec::new());
        for v in order.iter().map(|v| *v as usize) {
            let first = rows.len();
            rows.push(rank[v]);
            let list = &neighbours[starts[v] as usize..starts[v + 1] as usize];
            rows.extend(list.iter().map(|n| rank[*n as usize]).filter(|r| *r > rank[v]));
            rows[first..].sort_unstable();
            column_starts.push(rows.len() as u32);
        }
        let symbolic = SymbolicCholesky::analyse(Arc::new(SparsePattern { column_starts, rows })).unwrap();
        (symbolic.factor_entries(), symbolic.factor_flops())
    }

    #[test]
    fn the_factor_of_a_mesh_is_far_smaller_than_in_other_orders() {
        let (starts, neighbours) = tetrahedra([24, 20, 22]);
        let n = starts.len() - 1;
        let order = graph_order(&starts, &neighbours).unwrap();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, v)| i == *v as usize) && sorted.len() == n, "every vertex once");
        assert_eq!(graph_order(&starts, &neighbours).unwrap(), order, "the same at every call");
        // Slice by slice, the best banded order of a box.
        let slices: Vec<u32> = (0..n).map(|m| (m * 7919 % n) as u32).collect();
        let geometric = crate::linalg::nested_dissection([25, 21, 23]);
        let geometric: Vec<u32> = geometric.iter().map(|m| (*m as usize * 7919 % n) as u32).collect();
        let [(own, flops), (banded, _), (dissected, dissected_flops)] =
            [&order, &slices, &geometric].map(|order| cost(order, &starts, &neighbours));
        let by_degree = minimum_degree(&starts, &neighbours);
        let (amd, amd_flops) = cost(&by_degree, &starts, &neighbours);
        println!("entries {own}, banded {banded}, geometric {dissected}, degree {amd}");
        println!("flops {flops:.3e}, geometric {dissected_flops:.3e}, degree {amd_flops:.3e}");
        assert!(2 * own < banded, "{own} entries, {banded} in slices");
        assert!(flops < 0.6 * amd_flops, "{flops:e} operations, {amd_flops:e} by minimum degree");
        assert!((own as f64) < 1.15 * dissected as f64, "{own} entries, {dissected} by planes");
    }

    /// Approximate minimum degree, as faer has it.
    fn minimum_degree(starts: &[u32], rows: &[u32]) -> Vec<u32> {
        use faer::dyn_stack::{MemBuffer, MemStack};
        use faer::sparse::SymbolicSparseColMatRef;
        use faer::sparse::linalg::amd;
        let n = starts.len() - 1;
        let matrix = SymbolicSparseColMatRef::new_checked(n, n, starts, None, rows);
        let (mut order, mut inverse) = (vec![0u32; n], vec![0u32; n]);
        let mut memory = MemBuffer::new(amd::order_scratch::<u32>(n, rows.len()));
        let control = amd::Control::default();
        amd::order(&mut order, &mut inverse, matrix, control, MemStack::new(&mut memory)).unwrap();
        order
    }

    #[test]
    fn cliques_become_lists_of_neighbours_and_their_order_keeps_the_fill() {
        let (starts, neighbours) = graph_of_cliques(5, &[[0, 3, 1], [1, 3, 3], [2, 1, 2]]).unwrap();
        assert_eq!(
            (starts.as_slice(), neighbours.as_slice()),
            (&[0, 2, 5, 6, 8, 8][..], &[1, 3, 0, 2, 3, 1, 0, 1][..])
        );
        let side = 30;
        let cliques: Vec<[u32; 3]> = (0..side * (side + 1) - 1).map(|n| [n, n + 1, n + side]).collect();
        let (starts, neighbours) = graph_of_cliques(1000, &cliques).unwrap();
        let [order, postordered] = [graph_order(&starts, &neighbours), clique_order(1000, &cliques)];
        let [order, postordered] = [order.unwrap(), postordered.unwrap()];
        assert_ne!(order, postordered);
        let natural: Vec<u32> = (0..1000).collect();
        let [natural, order, postordered] =
            [&natural, &order, &postordered].map(|order| cost(order, &starts, &neighbours).0);
        assert_eq!(postordered, order, "entries");
        assert!(4 * postordered < 3 * natural, "{postordered} entries, {natural} in the natural order of a strip");
    }

    #[test]
    fn lists_that_are_no_graph_are_refused() {
        for (starts, neighbours) in [(vec![0, 1, 2], vec![1, 2]), (vec![0, 2, 3, 4], vec![2, 1, 0, 0])] {
            assert!(matches!(graph_order(&starts, &neighbours), Err(GraphOrderError::NoGraph { .. })));
        }
        assert_eq!(graph_order(&[0], &[]).unwrap(), Vec::<u32>::new());
        assert_eq!(graph_order(&[0, 0], &[]).unwrap(), [0]);
    }
}
