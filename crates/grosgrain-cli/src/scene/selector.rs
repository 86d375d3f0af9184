//! Which nodes or cells a condition holds on.

use grosgrain::mesh::{Axis, Blade, Brush, Cut, Label, PlaneAt, Selector};

use super::document::{Item, Reading, read_all};
use super::section::{Section, enumeration};

const KINDS: [&str; 11] = ["all", "plane", "box", "sphere", "label", "cut", "blade", "brush", "not", "and", "or"];
const KEYS: &[&str] = &["all", "plane", "at", "box", "sphere", "label", "cut", "blade", "brush", "not", "and", "or"];
const EXPECTED: &str = "\"all\" or a table with one of all, plane, box, sphere, label, cut, blade, brush, not, and, or";

/// Reads a selector: `"all"`, `{ plane = "x", at = "min" }`, `{ box = [[..], [..]] }` and so on.
pub fn read_selector(item: &Item) -> Reading<Selector> {
    if item.says("all") {
        return Ok(Selector::All);
    }
    if !item.is_table() {
        return Err(item.refuse(EXPECTED));
    }
    let section = item.section(KEYS)?;
    let given: Vec<String> = KINDS.iter().filter(|k| section.has(k)).map(|k| k.to_string()).collect();
    match given.as_slice() {
        [kind] => read_kind(kind, &section),
        [] => Err(item.note(format!("{} selects nothing; expected {EXPECTED}", item.key()))),
        several => Err(item.note(format!(
            "{} holds {} side by side; combine selectors with and = [..] or or = [..]",
            item.key(),
            enumeration(several)
        ))),
    }
}

fn read_kind(kind: &str, section: &Section) -> Reading<Selector> {
    if let (true, Some(at)) = (kind != "plane", section.get("at")) {
        return Err(at.note(format!("{} stands without a plane; expected plane = \"x\", \"y\" or \"z\"", at.key())));
    }
    section.required(kind, EXPECTED, |item| match kind {
        "plane" => read_plane(item, section),
        "box" => read_box(item),
        "sphere" => read_sphere(item),
        "label" => read_label(item).map(Selector::Label),
        "cut" => read_cut(item),
        "blade" => read_blade(item),
        "brush" => read_brush(item),
        "not" => read_selector(item).map(|inner| Selector::Not(Box::new(inner))),
        "and" => read_several(item).map(Selector::And),
        "or" => read_several(item).map(Selector::Or),
        _ => match item.boolean()? {
            true => Ok(Selector::All),
            false => Err(item.refuse("true; leave the condition out to select nothing")),
        },
    })
}

/// Reads a label: any 32-bit integer.
pub fn read_label(item: &Item) -> Reading<Label> {
    item.integer_32("an integer label of 32 bits").map(Label)
}

fn read_several(item: &Item) -> Reading<Vec<Selector>> {
    read_all(&item.list("a list of at least one selector")?, read_selector)
}

fn read_plane(item: &Item, section: &Section) -> Reading<Selector> {
    let axis = item.choice(&[("x", Axis::X), ("y", Axis::Y), ("z", Axis::Z)]);
    let expected = "\"min\", \"max\" or a coordinate in metres";
    let at = section.required("at", expected, |at| match at.is_text() {
        true if at.says("min") => Ok(PlaneAt::Min),
        true if at.says("max") => Ok(PlaneAt::Max),
        _ => at.number_where(expected, |_| true).map(PlaneAt::Coordinate),
    });
    Ok(Selector::Plane { axis: axis?, at: at? })
}

fn read_box(item: &Item) -> Reading<Selector> {
    let [low, high]: [[f64; 3]; 2] = item.array("two corners, [[x, y, z], [x, y, z]]", Item::vector)?;
    match (0..3).all(|a| low[a] <= high[a]) {
        true => Ok(Selector::Box { low, high }),
        false => Err(item.refuse("the lower corner first: no coordinate of it above the upper corner's")),
    }
}

fn read_sphere(item: &Item) -> Reading<Selector> {
    let section = item.section(&["centre", "radius"])?;
    let centre = section.required("centre", "a list of three numbers in metres", Item::vector);
    let radius = section.required("radius", "a positive number in metres", Item::positive);
    Ok(Selector::Sphere { centre: centre?, radius: radius? })
}

/// What the library refuses, at the selector's own line.
fn usable(item: &Item, selector: Selector) -> Reading<Selector> {
    match selector.validate() {
        Ok(()) => Ok(selector),
        Err(error) => Err(item.note(format!("{}: {error}", item.key()))),
    }
}

fn read_cut(item: &Item) -> Reading<Selector> {
    let section = item.section(&["point", "normal", "radius"])?;
    let point = section.required("point", "a point of the plane, three numbers in metres", Item::vector);
    let normal = section.required("normal", "the plane's normal, three numbers", Item::vector);
    let radius = section.optional("radius", Item::positive);
    usable(item, Selector::Cut(Cut { point: point?, normal: normal?, radius: radius? }))
}

/// `sweep` is one vector, or a list of vectors along which the edge moves one after the other.
fn read_blade(item: &Item) -> Reading<Selector> {
    let section = item.section(&["edge", "sweep"])?;
    let ends = "the ends of the edge, [[x, y, z], [x, y, z]]";
    let edge = section.required("edge", ends, |edge| edge.array(ends, Item::vector));
    let expected = "a list of three numbers in metres, or a list of such lists";
    let sweep = section.required("sweep", expected, |sweep| {
        let parts = sweep.list(expected)?;
        match parts.iter().any(Item::is_list) {
            true => read_all(&parts, Item::vector),
            false => sweep.vector().map(|one| vec![one]),
        }
    });
    let mut blades = Blade::path(edge?, &sweep?).into_iter().map(Selector::Blade).collect::<Vec<_>>();
    let selector = if blades.len() == 1 { blades.remove(0) } else { Selector::Or(blades) };
    usable(item, selector)
}

fn read_brush(item: &Item) -> Reading<Selector> {
    let section = item.section(&["path", "radius"])?;
    let expected = "a list of at least one point, [[x, y, z], ..]";
    let path = section.required("path", expected, |path| read_all(&path.list(expected)?, Item::vector));
    let radius = section.required("radius", "a positive number in metres", Item::positive);
    usable(item, Selector::Brush(Brush { path: path?, radius: radius? }))
}
