//! Pictures of what is coarsened by tensors: harmonic displacements, extreme positions, curves over time.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use grosgrain::mesh::Label;
use grosgrain_picture::{Axis, Chart, Figure, Panel, Rgb, Series};

use super::errors::percent;
use super::pair::{Coarse, Fine, SOFT, STIFF};
use super::played::{Player, Steps};
use crate::failure::Failure;
use crate::meshes::{Paint, Posed, SimplexLook, SimplexSkin, harmonic_panels, simplex_view};
use crate::picture::save;

/// The paper's blue and mauve, one light and one dark.
const COLOURS: [(i32, &str, Rgb); 2] = [(SOFT, "soft", [0x8f, 0xb8, 0xe6]), (STIFF, "stiff", [0x8a, 0x4f, 0x7d])];

/// A motion that is drawn.
pub struct Scene<'a> {
    /// Name of the artefact.
    pub name: &'static str,
    /// Name of the task.
    pub task: &'static str,
    /// Heading.
    pub title: &'a str,
}

fn look() -> SimplexLook {
    let materials = COLOURS.map(|(tag, name, colour)| (Label(tag), name.to_owned(), Some(colour))).to_vec();
    SimplexLook { materials, ..SimplexLook::default() }
}

/// `layers-harmonic.png`: the six harmonic displacements of each body, a row per body.
pub fn harmonic(bodies: &[(&str, &Fine)], folder: &Path) -> Result<PathBuf, Failure> {
    let mut panels = Vec::new();
    for (name, fine) in bodies {
        let skin = Arc::new(SimplexSkin::new(fine.model.mesh(), None)?);
        let named = |panel: Panel| Panel { caption: format!("{}, {name}", panel.caption), ..panel };
        panels.extend(harmonic_panels(&skin, &fine.free, None, &look()).into_iter().map(named));
    }
    let figure =
        Figure { title: "Harmonic displacements".into(), panels, columns: Some(6), width: 3000, ..Figure::default() };
    save(figure.render(), &folder.join("layers-harmonic.png"))
}

/// `NAME-TASK.png`: every model where it is farthest; `NAME-TASK-motion.png` and `NAME-TASK-error.png`: curves over time.
pub fn motion(
    scene: &Scene<'_>,
    (fine, coarse): (&Fine, &Coarse),
    (players, steps): (&[Player], Steps),
    folder: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let dimension = fine.model.mesh().dimension();
    let skins = [fine.model.mesh(), &coarse.mesh].map(|mesh| SimplexSkin::new(mesh, None).map(Arc::new));
    let [skin, cage] = skins;
    let (skin, cage) = (skin?, cage?);
    let panel = |player: &Player| {
        let wires = Posed { skin: &cage, displacement: &player.extreme.own };
        let is_fine = player.name == "fine";
        let body = Posed { skin: &skin, displacement: &player.extreme.fine };
        let error = match is_fine {
            true => String::new(),
            false => format!(", error {} %", percent(player.extreme_error(&players[0]))),
        };
        Panel {
            caption: player.name.into(),
            detail: format!("farthest at {:.3} s{error}", player.extreme.time),
            ..look().panel(body, &Paint::Tags, (!is_fine).then_some(wires))
        }
    };
    let figure = Figure {
        title: scene.title.into(),
        panels: players.iter().map(panel).collect(),
        view: simplex_view(dimension),
        columns: Some(4),
        footer: vec!["Lines are the edges of coarse cells; faint lines are the body at rest.".into()],
        ..Figure::default()
    };
    let file = |end: &str| {
        let task = scene.task.replace(' ', "-");
        folder.join(format!("{}-{task}{end}.png", scene.name))
    };
    let series = |values: &dyn Fn(&Player) -> Vec<f64>, from: usize| {
        let at = |n: usize, value: f64| [(n + 1) as f64 * steps.length, value];
        let points = |player: &Player| values(player).into_iter().enumerate().map(|(n, v)| at(n, v)).collect();
        players[from..].iter().map(|p| Series { name: p.name.into(), points: points(p) }).collect()
    };
    let chart = |title: String, label: &str, series: Vec<Series>| {
        let [x, y] = ["time [s]", label].map(|label| Axis { label: label.into(), ..Axis::default() });
        Chart { title, x, y, series, ..Chart::default() }
    };
    let means = |player: &Player| player.means.iter().map(|mean| 1e3 * mean).collect();
    // Charts have less room for a title than figures.
    let title = format!("{}, {}", scene.name, scene.task);
    let reach = chart(title.clone(), "mean displacement along the pull [mm]", series(&means, 0));
    let errors = |player: &Player| player.errors.clone();
    let error = chart(title, "RMS error [% of the largest displacement]", series(&errors, 1));
    Ok(vec![
        save(figure.render(), &file(""))?,
        save(reach.render(), &file("-motion"))?,
        save(error.render(), &file("-error"))?,
    ])
}
