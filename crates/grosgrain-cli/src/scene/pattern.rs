//! Synthetic bodies: `grid` and `pattern`.

use std::path::PathBuf;

use grosgrain::mesh::{Bars, Label, Pattern, SphereCentres};

use crate::quantities::{count, triple_count};

use super::document::{Item, Reading, read_all};
use super::section::Section;
use super::selector::read_label;

/// A grid without a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Fine cells along x, y, z.
    pub cells: [usize; 3],
    /// Edge lengths of the whole box \[m\].
    pub size: [f64; 3],
}

/// What fills a grid.
#[derive(Clone, Debug, PartialEq)]
pub enum Filling {
    /// A synthetic pattern.
    Pattern(Pattern),
    /// The integers of a volume file with as many voxels as the grid has cells.
    File(PathBuf),
}

/// Reads `grid`.
pub fn read_grid(item: &Item) -> Reading<Grid> {
    let section = item.section(&["cells", "size"])?;
    let cells = section.required("cells", "three integers of at least 1", read_cells);
    let expected = "three positive numbers in metres";
    let size = section.required("size", expected, |size| size.array(expected, Item::positive));
    Ok(Grid { cells: cells?, size: size? })
}

/// More cells than this are refused: 24 GB hold about as many of a matrix-free model.
const LARGEST_GRID: usize = 50_000_000;

