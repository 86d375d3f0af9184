//! Pictures of layered bodies, and charts of tables.

use std::path::{Path, PathBuf};

use grosgrain::mesh::{Node, VoxelGrid};
use grosgrain_picture::{Axis, Category, Chart, Colouring, Figure, Panel, Rgb, Series};

use super::bodies::{Heterogeneity, PHASES};
use super::row::Row;
use super::setting::Setting;
use super::table1::Entry;
use super::table1_error::Trainer;
use crate::body_surface::BodySurface;
use crate::failure::Failure;
use crate::picture::save;

/// Soft and stiff: the paper's green and magenta, one light and one dark, so that they differ to colour-blind eyes and in grey too.
const COLOURS: [(&str, Rgb); 2] = [("soft", [0xa6, 0xd9, 0x9a]), ("stiff", [0xa0, 0x1f, 0x7a])];

/// A panel with a body in the colours of its phases, and the edges of its coarse cells.
pub fn body_panel(grid: &VoxelGrid, degree: usize, caption: String, detail: String) -> Panel {
    let surface = BodySurface::new(grid, &grid.void);
    let position = |node: Node| grid.position(grid.lattice.node_position(node));
    let phase = |label| u32::from(label == PHASES[1]);
    let of_quad = surface.faces.iter().map(|face| phase(grid.labels[face.cell.0])).collect();
    let legend = COLOURS.map(|(name, colour)| Category { name: name.into(), colour: Some(colour) }).to_vec();
    Panel {
        caption,
        detail,
        colouring: Colouring::Category { of_quad, legend },
        grid: surface.coarse_grid(degree, position),
        ..surface.panel(position)
    }
}

/// A picture of each panel, named `NAME-PATTERN-dD.png`, and one sheet of all, `NAME.png`, a row per degree.
pub fn write_bodies(
    name: &str,
    title: &str,
    panels: &[((Heterogeneity, usize), Panel)],
    folder: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let mut written = Vec::new();
    for ((pattern, degree), panel) in panels {
        let figure = Figure { panels: vec![panel.clone()], width: 1200, ..Figure::default() };
        written.push(save(figure.render(), &folder.join(format!("{name}-{}-d{degree}.png", pattern.name())))?);
    }
    let first = panels.first().map(|((_, degree), _)| *degree);
    let columns = panels.iter().filter(|((_, degree), _)| Some(*degree) == first).count();
    let sheet = Figure {
        title: title.into(),
        panels: panels.iter().map(|(_, panel)| panel.clone()).collect(),
        columns: Some(columns),
        footer: vec!["Stiff material is 50 times as stiff as soft. Lines are the edges of coarse cells.".into()],
        ..Figure::default()
    };
    written.push(save(sheet.render(), &folder.join(format!("{name}.png")))?);
    Ok(written)
}

/// A chart per pattern of Table 1: error over degree, `table1-PATTERN.png`.
pub fn error_charts(entries: &[Entry], patterns: &[Heterogeneity], folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let chart = |pattern: &Heterogeneity| {
        let keys = Setting::ALL.into_iter().flat_map(|s| Trainer::ALL.map(|t| (s, t)));
        // Exact training has the same error in every setting.
        let depends = |trainer: Trainer| trainer == Trainer::Substructured;
        let keys = keys.filter(|(setting, trainer)| *setting == Setting::Own || depends(*trainer));
        let series = keys.map(|(setting, trainer)| Series {
            name: match depends(trainer) {
                true => format!("{}, {}", trainer.name(), setting.name()),
                false => trainer.name().into(),
            },
            points: points(entries, *pattern, setting, trainer),
        });
        let title = format!("Error of coarse beams, {} layers", pattern.name());
        let series = series.filter(|series| !series.points.is_empty()).collect();
        let file = folder.join(format!("table1-{}.png", pattern.name()));
        write_chart(title, "RMS error against the fine solution [%]", series, &file)
    };
    patterns.iter().map(chart).collect()
}

fn points(entries: &[Entry], pattern: Heterogeneity, setting: Setting, trainer: Trainer) -> Vec<[f64; 2]> {
    let of_it = entries.iter().filter(|e| (e.pattern, e.setting, e.trainer) == (pattern, setting, trainer));
    // A logarithmic axis has no place for an exact zero.
    of_it.filter(|e| e.percent > 0.0).map(|e| [e.degree as f64, e.percent]).collect()
}

/// A chart of measured and published times over the degree.
pub fn time_chart(title: &str, rows: &[Row], methods: &[&'static str], path: &Path) -> Result<PathBuf, Failure> {
    let mut series = Vec::new();
    for method in methods {
        let times = || rows.iter().filter(|row| row.quantity == "time" && row.method == Some(*method));
        let points = |pick: fn(&Row) -> Option<f64>| -> Vec<[f64; 2]> {
            times().filter_map(|row| Some([row.degree? as f64, pick(row)?])).collect()
        };
        series.push(Series { name: (*method).into(), points: points(|row| row.measured) });
        series.push(Series { name: format!("{method}, published"), points: points(|row| row.published) });
    }
    series.retain(|series| !series.points.is_empty());
    write_chart(title.into(), "time on one thread [ms]", series, path)
}

/// Writes a chart over the degree with a logarithmic vertical axis.
fn write_chart(title: String, quantity: &str, series: Vec<Series>, path: &Path) -> Result<PathBuf, Failure> {
    let x = Axis { label: "coarsening degree d".into(), whole: true, ..Axis::default() };
    let y = Axis { label: quantity.into(), logarithmic: true, ..Axis::default() };
    save(Chart { title, x, y, series, ..Chart::default() }.render(), path)
}
