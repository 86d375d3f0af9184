//! When a load or a motion grows and ends: `from`, `to` and `until`.

use grosgrain::dynamics::{Ramp, Schedule};

use super::document::{Item, Reading};
use super::section::Section;

/// When something acts. Without any of the times it acts in full from the beginning to the end of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Span {
    /// When it begins to grow \[s\].
    pub from: Option<f64>,
    /// When it has grown in full \[s\].
    pub to: Option<f64>,
    /// The last time at which it acts \[s\].
    pub until: Option<f64>,
}

impl Span {
    /// Its linear growth.
    pub fn ramp(&self) -> Ramp {
        let from = self.from.unwrap_or(0.0);
        Ramp { from, to: self.to.unwrap_or(from) }
    }

    /// The same as the library says it.
    pub fn schedule(&self) -> Schedule {
        Schedule { ramp: self.ramp(), until: self.until }
    }

    /// The share, from 0 to 1, that acts at a time \[s\].
    pub fn factor(&self, time: f64) -> f64 {
        self.schedule().share(time)
    }

    /// Whether the share ever changes.
    pub fn varies(&self) -> bool {
        *self != Self::default()
    }
}

/// Reads `from` and `to` of one table and `until` of the same or of another one.
pub fn read_span(growing: Option<&Section>, ending: &Section) -> Reading<Span> {
    let read = |name| growing.map_or(Ok(None), |section| section.optional(name, Item::non_negative));
    let (from, to) = (read("from"), read("to"));
    let until = ending.optional("until", Item::positive);
    let span = Span { from: from?, to: to?, until: until? };
    let begin = span.from.unwrap_or(0.0);
    if let (Some(growing), Some(_)) = (growing, span.to.filter(|to| *to <= begin)) {
        let expected =
            format!("a time after {}, {begin} s", if span.from.is_some() { "from" } else { "the beginning" });
        return growing.required("to", &expected, |to| Err(to.refuse(&expected)));
    }
    if span.until.is_some_and(|until| until <= begin) {
        let expected = format!("a time after from, {begin} s");
        return ending.required("until", &expected, |until| Err(until.refuse(&expected)));
    }
    Ok(span)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_grows_stays_and_ends() {
        let span = |from, to, until| Span { from, to, until };
        let at = |span: Span| [0.0, 1.0, 2.0, 3.0, 4.0].map(|time| span.factor(time));
        assert_eq!(at(Span::default()), [1.0; 5]);
        assert_eq!(at(span(Some(1.0), Some(3.0), None)), [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert_eq!(at(span(None, Some(4.0), Some(2.5))), [0.0, 0.25, 0.5, 0.0, 0.0]);
        assert_eq!(at(span(Some(2.0), None, Some(3.0))), [0.0, 0.0, 1.0, 1.0, 0.0]);
        assert_eq!(span(Some(1.0), Some(2.0), None).factor(f64::INFINITY), 1.0, "a static run without edits");
    }
}
