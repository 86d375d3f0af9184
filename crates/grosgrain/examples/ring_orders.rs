//! Does it pay to condense what neighbouring one-rings share? Counts the operations of the exact one-ring problem of an interior
//! cell, and what would be left of them if everything that rings can share came for free.
//!
//! ```sh
//! cargo run --release -p grosgrain --example ring_orders
//! ```
//!
//! *Interiors*: the inner nodes of each coarse cell are eliminated once and serve 27 rings. *Columns*: three cells along z,
//! with the ring's two ends, condensed to their four sides, serve nine rings. *Slabs*: three columns, condensed to two faces, serve three rings.

use std::error::Error;

use grosgrain::linalg::{FrontalPlan, FrontalPlanError, box_tree, box_tree_around};

type At = [usize; 3];

fn main() -> Result<(), Box<dyn Error>> {
    println!("Mflop of one ring with six loads; from the third column on: what is left when the shared parts are free");
    println!(
        "{:>2} {:>10} {:>10} {:>10} {:>10} {:>10}",
        "d", "dissection", "cell last", "interiors", "columns", "slabs"
    );
    for degree in 2..=5 {
        let counts = Ring { degree }.counts()?.map(|c| format!("{:>10.1}", c / 1e6));
        println!("{degree:>2} {}", counts.join(" "));
    }
    println!("workspace of one ring with the cell last, MB (one for each thread):");
    for degree in 2..=7 {
        println!("{degree:>2} {:>10.1}", Ring { degree }.workspace()? as f64 / 1e6);
    }
    Ok(())
}

struct Ring {
    degree: usize,
}

impl Ring {
    fn counts(&self) -> Result<[f64; 5], FrontalPlanError> {
        let d = self.degree;
        let inner = move |x: usize| !x.is_multiple_of(d);
        let one = [1; 3];
        Ok([
            self.operations(one, &|_| false, &[box_tree([3 * d + 1; 3])])?,
            self.operations(one, &|_| false, &[self.core_last()])?,
            self.operations([d; 3], &|[x, y, z]| inner(x) && inner(y) && inner(z), &self.orders())?,
            self.operations([d, d, 3 * d], &|[x, y, _]| inner(x) && inner(y), &self.orders())?,
            self.operations([d, 3 * d, 3 * d], &|[x, y, z]| inner(x) && !self.in_core([x, y, z]), &self.orders())?,
        ])
    }

    /// Bytes of a solver that keeps the factor of the cell.
    fn workspace(&self) -> Result<usize, FrontalPlanError> {
        let n = 3 * self.degree + 1;
        let corners = |c: usize| -> Vec<u32> {
            let at = [c % (n - 1), c / (n - 1) % (n - 1), c / (n - 1) / (n - 1)];
            let node = |a: usize| at[0] + (a & 1) + n * (at[1] + (a >> 1 & 1) + n * (at[2] + (a >> 2)));
            (0..8).map(|a| node(a) as u32).collect()
        };
        let elements: Vec<Vec<u32>> = (0..(n - 1).pow(3)).map(corners).collect();
        let groups = self.core_last();
        let in_core = groups.iter().rev().scan(0, |nodes, group| {
            *nodes += group.len();
            Some(*nodes)
        });
        let kept = in_core.take_while(|nodes| *nodes <= (self.degree + 1).pow(3)).count();
        Ok(FrontalPlan::new(n * n * n, 3, &elements, &groups)?.workspace_bytes(6, kept))
    }

    fn in_core(&self, at: At) -> bool {
        at.iter().all(|x| (self.degree..=2 * self.degree).contains(x))
    }

    /// The cheapest of several orders for dense elements that fill boxes of `size` cells, without the nodes that are gone.
    fn operations(
        &self,
        size: At,
        gone: &dyn Fn(At) -> bool,
        orders: &[Vec<Vec<u32>>],
    ) -> Result<f64, FrontalPlanError> {
        let n = 3 * self.degree + 1;
        let place = |i: usize| [i % n, i / n % n, i / n / n];
        let gone: Vec<bool> = (0..n * n * n).map(|i| gone(place(i))).collect();
        let counts = size.map(|s| (n - 1) / s);
        let elements: Vec<Vec<u32>> = (0..counts.iter().product())
            .map(|e: usize| {
                let low =
                    [e % counts[0] * size[0], e / counts[0] % counts[1] * size[1], e / counts[0] / counts[1] * size[2]];
                let holds = |at: At| (0..3).all(|a| (low[a]..=low[a] + size[a]).contains(&at[a]));
                (0..n * n * n).filter(|i| !gone[*i] && holds(place(*i))).map(|i| i as u32).collect()
            })
            .collect();
        let mut best = f64::INFINITY;
        for order in orders {
            let keep = |g: &Vec<u32>| g.iter().copied().filter(|i| !gone[*i as usize]).collect::<Vec<u32>>();
            let mut groups: Vec<Vec<u32>> = order.iter().map(keep).filter(|g| !g.is_empty()).collect();
            // Nodes that are gone: one each, in no element. Their own pivots are not counted.
            let lone: Vec<Vec<u32>> = (0..gone.len()).filter(|i| gone[*i]).map(|i| vec![i as u32]).collect();
            let free = lone.len() as f64 * (1..=3).map(|k| (k * k + 12 * k) as f64).sum::<f64>();
            groups.extend(lone);
            best = best.min(FrontalPlan::new(n * n * n, 3, &elements, &groups)?.operations(6) - free);
        }
        Ok(best)
    }

