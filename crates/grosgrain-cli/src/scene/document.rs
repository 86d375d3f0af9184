//! A scene file as text with places: every value knows its key and its line.

use std::cell::RefCell;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::problem::Problem;
use super::section::Section;

/// The problem has been noted in the [`Document`]; there is no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Noted;

/// A value, or the mark that a problem was noted instead.
pub type Reading<T> = Result<T, Noted>;

/// The text of a scene and the problems found in it so far.
pub struct Document<'s> {
    text: &'s str,
    folder: &'s Path,
    problems: RefCell<Vec<Problem>>,
}

impl<'s> Document<'s> {
    /// A document of `text` whose relative paths start at `folder`.
    pub fn new(text: &'s str, folder: &'s Path) -> Self {
        Self { text, folder, problems: RefCell::default() }
    }

    /// The line, from 1, of the byte at `at`.
    pub fn line(&self, at: usize) -> usize {
        1 + self.text[..at].bytes().filter(|b| *b == b'\n').count()
    }

    /// Notes a problem at the byte range `at`.
    pub fn note(&self, at: Range<usize>, sentence: String) -> Noted {
        let line = self.line(at.start);
        self.problems.borrow_mut().push(Problem { line, sentence });
        Noted
    }

    /// All problems in the order of their lines.
    pub fn into_problems(self) -> Vec<Problem> {
        let mut problems = self.problems.into_inner();
        problems.sort_by_key(|p| p.line);
        problems.dedup();
        problems
    }
}

/// A value of the scene with its key.
#[derive(Clone)]
pub struct Item<'s> {
    document: &'s Document<'s>,
    key: String,
    value: &'s Spanned<DeValue<'s>>,
}

impl<'s> Item<'s> {
    /// The value at `key` of `document`.
    pub fn new(document: &'s Document<'s>, key: String, value: &'s Spanned<DeValue<'s>>) -> Self {
        Self { document, key, value }
    }

    /// The full key, e.g. `materials.soft.young`.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Notes that this value is not what is `expected`.
    pub fn refuse(&self, expected: &str) -> Noted {
        self.note(format!("{} is {}; expected {expected}", self.key, self.found()))
    }

    /// Notes that this value means something, but nothing that this version can do.
    pub fn refuse_for_now(&self, instead: &str) -> Noted {
        self.note(format!("{} is {}, which this version cannot do; expected {instead}", self.key, self.found()))
    }

    /// Notes a sentence at this value.
    pub fn note(&self, sentence: String) -> Noted {
        self.document.note(self.value.span(), sentence)
    }

    /// What the file says, short enough for a sentence.
    fn found(&self) -> String {
        let source = &self.document.text[self.value.span()];
        let short = source.len() <= 48 && !source.contains('\n');
        match self.value.get_ref() {
            DeValue::Table(_) => "a table".into(),
            DeValue::Array(items) if !short => format!("a list of {} items", items.len()),
            DeValue::String(_) if !short => "a long text".into(),
            _ => source.into(),
        }
    }

    /// A finite number; integers count as numbers.
    pub fn number(&self) -> Reading<f64> {
        self.number_where("a finite number", |_| true)
    }

    /// A finite number for which `allowed` holds; `expected` names the condition.
    pub fn number_where(&self, expected: &str, allowed: impl Fn(f64) -> bool) -> Reading<f64> {
        let value = match self.value.get_ref() {
            DeValue::Float(v) => v.as_str().parse().ok(),
            DeValue::Integer(v) => i64::from_str_radix(v.as_str(), v.radix()).ok().map(|v| v as f64),
            _ => None,
        };
        value.filter(|v: &f64| v.is_finite() && allowed(*v)).ok_or_else(|| self.refuse(expected))
    }

    /// A finite number above zero.
    pub fn positive(&self) -> Reading<f64> {
        self.number_where("a positive finite number", |v| v > 0.0)
    }

    /// A finite number, zero or above.
    pub fn non_negative(&self) -> Reading<f64> {
        self.number_where("a finite number that is not negative", |v| v >= 0.0)
    }

    /// An integer for which `allowed` holds; `expected` names the condition.
    pub fn integer_where(&self, expected: &str, allowed: impl Fn(i64) -> bool) -> Reading<i64> {
        let value = match self.value.get_ref() {
            DeValue::Integer(v) => i64::from_str_radix(v.as_str(), v.radix()).ok(),
            _ => None,
        };
        value.filter(|v| allowed(*v)).ok_or_else(|| self.refuse(expected))
    }

    /// An integer of 32 bits; `expected` says what it stands for.
    pub fn integer_32(&self, expected: &str) -> Reading<i32> {
        let value = self.integer_where(expected, |_| true)?;
        i32::try_from(value).map_err(|_| self.refuse(expected))
    }

    /// An integer of at least 1.
    pub fn count(&self) -> Reading<usize> {
        self.integer_where("an integer of at least 1", |v| v >= 1).map(|v| v as usize)
    }

    /// True or false.
    pub fn boolean(&self) -> Reading<bool> {
        match self.value.get_ref() {
            DeValue::Boolean(v) => Ok(*v),
            _ => Err(self.refuse("true or false")),
        }
    }

