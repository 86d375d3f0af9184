//! Synthetic bodies: `grid` and `pattern`.

use std::path::PathBuf;

use grosgrain::mesh::Label;

use super::document::{Item, Reading, read_all};
use super::section::Section;
use super::selector::read_label;

/// A grid without a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Fine cells along x, y, z.
    pub cells: [usize; 3],
    /// Edge lengths of the whole box [m].
    pub size: [f64; 3],
}

/// How labels are laid out on a grid.
#[derive(Clone, Debug, PartialEq)]
pub enum Pattern {
    /// Layers normal to a direction.
    Layers {
        /// The normal, in fine cells along each axis; of any length.
        direction: [f64; 3],
        /// Thickness of one run through all labels, in fine cells.
        period: f64,
        /// The labels of the layers, of equal thickness.
        labels: Vec<Label>,
    },
    /// Blocks that take the labels in turn along every axis.
    Checkerboard {
        /// Edge of a block in fine cells.
        size: usize,
        /// The labels.
        labels: Vec<Label>,
    },
    /// Every block draws its label.
    Random {
        /// Edge of a block in fine cells.
        size: usize,
        /// The seed of the draw.
        seed: u64,
        /// The labels, equally likely.
        labels: Vec<Label>,
    },
    /// Balls in a matrix, placed at random.
    Spheres {
        /// How many balls.
        count: usize,
        /// Their radius in fine cells.
        radius: f64,
        /// The seed of the placement.
        seed: u64,
        /// The label of the matrix and that of the balls.
        labels: [Label; 2],
    },
    /// The integers of a volume file with as many voxels as the grid has cells.
    FromFile(PathBuf),
}

/// Reads `grid`.
pub fn read_grid(item: &Item) -> Reading<Grid> {
    let section = item.section(&["cells", "size"])?;
    let expected = "three integers of at least 1";
    let cells = section.required("cells", expected, |cells| cells.array(expected, Item::count));
    let expected = "three positive numbers in metres";
    let size = section.required("size", expected, |size| size.array(expected, Item::positive));
    Ok(Grid { cells: cells?, size: size? })
}

const KINDS: [&str; 5] = ["layers", "checkerboard", "random", "spheres", "from-file"];

/// Reads `pattern`.
pub fn read_pattern(item: &Item) -> Reading<Pattern> {
    let open = item.section(&["kind", "direction", "period", "labels", "size", "seed", "count", "radius", "file"])?;
    let kinds = KINDS.map(|kind| (kind, kind));
    let kind =
        open.required("kind", "\"layers\", \"checkerboard\", \"random\", \"spheres\" or \"from-file\"", |k| {
            k.choice(&kinds)
        })?;
    match kind {
        "layers" => read_layers(&only(&open, kind, &["direction", "period", "labels"])?),
        "checkerboard" => read_checkerboard(&only(&open, kind, &["size", "labels"])?),
        "random" => read_random(&only(&open, kind, &["size", "seed", "labels"])?),
        "spheres" => read_spheres(&only(&open, kind, &["count", "radius", "seed", "labels"])?),
        _ => only(&open, kind, &["file"])?
            .required("file", "a volume file of integers", Item::existing_path)
            .map(Pattern::FromFile),
    }
}

/// Refuses keys that belong to other kinds of pattern.
fn only<'a, 's>(section: &'a Section<'s>, kind: &str, keys: &[&str]) -> Reading<&'a Section<'s>> {
    let foreign = section.entries().into_iter().find(|(name, _)| *name != "kind" && !keys.contains(name));
    match foreign {
        None => Ok(section),
        Some((_, item)) => Err(item.note(format!(
            "{} does not belong to a pattern of kind {kind:?}; known there: {}",
            item.key(),
            keys.join(", ")
        ))),
    }
}

fn read_layers(section: &&Section) -> Reading<Pattern> {
    let direction = section.required("direction", "three numbers, not all zero", |direction| {
        let d = direction.vector()?;
        d.iter().any(|v| *v != 0.0).then_some(d).ok_or_else(|| direction.refuse("three numbers, not all zero"))
    });
    let period = section.required("period", "a positive number of fine cells", Item::positive);
    let labels = read_labels(section);
    Ok(Pattern::Layers { direction: direction?, period: period?, labels: labels? })
}

fn read_checkerboard(section: &&Section) -> Reading<Pattern> {
    let (size, labels) = (read_block(section), read_labels(section));
    Ok(Pattern::Checkerboard { size: size?, labels: labels? })
}

fn read_random(section: &&Section) -> Reading<Pattern> {
    let (size, seed, labels) = (read_block(section), read_seed(section), read_labels(section));
    Ok(Pattern::Random { size: size?, seed: seed?, labels: labels? })
}

fn read_spheres(section: &&Section) -> Reading<Pattern> {
    let count = section.required("count", "the number of balls, at least 1", Item::count);
    let radius = section.required("radius", "a positive number of fine cells", Item::positive);
    let seed = read_seed(section);
    let expected = "two labels, the matrix's and the balls'";
    let labels = section.required("labels", expected, |labels| labels.array(expected, read_label));
    Ok(Pattern::Spheres { count: count?, radius: radius?, seed: seed?, labels: labels? })
}

fn read_block(section: &Section) -> Reading<usize> {
    Ok(section.optional("size", Item::count)?.unwrap_or(1))
}

fn read_seed(section: &Section) -> Reading<u64> {
    let read = |seed: &Item| seed.integer_where("an integer that is not negative", |v| v >= 0);
    Ok(section.optional("seed", read)?.unwrap_or(0) as u64)
}

fn read_labels(section: &Section) -> Reading<Vec<Label>> {
    let expected = "a list of at least two labels";
    section.required("labels", expected, |item| {
        let items = item.list(expected)?;
        match items.len() {
            1 => Err(item.refuse(expected)),
            _ => read_all(&items, read_label),
        }
    })
}
