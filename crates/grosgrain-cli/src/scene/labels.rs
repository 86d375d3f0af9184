//! How the values of a volume become labels.

use grosgrain::mesh::{Label, LabelRule};

use super::document::{Item, Reading, read_all};
use super::section::Section;
use super::selector::read_label;

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
    /// Every voxel has label 0; the modulus tells what is void.
    One,
}

/// Reads the keys `labels` and `void` of the body.
///
/// `from_modulus` says that the volume's values are no labels but moduli, or become moduli by a law.
pub fn read_labelling(body: &Section, from_modulus: bool) -> Reading<Labelling> {
    body.exclusive(&["labels", "void"], "with labels, write void = true in the rules that are void")?;
    if let Some(labels) = body.get("labels") {
        return read_rules(&labels).map(Labelling::Rules);
    }
    match body.get("void") {
        Some(void) if from_modulus => {
            let sentence = "lists labels, but the volume's values are no labels here; expected rules in body.labels";
            Err(void.note(format!("{} {sentence}", void.key())))
        }
        Some(void) => {
            let void = read_all(&void.list("a list of at least one label")?, read_label)?;
            Ok(Labelling::Own { void })
        }
        None if from_modulus => Ok(Labelling::One),
        None => Ok(Labelling::Own { void: Vec::new() }),
    }
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
    let expected = "a list of at least one integer";
    let values =
        section.optional("values", |values| read_all(&values.list(expected)?, |v| v.integer_32("a 32-bit integer")));
    let void = section.optional("void", Item::boolean);
    Ok(LabelRule { label: label?, below: below?, values: values?, void: void?.unwrap_or(false) })
}

/// Notes a rule that an earlier one contradicts or leaves nothing to.
fn refuse_overlap(item: &Item, earlier: &[LabelRule], rule: &LabelRule) -> Reading<()> {
    if earlier.iter().any(|e| e.label == rule.label) {
        let sentence = format!("{} gives label {} again; expected each label once", item.key(), rule.label);
        return Err(item.note(sentence));
    }
    match earlier.iter().position(|e| takes_from(e, rule)) {
        None => Ok(()),
        Some(n) => Err(item.note(format!(
            "{} overlaps body.labels[{n}], which takes its values first; expected thresholds that ascend, \
             distinct values, and a rule without below and values at the end only",
            item.key()
        ))),
    }
}

/// Whether `first` leaves `second` nothing, or takes one of the values it lists.
fn takes_from(first: &LabelRule, second: &LabelRule) -> bool {
    match (first.below, &first.values, second.below, &second.values) {
        (None, None, _, _) => true,
        (Some(a), _, Some(b), _) => b <= a,
        (Some(a), _, None, Some(values)) => values.iter().any(|v| f64::from(*v) < a),
        (None, Some(a), None, Some(b)) => b.iter().any(|v| a.contains(v)),
        _ => false,
    }
}
