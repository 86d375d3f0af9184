//! A table of the scene, whose keys are looked up by name.

use std::ops::Range;

use toml::de::DeTable;

use super::document::{Document, Item, Noted, Reading};

/// A table with its key.
pub struct Section<'s> {
    document: &'s Document<'s>,
    key: String,
    span: Range<usize>,
    table: &'s DeTable<'s>,
}

impl<'s> Section<'s> {
    /// The table at `key`; an empty key is the whole scene.
    pub fn new(document: &'s Document<'s>, key: String, span: Range<usize>, table: &'s DeTable<'s>) -> Self {
        Self { document, key, span, table }
    }

    /// Notes every key that is not among `known`.
    pub fn limited_to(self, known: &[&str]) -> Self {
        for (name, _) in self.table.iter().filter(|(name, _)| !known.contains(&name.get_ref().as_ref())) {
            let hint = match nearest(name.get_ref(), known) {
                Some(near) => format!("did you mean {near:?}?"),
                None => format!("known here: {}", known.join(", ")),
            };
            self.document.note(name.span(), format!("{} is not a known key; {hint}", self.child(name.get_ref())));
        }
        self
    }

    /// Notes a sentence at this section's first line.
    pub fn note(&self, sentence: String) -> Noted {
        self.document.note(self.span.clone(), sentence)
    }

    /// Notes a sentence at the value that `names` lead to, or at the last table on the way that exists.
    pub fn note_at(&self, names: &[&str], sentence: String) -> Noted {
        let start = names.first().and_then(|name| self.get(name));
        let deeper = |item: Option<Item<'s>>, name: &&str| item.map(|i| i.child(name).unwrap_or(i));
        match names.iter().skip(1).fold(start, deeper) {
            Some(item) => item.note(sentence),
            None => self.note(sentence),
        }
    }

    /// The full key.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The names in the table, in alphabetical order, with their values.
    pub fn entries(&self) -> Vec<(&'s str, Item<'s>)> {
        let entry = |(name, value): (&'s toml::Spanned<_>, _)| {
            let name: &'s std::borrow::Cow<'s, str> = name.get_ref();
            (name.as_ref(), Item::new(self.document, self.child(name), value))
        };
        self.table.iter().map(entry).collect()
    }

    /// The value of `name`, if the table has it.
    pub fn get(&self, name: &str) -> Option<Item<'s>> {
        let value = self.table.get(name)?;
        Some(Item::new(self.document, self.child(name), value))
    }

    /// Whether the table has `name`.
    pub fn has(&self, name: &str) -> bool {
        self.table.contains_key(name)
    }

    /// Reads `name` if the table has it.
    pub fn optional<T>(&self, name: &str, read: impl FnOnce(&Item<'s>) -> Reading<T>) -> Reading<Option<T>> {
        self.get(name).map(|item| read(&item)).transpose()
    }

    /// Reads `name`; its absence is a problem. `expected` says what belongs there.
    pub fn required<T>(&self, name: &str, expected: &str, read: impl FnOnce(&Item<'s>) -> Reading<T>) -> Reading<T> {
        match self.get(name) {
            Some(item) => read(&item),
            None => Err(self.missing(name, expected)),
        }
    }

    /// Notes that `name` is missing.
    pub fn missing(&self, name: &str, expected: &str) -> Noted {
        self.note(format!("{} is missing; expected {expected}", self.child(name)))
    }

    /// Refuses two of the given keys together.
    pub fn exclusive(&self, names: &[&str], advice: &str) -> Reading<()> {
        let given: Vec<String> = names.iter().filter(|n| self.has(n)).map(|n| self.child(n)).collect();
        let second = names.iter().filter_map(|n| self.get(n)).nth(1);
        match second {
            None => Ok(()),
            Some(item) => Err(item.note(format!("{} exclude each other; {advice}", enumeration(&given)))),
        }
    }

    fn child(&self, name: &str) -> String {
        match self.key.is_empty() {
            true => name.to_string(),
            false => format!("{}.{name}", self.key),
        }
    }
}

/// The known word that `word` was probably meant to be.
pub fn nearest<'k>(word: &str, known: &[&'k str]) -> Option<&'k str> {
    let scored = known.iter().map(|k| (strsim::damerau_levenshtein(word, k), *k));
    let (distance, near) = scored.min_by_key(|(distance, _)| *distance)?;
    (distance <= 1 + near.len() / 4).then_some(near)
}

/// `a`, `a or b`, `a, b or c`.
pub fn alternatives(names: &[String]) -> String {
    joined(names, "or")
}

/// `a`, `a and b`, `a, b and c`.
pub fn enumeration(names: &[String]) -> String {
    joined(names, "and")
}

fn joined(names: &[String], word: &str) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} {word} {last}", most.join(", ")),
    }
}
