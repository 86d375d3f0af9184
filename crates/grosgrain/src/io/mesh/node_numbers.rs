//! Numbers that files give to nodes: any, in any order.

use super::{MeshReadError, Place};

/// From the number of a node in the file to its position in the list.
#[derive(Clone, Debug)]
pub(in crate::io) struct NodeNumbers(Vec<(i64, u32)>);

impl NodeNumbers {
    /// Numbers in the order in which the nodes stand.
    pub fn new(numbers: &[i64]) -> Result<Self, MeshReadError> {
        let count = u32::try_from(numbers.len()).map_err(|_| MeshReadError::TooManyNodes { nodes: numbers.len() })?;
        let mut sorted: Vec<(i64, u32)> = numbers.iter().copied().zip(0..count).collect();
        sorted.sort_unstable();
        match sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(MeshReadError::RepeatedNode { node: pair[0].0 }),
            None => Ok(Self(sorted)),
        }
    }

    /// The position of a node that an element at `place` names.
    pub fn position(&self, number: i64, place: impl Fn() -> Place) -> Result<u32, MeshReadError> {
        match self.0.binary_search_by_key(&number, |(n, _)| *n) {
            Ok(found) => Ok(self.0[found].1),
            Err(_) => Err(MeshReadError::NoSuchNode { place: place(), node: number }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_any_order_are_found_and_others_refused() {
        let numbers = NodeNumbers::new(&[70, 3, 12]).unwrap();
        let line = || Place::Line(4);
        let found: Vec<u32> = [3, 12, 70].iter().map(|n| numbers.position(*n, line).unwrap()).collect();
        assert_eq!(found, [1, 2, 0]);
        assert!(numbers.position(4, line).unwrap_err().to_string().starts_with("line 4: an element names node 4"));
        assert!(matches!(NodeNumbers::new(&[1, 2, 1]).unwrap_err(), MeshReadError::RepeatedNode { node: 1 }));
    }
}
