//! What is connected: sets of numbers that are joined pair by pair.

/// Disjoint sets of numbers; the root of each is its smallest.
#[derive(Clone, Debug)]
pub(crate) struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// `count` sets of one number each.
    pub(crate) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The smallest number of the set of `n`.
    pub(crate) fn root(&mut self, mut n: u32) -> u32 {
        while self.0[n as usize] != n {
            self.0[n as usize] = self.0[self.0[n as usize] as usize];
            n = self.0[n as usize];
        }
        n
    }

    /// Joins the sets of two numbers.
    pub(crate) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// The set of each number, sets counted in the order of their smallest numbers, and how many there are.
    pub(crate) fn numbered(mut self) -> (Vec<u32>, usize) {
        let (mut numbers, mut count) = (vec![0; self.0.len()], 0);
        for n in 0..numbers.len() {
            let root = self.root(n as u32) as usize;
            if root == n {
                numbers[n] = count as u32;
                count += 1;
            } else {
                numbers[n] = numbers[root];
            }
        }
        (numbers, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_numbers_get_the_number_of_their_set() {
        let mut sets = DisjointSets::new(7);
        [(5, 1), (6, 3), (1, 6)].into_iter().for_each(|(a, b)| sets.unite(a, b));
        assert_eq!((sets.root(6), sets.root(2)), (1, 2));
        assert_eq!(sets.numbered(), (vec![0, 1, 2, 1, 3, 1, 1], 4));
    }
}
