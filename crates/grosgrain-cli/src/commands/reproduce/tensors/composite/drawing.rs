//! The picture of Fig. 6.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use grosgrain::homogenization::SimplexModel;
use grosgrain::mesh::Label;
use grosgrain::simplex::Dimension;
use grosgrain_picture::{Figure, Panel, Rgb};

use super::super::super::row::digits;
use super::body::Hanging;
use super::{COARSE, MAPS, Moved, NAME, Shown};
use crate::failure::Failure;
use crate::meshes::{Paint, Posed, SimplexLook, SimplexSkin, simplex_view};
use crate::picture::save;

/// One light and one dark, so that they differ in grey too.
const MATERIALS: [(i32, &str, Rgb); 2] = [(0, "soft", [0xa6, 0xd9, 0x9a]), (1, "stiff", [0xa0, 0x1f, 0x7a])];
/// Coarse mesh and map of the panels beside rest and fine equilibrium.
const DRAWN: [(usize, usize); 4] = [(0, 0), (0, 1), (1, 2), (2, 2)];

/// Draws rest, fine equilibrium, and what coarse equilibria show, into `composite.png`.
pub fn write(
    model: &SimplexModel,
    fine: &Hanging,
    coarse: &[Moved],
    shown: &[Shown],
    folder: &Path,
) -> Result<PathBuf, Failure> {
    let skin = Arc::new(SimplexSkin::new(model.mesh(), None)?);
    let materials = MATERIALS.map(|(tag, name, colour)| (Label(tag), name.to_owned(), Some(colour)));
    let look = SimplexLook { materials: materials.to_vec(), ..SimplexLook::default() };
    let panel = |displacement: &[f64], (caption, detail): (String, String), wires: Option<Posed<'_>>| Panel {
        caption,
        detail,
        ..look.panel(Posed { skin: &skin, displacement }, &Paint::Tags, wires)
    };
    let rest = vec![0.0; fine.displacement.len()];
    let mut panels = vec![
        panel(&rest, ("At rest".into(), "two materials, moduli 1 : 100".into()), None),
        panel(&fine.displacement, ("Fine equilibrium".into(), String::new()), None),
    ];
    for (number, map) in DRAWN {
        let Some(found) = shown.iter().find(|s| (s.coarse, s.corners, s.map) == (number, 0, map)) else { continue };
        let moved = &coarse[number];
        let edges = Arc::new(SimplexSkin::new(&moved.mesh, None)?);
        let wires = Posed { skin: &edges, displacement: &moved.displacements[0] };
        let caption = format!("{}, {}", COARSE[number].1, MAPS[map].0);
        let detail = format!("error {} %, energy × {}", digits(found.error), digits(found.energy));
        panels.push(panel(&found.displacement, (caption, detail), Some(wires)));
    }
    let figure = Figure {
        title: "A composite that hangs from its top".into(),
        panels,
        view: simplex_view(Dimension::Two),
        footer: vec!["Lines are coarse cells in their own equilibrium, with effective tensors.".into()],
        ..Figure::default()
    };
    save(figure.render(), &folder.join(format!("{NAME}.png")))
}
