//! What a chart promises.

use grosgrain_picture::{Axis, Chart, Event, PictureError, Series};

fn chart(points: Vec<[f64; 2]>, logarithmic: bool) -> Chart {
    let axis = |label: &str| Axis { label: label.into(), logarithmic, whole: false };
    let series = vec![Series { name: "one-ring".into(), points }];
    Chart { title: "Error".into(), x: axis("unknowns"), y: axis("error [%]"), series, width: 800, ..Chart::default() }
}

#[test]
fn a_power_law_is_a_straight_line_on_logarithmic_axes() -> Result<(), PictureError> {
    let image = chart((1..=30).map(|i| [f64::from(i), f64::from(i).powi(-2)]).collect(), true).render()?;
    // Markers and lines are blue (0x44, 0x77, 0xaa); their mean height per column must be linear in the column.
    let blue = |x: usize| {
        let rows = (120..image.height()).filter(|y| image.pixel(x, *y) == Some([0x44, 0x77, 0xaa]));
        let (sum, count) = rows.fold((0, 0), |(s, n), y| (s + y, n + 1));
        (count > 0).then(|| sum as f64 / f64::from(count))
    };
    let heights: Vec<(usize, f64)> = (0..image.width()).filter_map(|x| Some((x, blue(x)?))).collect();
    let (first, last) = (heights[20], heights[heights.len() - 21]);
    for (x, y) in &heights[20..heights.len() - 20] {
        let line = first.1 + (last.1 - first.1) * (x - first.0) as f64 / (last.0 - first.0) as f64;
        // A marker has a radius of 3 pixels, which bounds the shift of a column's mean.
        assert!((y - line).abs() < 4.0, "column {x}: {y} off the line {line}");
    }
    assert!(heights.len() > 500);
    Ok(())
}

#[test]
fn a_chart_over_whole_numbers_has_a_line_at_each_and_nowhere_else() -> Result<(), PictureError> {
    let mut chart = chart((2..=5).map(|i| [f64::from(i), 1.0]).collect(), false);
    chart.x.whole = true;
    let image = chart.render()?;
    // On a row with neither curve nor horizontal rule only the vertical rules, thinner than a pixel, tint the white paper.
    let row = image.height() / 2 + 60;
    let is_rule = |x: usize| image.pixel(x, row) != Some([0xff; 3]);
    let starts: Vec<usize> = (80..image.width() - 40).filter(|x| is_rule(*x) && !is_rule(x - 1)).collect();
    assert_eq!(starts.len(), 4, "{starts:?}");
    let steps: Vec<usize> = starts.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(steps.iter().all(|step| step.abs_diff(steps[0]) <= 1), "{starts:?}");
    Ok(())
}

#[test]
fn charts_of_one_point_or_a_constant_are_drawn() -> Result<(), PictureError> {
    for points in [vec![[3.0, 2.0]], vec![[0.0, 0.0], [1.0, 0.0]], vec![[1e-9, -5e12], [2e-9, 5e12]]] {
        assert_eq!(chart(points, false).render()?.width(), 800);
    }
    assert_eq!(chart(vec![[3.0, 2.0]], true).render()?.width(), 800);
    assert_eq!(chart(vec![[1.0, 0.5]], true).render()?.width(), 800);
    Ok(())
}

#[test]
fn points_without_a_place_are_refused_with_a_sentence() {
    let refusal = |points, log| chart(points, log).render().map_or_else(|e| e.to_string(), |_| "drawn".into());
    assert!(refusal(vec![[1.0, 2.0], [2.0, 0.0]], true).starts_with("series \"one-ring\", point 1 (2, 0)"));
    assert!(refusal(vec![[1.0, f64::NAN]], false).contains("point 0 (1, NaN)"));
    assert_eq!(refusal(vec![], false), "the chart \"Error\" has no points");
}

#[test]
fn an_event_is_a_dashed_line_at_its_place_and_its_labels_stand_apart() -> Result<(), PictureError> {
    let mut plain = chart((0..=50).map(|i| [f64::from(i) / 50.0, 0.5]).collect(), false);
    plain.y.label = String::new();
    let mut marked = plain.clone();
    let event = |at, label: &str| Event { at, label: label.into() };
    marked.events = vec![event(0.25, "cut 1"), event(0.27, "cut 2"), event(0.8, "let go")];
    let (before, after) = (plain.render()?, marked.render()?);
    // Right of the tick labels, which the labels above move down, only the dashes differ on the lower part of the plot.
    let rows = before.height() * 6 / 10..before.height() * 3 / 4;
    let differs = |x: usize| rows.clone().filter(|y| before.pixel(x, *y) != after.pixel(x, *y)).count();
    let columns: Vec<usize> = (70..before.width()).filter(|x| differs(*x) > 10).collect();
    let mut centres: Vec<f64> = Vec::new();
    for group in columns.chunk_by(|a, b| b - a == 1) {
        centres.push(group.iter().sum::<usize>() as f64 / group.len() as f64);
        assert!(group.iter().all(|x| differs(*x) < rows.len() * 9 / 10), "dashes leave gaps");
    }
    assert_eq!(centres.len(), 3, "{centres:?}");
    let ratio = (centres[1] - centres[0]) / (centres[2] - centres[0]);
    assert!((ratio - 0.02 / 0.55).abs() < 0.004, "{centres:?}");
    Ok(())
}

#[test]
fn an_event_without_a_label_moves_no_label_and_no_plot() -> Result<(), PictureError> {
    let mut named = chart((0..=50).map(|i| [f64::from(i) / 50.0, 0.5]).collect(), false);
    named.events = vec![Event { at: 0.5, label: "a long label".into() }];
    let mut both = named.clone();
    both.events.push(Event { at: 0.53, label: String::new() });
    let (before, after) = (named.render()?, both.render()?);
    let differs = |x: &usize| (0..before.height()).any(|y| before.pixel(*x, y) != after.pixel(*x, y));
    let columns: Vec<usize> = (0..before.width()).filter(differs).collect();
    assert!(!columns.is_empty() && columns.last() < columns.first().map(|x| x + 10).as_ref(), "{columns:?}");
    Ok(())
}

#[test]
fn an_event_without_a_place_is_refused() {
    let mut chart = chart(vec![[1.0, 2.0]], true);
    chart.events = vec![Event { at: -1.0, label: "cut".into() }];
    let sentence = chart.render().map_or_else(|e| e.to_string(), |_| "drawn".into());
    assert!(sentence.starts_with("event \"cut\" at -1: it must be"), "{sentence}");
}
