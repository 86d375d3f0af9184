//! Tables of errors and their rows.

use super::super::Study;
use super::super::row::Row;
use super::pair::{Errors, Way, gain};
use super::played::Player;
use crate::quantities::count;
use crate::results;

/// Static errors of a body with a coarse mesh.
pub struct Case {
    /// Which body.
    pub body: &'static str,
    /// Which coarse mesh.
    pub mesh: &'static str,
    /// The errors in percent.
    pub errors: Errors,
}

/// How a table shows an error in percent.
pub fn percent(error: f64) -> String {
    if error < 999.5 { format!("{error:.1}") } else { format!("{error:.0}") }
}

/// A table of static errors: a line per case.
pub fn static_table(cases: &[Case]) -> String {
    let headings = ["body", "coarse mesh"].into_iter().chain(Way::ALL.map(Way::name)).chain(["gain"]);
    let mut lines = vec![array(headings.map(String::from))];
    for case in cases {
        let names = [case.body, case.mesh].map(String::from);
        let errors = case.errors.map(percent).into_iter();
        lines.push(array(names.into_iter().chain(errors).chain([format!("{:.1}", gain(&case.errors))])));
    }
    results::columns(&lines)
}

/// The first nine entries.
fn array(mut entries: impl Iterator<Item = String>) -> [String; 9] {
    std::array::from_fn(|_| entries.next().unwrap_or_default())
}

/// Rows of static errors of a task.
pub fn static_rows(study: &Study, name: &'static str, task: &'static str, cases: &[Case]) -> Vec<Row> {
    let row = |case: &Case, method, measured, quantity, unit| Row {
        pattern: Some(case.body),
        setting: Some(task),
        method: Some(method),
        measured: Some(measured),
        note: Some(format!("coarse mesh of {}; the paper shows pictures, no numbers", case.mesh)),
        ..Row::new(study, name, quantity, unit)
    };
    let mut rows = Vec::new();
    for case in cases {
        let of_way = |(way, error): (Way, f64)| row(case, way.name(), error, "static error", "%");
        rows.extend(Way::ALL.into_iter().zip(case.errors).map(of_way));
        rows.push(row(case, "lesser average over tensor", gain(&case.errors), "gain in static error", "1"));
    }
    rows
}

/// A table of a motion: a line per model, and the gains.
pub fn motion_table(players: &[Player]) -> String {
    let headings = [
        "model",
        "unknowns",
        "largest mean displacement",
        "first swing",
        "all swings",
        "worst",
        "at the extremes",
        "fine / this",
    ];
    let mut lines = vec![headings.map(String::from)];
    for player in players {
        let is_fine = player.name == "fine";
        let error = |error: f64| if is_fine { "–".into() } else { format!("{} %", percent(error)) };
        lines.push([
            player.name.into(),
            count(player.unknowns),
            format!("{:.1} mm", 1e3 * player.reach()),
            error(player.swing_error(&players[0])),
            error(player.mean_error()),
            error(player.worst_error()),
            error(player.extreme_error(&players[0])),
            if is_fine { "–".into() } else { format!("{:.0}", players[0].step / player.step) },
        ]);
    }
    let gains = gains(players).map(|(what, gain)| format!("{what} {gain:.1}"));
    format!("{}\n{}", results::columns(&lines), gains.join(", "))
}

/// Gains over the first swing, over the whole motion, and at the most extreme positions.
pub fn gains(players: &[Player]) -> [(&'static str, f64); 3] {
    let fine = &players[0];
    let gain = |error: &dyn Fn(&Player) -> f64| gain(&std::array::from_fn(|n| error(&players[n + 1])));
    [
        ("gain in the first swing", gain(&|player| player.swing_error(fine))),
        ("gain in mean error", gain(&Player::mean_error)),
        ("gain at the extremes", gain(&|player| player.extreme_error(fine))),
    ]
}

/// Rows of a motion.
pub fn motion_rows(
    study: &Study,
    name: &'static str,
    (body, task): (&'static str, &'static str),
    players: &[Player],
) -> Vec<Row> {
    let row = |method, quantity, unit, measured| Row {
        pattern: Some(body),
        setting: Some(task),
        method: Some(method),
        measured: Some(measured),
        note: Some("the paper shows pictures, no numbers".into()),
        ..Row::new(study, name, quantity, unit)
    };
    let mut rows = Vec::new();
    for player in players {
        let mut add = |quantity, unit, measured| rows.push(row(player.name, quantity, unit, measured));
        add("unknowns", "1", player.unknowns as f64);
        add("largest mean displacement", "m", player.reach());
        if player.name != "fine" {
            add("mean error of the first swing", "%", player.swing_error(&players[0]));
            add("mean error", "%", player.mean_error());
            add("worst error", "%", player.worst_error());
            add("error at the extremes", "%", player.extreme_error(&players[0]));
            add("cost of fine over this", "1", players[0].step / player.step);
        }
    }
    rows.extend(gains(players).map(|(what, gain)| row("lesser average over tensor", what, "1", gain)));
    rows
}
