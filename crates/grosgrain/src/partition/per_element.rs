//! Values that belong to the elements of a coarse mesh, one each.

use super::CellPart;

/// One value per listed element, in ascending order of elements.
#[derive(Clone, Debug, PartialEq)]
pub struct PerElement<T> {
    elements: Vec<CellPart>,
    values: Vec<T>,
}

impl<T> PerElement<T> {
    /// Values of the listed elements.
    ///
    /// # Panics
    /// Panics when there are not as many values as elements.
    pub fn new(elements: Vec<CellPart>, values: Vec<T>) -> Self {
        assert_eq!(elements.len(), values.len(), "one value per element");
        Self { elements, values }
    }

    /// The elements, in the order of their values.
    pub fn elements(&self) -> &[CellPart] {
        &self.elements
    }

    /// The values.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// Takes `renewed` values into a list that is to hold the elements `now`: renewed values win over those held so far,
    /// and elements that are not in `now` go. Values are moved, not copied.
    ///
    /// The list, `now` and `renewed` must be ascending. Part numbers mean nothing beyond an edit of their coarse cell, so
    /// all parts of an edited cell must be among the renewed.
    ///
    /// # Panics
    /// Panics when an element of `now` is neither held nor renewed.
    pub fn replace(&mut self, now: &[CellPart], renewed: Self) {
        let held = std::mem::take(&mut self.elements).into_iter().zip(std::mem::take(&mut self.values));
        let renewed = renewed.elements.into_iter().zip(renewed.values);
        let (mut held, mut renewed) = (held.peekable(), renewed.peekable());
        let values = now.iter().map(|element| {
            let old = last_up_to(&mut held, *element);
            let value = last_up_to(&mut renewed, *element).or(old);
            let Some(value) = value else { panic!("{element:?} is neither held nor renewed") };
            value
        });
        self.values = values.collect();
        self.elements = now.to_vec();
    }
}

/// Skips what comes before `element` and takes its value if it comes next.
fn last_up_to<T>(list: &mut std::iter::Peekable<impl Iterator<Item = (CellPart, T)>>, element: CellPart) -> Option<T> {
    while list.next_if(|(e, _)| *e < element).is_some() {}
    list.next_if(|(e, _)| *e == element).map(|(_, value)| value)
}

#[cfg(test)]
mod tests {
    use super::super::CoarseCell;
    use super::*;

    fn key(cell: usize, part: u32) -> CellPart {
        CellPart { cell: CoarseCell(cell), part }
    }

    #[test]
    fn renewed_values_win_others_stay_and_absent_elements_go() {
        let held = vec![key(0, 0), key(1, 0), key(1, 1), key(3, 0), key(5, 0)];
        let mut list = PerElement::new(held, vec!["a", "b", "c", "d", "e"]);
        let renewed = PerElement::new(vec![key(1, 0), key(2, 0), key(2, 1), key(4, 0)], vec!["B", "F", "G", "gone"]);
        let now = [key(0, 0), key(1, 0), key(2, 0), key(2, 1), key(5, 0)];
        list.replace(&now, renewed);
        assert_eq!((list.elements(), list.values()), (&now[..], &["a", "B", "F", "G", "e"][..]));
    }

    #[test]
    #[should_panic(expected = "neither held nor renewed")]
    fn an_element_without_a_value_is_refused() {
        let mut list = PerElement::new(vec![key(0, 0)], vec![1]);
        list.replace(&[key(0, 0), key(1, 0)], PerElement::new(Vec::new(), Vec::new()));
    }
}
