//! Coarse models: the stiffness of a cell, and the maps between coarse and fine nodes.

use super::cases::Outcome;
use super::cases::coarse::CoarseCase;
use super::machine::{Machine, copy_rate};
use super::measure::{Effort, MICRO, digits, measure};
use super::table::Table;

pub fn section(machine: &Machine, effort: &Effort) -> Outcome<String> {
    let mut stiffness = Table::new(&["d", "µs", "Mflop", "Gflop/s", "floor, µs", "measured / floor"]);
    let mut maps =
        Table::new(&["d", "fine unknowns", "coarse to fine, µs", "GB/s", "fine to coarse, µs", "GB/s", "GB/s copying"]);
    let mut ratio = (f64::INFINITY, 0.0f64);
    for degree in 2..=effort.largest_degree.min(5) {
        let case = CoarseCase::new(degree)?;
        let galerkin = measure(effort.samples, || case.galerkin());
        let floor = machine.floor(case.galerkin_flops(), 0.0);
        ratio = (ratio.0.min(galerkin.median / floor), ratio.1.max(galerkin.median / floor));
        stiffness.row(&[
            degree.to_string(),
            galerkin.show(MICRO),
            digits(case.galerkin_flops() / 1e6),
            digits(case.galerkin_flops() / galerkin.median / 1e9),
            digits(floor / MICRO),
            digits(galerkin.median / floor),
        ]);
        let embedding = case.embedding();
        let prolong = measure(effort.samples, || case.prolong(&embedding));
        let restrict = measure(effort.samples, || case.restrict(&embedding));
        let bytes = case.embedding_bytes();
        maps.row(&[
            degree.to_string(),
            case.fine_unknowns().to_string(),
            prolong.show(MICRO),
            digits(bytes / prolong.median / 1e9),
            restrict.show(MICRO),
            digits(bytes / restrict.median / 1e9),
            digits(copy_rate(bytes) / 1e9),
        ]);
    }
    Ok(format!(
        "## Coarse model\n\nStiffness K̄ = Σ Wᵀ K W of one coarse cell, one thread; the operations are those of K W and of one triangle of Wᵀ(K W).\n\n{}\n\
         Between {} and {} times the floor.\n\nThe maps between coarse and fine nodes for 4 × 2 × 2 coarse cells; each reads all shape functions once, which are the bytes counted.\n\n{}\n\
         The last column is how fast the machine copies as many bytes.\n",
        stiffness.text(),
        digits(ratio.0),
        digits(ratio.1),
        maps.text(),
    ))
}
