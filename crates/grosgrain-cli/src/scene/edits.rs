//! What changes during the run: `[[edit]]`.

use grosgrain::mesh::Selector;

use super::document::{Item, Reading, read_all};
use super::materials::Constants;
use super::section::{Section, alternatives};
use super::selector::read_selector;
use super::{Scene, SceneMaterial};

/// A time or an interval, in either of two measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// Seconds \[s\].
    Seconds(f64),
    /// Steps.
    Steps(usize),
}

impl When {
    /// In seconds, where a step takes `length` seconds.
    pub fn seconds(self, length: f64) -> f64 {
        match self {
            Self::Seconds(seconds) => seconds,
            Self::Steps(steps) => steps as f64 * length,
        }
    }
}

/// How an edit goes on after the first time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeat {
    /// The interval.
    pub every: When,
    /// By how much the region moves at each repetition \[m\].
    pub advance: [f64; 3],
    /// How many times the edit is made in all.
    pub times: Option<usize>,
    /// No repetition comes after this time \[s\].
    pub until: Option<f64>,
}

/// What an edit does, with materials by name.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneChange {
    /// Solid cells get a material.
    Material(String),
    /// Solid cells get a Young modulus \[Pa\].
    Young(f64),
    /// Solid cells become void.
    Remove,
    /// Void cells get a material.
    Add(String),
}

/// One `[[edit]]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneEdit {
    /// When it is made first.
    pub at: When,
    /// Whether and how it is repeated.
    pub repeat: Option<Repeat>,
    /// Where.
    pub selection: Selector,
    /// What it does.
    pub change: SceneChange,
    /// Its key, e.g. `edit[0]`.
    pub key: String,
}

const KEYS: &[&str] = &[
    "at",
    "at_step",
    "every",
    "every_steps",
    "advance",
    "times",
    "until",
    "where",
    "remove",
    "material",
    "young",
    "add",
];
const CHANGES: [&str; 4] = ["remove", "material", "young", "add"];

/// Reads `[[edit]]`.
pub fn read_edits(item: &Item) -> Reading<Vec<SceneEdit>> {
    read_all(&item.list("one table [[edit]] for each change")?, |edit| {
        let section = edit.section(KEYS)?;
        let at = read_start(&section);
        let repeat = read_repeat(&section);
        let selection = section.required("where", "the selector of the cells that change", read_selector);
        let change = read_change(&section);
        Ok(SceneEdit { at: at?, repeat: repeat?, selection: selection?, change: change?, key: edit.key().into() })
    })
}

fn read_start(section: &Section) -> Reading<When> {
    let start = read_when(section, ["at", "at_step"], "give seconds or a step")?;
    start.ok_or_else(|| section.missing("at", "a positive number of seconds, or at_step with a step from 1 on"))
}

fn read_when(section: &Section, [seconds, steps]: [&str; 2], advice: &str) -> Reading<Option<When>> {
    section.exclusive(&[seconds, steps], advice)?;
    let in_seconds = section.optional(seconds, |at| at.positive().map(When::Seconds));
    let in_steps = section.optional(steps, |at| at.count().map(When::Steps));
    Ok(in_seconds?.or(in_steps?))
}

fn read_repeat(section: &Section) -> Reading<Option<Repeat>> {
    let every = read_when(section, ["every", "every_steps"], "give seconds or a number of steps");
    let exclusive = section.exclusive(&["times", "until"], "one of them ends the repetition");
    let advance = section.optional("advance", Item::vector);
    let times = section.optional("times", Item::count);
    let until = section.optional("until", Item::positive);
    exclusive?;
    let (every, advance, times, until) = (every?, advance?, times?, until?);
    let Some(every) = every else {
        return match ["advance", "times", "until"].iter().find_map(|name| section.get(name)) {
            None => Ok(None),
            Some(item) => {
                Err(item.note(format!("{} stands without a repetition; expected every or every_steps", item.key())))
            }
        };
    };
    Ok(Some(Repeat { every, advance: advance.unwrap_or_default(), times, until }))
}

fn read_change(section: &Section) -> Reading<SceneChange> {
    section.exclusive(&CHANGES, "write one [[edit]] table for each")?;
    let name = |item: &Item| item.text().map(String::from);
    let removed = section.optional("remove", |remove| match remove.boolean()? {
        true => Ok(SceneChange::Remove),
        false => Err(remove.refuse("true; leave the edit out to remove nothing")),
    });
    let material = section.optional("material", |material| name(material).map(SceneChange::Material));
    let young = section.optional("young", |young| {
        young.number_where("a positive finite number of pascals", |v| v > 0.0).map(SceneChange::Young)
    });
    let added = section.optional("add", |add| name(add).map(SceneChange::Add));
    let change = removed?.or(material?).or(young?).or(added?);
    let expected = alternatives(&CHANGES.map(String::from));
    change.ok_or_else(|| section.note(format!("{} does not change anything; expected {expected}", section.key())))
}

/// Notes edits that do not fit the other tables.
pub fn check(root: &Section, scene: &Scene) -> Reading<()> {
    let Some(list) = root.get("edit") else { return Ok(()) };
    let items = list.list("")?;
    let checks = items.iter().zip(&scene.edits).map(|(item, edit)| {
        let material = check_material(item, edit, scene);
        check_times(item, edit, scene).and(material)
    });
    checks.collect::<Vec<_>>().into_iter().collect()
}