    /// The value of `name` in this table.
    pub fn child(&self, name: &str) -> Option<Item<'s>> {
        let value = self.value.get_ref().as_table()?.get(name)?;
        Some(Item::new(self.document, format!("{}.{name}", self.key), value))
    }

    /// Whether the value is exactly this text.
    pub fn says(&self, text: &str) -> bool {
        self.value.get_ref().as_str() == Some(text)
    }

    /// The full keys of this value and of all below it, each with its line.
    pub fn lines(&self) -> Vec<(String, usize)> {
        let children: Vec<Item> = match self.value.get_ref() {
            DeValue::Table(_) => self.named_entries("").into_iter().flatten().map(|(_, item)| item).collect(),
            DeValue::Array(items) => self.items(items),
            _ => Vec::new(),
        };
        let own = (self.key.clone(), self.document.line(self.value.span().start));
        std::iter::once(own).chain(children.iter().flat_map(Item::lines)).collect()
    }

    fn items(&self, items: &'s toml::de::DeArray<'s>) -> Vec<Item<'s>> {
        let item = |(n, value)| Item::new(self.document, format!("{}[{n}]", self.key), value);
        items.iter().enumerate().map(item).collect()
    }

    /// Whether the value is a text.
    pub fn is_text(&self) -> bool {
        self.value.get_ref().is_str()
    }

    /// Whether the value is a table.
    pub fn is_table(&self) -> bool {
        self.value.get_ref().is_table()
    }

    /// Whether the value is a list.
    pub fn is_list(&self) -> bool {
        self.value.get_ref().is_array()
    }

    /// A text.
    pub fn text(&self) -> Reading<&'s str> {
        self.value.get_ref().as_str().ok_or_else(|| self.refuse("a text in quotes"))
    }

    /// One of the names in `choices`, with the value that belongs to it.
    pub fn choice<T: Copy>(&self, choices: &[(&str, T)]) -> Reading<T> {
        let found = self.value.get_ref().as_str();
        let chosen = choices.iter().find(|(name, _)| Some(*name) == found);
        chosen.map(|(_, value)| *value).ok_or_else(|| {
            let names: Vec<String> = choices.iter().map(|(name, _)| format!("{name:?}")).collect();
            self.refuse(&super::section::alternatives(&names))
        })
    }

    /// The path of an existing file or folder, relative to the scene.
    pub fn existing_path(&self) -> Reading<PathBuf> {
        let name = self.value.get_ref().as_str().ok_or_else(|| self.refuse("a path in quotes"))?;
        let path = self.document.folder.join(name);
        match path.exists() {
            true => Ok(path),
            false => Err(self.note(format!(
                "{} names {:?}, which does not exist; paths are relative to the folder of the scene",
                self.key, name
            ))),
        }
    }

    /// The items of a list that is not empty; `expected` names what it must be.
    pub fn list(&self, expected: &str) -> Reading<Vec<Item<'s>>> {
        let items = self.value.get_ref().as_array().filter(|items| !items.is_empty());
        let items = items.ok_or_else(|| self.refuse(expected))?;
        Ok(self.items(items))
    }

    /// A list of exactly `N` items, each read by `read`; `expected` names what the list must be.
    pub fn array<T, const N: usize>(&self, expected: &str, read: impl Fn(&Item<'s>) -> Reading<T>) -> Reading<[T; N]> {
        let items = self.list(expected)?;
        if items.len() != N {
            return Err(self.refuse(expected));
        }
        let values = read_all(&items, read)?;
        values.try_into().map_err(|_| self.refuse(expected))
    }

    /// Three finite numbers.
    pub fn vector(&self) -> Reading<[f64; 3]> {
        self.array("a list of three numbers", Item::number)
    }

    /// A table whose keys are names that the user chose.
    pub fn named_entries(&self, expected: &str) -> Reading<Vec<(&'s str, Item<'s>)>> {
        let table: &'s DeTable<'s> = self.value.get_ref().as_table().ok_or_else(|| self.refuse(expected))?;
        Ok(Section::new(self.document, self.key.clone(), self.value.span(), table).entries())
    }

    /// A table whose keys are among `known`; every other key is noted.
    pub fn section(&self, known: &'static [&'static str]) -> Reading<Section<'s>> {
        let table: &'s DeTable<'s> = self.value.get_ref().as_table().ok_or_else(|| {
            let list: Vec<String> = known.iter().map(|k| k.to_string()).collect();
            self.refuse(&format!("a table with {}", super::section::alternatives(&list)))
        })?;
        Ok(Section::new(self.document, self.key.clone(), self.value.span(), table).limited_to(known))
    }
}

/// Reads every item before giving up, so that all problems of a list are noted.
pub fn read_all<'s, T>(items: &[Item<'s>], read: impl Fn(&Item<'s>) -> Reading<T>) -> Reading<Vec<T>> {
    let readings: Vec<Reading<T>> = items.iter().map(read).collect();
    readings.into_iter().collect()
}
