//! Many cells on several threads.

use super::cases::Outcome;
use super::cases::harmonic::ManyCells;
use super::measure::{Effort, MILLI, digits, measure};
use super::table::Table;

pub fn section(effort: &Effort) -> Outcome<String> {
    let degree = effort.largest_degree.min(4);
    let mut table = Table::new(&["threads", "ms", "cells per second", "times one thread"]);
    let (mut one, mut last, mut cells) = (None, 1.0, 0);
    for threads in 1..=2 {
        let case = ManyCells::new(degree, threads)?;
        let spread = measure(effort.samples.min(7), || case.train());
        let base = *one.get_or_insert(spread.median);
        (last, cells) = (base / spread.median, case.cell_count());
        table.row(&[threads.to_string(), spread.show(MILLI), digits(cells as f64 / spread.median), digits(last)]);
    }
    Ok(format!(
        "## Threads\n\nOne-ring training of {cells} cells (4 × 4 × 4, d = {degree}, rings clipped at the boundary). Cells are independent and each is solved on one thread; the \
         results are the same bit for bit.\n\n{}\nTwo threads are {} times as fast as one.\n",
        table.text(),
        digits(last),
    ))
}