fn check_material(item: &Item, edit: &SceneEdit, scene: &Scene) -> Reading<()> {
    let (key, name) = match &edit.change {
        SceneChange::Material(name) => ("material", name),
        SceneChange::Add(name) => ("add", name),
        SceneChange::Young(_) | SceneChange::Remove => return Ok(()),
    };
    let at = item.child(key).unwrap_or_else(|| item.clone());
    match scene.materials.iter().find(|m| m.name == *name) {
        Some(SceneMaterial { constants: Constants::YoungPerVoxel { .. }, .. }) => Err(at.note(format!(
            "{} is {name:?}, a material without young; expected one that gives young and poisson",
            at.key()
        ))),
        Some(_) => Ok(()),
        None => {
            let known: Vec<String> = scene.materials.iter().map(|m| format!("{:?}", m.name)).collect();
            let expected = if known.is_empty() { "a table [materials.NAME]".into() } else { alternatives(&known) };
            Err(at.note(format!("{} is {name:?}, which is no material; expected {expected}", at.key())))
        }
    }
}

fn check_times(item: &Item, edit: &SceneEdit, scene: &Scene) -> Reading<()> {
    let note = |name: &str, sentence: String| {
        let at = item.child(name).unwrap_or_else(|| item.clone());
        Err(at.note(format!("{} {sentence}", at.key())))
    };
    let every = edit.repeat.map(|r| r.every);
    let until = edit.repeat.and_then(|r| r.until);
    let Some(step) = scene.time.step else {
        let in_seconds = [
            ("at", matches!(edit.at, When::Seconds(_))),
            ("every", matches!(every, Some(When::Seconds(_)))),
            ("until", until.is_some()),
        ];
        return match in_seconds.iter().find(|(_, given)| *given) {
            None => check_steps(&note, edit, scene),
            Some((name, _)) => {
                note(name, "is in seconds, but time.step is missing; expected time.step, the seconds per step".into())
            }
        };
    };
    match every {
        Some(When::Seconds(every)) if every < step * (1.0 - 1e-9) => {
            note("every", format!("is {every} s, shorter than a step; expected at least time.step, {step} s"))
        }
        _ => check_steps(&note, edit, scene),
    }
}

fn check_steps(note: &dyn Fn(&str, String) -> Reading<()>, edit: &SceneEdit, scene: &Scene) -> Reading<()> {
    let first = edit.step(0, scene.time.step);
    let name = if matches!(edit.at, When::Seconds(_)) { "at" } else { "at_step" };
    let every = if edit.repeat.is_some_and(|r| matches!(r.every, When::Seconds(_))) { "every" } else { "every_steps" };
    match (scene.time.steps, edit.last_step(scene.time.step)) {
        _ if first.is_none() => note("until", "comes before the edit is made; expected a later time".into()),
        (None, None) => note(every, "repeats the edit for ever; expected times, until or time.steps".into()),
        (Some(steps), _) if first.is_some_and(|first| first > steps) => {
            note(name, format!("comes after the last step; expected a time within the {steps} steps of time.steps"))
        }
        _ => Ok(()),
    }
}

impl SceneEdit {
    /// The step of repetition `n`, from 0, where a step takes `step` seconds; `None` if it never comes.
    pub fn step(&self, n: usize, step: Option<f64>) -> Option<usize> {
        let length = step.unwrap_or(1.0);
        let Some(repeat) = self.repeat.as_ref().filter(|_| n > 0 || self.repeat.is_some_and(|r| r.until.is_some()))
        else {
            return (n == 0).then(|| self.first(step));
        };
        if repeat.times.is_some_and(|times| n >= times) {
            return None;
        }
        let time = self.at.seconds(length) + n as f64 * repeat.every.seconds(length);
        if repeat.until.is_some_and(|until| time > until + 1e-9 * length) {
            return None;
        }
        match (self.at, repeat.every) {
            (When::Steps(first), When::Steps(every)) => n.checked_mul(every).and_then(|later| first.checked_add(later)),
            _ => Some(step_at(time, length)),
        }
    }

    /// Whether cells get the material of this name.
    pub fn sets(&self, name: &str) -> bool {
        matches!(&self.change, SceneChange::Material(given) | SceneChange::Add(given) if given == name)
    }

    fn first(&self, step: Option<f64>) -> usize {
        match self.at {
            When::Steps(first) => first,
            When::Seconds(time) => step_at(time, step.unwrap_or(1.0)),
        }
    }

    /// The step of the last repetition; `None` if there is no last one.
    pub fn last_step(&self, step: Option<f64>) -> Option<usize> {
        let Some(repeat) = &self.repeat else { return Some(self.first(step)) };
        if let Some(times) = repeat.times {
            return self.step(times - 1, step);
        }
        let until = repeat.until?;
        let length = step.unwrap_or(1.0);
        let n = ((until - self.at.seconds(length)) / repeat.every.seconds(length)).max(0.0) as usize;
        [n + 1, n, n.saturating_sub(1)].iter().find_map(|n| self.step(*n, step))
    }
}

/// The first step that is not before a time: steps are at their number times their length.
fn step_at(time: f64, length: f64) -> usize {
    ((time / length - 1e-9).ceil() as usize).max(1)
}