/// Reads a number of cells along x, y, z that fits into memory.
pub fn read_cells(item: &Item) -> Reading<[usize; 3]> {
    let cells: [usize; 3] = item.array("three integers of at least 1", Item::count)?;
    let product = cells.iter().try_fold(1usize, |product, n| product.checked_mul(*n));
    match product.is_some_and(|product| product <= LARGEST_GRID) {
        true => Ok(cells),
        false => Err(item.note(format!(
            "{} asks for {} cells; expected at most {} in all",
            item.key(),
            triple_count(cells),
            count(LARGEST_GRID)
        ))),
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Layers,
    Checkerboard,
    Random,
    Spheres,
    Grid,
    FromFile,
}

const KEYS: &[&str] = &[
    "kind",
    "direction",
    "period",
    "labels",
    "size",
    "seed",
    "fractions",
    "count",
    "centres",
    "radius",
    "width",
    "box",
    "file",
];

/// Reads `pattern`.
pub fn read_pattern(item: &Item) -> Reading<Filling> {
    let section = item.section(KEYS)?;
    let kinds = [
        ("layers", Kind::Layers),
        ("checkerboard", Kind::Checkerboard),
        ("random", Kind::Random),
        ("spheres", Kind::Spheres),
        ("grid", Kind::Grid),
        ("from-file", Kind::FromFile),
    ];
    let expected = "\"layers\", \"checkerboard\", \"random\", \"spheres\", \"grid\" or \"from-file\"";
    let kind = section.required("kind", expected, |kind| kind.choice(&kinds))?;
    refuse_foreign_keys(&section, kind)?;
    match kind {
        Kind::Layers => read_layers(&section),
        Kind::Checkerboard => read_checkerboard(&section),
        Kind::Random => read_random(&section),
        Kind::Spheres => read_spheres(&section),
        Kind::Grid => read_bars(&section),
        Kind::FromFile => {
            return section.required("file", "a volume file of integers", Item::existing_path).map(Filling::File);
        }
    }
    .map(Filling::Pattern)
}

/// Refuses keys that belong to other kinds of pattern.
fn refuse_foreign_keys(section: &Section, kind: Kind) -> Reading<()> {
    let (name, keys): (_, &[&str]) = match kind {
        Kind::Layers => ("layers", &["direction", "period", "labels"]),
        Kind::Checkerboard => ("checkerboard", &["size", "labels"]),
        Kind::Random => ("random", &["size", "seed", "labels", "fractions"]),
        Kind::Spheres => ("spheres", &["radius", "labels", "centres", "period", "count", "seed"]),
        Kind::Grid => ("grid", &["period", "width", "box", "labels"]),
        Kind::FromFile => ("from-file", &["file"]),
    };
    let is_foreign = |key: &&&str| **key != "kind" && !keys.contains(key);
    match KEYS.iter().filter(is_foreign).find_map(|key| section.get(key)) {
        None => Ok(()),
        Some(item) => Err(item.note(format!(
            "{} does not belong to a pattern of kind {name:?}; known there: {}",
            item.key(),
            keys.join(", ")
        ))),
    }
}

fn read_layers(section: &Section) -> Reading<Pattern> {
    let expected = "three numbers, not all zero";
    let direction = section.required("direction", expected, |item| match item.vector()? {
        [0.0, 0.0, 0.0] => Err(item.refuse(expected)),
        direction => Ok(direction),
    });
    let period = read_period(section);
    let labels = read_labels(section);
    Ok(Pattern::Layers { direction: direction?, period: period?, labels: labels? })
}

fn read_checkerboard(section: &Section) -> Reading<Pattern> {
    let (size, labels) = (read_block(section), read_labels(section));
    Ok(Pattern::Checkerboard { size: size?, labels: labels? })
}

fn read_random(section: &Section) -> Reading<Pattern> {
    let (size, seed, labels) = (read_block(section), read_seed(section), read_labels(section));
    let fractions = section.optional("fractions", |item| {
        let expected = "one number for each label, none negative, with the sum 1";
        let fractions = read_all(&item.list(expected)?, Item::non_negative)?;
        let fits = labels.as_ref().is_ok_and(|labels| labels.len() == fractions.len());
        let is_one = (fractions.iter().sum::<f64>() - 1.0).abs() <= 1e-9;
        (fits && is_one).then_some(fractions).ok_or_else(|| item.refuse(expected))
    });
    Ok(Pattern::Random { size: size?, seed: seed?, labels: labels?, fractions: fractions? })
}

fn read_spheres(section: &Section) -> Reading<Pattern> {
    let radius = section.required("radius", "a positive number of fine cells", Item::positive);
    let expected = "two labels, the matrix's and the spheres'";
    let labels = section.required("labels", expected, |labels| labels.array(expected, read_label));
    let centres = read_centres(section);
    Ok(Pattern::Spheres { radius: radius?, labels: labels?, centres: centres? })
}

fn read_bars(section: &Section) -> Reading<Pattern> {
    let expected = "three integers of at least 1, the distances of the bars along x, y, z in fine cells";
    let period = section.required("period", expected, |period| period.array(expected, Item::count));
    let width = section.required("width", "the thickness of the bars in fine cells", Item::count);
    let extent = section.optional("box", |corners| {
        let expected = "two corners [i, j, k] in fine cells: the first cell, and the one after the last";
        let index = |item: &Item| item.integer_where("a number of fine cells", |v| v >= 0).map(|v| v as usize);
        corners.array(expected, |corner| corner.array(expected, index))
    });
    let expected = "two labels, the matrix's and the bars'";
    let labels = section.required("labels", expected, |labels| labels.array(expected, read_label));
    let bars = Bars { period: period?, width: width?, extent: extent? };
    Ok(Pattern::Grid { bars, labels: labels? })
}

fn read_centres(section: &Section) -> Reading<SphereCentres> {
    section.exclusive(&["centres", "period", "count"], "the spheres are listed, periodic or counted")?;
    if let Some(item) = section.get("centres") {
        let centres = read_all(&item.list("a list of centres [x, y, z] in fine cells")?, Item::vector)?;
        return Ok(SphereCentres::List(centres));
    }
    if section.has("period") {
        return read_period(section).map(|period| SphereCentres::Periodic { period });
    }
    let expected = "the number of spheres; or centres = [[x, y, z]], or period, in fine cells";
    let (count, seed) = (section.required("count", expected, Item::count), read_seed(section));
    Ok(SphereCentres::Random { count: count?, seed: seed? })
}

fn read_period(section: &Section) -> Reading<f64> {
    section.required("period", "a positive number of fine cells", Item::positive)
}

fn read_block(section: &Section) -> Reading<usize> {
    Ok(section.optional("size", Item::count)?.unwrap_or(1))
}

fn read_seed(section: &Section) -> Reading<u64> {
    let read = |seed: &Item| seed.integer_where("an integer that is not negative", |v| v >= 0);
    Ok(section.optional("seed", read)?.map_or(0, i64::unsigned_abs))
}

fn read_labels(section: &Section) -> Reading<Vec<Label>> {
    let expected = "a list of at least one label";
    section.required("labels", expected, |labels| read_all(&labels.list(expected)?, read_label))
}