    fn core_last(&self) -> Vec<Vec<u32>> {
        let d = self.degree;
        box_tree_around([3 * d + 1; 3], [d; 3], [2 * d + 1; 3])
    }

    /// Orders with the cell last: dissection by middle planes, and by planes between coarse cells in each order of the axes.
    fn orders(&self) -> Vec<Vec<Vec<u32>>> {
        let aligned = [[0, 1, 2], [2, 1, 0], [1, 2, 0]].map(|axes| self.aligned(axes));
        [self.core_last(), self.between_cells()].into_iter().chain(aligned).collect()
    }

    /// Dissection by planes between coarse cells, the one nearest to the middle of the longest axis first; the wanted cell last.
    fn between_cells(&self) -> Vec<Vec<u32>> {
        let n = 3 * self.degree + 1;
        let mut groups = Vec::new();
        self.split([0; 3], [n; 3], &mut groups);
        let in_core = |i: &u32| self.in_core([*i as usize % n, *i as usize / n % n, *i as usize / n / n]);
        let core: Vec<u32> = groups.concat().into_iter().filter(in_core).collect();
        groups.iter_mut().for_each(|g| g.retain(|i| !in_core(i)));
        groups.push(core);
        groups.retain(|g| !g.is_empty());
        groups
    }

    fn split(&self, low: At, high: At, groups: &mut Vec<Vec<u32>>) {
        let planes = (0..3)
            .flat_map(|a| (low[a] + 1..high[a] - 1).filter(|x| x.is_multiple_of(self.degree)).map(move |x| (a, x)));
        let balance = |&(a, x): &(usize, usize)| (high[a] - low[a], (x - low[a]).min(high[a] - 1 - x));
        let Some((axis, plane)) = planes.max_by_key(balance) else { return groups.extend(self.dissect(low, high)) };
        let with = |mut at: At, x: usize| {
            at[axis] = x;
            at
        };
        self.split(low, with(high, plane), groups);
        self.split(with(low, plane + 1), high, groups);
        groups.extend(self.dissect(with(low, plane), with(high, plane + 1)));
    }

    /// The two outer slabs along the first axis, then the outer columns of the middle slab, the outer cells of the middle column, and the cell.
    fn aligned(&self, axes: At) -> Vec<Vec<u32>> {
        let (d, n) = (self.degree, 3 * self.degree + 1);
        let mut groups = Vec::new();
        let (mut low, mut high) = ([0; 3], [n; 3]);
        for axis in axes {
            let (mut first, mut last) = (high, low);
            (first[axis], last[axis]) = (d, 2 * d + 1);
            groups.extend(self.dissect(low, first));
            groups.extend(self.dissect(last, high));
            (low[axis], high[axis]) = (d, 2 * d + 1);
        }
        groups.extend(self.dissect([d + 1; 3], [2 * d; 3]));
        let listed: Vec<u32> = groups.concat();
        groups.push((0..(n * n * n) as u32).filter(|i| !listed.contains(i)).collect());
        groups
    }

    /// Nested dissection of a box of nodes inside the ring.
    fn dissect(&self, low: At, high: At) -> Vec<Vec<u32>> {
        let (n, size) = (3 * self.degree + 1, [0, 1, 2].map(|a| high[a] - low[a]));
        let shifted = |i: u32| {
            let i = i as usize;
            let at = [i % size[0] + low[0], i / size[0] % size[1] + low[1], i / size[0] / size[1] + low[2]];
            (at[0] + n * (at[1] + n * at[2])) as u32
        };
        box_tree(size).into_iter().map(|g| g.into_iter().map(shifted).collect()).collect()
    }
}
