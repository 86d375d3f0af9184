//! Appendix A: springs in series.

use grosgrain::simplex::{Dimension, MandelTensor, SimplexMesh};

use super::super::row::{Row, digits};
use super::super::{Findings, Study};
use super::{body, homogenized};
use crate::failure::Failure;
use crate::results;

/// Name of the artefact.
pub const NAME: &str = "springs";

/// Stiffnesses \[N/m\] and lengths \[m\] of springs that are replaced by one.
const CASES: [(&str, &[f64], &[f64]); 4] = [
    ("two alike", &[1.0, 1.0], &[0.5, 0.5]),
    ("soft and stiff", &[1.0, 1000.0], &[0.5, 0.5]),
    ("short and soft between two long and rigid ones", &[1e9, 1.0, 1e9], &[0.495, 0.01, 0.495]),
    ("six of all kinds", &[3.0, 200.0, 0.7, 11.0, 5000.0, 42.0], &[0.13, 0.07, 0.25, 0.05, 0.31, 0.19]),
];

/// Replaces the springs of each case by one.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let mut found = Findings::default();
    let headings = ["springs", "by 1/k = Σ 1/k_i", "coarsened", "difference", "mean stiffness"];
    let mut lines = vec![headings.map(String::from)];
    for (name, stiffnesses, lengths) in CASES {
        let exact = 1.0 / stiffnesses.iter().map(|k| 1.0 / k).sum::<f64>();
        let measured = coarsened(study, stiffnesses, lengths)?;
        let total: f64 = lengths.iter().sum();
        // What the average of moduli would make of them.
        let mean = stiffnesses.iter().zip(lengths).map(|(k, l)| k * l * l).sum::<f64>() / (total * total);
        let difference = (measured / exact - 1.0).abs();
        lines.push([name.into(), digits(exact), digits(measured), format!("{difference:.1e}"), digits(mean)]);
        found.rows.push(Row {
            pattern: Some(name),
            published: Some(exact),
            measured: Some(measured),
            ..Row::new(study, NAME, "stiffness", "N/m")
        });
    }
    found.text = format!(
        "Appendix A of kharevych2009numerical: springs in series replaced by one, stiffness in N/m\n{}",
        results::columns(&lines)
    );
    Ok(found)
}

/// k = C̄ / L of the one segment that replaces segments with C_i = k_i l_i.
fn coarsened(study: &Study, stiffnesses: &[f64], lengths: &[f64]) -> Result<f64, Failure> {
    let mut places = vec![0.0];
    lengths.iter().for_each(|length| places.push(places[places.len() - 1] + length));
    let total = places[places.len() - 1];
    let tensor = |(k, l): (&f64, &f64)| {
        let mut matrix = [[0.0; 6]; 6];
        matrix[0][0] = k * l;
        MandelTensor { dimension: Dimension::One, matrix }
    };
    let tensors = stiffnesses.iter().zip(lengths).map(tensor).collect();
    let model = body(segments(&places)?, tensors)?;
    let found = homogenized(study, &model, &segments(&[0.0, total])?)?;
    Ok(found.effective.tensors[0].matrix[0][0] / total)
}

fn segments(places: &[f64]) -> Result<SimplexMesh, Failure> {
    let cells: Vec<[u32; 4]> = (1..places.len() as u32).map(|n| [n - 1, n, 0, 0]).collect();
    let tags = vec![0; cells.len()];
    let nodes = places.iter().map(|x| [*x, 0.0, 0.0]).collect();
    SimplexMesh::new(Dimension::One, nodes, cells, tags).map_err(|error| Failure::Failed(error.to_string()))
}
