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

#[cfg(test)]
mod tests {
    use super::*;

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
