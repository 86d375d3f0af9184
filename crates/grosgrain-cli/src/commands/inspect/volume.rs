//! What a volume holds.

use std::collections::BTreeMap;
use std::path::Path;

use grosgrain::io::read_volume;
use grosgrain::mesh::{Lattice, Volume};
use serde::Serialize;

use super::row;
use crate::failure::Failure;
use crate::memory;
use crate::quantities::{bytes, count, number, triple, triple_count};

/// More distinct values than this are an image, not labels.
const MOST_LABELS: usize = 64;

/// What a volume holds.
#[derive(Debug, Serialize)]
pub struct VolumeSummary {
    cells: [usize; 3],
    voxels: usize,
    spacing_metres: Option<[f64; 3]>,
    extent_metres: Option<[f64; 3]>,
    range: Option<[f64; 2]>,
    integral: bool,
    labels: Option<Vec<LabelCount>>,
    unknowns: usize,
    direct_bytes: f64,
    iterative_bytes: f64,
}

#[derive(Debug, PartialEq, Serialize)]
struct LabelCount {
    label: i64,
    voxels: usize,
}

/// Reads the volume in `file` and sums it up.
pub fn summarise(file: &Path) -> Result<VolumeSummary, Failure> {
    let volume = read_volume(file)?;
    let lattice = Lattice::new(volume.cells);
    let unknowns = 3 * lattice.node_count();
    Ok(VolumeSummary {
        cells: volume.cells,
        voxels: lattice.cell_count(),
        spacing_metres: volume.spacing,
        extent_metres: volume.spacing.map(|h| std::array::from_fn(|a| h[a] * volume.cells[a] as f64)),
        range: volume.range().map(|(low, high)| [low, high]),
        integral: volume.integral,
        labels: label_counts(&volume),
        unknowns,
        direct_bytes: memory::direct(unknowns),
        iterative_bytes: memory::iterative(unknowns),
    })
}

/// How many voxels have each value, if all are whole numbers and few differ.
fn label_counts(volume: &Volume) -> Option<Vec<LabelCount>> {
    let mut counts: BTreeMap<i64, usize> = BTreeMap::new();
    for value in volume.values.iter().filter(|_| volume.integral) {
        *counts.entry(*value as i64).or_default() += 1;
        if counts.len() > MOST_LABELS {
            return None;
        }
    }
    let counts = counts.into_iter().map(|(label, voxels)| LabelCount { label, voxels }).collect();
    volume.integral.then_some(counts)
}

impl VolumeSummary {
    /// The summary for people.
    pub fn rows(&self) -> Vec<(String, String)> {
        let unsaid = || "the file does not say; a scene gives it as body.spacing".to_string();
        let mut rows = vec![
            row("volume", format!("{} voxels, {} in all", triple_count(self.cells), count(self.voxels))),
            row("spacing", self.spacing_metres.map_or_else(unsaid, |h| format!("{} mm", triple(h.map(|h| 1e3 * h))))),
        ];
        rows.extend(self.extent_metres.map(|extent| row("extent", format!("{} m", triple(extent)))));
        let kind = if self.integral { "whole numbers" } else { "real numbers" };
        rows.extend(self.range.map(|r| row("values", format!("{} to {}, {kind}", number(r[0]), number(r[1])))));
        for label in self.labels.iter().flatten() {
            let share = 100.0 * label.voxels as f64 / self.voxels as f64;
            rows.push(row(&format!("label {}", label.label), format!("{} voxels, {share:.2} %", count(label.voxels))));
        }
        rows.push(row("fine model", format!("up to {} unknowns if nothing is void", count(self.unknowns))));
        rows.push(memory_row(self.direct_bytes, self.iterative_bytes));
        rows
    }
}

/// The row about memory.
pub fn memory_row(direct: f64, iterative: f64) -> (String, String) {
    let sentence = format!("about {} with a direct solver, {} with an iterative one", bytes(direct), bytes(iterative));
    row("memory", sentence)
}
