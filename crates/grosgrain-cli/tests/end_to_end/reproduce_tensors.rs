//! The bodies that are coarsened by effective tensors and by averages.

use std::path::Path;

use serde_json::Value;

use super::program::{grosgrain, json, names};

/// Runs an artefact with pictures and reads its rows.
fn reproduce(folder: &Path, name: &str) -> Vec<Value> {
    let told = grosgrain(folder, &["reproduce", name, "--json", "rows.json", "-o", "out"]).done().stdout;
    assert!(told.contains("kharevych2009numerical"), "{told}");
    json(&folder.join("rows.json")).as_array().unwrap().clone()
}

/// What was measured in all rows whose fields have these values; none of them has a published figure.
fn measured(rows: &[Value], fields: &[(&str, &str)]) -> Vec<f64> {
    let fits = |row: &&Value| fields.iter().all(|(key, value)| row[*key] == *value);
    let found: Vec<&Value> = rows.iter().filter(fits).collect();
    assert!(!found.is_empty() && found.iter().all(|row| row["published"].is_null()), "{fields:?}");
    found.iter().map(|row| row["measured"].as_f64().unwrap()).collect()
}

#[test]
fn tensors_of_a_layered_cube_are_three_times_closer_to_it_than_averages_when_it_is_pulled_across() {
    let folder = tempfile::tempdir().unwrap();
    let rows = reproduce(folder.path(), "layers");
    let stretch = |body| measured(&rows, &[("quantity", "stretch of h33 over h11"), ("pattern", body)])[0];
    assert!((stretch("one material") - 1.0).abs() < 1e-9, "{}", stretch("one material"));
    assert!(stretch("layers") > 1.5, "{}", stretch("layers"));
    for entry in ["C11", "C33", "C13", "C44", "C66"] {
        let ratio = measured(&rows, &[("quantity", "inner tensors over those of layers"), ("pattern", entry)])[0];
        assert!((ratio - 1.0).abs() < 0.1, "{entry}: {ratio}");
    }
    let body = ("pattern", "10:1, coarse nodes in stiff layers");
    for quantity in ["gain in static error", "gain in mean error", "gain in the first swing", "gain at the extremes"] {
        let gains = measured(&rows, &[("quantity", quantity), body, ("setting", "across")]);
        assert!(gains.iter().all(|gain| *gain > 3.0), "{quantity}: {gains:?}");
    }
    // The averages are bounds from above: a cube of them never stretches as far as the fine one.
    let reach = |method| {
        measured(&rows, &[("quantity", "largest mean displacement"), ("method", method), ("setting", "across")])[0]
    };
    assert!(reach("average") < 0.6 * reach("fine") && reach("tensor") > 0.8 * reach("fine"));
    let pictures = ["across-error", "across-motion", "across", "along-error", "along-motion", "along", "harmonic"];
    assert_eq!(names(&folder.path().join("out")), pictures.map(|picture| format!("layers-{picture}.png")));
}

#[test]
fn tensors_of_a_bar_with_a_deep_slice_bend_there_and_averages_do_not() {
    let folder = tempfile::tempdir().unwrap();
    let rows = reproduce(folder.path(), "crack");
    let body = ("pattern", "1000:1, 90 % deep");
    let gains = |quantity| measured(&rows, &[("quantity", quantity), body]);
    let at_rest = gains("gain in static error");
    assert!(at_rest.len() == 5 && at_rest.iter().all(|gain| *gain > 3.0), "{at_rest:?}");
    for quantity in ["gain in the first swing", "gain at the extremes"] {
        assert!(gains(quantity)[0] > 3.0, "{quantity}: {:?}", gains(quantity));
    }
    let reach = |method| measured(&rows, &[("quantity", "largest mean displacement"), ("method", method)])[0];
    assert!(reach("mean stiffness") < 0.6 * reach("fine") && reach("tensor") > 0.75 * reach("fine"));
    let pictures = ["-error", "-motion", ""].map(|end| format!("crack-hanging-out{end}.png"));
    assert_eq!(names(&folder.path().join("out")), pictures);
}
