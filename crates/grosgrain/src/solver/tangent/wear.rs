//! When a cycle made for an earlier matrix has become too old.

/// A cycle is worn after a solve that needs more than this times the iterations of the first solve with it, per digit, and
/// [`EXTRA`] more.
const GROWTH: f64 = 1.5;
const EXTRA: f64 = 5.0;

/// The pace of convergence with a cycle since it was made.
#[derive(Debug)]
pub(super) struct Wear {
    /// Iterations per digit of the first solve; none before it.
    pace: Option<f64>,
    is_worn: bool,
}

impl Wear {
    /// Of a cycle just made.
    pub fn none() -> Self {
        Self { pace: None, is_worn: false }
    }

    /// Of a cycle that must be made before the next solve.
    pub fn complete() -> Self {
        Self { pace: None, is_worn: true }
    }

    /// Whether the next update should make a new cycle.
    pub fn is_worn(&self) -> bool {
        self.is_worn
    }

    /// Takes note of a solve that reached this relative residual.
    pub fn book(&mut self, iterations: usize, residual: f64) {
        let digits = -residual.max(f64::MIN_POSITIVE).log10();
        if iterations == 0 || digits <= 0.0 {
            return;
        }
        let pace = *self.pace.get_or_insert(iterations as f64 / digits);
        self.is_worn |= iterations as f64 > GROWTH * pace * digits + EXTRA;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cycle_is_worn_when_a_digit_costs_half_as_much_again_and_five_iterations_more() {
        let mut wear = Wear::none();
        wear.book(20, 1e-4);
        for (iterations, residual, is_worn) in [(35, 1e-4, false), (20, 1e-2, false), (21, 1e-2, true), (1, 1e-4, true)]
        {
            wear.book(iterations, residual);
            assert_eq!(wear.is_worn(), is_worn, "{iterations} iterations to {residual:e}");
        }
    }
}
