//! The table of `compare`.

use super::program::{SMALL, grosgrain, json};

const METHODS: [&str; 4] = ["one-ring", "fine", "trilinear", "average"];

#[test]
fn compare_writes_one_row_for_each_method_in_the_order_asked() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), SMALL).unwrap();
    let methods = METHODS.join(",");
    let run =
        grosgrain(folder.path(), &["compare", "scene.toml", "--methods", &methods, "--json", "new/table.json"]).done();
    let table = json(&folder.path().join("new/table.json"));
    let rows = table.as_array().unwrap();
    let keys = ["build_seconds", "energy_ratio", "error_percent", "method", "solve_seconds", "unknowns"];
    for row in rows {
        let mut found: Vec<&String> = row.as_object().unwrap().keys().collect();
        found.sort();
        assert_eq!(found, keys);
    }
    assert_eq!(rows.iter().map(|row| row["method"].as_str().unwrap()).collect::<Vec<_>>(), METHODS);
    let told: Vec<&str> =
        run.stdout.lines().skip(2).take(4).filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(told, METHODS, "{}", run.stdout);
    let of = |n: usize, key: &str| rows[n][key].as_f64().unwrap();
    assert_eq!((of(1, "error_percent"), of(1, "energy_ratio")), (0.0, 1.0), "the fine model against itself");
    assert_eq!([0, 1, 2, 3].map(|n| of(n, "unknowns")), [243.0, 1275.0, 243.0, 243.0]);
    // Trilinear elements are stiffer than what they hold; fitted functions are nearer.
    assert!(of(2, "energy_ratio") < 1.0 && of(3, "energy_ratio") < 1.0, "{table}");
    assert!(of(0, "error_percent") < of(2, "error_percent"), "{table}");
}

#[test]
fn compare_without_methods_runs_all_of_them() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), SMALL).unwrap();
    grosgrain(folder.path(), &["compare", "scene.toml", "--json", "table.json"]).done();
    let table = json(&folder.path().join("table.json"));
    let methods: Vec<&str> = table.as_array().unwrap().iter().filter_map(|row| row["method"].as_str()).collect();
    assert_eq!(methods, ["fine", "trilinear", "average", "global", "one-ring", "single-cell", "substructured"]);
}
