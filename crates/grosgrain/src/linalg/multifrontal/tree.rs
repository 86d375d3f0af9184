//! Which nodes of a box are eliminated together.

/// Boxes of at most this many nodes become one front.
const LEAF: usize = 18;

/// Nested dissection of a box of `nodes` along x, y, z, as groups of nodes (indices x fastest) in the order of their elimination:
/// every group becomes one dense front, a separator after the two halves that it parts.
pub fn box_tree(nodes: [usize; 3]) -> Vec<Vec<u32>> {
    let mut groups = Vec::new();
    dissect(nodes, [0; 3], nodes, &|_| true, &mut groups);
    groups
}

/// The same with the nodes from `low` to `high` (exclusive) last: first their interior, by nested dissection, then their boundary as one group.
pub fn box_tree_around(nodes: [usize; 3], low: [usize; 3], high: [usize; 3]) -> Vec<Vec<u32>> {
    let inside = |at: [usize; 3], margin: usize| (0..3).all(|a| at[a] >= low[a] + margin && at[a] + margin < high[a]);
    let mut groups = Vec::new();
    dissect(nodes, [0; 3], nodes, &|at| !inside(at, 0), &mut groups);
    dissect(nodes, low, high, &|at| inside(at, 1), &mut groups);
    groups.push(list(nodes, low, high, &|at| !inside(at, 1)));
    groups
}

fn dissect(
    nodes: [usize; 3],
    low: [usize; 3],
    high: [usize; 3],
    wanted: &dyn Fn([usize; 3]) -> bool,
    groups: &mut Vec<Vec<u32>>,
) {
    let size: [usize; 3] = std::array::from_fn(|a| high[a] - low[a]);
    let axis = (0..3).fold(0, |best, a| if size[a] > size[best] { a } else { best });
    let all = list(nodes, low, high, wanted);
    if all.is_empty() {
        return;
    }
    if size[axis] < 3 || all.len() <= LEAF {
        return groups.push(all);
    }
    let plane = low[axis] + size[axis] / 2;
    let with = |mut corner: [usize; 3], at: usize| {
        corner[axis] = at;
        corner
    };
    dissect(nodes, low, with(high, plane), wanted, groups);
    dissect(nodes, with(low, plane + 1), high, wanted, groups);
    let separator = list(nodes, with(low, plane), with(high, plane + 1), wanted);
    if !separator.is_empty() {
        groups.push(separator);
    }
}

fn list(nodes: [usize; 3], low: [usize; 3], high: [usize; 3], wanted: &dyn Fn([usize; 3]) -> bool) -> Vec<u32> {
    let mut found = Vec::new();
    for k in low[2]..high[2] {
        for j in low[1]..high[1] {
            let row = (low[0]..high[0]).filter(|&i| wanted([i, j, k]));
            found.extend(row.map(|i| (i + nodes[0] * (j + nodes[1] * k)) as u32));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_is_in_exactly_one_group_and_the_core_comes_last() {
        for (nodes, low, high) in
            [([7, 7, 7], [2, 2, 2], [5, 5, 5]), ([5, 7, 13], [0, 2, 8], [3, 5, 13]), ([3, 3, 3], [0, 0, 0], [3, 3, 3])]
        {
            for groups in [box_tree(nodes), box_tree_around(nodes, low, high)] {
                let mut all: Vec<u32> = groups.concat();
                all.sort_unstable();
                assert!(all.iter().enumerate().all(|(i, n)| i == *n as usize), "{nodes:?}");
                assert_eq!(all.len(), nodes.iter().product::<usize>());
            }
            let core: usize = (0..3).map(|a| high[a] - low[a]).product();
            let order = box_tree_around(nodes, low, high).concat();
            let tail = &order[order.len() - core..];
            for n in tail.iter().map(|n| *n as usize) {
                let at = [n % nodes[0], n / nodes[0] % nodes[1], n / (nodes[0] * nodes[1])];
                assert!((0..3).all(|a| (low[a]..high[a]).contains(&at[a])));
            }
        }
    }
}
