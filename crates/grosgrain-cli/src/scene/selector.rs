//! Which nodes or cells a condition holds on.

use grosgrain::mesh::Label;

use super::document::{Item, Reading, read_all};
use super::section::{Section, enumeration};

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The first axis.
    X,
    /// The second axis.
    Y,
    /// The third axis.
    Z,
}

/// Where along its axis a plane stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanePosition {
    /// At the smallest coordinate of the body's solid part.
    Min,
    /// At the largest coordinate of the body's solid part.
    Max,
    /// At a coordinate [m].
    At(f64),
}

/// A part of the body.
#[derive(Clone, Debug, PartialEq)]
pub enum Selector {
    /// Everything.
    All,
    /// A plane normal to an axis.
    Plane(Axis, PlanePosition),
    /// An axis-parallel box between two corners [m].
    Box([f64; 3], [f64; 3]),
    /// A ball [m].
    Sphere {
        /// Its centre.
        centre: [f64; 3],
        /// Its radius.
        radius: f64,
    },
    /// What carries a label.
    Label(Label),
    /// What the inner selector leaves out.
    Not(Box<Selector>),
    /// What all of them hold.
    And(Vec<Selector>),
    /// What any of them holds.
    Or(Vec<Selector>),
}

const KINDS: [&str; 8] = ["all", "plane", "box", "sphere", "label", "not", "and", "or"];
const KEYS: &[&str] = &["all", "plane", "at", "box", "sphere", "label", "not", "and", "or"];
const EXPECTED: &str = "\"all\" or a table with one of all, plane, box, sphere, label, not, and, or";

impl Selector {
    /// Reads a selector: `"all"`, `{ plane = "x", at = "min" }`, `{ box = [[..], [..]] }` and so on.
    pub fn read(item: &Item) -> Reading<Self> {
        if item.is_text() {
            return item.text().ok().filter(|t| *t == "all").map(|_| Self::All).ok_or_else(|| item.refuse(EXPECTED));
        }
        if !item.is_table() {
            return Err(item.refuse(EXPECTED));
        }
        let section = item.section(KEYS)?;
        let given: Vec<String> = KINDS.iter().filter(|k| section.has(k)).map(|k| k.to_string()).collect();
        match given.as_slice() {
            [kind] => Self::read_kind(kind, &section),
            [] => Err(item.note(format!("{} selects nothing; expected {EXPECTED}", item.key()))),
            several => Err(item.note(format!(
                "{} holds {} side by side; combine selectors with and = [..] or or = [..]",
                item.key(),
                enumeration(several)
            ))),
        }
    }

    fn read_kind(kind: &str, section: &Section) -> Reading<Self> {
        if let (true, Some(at)) = (kind != "plane", section.get("at")) {
            return Err(at.note(format!("{} stands without a plane; expected plane = \"x\", \"y\" or \"z\"", at.key())));
        }
        section.required(kind, EXPECTED, |item| match kind {
            "plane" => read_plane(item, section),
            "box" => read_box(item),
            "sphere" => read_sphere(item),
            "label" => read_label(item).map(Self::Label),
            "not" => Self::read(item).map(|inner| Self::Not(Box::new(inner))),
            "and" => read_several(item).map(Self::And),
            "or" => read_several(item).map(Self::Or),
            _ => match item.boolean()? {
                true => Ok(Self::All),
                false => Err(item.refuse("true; leave the condition out to select nothing")),
            },
        })
    }
}

/// Reads a label: any 32-bit integer.
pub fn read_label(item: &Item) -> Reading<Label> {
    let in_range = |v: i64| i32::try_from(v).is_ok();
    item.integer_where("an integer label of 32 bits", in_range).map(|v| Label(v as i32))
}

fn read_several(item: &Item) -> Reading<Vec<Selector>> {
    read_all(&item.list("a list of at least one selector")?, Selector::read)
}

fn read_plane(item: &Item, section: &Section) -> Reading<Selector> {
    let axis = item.choice(&[("x", Axis::X), ("y", Axis::Y), ("z", Axis::Z)]);
    let expected = "\"min\", \"max\" or a coordinate in metres";
    let at = section.required("at", expected, |at| match at.is_text() {
        true => at.choice(&[("min", PlanePosition::Min), ("max", PlanePosition::Max)]),
        false => at.number_where(expected, |_| true).map(PlanePosition::At),
    });
    Ok(Selector::Plane(axis?, at?))
}

fn read_box(item: &Item) -> Reading<Selector> {
    let [low, high]: [[f64; 3]; 2] = item.array("two corners, [[x, y, z], [x, y, z]]", Item::vector)?;
    match (0..3).all(|a| low[a] <= high[a]) {
        true => Ok(Selector::Box(low, high)),
        false => Err(item.refuse("the lower corner first: no coordinate of it above the upper corner's")),
    }
}

fn read_sphere(item: &Item) -> Reading<Selector> {
    let section = item.section(&["centre", "radius"])?;
    let centre = section.required("centre", "a list of three numbers in metres", Item::vector);
    let radius = section.required("radius", "a positive number in metres", Item::positive);
    Ok(Selector::Sphere { centre: centre?, radius: radius? })
}
