//! Fill-reducing orders.

/// Boxes of at most this many nodes are not split any further.
const LEAF: usize = 6;

/// Geometric nested dissection of a box of `nodes` along x, y, z: the order in which to eliminate the
/// nodes (indices x fastest).
///
/// The longest axis is split by a plane of nodes that is eliminated after both halves
/// (George 1973, `george1973nested`); a cube of n nodes then needs O(n²) operations and O(n^{4/3}) entries.
pub fn nested_dissection(nodes: [usize; 3]) -> Vec<u32> {
    let mut order = Vec::with_capacity(nodes.iter().product());
    dissect(nodes, [0; 3], nodes, &mut order);
    order
}

fn dissect(nodes: [usize; 3], low: [usize; 3], high: [usize; 3], order: &mut Vec<u32>) {
    let size: [usize; 3] = std::array::from_fn(|a| high[a] - low[a]);
    let axis = (0..3).fold(0, |best, a| if size[a] > size[best] { a } else { best });
    if size[axis] < 3 || size.iter().product::<usize>() <= LEAF {
        return list(nodes, low, high, order);
    }
    let plane = low[axis] + size[axis] / 2;
    let with = |mut corner: [usize; 3], at: usize| {
        corner[axis] = at;
        corner
    };
    dissect(nodes, low, with(high, plane), order);
    dissect(nodes, with(low, plane + 1), high, order);
    // A separator becomes one dense front; its own order is free.
    list(nodes, with(low, plane), with(high, plane + 1), order);
}

fn list(nodes: [usize; 3], low: [usize; 3], high: [usize; 3], order: &mut Vec<u32>) {
    for k in low[2]..high[2] {
        for j in low[1]..high[1] {
            order.extend((low[0]..high[0]).map(|i| (i + nodes[0] * (j + nodes[1] * k)) as u32));
        }
    }
}

/// The same elimination with columns of one pattern side by side: `order` by a postorder of its elimination tree, for a matrix that
/// couples all vertices of a `clique` (an element).
///
/// The factor keeps its entries and operations, but a vertex follows the last of those that wait for it, so that separators that a cut has
/// split into two interleaved sides become two wide supernodes again instead of many narrow ones. The tree is found as that of AᵀA by its rows
/// (Liu 1990, `liu1990role`), in nearly linear time.
///
/// # Panics
/// Panics when a vertex of a clique is not in `order`.
pub fn postordered<const N: usize>(order: &[u32], cliques: &[[u32; N]]) -> Vec<u32> {
    let parents = elimination_tree(order, cliques);
    let mut children = vec![Vec::new(); order.len()];
    let mut stack = Vec::new();
    for (rank, parent) in parents.iter().enumerate().rev() {
        match parent {
            Some(parent) => children[*parent as usize].push(rank as u32),
            None => stack.push(rank as u32),
        }
    }
    // Children were pushed from the last to the first, so the first is on top of the stack. Parents come before children here, last child first;
    // reversed, it is a postorder.
    stack.reverse();
    let mut reversed = Vec::with_capacity(order.len());
    while let Some(rank) = stack.pop() {
        reversed.push(order[rank as usize]);
        stack.extend(children[rank as usize].iter().rev());
    }
    reversed.reverse();
    reversed
}

/// The rank of the parent of each rank.
fn elimination_tree<const N: usize>(order: &[u32], cliques: &[[u32; N]]) -> Vec<Option<u32>> {
    let mut rank = vec![0u32; order.len()];
    order.iter().enumerate().for_each(|(r, v)| rank[*v as usize] = r as u32);
    let mut members: Vec<(u32, u32)> =
        (0..).zip(cliques).flat_map(|(c, clique)| clique.map(|v| (rank[v as usize], c))).collect();
    members.sort_unstable();
    let (mut parents, mut ancestors) = (vec![None; order.len()], vec![None; order.len()]);
    let mut latest: Vec<Option<u32>> = vec![None; cliques.len()];
    for (now, clique) in members {
        let mut below = latest[clique as usize].replace(now);
        while let Some(vertex) = below.filter(|vertex| *vertex < now) {
            below = ancestors[vertex as usize].replace(now);
            if below.is_none() {
                parents[vertex as usize] = Some(now);
            }
        }
    }
    parents
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of the factor below the diagonal by elimination on paper, column by column in ranks.
    fn fill(order: &[u32], cliques: &[[u32; 4]]) -> Vec<std::collections::BTreeSet<u32>> {
        let mut rank = vec![0; order.len()];
        order.iter().enumerate().for_each(|(r, v)| rank[*v as usize] = r as u32);
        let mut columns = vec![std::collections::BTreeSet::new(); order.len()];
        for clique in cliques {
            let ranks = clique.map(|v| rank[v as usize]);
            for (a, b) in ranks.iter().flat_map(|a| ranks.map(|b| (*a, b))).filter(|(a, b)| b > a) {
                columns[a as usize].insert(b);
            }
        }
        for r in 0..columns.len() {
            let column = columns[r].clone();
            if let Some(next) = column.first() {
                columns[*next as usize].extend(column.iter().skip(1));
            }
        }
        columns
    }

    /// Runs of columns in which each is the one before without its first row.
    fn supernodes(columns: &[std::collections::BTreeSet<u32>]) -> usize {
        let follows = |pair: &[std::collections::BTreeSet<u32>], next: u32| {
            pair[0].first() == Some(&next) && pair[0].iter().skip(1).eq(pair[1].iter())
        };
        1 + columns.windows(2).enumerate().filter(|(r, pair)| !follows(pair, *r as u32 + 1)).count()
    }

    #[test]
    fn a_postorder_keeps_the_fill_and_joins_what_two_sides_of_a_cut_have_interleaved() {
        // Two strips of quadrilaterals, side by side and not joined, whose nodes are counted alternately.
        let strip = |side: u32| (0..9).map(move |i| [0, 1, 2, 3].map(|n| 2 * (2 * i + n) + side));
        let cliques: Vec<[u32; 4]> = strip(0).chain(strip(1)).collect();
        let order: Vec<u32> = (0..40).collect();
        let after = postordered(&order, &cliques);
        let mut sorted = after.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, order, "every vertex once");
        let [before, then] = [fill(&order, &cliques), fill(&after, &cliques)];
        let entries = |columns: &[std::collections::BTreeSet<u32>]| columns.iter().map(|c| c.len()).sum::<usize>();
        assert_eq!(entries(&then), entries(&before));
        assert!(3 * supernodes(&then) < 2 * supernodes(&before), "{} of {}", supernodes(&then), supernodes(&before));
        // Each parent in the elimination tree comes after all below it, and the tree of a postorder has it right after its last child.
        assert_eq!(postordered(&after, &cliques), after);
    }

    #[test]
    fn every_node_is_eliminated_exactly_once() {
        for nodes in [[1, 1, 1], [2, 3, 1], [5, 4, 7], [13, 13, 13], [40, 2, 3]] {
            let mut order = nested_dissection(nodes);
            order.sort_unstable();
            assert!(order.iter().enumerate().all(|(i, n)| i == *n as usize), "{nodes:?}");
            assert_eq!(order.len(), nodes.iter().product::<usize>());
        }
    }
}
