//! Element sets and the tags that they give.

use std::collections::{BTreeMap, BTreeSet};

/// Where a set comes from; tags come from the most telling origin that has a set for the element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Origin {
    /// A parameter of `*ELEMENT`.
    #[default]
    Elements,
    /// `*ELSET`.
    Set,
    /// Named by a section, which gives its elements a material.
    Section,
}

/// An element set before its numbers are looked up.
#[derive(Clone, Debug, Default)]
struct ElementSet {
    name: String,
    origin: Origin,
    /// Numbers from, to, step.
    ranges: Vec<(i64, i64, i64)>,
    /// Sets that are parts of it, defined before.
    parts: BTreeSet<usize>,
}

/// The sets of a file; upper and lower case are the same.
#[derive(Clone, Debug, Default)]
pub(super) struct ElementSets {
    sets: Vec<ElementSet>,
    by_name: BTreeMap<String, usize>,
}

/// What the sets say of the elements.
#[derive(Clone, Debug, Default)]
pub(super) struct Tags {
    /// Of each element; 0 for one in no set.
    pub tags: Vec<i32>,
    /// Of the tags that sets with a name of their own have.
    pub names: BTreeMap<i32, String>,
    /// Elements that are in several sets of the same origin.
    pub in_several: usize,
}

impl ElementSets {
    /// The set of this name, made if there is none.
    pub fn open(&mut self, name: &str, origin: Origin) -> usize {
        let place = self.sets.len();
        let set = *self.by_name.entry(name.to_uppercase()).or_insert(place);
        if set == place {
            self.sets.push(ElementSet { name: name.to_owned(), ..ElementSet::default() });
        }
        self.sets[set].origin = self.sets[set].origin.max(origin);
        set
    }

    /// Adds elements by number: first, last, step (at least 1).
    pub fn add_range(&mut self, set: usize, first: i64, last: i64, step: i64) {
        self.sets[set].ranges.push((first, last, step.max(1)));
    }

    /// Adds the elements of another set that stands before; `false` if there is none of this name.
    pub fn add_set(&mut self, set: usize, name: &str) -> bool {
        match self.by_name.get(&name.to_uppercase()) {
            Some(&part) if part < set => self.sets[set].parts.insert(part),
            _ => return false,
        };
        true
    }

    /// Tags of elements with these numbers: in each origin the smallest set counts, and `TAG_n` gives n. Other sets that count
    /// get numbers from 1, in the order in which they stand.
    pub fn tags(&self, numbers: &[i64]) -> Tags {
        let members = self.members(numbers);
        let given = |set: &ElementSet| -> Option<i32> { set.name.to_uppercase().strip_prefix("TAG_")?.parse().ok() };
        let taken: BTreeSet<i32> = self.sets.iter().filter_map(given).collect();
        let mut order: Vec<usize> = (0..self.sets.len()).collect();
        order.sort_by_key(|set| (self.sets[*set].origin, std::cmp::Reverse(members[*set].len())));
        let mut owner: Vec<Option<usize>> = vec![None; numbers.len()];
        let mut is_shared = vec![false; numbers.len()];
        for set in order {
            for element in members[set].iter().map(|e| *e as usize) {
                is_shared[element] = owner[element].is_some_and(|o| self.sets[o].origin == self.sets[set].origin);
                owner[element] = Some(set);
            }
        }
        let owners: BTreeSet<usize> = owner.iter().flatten().copied().collect();
        let mut free = (1..i32::MAX).filter(|tag| !taken.contains(tag));
        let tag_of = |set: usize| (set, given(&self.sets[set]).or_else(|| free.next()).unwrap_or(0));
        let tag_of: BTreeMap<usize, i32> = owners.into_iter().map(tag_of).collect();
        let named = tag_of.iter().filter(|(set, _)| given(&self.sets[**set]).is_none());
        Tags {
            tags: owner.iter().map(|set| set.map_or(0, |set| tag_of[&set])).collect(),
            names: named.map(|(set, tag)| (*tag, self.sets[*set].name.clone())).collect(),
            in_several: is_shared.iter().filter(|shared| **shared).count(),
        }
    }

    /// Positions of the elements of each set, each once.
    fn members(&self, numbers: &[i64]) -> Vec<Vec<u32>> {
        let mut sorted: Vec<(i64, u32)> = numbers.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        let mut members: Vec<Vec<u32>> = Vec::with_capacity(self.sets.len());
        for set in &self.sets {
            let mut found: Vec<u32> = set.parts.iter().flat_map(|part| members[*part].iter().copied()).collect();
            for &(first, last, step) in &set.ranges {
                let from = sorted.partition_point(|(number, _)| *number < first);
                let inside = sorted[from..].iter().take_while(|(number, _)| *number <= last);
                let hit = inside.filter(|(number, _)| number.wrapping_sub(first) % step == 0);
                found.extend(hit.map(|(_, element)| *element));
            }
            found.sort_unstable();
            found.dedup();
            members.push(found);
        }
        members
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_come_before_sets_and_small_sets_before_large_ones() {
        let mut sets = ElementSets::default();
        let all = sets.open("all", Origin::Elements);
        sets.add_range(all, 1, 9, 1);
        let odd = sets.open("odd", Origin::Set);
        sets.add_range(odd, 1, i64::MAX, 2);
        let large = sets.open("large", Origin::Set);
        sets.add_range(large, 4, 9, 1);
        let bone = sets.open("bone", Origin::Set);
        assert!(sets.add_set(bone, "ODD") && !sets.add_set(bone, "bone") && !sets.add_set(bone, "liver"));
        let seven = sets.open("tag_7", Origin::Set);
        sets.add_range(seven, 9, 9, 1);
        let found = sets.tags(&[9, 4, 5, 2, 12]);
        // 9 is in all of them, 5 in odd, bone (equal sizes: the later one) and large, 4 in large, 2 in all only, 12 in none.
        assert_eq!((found.tags, found.in_several), (vec![7, 2, 3, 1, 0], 2));
        let names: Vec<(i32, &str)> = found.names.iter().map(|(tag, name)| (*tag, name.as_str())).collect();
        assert_eq!(names, [(1, "all"), (2, "large"), (3, "bone")]);
        sets.open("LARGE", Origin::Section);
        assert_eq!(sets.tags(&[9, 4, 5, 2, 12]).tags, [2, 2, 2, 1, 0]);
    }
}
