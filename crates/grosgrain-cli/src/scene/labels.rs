//! How the values of a volume become labels.

use grosgrain::mesh::Label;

use super::document::{Item, Reading, read_all};
use super::section::Section;
use super::selector::read_label;

/// What a rule takes.
#[derive(Clone, Debug, PartialEq)]
pub enum Taken {
    /// Values below a threshold that no earlier rule took.
    Below(f64),
    /// These values exactly.
    Values(Vec<f64>),
    /// All that earlier rules left.
    Rest,
}

/// One rule from values to a label; the first rule that takes a value decides.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelRule {
    /// The label of what the rule takes.
    pub label: Label,
    /// What it takes.
    pub taken: Taken,
    /// Whether it is void.
    pub void: bool,
}

/// Where labels and voids come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Labelling {
    /// The volume's or the pattern's own integers are the labels; those listed are void.
    Own {
        /// The labels of void voxels.
        void: Vec<Label>,
    },
    /// Rules on the values.
    Rules(Vec<LabelRule>),
}

/// Reads the keys `labels` and `void` of the body.
pub fn read_labelling(body: &Section) -> Reading<Labelling> {
    body.exclusive(&["labels", "void"], "with labels, write void = true in the rules that are void")?;
    if let Some(labels) = body.get("labels") {
        return read_rules(&labels).map(Labelling::Rules);
    }
    let void = body.optional("void", |void| read_all(&void.list("a list of at least one label")?, read_label))?;
    Ok(Labelling::Own { void: void.unwrap_or_default() })
}

fn read_rules(item: &Item) -> Reading<Vec<LabelRule>> {
    let items = item.list("a list of rules like { label = 1, below = 150 }")?;
    let rules = read_all(&items, read_rule)?;
    let overlaps: Vec<Reading<()>> =
        (0..rules.len()).map(|n| refuse_overlap(&items[n], &rules[..n], &rules[n])).collect();
    overlaps.into_iter().collect::<Reading<()>>()?;
    match rules.iter().all(|rule| rule.void) {
        true => Err(item.note(format!("{} makes every voxel void; expected a rule without void = true", item.key()))),
        false => Ok(rules),
    }
}

fn read_rule(item: &Item) -> Reading<LabelRule> {
    let section = item.section(&["label", "below", "values", "void"])?;
    section.exclusive(&["below", "values"], "write two rules")?;
    let label = section.required("label", "the integer label of what the rule takes", read_label);
    let below = section.optional("below", Item::number);
    let values =
        section.optional("values", |values| read_all(&values.list("a list of at least one number")?, Item::number));
    let void = section.optional("void", Item::boolean);
    let taken = match (below?, values?) {
        (Some(threshold), _) => Taken::Below(threshold),
        (None, Some(values)) => Taken::Values(values),
        (None, None) => Taken::Rest,
    };
    Ok(LabelRule { label: label?, taken, void: void?.unwrap_or(false) })
}

/// Notes a rule that an earlier one contradicts or leaves nothing to.
fn refuse_overlap(item: &Item, earlier: &[LabelRule], rule: &LabelRule) -> Reading<()> {
    if earlier.iter().any(|e| e.label == rule.label) {
        let sentence = format!("{} gives label {} again; expected each label once", item.key(), rule.label);
        return Err(item.note(sentence));
    }
    match earlier.iter().position(|e| takes_all(&e.taken, &rule.taken)) {
        None => Ok(()),
        Some(n) => Err(item.note(format!(
            "{} takes nothing that rule {n} does not take first; expected thresholds that ascend, distinct values, \
             and a rule without below and values at the end only",
            item.key()
        ))),
    }
}

fn takes_all(first: &Taken, second: &Taken) -> bool {
    match (first, second) {
        (Taken::Rest, _) => true,
        (Taken::Below(a), Taken::Below(b)) => b <= a,
        (Taken::Below(a), Taken::Values(values)) => values.iter().any(|v| v < a),
        (Taken::Values(a), Taken::Values(b)) => b.iter().any(|v| a.contains(v)),
        _ => false,
    }
}
